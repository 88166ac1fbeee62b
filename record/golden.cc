#include "record/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "core/base/json.h"
#include "core/base/output_file.h"
#include "record/compare.h"
#include "record/compare_columns.h"
#include "record/golden_curves.h"
#include "record/golden_digest.h"
#include "record/schemas.h"

namespace takt::record {

namespace {

/// A golden may be larger than an input of the user's hand, but not without bound.
constexpr InputLimits kGoldenLimits{.bytes = 4u << 20, .depth = 16};

/// A golden takes a quarter of the tolerance, so that three quarters stay for the run; half of it where the golden
/// would be too large otherwise (noise).
constexpr double kThinningShare = 0.25, kCoarseShare = 0.5;

bool topic_wanted(const BlessOptions& options, const ChannelInfo& channel) {
  if (options.topics.empty()) return channel.schema != kSimStateSchema;
  return std::ranges::any_of(options.topics, [&](const std::string& p) { return matches(p, channel.topic); });
}

/// What was commanded comes first: what was measured follows it.
void add_columns(const Recording& recording, const BlessOptions& options, double share, Golden& golden,
                 Diagnostics& diagnostics) {
  golden.columns.clear();
  golden.grids.clear();
  GoldenWriter writer(golden, share);
  std::vector<std::string> topics = recording.table_topics();
  std::ranges::stable_partition(topics, [](const std::string& topic) { return topic.ends_with("/set_point"); });
  for (const std::string& topic : topics) {
    if (!topic_wanted(options, *recording.find_channel(topic))) continue;
    const Result<Table> table = recording.table(topic);
    if (!table) {
      diagnostics.append(table.error());
      continue;
    }
    std::vector<Tolerance> tolerances;
    for (std::size_t i = 0; i < table->columns.size(); ++i)
      tolerances.push_back(
          choose_tolerance(options.rules, topic, table->columns[i], default_tolerance(topic, table->units[i])));
    writer.add(*table, tolerances);
  }
}

/// Characters or points: what makes a column large.
std::size_t size_of(const GoldenColumn& column) {
  return column.curve ? column.curve->pieces.size() : 10 * column.time_s.size();
}

Diagnostics too_large(const Golden& golden, std::size_t bytes, std::size_t most) {
  std::vector<const GoldenColumn*> columns;
  for (const GoldenColumn& column : golden.columns) columns.push_back(&column);
  std::ranges::stable_sort(columns, std::greater{}, [](const GoldenColumn* c) { return size_of(*c); });
  std::string largest;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, columns.size()); ++i) {
    largest += fmt::format("{}{} {} ({} bytes)", i == 0 ? "" : ", ", columns[i]->topic, columns[i]->column,
                           size_of(*columns[i]));
  }
  Diagnostics diagnostics;
  diagnostics.error(
      Code::kTooLarge, "", fmt::format("the golden has {} bytes, at most {} are allowed", bytes, most),
      fmt::format("Widen tolerances (golden.tolerances), or report_only; the largest columns: {}", largest));
  return diagnostics;
}

}  // namespace

/// How many digests there are, and the last one in hexadecimal digits; empty if there is none.
std::pair<std::uint64_t, std::string> last_digest(const Recording& recording) {
  std::uint64_t count = 0;
  RecordedDigest digest;
  for (DigestCursor cursor(recording); cursor.next(digest);) ++count;
  return {count, count == 0 ? "" : fmt::format("{:016x}", digest.digest)};
}

Result<Golden> make_golden(const Recording& recording, const BlessOptions& options) {
  Diagnostics diagnostics;
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos) {
    diagnostics.error(Code::kMissing, "", "a golden needs a reason", "Say in a few words why this run is right");
  }
  for (const std::string& damage : recording.damage())
    diagnostics.error(Code::kFileNotReadable, "", fmt::format("recording: {}", damage));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  Golden golden;
  golden.scenario = options.scenario;
  golden.reason = options.reason;
  if (const auto f = recording.metadata().find("takt.fingerprint"); f != recording.metadata().end()) {
    golden.fingerprint = f->second;
  }
  std::tie(golden.cycles, golden.digest) = last_digest(recording);
  golden.end_s = static_cast<double>(recording.end_time()) / 1e9;

  const Tolerance of_run = choose_tolerance(options.rules, "run", "end", Tolerance{});
  golden.event_tolerance = choose_tolerance(options.rules, "/program", "events", of_run);
  for (const std::string& topic : recording.event_topics()) {
    if (!topic_wanted(options, *recording.find_channel(topic))) continue;
    const auto events = recording.events(topic);
    if (!events) return std::unexpected(events.error());
    for (const RecordedEvent& event : *events) {
      golden.events.push_back({.topic = topic,
                               .source = event.source,
                               .name = event.name,
                               .time_s = static_cast<double>(event.time) / 1e9,
                               .step = event.step});
    }
  }
  add_columns(recording, options, kThinningShare, golden, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  if (golden.columns.empty() && golden.events.empty()) {
    return failure(Code::kMissing, "", "the recording has no columns and no events to keep");
  }
  std::size_t bytes = golden_to_text(golden).size();
  if (bytes > options.max_bytes) {
    add_columns(recording, options, kCoarseShare, golden, diagnostics);
    bytes = golden_to_text(golden).size();
  }
  if (bytes > options.max_bytes) return std::unexpected(too_large(golden, bytes, options.max_bytes));
  return golden;
}

Result<Golden> read_golden(const std::filesystem::path& path) {
  const auto json = read_json(path, kGoldenLimits);
  if (!json) return std::unexpected(json.error());
  auto golden = golden_from_json(*json);
  if (!golden) golden.error().set_file(path.string());
  return golden;
}

Result<Golden> bless(const std::filesystem::path& recording, const std::filesystem::path& golden,
                     const BlessOptions& options) {
  const auto run = Recording::open(recording);
  if (!run) return std::unexpected(run.error());
  auto made = make_golden(*run, options);
  if (!made) {
    made.error().set_file(recording.string());
    return made;
  }
  std::error_code code;
  if (golden.has_parent_path()) std::filesystem::create_directories(golden.parent_path(), code);
  if (Diagnostics diagnostics = write_file(golden, golden_to_text(*made)); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  return made;
}

}  // namespace takt::record
