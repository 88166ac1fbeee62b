#include "record/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/json.h"
#include "core/base/output_file.h"
#include "record/compare_columns.h"
#include "record/schemas.h"

namespace takt::record {

namespace {

/// A golden may be larger than an input of the user's hand, but not without bound.
constexpr InputLimits kGoldenLimits{.bytes = 4u << 20, .depth = 16};

/// Thinning takes a quarter of the tolerance, so that three quarters stay for the run; half of it where the golden
/// would be too large otherwise (noise).
constexpr double kThinningShare = 0.25, kCoarseShare = 0.5;

bool topic_wanted(const BlessOptions& options, const ChannelInfo& channel) {
  if (options.topics.empty()) return channel.schema != kSimStateSchema;
  return std::ranges::any_of(options.topics, [&](const std::string& p) { return matches(p, channel.topic); });
}

/// `value` rounded to a multiple of a power of ten of at most `step`: short to write, and within step/2.
double rounded(double value, double step) {
  if (!std::isfinite(value) || !(step > 0.0)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(step)));
  const double inverse = std::round(1.0 / unit);
  return unit < 1.0 ? std::round(value * inverse) / inverse : std::round(value / unit) * unit;
}

GoldenColumn thin_column(const Table& table, std::size_t column, const Tolerance& tolerance, double share) {
  GoldenColumn golden{.topic = table.topic,
                      .column = table.columns[column],
                      .unit = table.units[column],
                      .tolerance = tolerance,
                      .thinning = share * tolerance.dv,
                      .time_s = {},
                      .value = {}};
  const CurveView curve{table.time, table.values[column]};
  const bool exact = tolerance.kind == ToleranceKind::kExact;
  if (exact) golden.thinning = 0.0;
  // Rounding uses a tenth of the thinning, the lines the rest.
  const double step = 0.2 * golden.thinning;
  std::vector<std::size_t> kept;
  if (exact) {
    for (std::size_t i = 0; i < table.time.size(); ++i) kept.push_back(i);
  } else {
    kept = thin(curve, 0.9 * golden.thinning);
  }
  for (const std::size_t i : kept) {
    golden.time_s.push_back(to_seconds(curve.time[i]));
    golden.value.push_back(rounded(curve.value[i], step));
  }
  return golden;
}

std::vector<GoldenColumn> golden_columns(const Recording& recording, const BlessOptions& options, double share,
                                         Diagnostics& diagnostics) {
  std::vector<GoldenColumn> columns;
  for (const std::string& topic : recording.table_topics()) {
    if (!topic_wanted(options, *recording.find_channel(topic))) continue;
    const Result<Table> read = recording.table(topic);
    if (!read) {
      diagnostics.append(read.error());
      continue;
    }
    const Table& table = *read;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const Tolerance tolerance =
          choose_tolerance(options.rules, topic, table.columns[i], default_tolerance(topic, table.units[i]));
      if (tolerance.kind == ToleranceKind::kReportOnly) continue;
      columns.push_back(thin_column(table, i, tolerance, share));
    }
  }
  return columns;
}

/// How many digests there are, and the last one in hexadecimal digits; empty if there is none.
std::pair<std::uint64_t, std::string> last_digest(const Recording& recording) {
  std::uint64_t count = 0;
  RecordedDigest digest;
  for (DigestCursor cursor(recording); cursor.next(digest);) ++count;
  return {count, count == 0 ? "" : fmt::format("{:016x}", digest.digest)};
}

const char* kind_name(ToleranceKind kind) {
  switch (kind) {
    case ToleranceKind::kExact:
      return "exact";
    case ToleranceKind::kTube:
      return "tube";
    case ToleranceKind::kFeatures:
      return "features";
    case ToleranceKind::kReportOnly:
      return "report_only";
  }
  return "";
}

nlohmann::ordered_json to_json(const Tolerance& tolerance) {
  nlohmann::ordered_json json = {
      {"kind", kind_name(tolerance.kind)}, {"dt_s", to_seconds(tolerance.dt)}, {"dv", tolerance.dv}};
  if (tolerance.features == Tolerance{}.features) return json;
  json["features"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kFeatureCount; ++i)
    if (tolerance.features.test(i)) json["features"].push_back(std::string(name_of(static_cast<Feature>(i))));
  return json;
}

Nanoseconds nanoseconds(double seconds) { return static_cast<Nanoseconds>(std::llround(seconds * 1e9)); }

nlohmann::ordered_json to_json(const Golden& golden) {
  nlohmann::ordered_json json;
  json["takt_golden"] = 1;
  json["scenario"] = golden.scenario;
  json["reason"] = golden.reason;
  json["fingerprint"] = golden.fingerprint;
  json["cycles"] = golden.cycles;
  json["end_s"] = golden.end_s;
  json["digest"] = golden.digest;
  json["event_tolerance"] = to_json(golden.event_tolerance);
  auto& events = json["events"] = nlohmann::ordered_json::array();
  for (const GoldenEvent& event : golden.events) {
    events.push_back(
        {{"topic", event.topic}, {"source", event.source}, {"name", event.name}, {"time_s", event.time_s}});
  }
  auto& columns = json["columns"] = nlohmann::ordered_json::array();
  for (const GoldenColumn& column : golden.columns) {
    nlohmann::ordered_json values = nlohmann::ordered_json::array();
    for (const double value : column.value) {
      values.push_back(std::isnan(value) ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value));
    }
    columns.push_back({{"topic", column.topic},
                       {"column", column.column},
                       {"unit", column.unit},
                       {"tolerance", to_json(column.tolerance)},
                       {"thinning", column.thinning},
                       {"time_s", column.time_s},
                       {"value", std::move(values)}});
  }
  return json;
}

/// Reads members with a type; every miss is a diagnostic at its pointer.
class MemberReader {
 public:
  explicit MemberReader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  std::string text(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    const auto* member = find(json, at, key);
    if (member == nullptr) return {};
    if (member->is_string()) return member->get<std::string>();
    wrong(at, key, "a text");
    return {};
  }
  double number(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    const auto* member = find(json, at, key);
    if (member == nullptr) return 0.0;
    if (member->is_number()) return member->get<double>();
    wrong(at, key, "a number");
    return 0.0;
  }
  const nlohmann::ordered_json& list(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    static const nlohmann::ordered_json kEmpty = nlohmann::ordered_json::array();
    const auto* member = find(json, at, key);
    if (member == nullptr) return kEmpty;
    if (member->is_array()) return *member;
    wrong(at, key, "an array");
    return kEmpty;
  }
  std::vector<double> numbers(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    std::vector<double> values;
    for (const auto& item : list(json, at, key)) {
      if (!item.is_number() && !item.is_null()) {
        wrong(at, key, "an array of numbers and null");
        return {};
      }
      values.push_back(item.is_null() ? std::numeric_limits<double>::quiet_NaN() : item.get<double>());
    }
    return values;
  }
  Tolerance tolerance(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    Tolerance tolerance;
    const auto* member = find(json, at, key);
    if (member == nullptr) return tolerance;
    const std::string place = at + pointer_segment(key);
    const std::string kind = text(*member, place, "kind");
    std::vector<std::string> names;
    bool known = false;
    for (const ToleranceKind k :
         {ToleranceKind::kExact, ToleranceKind::kTube, ToleranceKind::kFeatures, ToleranceKind::kReportOnly}) {
      names.emplace_back(kind_name(k));
      if (kind != names.back()) continue;
      tolerance.kind = k;
      known = true;
    }
    if (!known) {
      diagnostics_.error(Code::kUnknownName, place + "/kind", fmt::format("'{}' is not a kind of tolerance", kind),
                         nearest_choice(kind, names));
    }
    tolerance.dt = nanoseconds(number(*member, place, "dt_s"));
    tolerance.dv = number(*member, place, "dv");
    if (!member->contains("features")) return tolerance;
    tolerance.features.reset();
    const auto& names_judged = list(*member, place, "features");
    for (std::size_t i = 0; i < names_judged.size(); ++i) {
      const std::string name = names_judged[i].is_string() ? names_judged[i].get<std::string>() : std::string();
      judge_feature(name, place + "/features" + pointer_segment(i), tolerance.features, diagnostics_);
    }
    return tolerance;
  }

 private:
  const nlohmann::ordered_json* find(const nlohmann::ordered_json& json, const std::string& at, const char* key) {
    if (json.is_object()) {
      if (const auto found = json.find(key); found != json.end()) return &*found;
    }
    diagnostics_.error(Code::kMissing, at, fmt::format("'{}' is missing", key));
    return nullptr;
  }
  void wrong(const std::string& at, const char* key, const char* wanted) {
    diagnostics_.error(Code::kWrongType, at + pointer_segment(key), "the value has another type",
                       fmt::format("wanted: {}", wanted));
  }

  Diagnostics& diagnostics_;
};

Diagnostics too_large(const Golden& golden, std::size_t bytes, std::size_t most) {
  std::vector<const GoldenColumn*> columns;
  for (const GoldenColumn& column : golden.columns) columns.push_back(&column);
  std::ranges::stable_sort(columns, std::greater{}, [](const GoldenColumn* c) { return c->time_s.size(); });
  std::string largest;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, columns.size()); ++i) {
    largest += fmt::format("{}{} {} ({} points)", i == 0 ? "" : ", ", columns[i]->topic, columns[i]->column,
                           columns[i]->time_s.size());
  }
  Diagnostics diagnostics;
  diagnostics.error(Code::kTooLarge, "", fmt::format("the golden has {} bytes, at most {} are allowed", bytes, most),
                    fmt::format("leave topics out or widen tolerances; the largest columns: {}", largest));
  return diagnostics;
}

}  // namespace

Result<Golden> make_golden(const Recording& recording, const BlessOptions& options) {
  Diagnostics diagnostics;
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos) {
    diagnostics.error(Code::kMissing, "", "a golden needs a reason", "say in a few words why this run is right");
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
  golden.end_s = to_seconds(recording.end_time());

  const Tolerance of_run = choose_tolerance(options.rules, "run", "end", Tolerance{});
  golden.event_tolerance = choose_tolerance(options.rules, "/program", "events", of_run);
  for (const std::string& topic : recording.event_topics()) {
    if (!topic_wanted(options, *recording.find_channel(topic))) continue;
    const auto events = recording.events(topic);
    if (!events) return std::unexpected(events.error());
    for (const RecordedEvent& event : *events) {
      golden.events.push_back({topic, event.source, event.name, to_seconds(event.time)});
    }
  }
  golden.columns = golden_columns(recording, options, kThinningShare, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  if (golden.columns.empty() && golden.events.empty()) {
    return failure(Code::kMissing, "", "the recording has no columns and no events to keep");
  }
  std::size_t bytes = golden_to_text(golden).size();
  if (bytes > options.max_bytes) {
    golden.columns = golden_columns(recording, options, kCoarseShare, diagnostics);
    bytes = golden_to_text(golden).size();
  }
  if (bytes > options.max_bytes) return std::unexpected(too_large(golden, bytes, options.max_bytes));
  return golden;
}

std::string golden_to_text(const Golden& golden) {
  // One line per column and event: differences stay readable in a review.
  const nlohmann::ordered_json json = to_json(golden);
  std::string text = "{";
  for (auto member = json.begin(); member != json.end(); ++member) {
    text += fmt::format("{}\n  {}: ", member == json.begin() ? "" : ",", nlohmann::ordered_json(member.key()).dump());
    if (!member->is_array()) {
      text += member->dump();
      continue;
    }
    text += "[";
    for (std::size_t i = 0; i < member->size(); ++i)
      text += fmt::format("{}\n    {}", i == 0 ? "" : ",", (*member)[i].dump());
    text += member->empty() ? "]" : "\n  ]";
  }
  return text + "\n}\n";
}

Result<Golden> golden_from_json(const nlohmann::ordered_json& json) {
  Diagnostics diagnostics;
  MemberReader read(diagnostics);
  if (!json.is_object() || !json.contains("takt_golden"))
    return failure(Code::kMissing, "", "this is not a golden: 'takt_golden' is missing");
  if (json.at("takt_golden") != 1)
    return failure(Code::kIncompatible, "/takt_golden", "this version of goldens is not known", "known: 1");
  Golden golden;
  golden.scenario = read.text(json, "", "scenario");
  golden.reason = read.text(json, "", "reason");
  golden.cycles = static_cast<std::uint64_t>(std::max(0.0, read.number(json, "", "cycles")));
  golden.end_s = read.number(json, "", "end_s");
  golden.digest = read.text(json, "", "digest");
  golden.event_tolerance = read.tolerance(json, "", "event_tolerance");
  if (json.contains("fingerprint") && json.at("fingerprint").is_object()) {
    for (const auto& [key, value] : json.at("fingerprint").items()) {
      if (value.is_string()) golden.fingerprint[key] = value.get<std::string>();
    }
  }
  std::size_t i = 0;
  for (const auto& event : read.list(json, "", "events")) {
    const std::string at = fmt::format("/events/{}", i++);
    golden.events.push_back({read.text(event, at, "topic"), read.text(event, at, "source"),
                             read.text(event, at, "name"), read.number(event, at, "time_s")});
  }
  i = 0;
  for (const auto& item : read.list(json, "", "columns")) {
    const std::string at = fmt::format("/columns/{}", i++);
    GoldenColumn column;
    column.topic = read.text(item, at, "topic");
    column.column = read.text(item, at, "column");
    column.unit = read.text(item, at, "unit");
    column.tolerance = read.tolerance(item, at, "tolerance");
    column.thinning = read.number(item, at, "thinning");
    column.time_s = read.numbers(item, at, "time_s");
    column.value = read.numbers(item, at, "value");
    if (column.time_s.size() != column.value.size()) {
      diagnostics.error(Code::kWrongSize, at,
                        fmt::format("{} times and {} values", column.time_s.size(), column.value.size()));
    }
    const bool ascending = std::ranges::is_sorted(column.time_s) &&
                           std::ranges::none_of(column.time_s, [](double t) { return std::isnan(t); });
    if (!ascending) diagnostics.error(Code::kOutOfRange, at + "/time_s", "times do not ascend");
    golden.columns.push_back(std::move(column));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return golden;
}

Result<Golden> read_golden(const std::filesystem::path& path) {
  const auto json = read_json(path, kGoldenLimits);
  if (!json) return std::unexpected(json.error());
  auto golden = golden_from_json(*json);
  if (!golden) golden.error().set_file(path.string());
  return golden;
}

namespace {

void compare_golden_events(const Recording& recording, const Golden& golden, const CompareOptions& options,
                           Comparison& comparison) {
  std::vector<std::string> topics;
  for (const GoldenEvent& event : golden.events) {
    if (std::ranges::find(topics, event.topic) == topics.end()) topics.push_back(event.topic);
  }
  for (const std::string& topic : topics) {
    std::vector<RecordedEvent> reference;
    for (const GoldenEvent& event : golden.events) {
      if (event.topic == topic) reference.push_back({nanoseconds(event.time_s), 0, event.source, event.name, {}});
    }
    const auto events = recording.events(topic);
    if (!events) {
      comparison.missing.push_back(fmt::format("events '{}' are only in the golden", topic));
      continue;
    }
    Tolerance tolerance = choose_tolerance(options.rules, topic, "events", golden.event_tolerance);
    comparison.columns.push_back(compare_events(topic, *events, reference, tolerance));
  }
}

void compare_golden_column(const Table& table, const GoldenColumn& column, const CompareOptions& options,
                           Comparison& comparison) {
  const auto found = std::ranges::find(table.columns, column.column);
  if (found == table.columns.end()) {
    comparison.missing.push_back(fmt::format("column '{}' of '{}' is only in the golden", column.column, column.topic));
    return;
  }
  std::vector<Nanoseconds> time;
  for (const double t : column.time_s) time.push_back(nanoseconds(t));
  const Tolerance tolerance = choose_tolerance(options.rules, column.topic, column.column, column.tolerance);
  const auto i = static_cast<std::size_t>(found - table.columns.begin());
  comparison.columns.push_back(compare_column({column.topic, column.column, column.unit}, {table.time, table.values[i]},
                                              {time, column.value}, tolerance, options.plot_points));
}

/// Of a golden: the columns of a quaternion, one behind the other.
constexpr std::size_t kQuaternion = 4;

/// The orientation that begins with a column of the golden: "FRAME.rotation".
std::optional<std::string> golden_rotation(const Golden& golden, std::size_t first) {
  std::vector<std::string> names;
  for (std::size_t i = first; i < std::min(first + kQuaternion, golden.columns.size()); ++i)
    if (golden.columns[i].topic == golden.columns[first].topic) names.push_back(golden.columns[i].column);
  auto frame = rotation_at(names, 0);
  if (frame) *frame += ".rotation";
  return frame;
}

/// An orientation is judged by the angle, as between recordings. The tolerance of the four numbers is half an angle: a
/// small turn changes the numbers by half of it.
void compare_golden_rotation(const Table& table, const Golden& golden, std::size_t first, const std::string& name,
                             const CompareOptions& options, Comparison& comparison) {
  const GoldenColumn& head = golden.columns[first];
  std::array<std::vector<double>, kQuaternion> reference;
  RotationView run{table.time, {}}, golden_run{table.time, {}};
  Tolerance otherwise = head.tolerance;
  for (std::size_t k = 0; k < kQuaternion; ++k) {
    const GoldenColumn& part = golden.columns[first + k];
    const auto found = std::ranges::find(table.columns, part.column);
    if (found == table.columns.end()) {
      comparison.missing.push_back(fmt::format("column '{}' of '{}' is only in the golden", part.column, part.topic));
      return;
    }
    run.wxyz[k] = table.values[static_cast<std::size_t>(found - table.columns.begin())];
    std::vector<Nanoseconds> time;
    for (const double t : part.time_s) time.push_back(nanoseconds(t));
    for (const Nanoseconds t : table.time) reference[k].push_back(value_at({time, part.value}, t));
    golden_run.wxyz[k] = reference[k];
    otherwise.dv = std::max(otherwise.dv, part.tolerance.dv);
  }
  otherwise.dv *= 2.0;
  const Tolerance tolerance = choose_tolerance(options.rules, head.topic, name, otherwise);
  comparison.columns.push_back(
      compare_rotation({head.topic, name, "rad"}, run, golden_run, tolerance, options.plot_points));
}

void compare_golden_digest(const Recording& recording, const Golden& golden, Comparison& comparison) {
  const auto [cycles, digest] = last_digest(recording);
  comparison.cycles_a = cycles;
  comparison.cycles_b = golden.cycles;
  comparison.digests_compared = !digest.empty() && !golden.digest.empty();
  if (!comparison.digests_compared) return;
  comparison.identical = digest == golden.digest && cycles == golden.cycles;
  if (!comparison.identical) {
    comparison.notes.push_back(fmt::format("the digest at the end is {}, the golden's is {}", digest, golden.digest));
  }
}

}  // namespace

Comparison compare_with_golden(const Recording& recording, const Golden& golden, const CompareOptions& options) {
  Comparison comparison;
  comparison.name_a = "run";
  comparison.name_b = "golden";
  comparison.end_a = recording.end_time();
  comparison.end_b = nanoseconds(golden.end_s);
  compare_golden_digest(recording, golden, comparison);
  comparison.steps = steps_of(recording);
  note_differences(recording, "run", golden.fingerprint, comparison);
  comparison.columns.push_back(compare_end(comparison.end_a, comparison.end_b,
                                           choose_tolerance(options.rules, "run", "end", golden.event_tolerance)));
  compare_golden_events(recording, golden, options, comparison);

  std::optional<Table> table;
  std::set<std::string> told;
  for (std::size_t i = 0; i < golden.columns.size(); ++i) {
    const GoldenColumn& column = golden.columns[i];
    if (!table || table->topic != column.topic) {
      auto read = recording.table(column.topic);
      if (!read) {
        if (told.insert(column.topic).second) {
          comparison.missing.push_back(fmt::format("topic '{}' is only in the golden", column.topic));
        }
        continue;
      }
      table = std::move(*read);
    }
    if (const auto rotation = golden_rotation(golden, i)) {
      compare_golden_rotation(*table, golden, i, *rotation, options, comparison);
      i += kQuaternion - 1;
      continue;
    }
    compare_golden_column(*table, column, options, comparison);
  }
  judge(options, comparison);
  return comparison;
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

Result<Comparison> verify(const std::filesystem::path& recording, const std::filesystem::path& golden,
                          const CompareOptions& options) {
  Diagnostics diagnostics;
  const auto run = Recording::open(recording);
  const auto reference = read_golden(golden);
  if (!run) diagnostics.append(run.error());
  if (!reference) diagnostics.append(reference.error());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  Comparison comparison = compare_with_golden(*run, *reference, options);
  comparison.name_a = recording.string();
  comparison.name_b = golden.string();
  return comparison;
}

}  // namespace takt::record
