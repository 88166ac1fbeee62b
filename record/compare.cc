#include "record/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/utf8.h"
#include "record/compare_columns.h"
#include "record/compare_messages.h"
#include "record/departure.h"
#include "record/mcap_reader.h"
#include "record/scenario_difference.h"
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
  const std::set<std::string_view> in_a(a.begin(), a.end()), in_b(b.begin(), b.end());
  std::set<std::string_view> seen;
  std::vector<std::string> both;
  for (const std::string& name : a) {
    if (!in_b.contains(name)) {
      note_missing(fmt::format("{} '{}' is only in A", what, name), comparison);
    } else if (seen.insert(name).second) {
      both.push_back(name);
    }
  }
  for (const std::string& name : b)
    if (!in_a.contains(name)) note_missing(fmt::format("{} '{}' is only in B", what, name), comparison);
  return both;
}

/// Columns of two recordings that are compared, as many at a time as fit into memory, each time in one pass over both.
class TableComparer {
 public:
  TableComparer(const Recording& a, const Recording& b, const CompareOptions& options, Comparison& comparison)
      : a_(a),
        b_(b),
        options_(options),
        comparison_(comparison),
        most_values_(options.values_at_a_time > 0 ? options.values_at_a_time : mcap::ReadLimits::kTableValues) {}

  void add_topic(const std::string& topic) {
    const auto names_a = a_.header(topic), names_b = b_.header(topic);
    if (!names_a || !names_b)
      return note_missing((names_a ? names_b : names_a).error().list().front().message, comparison_);
    // A channel without any message has no columns yet: that is a difference of samples, not of shape.
    const std::size_t rows_a = a_.rows(topic), rows_b = b_.rows(topic);
    if ((rows_a == 0) != (rows_b == 0))
      return note_missing(fmt::format("topic '{}' has no messages in {}", topic, rows_a == 0 ? "A" : "B"), comparison_);
    if (rows_a > 0 && names_a->columns.empty() && names_b->columns.empty())
      return note_missing(fmt::format("topic '{}': its messages cannot be read", topic), comparison_);
    // Times and one column, of both.
    if (2 * (rows_a + rows_b) > most_values_)
      return note_missing(fmt::format("topic '{}' has too many messages to be compared", topic), comparison_);
    const auto names =
        names_in_both(names_a->columns, names_b->columns, fmt::format("column of '{}':", topic), comparison_);
    const std::size_t rows = rows_a + rows_b;
    for (std::size_t i = 0; i < names.size(); ++i) {
      // The parts of an orientation are compared together, so they are read together, also where only two columns fit.
      const std::size_t together = is_rotation(topic, names, i) ? 4 : 1;
      if (values_ > 0 && values_ + (together + 1) * rows > most_values_) finish();
      for (std::size_t k = 0; k < together; ++k) add_column(*names_a, *names_b, names[i + k]);
      i += together - 1;
    }
  }

  /// Compares what has been added and not compared yet.
  void finish() {
    const auto tables_a = a_.tables(in_a_), tables_b = b_.tables(in_b_);
    for (std::size_t i = 0; tables_a && tables_b && i < in_a_.size(); ++i) compare((*tables_a)[i], (*tables_b)[i]);
    if (!tables_a || !tables_b)
      note_missing((tables_a ? tables_b : tables_a).error().list().front().message, comparison_);
    in_a_.clear();
    in_b_.clear();
    values_ = 0;
  }

 private:
  static constexpr std::size_t kMostColumns = 50'000, kMostPlotPoints = 4'000'000;

  void add_column(const Table& names_a, const Table& names_b, const std::string& name) {
    if (++columns_ > kMostColumns) {
      if (columns_ == kMostColumns + 1) note_missing(fmt::format("columns beyond {}", kMostColumns), comparison_);
      return;
    }
    const std::size_t rows = a_.rows(names_a.topic) + b_.rows(names_b.topic);
    if (in_a_.empty() || in_a_.back().topic != names_a.topic) {
      in_a_.push_back({names_a.topic, std::vector<std::size_t>()});
      in_b_.push_back({names_a.topic, std::vector<std::size_t>()});
      values_ += rows;
    }
    const auto index = [&name](const Table& names) {
      return static_cast<std::size_t>(std::ranges::find(names.columns, name) - names.columns.begin());
    };
    in_a_.back().columns->push_back(index(names_a));
    in_b_.back().columns->push_back(index(names_b));
    values_ += rows;
  }

  /// Whether an orientation begins at this column.
  [[nodiscard]] bool is_rotation(const std::string& topic, const std::vector<std::string>& columns,
                                 std::size_t first) const {
    return a_.find_channel(topic)->schema == kFrameTransformsSchema && rotation_at(columns, first);
  }

  static RotationView rotation_view(const Table& table, std::size_t first) {
    return {table.time,
            {table.values[first], table.values[first + 1], table.values[first + 2], table.values[first + 3]}};
  }

  [[nodiscard]] ColumnComparison compare_rotations(const Table& a, const Table& b, std::size_t first) {
    std::string name = a.columns[first];
    name.replace(name.size() - 2, 2, "rotation");
    const Tolerance tolerance = choose_tolerance(options_.rules, a.topic, name, default_tolerance(a.topic, "rad"));
    return compare_rotation({a.topic, name, "rad"}, rotation_view(a, first), rotation_view(b, first), tolerance,
                            points_left());
  }

  /// Messages that are no rows, and rows that only one of both has: once for each topic, however often it is read.
  void note_unread_rows(const Table& a, const Table& b) {
    if (!told_rows_.insert(a.topic).second) return;
    note_lost_rows(a_, a, "A", comparison_);
    note_lost_rows(b_, b, "B", comparison_);
    const Nanoseconds end = common_end(comparison_);
    note_hole(a.topic, "A", find_hole(a.time, b.time, end, Tolerance{}.dt), comparison_);
    note_hole(a.topic, "B", find_hole(b.time, a.time, end, Tolerance{}.dt), comparison_);
  }

  [[nodiscard]] std::size_t points_left() const { return plot_points_ < kMostPlotPoints ? options_.plot_points : 0; }

  void add(ColumnComparison column) {
    plot_points_ += column.curve_a.value.size() + column.curve_b.value.size();
    comparison_.columns.push_back(std::move(column));
  }

  /// Two tables of equal columns.
  void compare(const Table& a, const Table& b) {
    note_unread_rows(a, b);
    // States have no units to judge by; the digest covers them. Which contacts there are depends on the processor.
    const bool only_shown = a_.find_channel(a.topic)->schema == kSimStateSchema || a.topic == kContactForceTopic;
    for (std::size_t i = 0; i < std::min(a.columns.size(), b.columns.size()); ++i) {
      if (is_rotation(a.topic, a.columns, i) && is_rotation(b.topic, b.columns, i)) {
        add(compare_rotations(a, b, i));
        i += 3;
        continue;
      }
      Tolerance otherwise{.kind = ToleranceKind::kReportOnly};
      if (!only_shown) otherwise = default_tolerance(a.topic, b.units[i]);
      const Tolerance tolerance = choose_tolerance(options_.rules, a.topic, a.columns[i], otherwise);
      add(compare_column({a.topic, a.columns[i], b.units[i]}, column_view(a, i), column_view(b, i), tolerance,
                         points_left()));
    }
  }

  const Recording &a_, &b_;
  const CompareOptions& options_;
  Comparison& comparison_;
  const std::size_t most_values_;
  std::vector<ColumnChoice> in_a_, in_b_;  ///< of the same topics, as many columns each
  std::size_t values_ = 0;                 ///< of them, in both
  std::size_t columns_ = 0, plot_points_ = 0;
  std::set<std::string> told_rows_;
};

/// Digests of two recordings, cycle by cycle; cycles that only one of them has are skipped.
class DigestPairs {
 public:
  DigestPairs(const Recording& a, const Recording& b) : a_(a), b_(b) { step(true, true); }

  /// @return false: there are no more cycles that both have
  bool next(RecordedDigest& a, RecordedDigest& b) {
    while (more_a_ && more_b_ && in_a_.cycle != in_b_.cycle) step(in_a_.cycle < in_b_.cycle, in_b_.cycle < in_a_.cycle);
    if (!more_a_ || !more_b_) return false;
    a = in_a_;
    b = in_b_;
    step(true, true);
    return true;
  }
  /// To the ends of both. @return how many cycles A and B have
  std::pair<std::uint64_t, std::uint64_t> counts() {
    while (more_a_ || more_b_) step(more_a_, more_b_);
    return {count_a_, count_b_};
  }

 private:
  void step(bool a, bool b) {
    if (a && (more_a_ = a_.next(in_a_))) ++count_a_;
    if (b && (more_b_ = b_.next(in_b_))) ++count_b_;
  }

  DigestCursor a_, b_;
  RecordedDigest in_a_, in_b_;
  bool more_a_ = true, more_b_ = true;
  std::uint64_t count_a_ = 0, count_b_ = 0;
};

/// The digests of single blocks of one cycle.
std::vector<RecordedEvent> blocks_of(const Recording& recording, std::uint64_t cycle) {
  constexpr std::size_t kMost = 100'000;
  std::vector<RecordedEvent> found;
  const auto take = [&](const RecordedEvent& event) {
    if (event.cycle == cycle) found.push_back(event);
    return event.cycle <= cycle && found.size() < kMost;
  };
  recording.for_each_event(kBlockTopic, take);
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
  DigestPairs pairs(a, b);
  RecordedDigest da, db;
  std::uint64_t common = 0;
  while (pairs.next(da, db)) {
    ++common;
    if (da.digest != db.digest && !comparison.first_difference)
      comparison.first_difference = DigestDifference{da.cycle, da.time, da.digest, db.digest};
  }
  std::tie(comparison.cycles_a, comparison.cycles_b) = pairs.counts();
  if (comparison.first_difference)
    comparison.first_difference->block = first_block(a, b, comparison.first_difference->cycle);
  comparison.digests_compared = comparison.cycles_a > 0 && comparison.cycles_b > 0;
  comparison.identical =
      common > 0 && !comparison.first_difference && comparison.cycles_a == common && comparison.cycles_b == common;
}

/// Digests of blocks say where two runs differ, not whether they may; the log of a run of ours repeats its events.
std::vector<std::string> judged_events(const Recording& recording) {
  auto topics = recording.event_topics();
  std::erase(topics, kBlockTopic);
  if (std::ranges::find(topics, kProgramTopic) != topics.end()) std::erase(topics, kLogTopic);
  return topics;
}

/// What was commanded, call by call, is no curve; set points are compared where they were sent.
std::vector<std::string> judged_tables(const Recording& recording, const CompareOptions& options) {
  auto topics = recording.table_topics();
  std::erase_if(topics, [](const std::string& topic) { return topic.ends_with(kCommandSuffix); });
  const auto wanted = [&](const std::string& topic) {
    return std::ranges::any_of(options.topics, [&](const std::string& pattern) { return matches(pattern, topic); });
  };
  if (!options.topics.empty()) std::erase_if(topics, [&](const std::string& topic) { return !wanted(topic); });
  return topics;
}

/// A log of another program says by its texts what happened; ours have numbers in their texts that vary.
Texts texts_of(const Recording& recording, const std::string& topic) {
  return recording.find_channel(topic)->schema == kLogSchema ? Texts::kJudged : Texts::kIgnored;
}

void compare_all_events(const Recording& a, const Recording& b, const CompareOptions& options, Comparison& comparison) {
  for (const std::string& topic : names_in_both(judged_events(a), judged_events(b), "events", comparison)) {
    Tolerance otherwise;
    if (topic == kContactTopic) otherwise.kind = ToleranceKind::kReportOnly;
    const Tolerance tolerance = choose_tolerance(options.rules, topic, "events", otherwise);
    const auto events_a = a.events(topic), events_b = b.events(topic);
    if (!events_a || !events_b) {
      note_missing((events_a ? events_b : events_a).error().list().front().message, comparison);
      continue;
    }
    note_lost_rows(a, topic, events_a->size(), "A", comparison);
    note_lost_rows(b, topic, events_b->size(), "B", comparison);
    comparison.columns.push_back(compare_events(topic, *events_a, *events_b, tolerance, texts_of(b, topic)));
  }
}

/// Topics of bytes with messages, or that are told. The looks of a cell of ours say nothing of its run.
std::vector<std::string> byte_topics(const Recording& recording) {
  std::vector<std::string> topics;
  for (const ChannelInfo& channel : recording.channels())
    if (!Recording::decodes(channel)) topics.push_back(channel.topic);
  return topics;
}

void compare_all_messages(const Recording& a, const Recording& b, const CompareOptions& options,
                          Comparison& comparison) {
  for (const std::string& topic : names_in_both(byte_topics(a), byte_topics(b), "topic", comparison)) {
    Tolerance otherwise{.kind = ToleranceKind::kExact, .dt = 0};
    const bool is_scene = b.find_channel(topic)->schema == kSceneUpdateSchema && !b.digest_topic().empty();
    if (is_scene) otherwise.kind = ToleranceKind::kReportOnly;
    comparison.columns.push_back(
        compare_messages(a, b, topic, choose_tolerance(options.rules, topic, "messages", otherwise)));
    if (!is_scene)
      comparison.notes.push_back(fmt::format("topic '{}' is compared as bytes: its {} is not decoded", topic,
                                             why_not_decoded(*b.find_channel(topic))));
  }
}

/// Durations of steps, where both have steps; else those of A name the steps all the same.
void add_durations(const Recording& a, const Recording& b, const CompareOptions& options, Comparison& comparison) {
  const auto steps_a = step_events(a), steps_b = step_events(b);
  const Tolerance of_events = choose_tolerance(options.rules, kProgramTopic, "events", Tolerance{});
  const bool both = options.topics.empty() && !steps_b.empty();
  comparison.durations = compare_durations(steps_a, both ? steps_b : steps_a, comparison.end_a,
                                           both ? comparison.end_b : comparison.end_a, of_events.dt);
}

/// Attachments beside the scenario, which is compared by its values.
void note_attachments(const Recording& a, const Recording& b, Comparison& comparison) {
  constexpr std::size_t kMost = 20;
  const std::size_t before = comparison.notes.size();
  const auto note = [&](const std::string& name, const char* what) {
    if (comparison.notes.size() < before + kMost && name != "scenario.json")
      comparison.notes.push_back(to_valid_utf8(fmt::format("attachment '{}' {}", name, what)));
  };
  std::set<std::string> in_a, in_b;
  for (const AttachmentInfo& info : a.attachments()) in_a.insert(info.name);
  for (const AttachmentInfo& info : b.attachments()) in_b.insert(info.name);
  for (const std::string& name : in_a) {
    if (!in_b.contains(name)) {
      note(name, "is only in A");
    } else if (a.attachment(name) != b.attachment(name)) {
      note(name, "differs");
    }
  }
  for (const std::string& name : in_b)
    if (!in_a.contains(name)) note(name, "is only in B");
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
  if (options.topics.empty()) compare_digests(a, b, comparison);
  comparison.steps = steps_of(a);
  const auto fingerprint_b = b.metadata().find("takt.fingerprint");
  note_differences(a, "A",
                   fingerprint_b == b.metadata().end() ? std::map<std::string, std::string>{} : fingerprint_b->second,
                   comparison);
  note_damage(b, "B", comparison);
  note_attachments(a, b, comparison);
  comparison.scenario_differences = scenario_differences(a, b);

  add_durations(a, b, options, comparison);
  if (options.topics.empty()) {
    comparison.columns.push_back(
        compare_end(comparison.end_a, comparison.end_b, choose_tolerance(options.rules, "run", "end", Tolerance{})));
    compare_all_events(a, b, options, comparison);
    compare_all_messages(a, b, options, comparison);
  }
  TableComparer tables(a, b, options, comparison);
  for (const std::string& topic :
       names_in_both(judged_tables(a, options), judged_tables(b, options), "topic", comparison))
    tables.add_topic(topic);
  tables.finish();
  comparison.judged_a = judged_share(a, comparison);
  comparison.judged_b = judged_share(b, comparison);
  note_unjudged(a, b, comparison);
  if (!options.topics.empty()) comparison.not_judged.clear();
  judge(options, comparison);
  find_departure(comparison);
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
