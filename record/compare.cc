#include "record/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "record/compare_columns.h"
#include "record/schemas.h"

namespace takt::record {

namespace {

struct UnitTolerance {
  std::string_view unit;
  double dv;
};
/// About ten times what another processor or libm has been seen to change, and far below what a person would call
/// another motion.
constexpr UnitTolerance kUnitTolerances[] = {
    {"rad", 2e-3}, {"rad/s", 2e-2}, {"m", 5e-4}, {"m/s", 5e-3}, {"N", 0.5}, {"Nm", 0.2}, {"s", 5e-3}, {"", 2e-3},
};
constexpr double kOtherUnits = 1e-3;

CurveView column_view(const Table& table, std::size_t column) { return {table.time, table.values[column]}; }

std::vector<std::string> names_in_both(const std::vector<std::string>& a, const std::vector<std::string>& b,
                                       std::string_view what, Comparison& comparison) {
  std::vector<std::string> both;
  for (const std::string& name : a) {
    if (std::ranges::find(b, name) == b.end()) {
      comparison.missing.push_back(fmt::format("{} '{}' is only in A", what, name));
    } else if (std::ranges::find(both, name) == both.end()) {
      both.push_back(name);
    }
  }
  for (const std::string& name : b) {
    if (std::ranges::find(a, name) == a.end()) {
      comparison.missing.push_back(fmt::format("{} '{}' is only in B", what, name));
    }
  }
  return both;
}

void compare_tables(const Table& a, const Table& b, Tolerance otherwise, bool use_units, const CompareOptions& options,
                    Comparison& comparison) {
  // A channel without any message has no columns yet: that is a difference of samples, not of shape.
  const bool one_is_empty = a.time.empty() != b.time.empty();
  if (one_is_empty) {
    comparison.missing.push_back(fmt::format("topic '{}' has no messages in {}", a.topic, a.time.empty() ? "A" : "B"));
    return;
  }
  for (const std::string& name :
       names_in_both(a.columns, b.columns, fmt::format("column of '{}':", a.topic), comparison)) {
    const auto ia = static_cast<std::size_t>(std::ranges::find(a.columns, name) - a.columns.begin());
    const auto ib = static_cast<std::size_t>(std::ranges::find(b.columns, name) - b.columns.begin());
    if (use_units) otherwise = default_tolerance(a.topic, b.units[ib]);
    const Tolerance tolerance = choose_tolerance(options.rules, a.topic, name, otherwise);
    comparison.columns.push_back(compare_column({a.topic, name, b.units[ib]}, column_view(a, ia), column_view(b, ib),
                                                tolerance, options.plot_points));
  }
}

/// The events of one cycle.
std::vector<RecordedEvent> blocks_of(const Recording& recording, std::uint64_t cycle) {
  std::vector<RecordedEvent> found;
  const auto events = recording.events(kBlockTopic);
  if (!events) return found;
  std::ranges::copy_if(*events, std::back_inserter(found), [cycle](const auto& event) { return event.cycle == cycle; });
  return found;
}

/// The first block of a cycle that two recordings tell apart; empty: they do not say.
std::string first_block(const Recording& a, const Recording& b, std::uint64_t cycle) {
  const auto blocks_a = blocks_of(a, cycle), blocks_b = blocks_of(b, cycle);
  for (std::size_t i = 0; i < std::min(blocks_a.size(), blocks_b.size()); ++i) {
    if (blocks_a[i].name != blocks_b[i].name) return fmt::format("{} against {}", blocks_a[i].name, blocks_b[i].name);
    if (blocks_a[i].text != blocks_b[i].text) return blocks_a[i].name;
  }
  return {};
}

void compare_digests(const Recording& a, const Recording& b, Comparison& comparison) {
  const auto da = a.digests(), db = b.digests();
  comparison.cycles_a = da.size();
  comparison.cycles_b = db.size();
  comparison.digests_compared = !da.empty() && !db.empty();
  for (std::size_t i = 0; i < std::min(da.size(), db.size()); ++i) {
    if (da[i].cycle == db[i].cycle && da[i].digest == db[i].digest) continue;
    comparison.first_difference = DigestDifference{da[i].cycle, da[i].time, da[i].digest, db[i].digest};
    comparison.first_difference->block = first_block(a, b, da[i].cycle);
    break;
  }
  comparison.identical = comparison.digests_compared && !comparison.first_difference && da.size() == db.size();
}

/// Digests of blocks say where two runs differ, not whether they may.
std::vector<std::string> judged_events(const Recording& recording) {
  auto topics = recording.event_topics();
  std::erase(topics, kBlockTopic);
  return topics;
}

}  // namespace

Tolerance default_tolerance(std::string_view topic, std::string_view unit) {
  (void)topic;
  Tolerance tolerance;
  const auto found = std::ranges::find(kUnitTolerances, unit, &UnitTolerance::unit);
  tolerance.dv = found == std::end(kUnitTolerances) ? kOtherUnits : found->dv;
  return tolerance;
}

Comparison compare(const Recording& a, const Recording& b, const CompareOptions& options) {
  Comparison comparison;
  comparison.name_a = "A";
  comparison.name_b = "B";
  comparison.end_a = a.end_time();
  comparison.end_b = b.end_time();
  compare_digests(a, b, comparison);
  const auto fingerprint_b = b.metadata().find("takt.fingerprint");
  note_differences(a, "A",
                   fingerprint_b == b.metadata().end() ? std::map<std::string, std::string>{} : fingerprint_b->second,
                   comparison);
  for (const std::string& damage : b.damage()) comparison.notes.push_back(fmt::format("B: {}", damage));

  comparison.columns.push_back(
      compare_end(comparison.end_a, comparison.end_b, choose_tolerance(options.rules, "run", "end", Tolerance{})));
  for (const std::string& topic : names_in_both(judged_events(a), judged_events(b), "events", comparison)) {
    const Tolerance tolerance = choose_tolerance(options.rules, topic, "events", Tolerance{});
    comparison.columns.push_back(compare_events(topic, *a.events(topic), *b.events(topic), tolerance));
  }
  for (const std::string& topic : names_in_both(a.table_topics(), b.table_topics(), "topic", comparison)) {
    // States have no units to judge by; the digest covers them.
    const bool is_state = a.find_channel(topic)->schema == kSimStateSchema;
    const Tolerance report_only{.kind = ToleranceKind::kReportOnly};
    const auto table_a = a.table(topic), table_b = b.table(topic);
    if (table_a && table_b) {
      compare_tables(*table_a, *table_b, report_only, !is_state, options, comparison);
    } else {
      comparison.missing.push_back((table_a ? table_b : table_a).error().list().front().message);
    }
  }
  judge(options, comparison);
  return comparison;
}

Result<Comparison> compare_recordings(const std::filesystem::path& a, const std::filesystem::path& b,
                                      const CompareOptions& options) {
  Diagnostics diagnostics;
  Result<Recording> ra = Recording::open(a), rb = Recording::open(b);
  if (!ra) diagnostics.append(ra.error());
  if (!rb) diagnostics.append(rb.error());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  Comparison comparison = compare(*ra, *rb, options);
  comparison.name_a = a.string();
  comparison.name_b = b.string();
  return comparison;
}

}  // namespace takt::record
