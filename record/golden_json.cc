// A golden as a file: one line for each column and each event.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/json.h"
#include "record/golden.h"
#include "record/golden_curves.h"
#include "record/recording.h"

namespace takt::record {

namespace {

constexpr int kVersion = 2;
/// Samples of all columns together: reading a golden takes memory for those that others follow.
constexpr double kMostSamples = 64.0 * 1024 * 1024;

using Json = nlohmann::ordered_json;

/// The shortest decimal number of a time.
double seconds(Nanoseconds time) { return static_cast<double>(time) / 1e9; }

Nanoseconds nanoseconds(double seconds) { return static_cast<Nanoseconds>(std::llround(seconds * 1e9)); }

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

Json to_json(const Tolerance& tolerance) {
  Json json = {{"kind", kind_name(tolerance.kind)}, {"dt_s", seconds(tolerance.dt)}, {"dv", tolerance.dv}};
  if (tolerance.features == Tolerance{}.features) return json;
  json["features"] = Json::array();
  for (std::size_t i = 0; i < kFeatureCount; ++i)
    if (tolerance.features.test(i)) json["features"].push_back(std::string(name_of(static_cast<Feature>(i))));
  return json;
}

Json to_json(const GoldenCurve& curve) {
  Json json = Json::object();
  if (!curve.follows_column.empty()) json["follows"] = {curve.follows_topic, curve.follows_column};
  if (curve.rate) json["rate"] = true;
  if (curve.delay > 0) json["delay"] = curve.delay;
  if (curve.hold_every > 1) json["hold"] = {curve.hold_every, curve.hold_from};
  if (curve.pieces.empty()) return json;
  json["exponent"] = curve.exponent;
  if (curve.rate_exponent) json["rate_exponent"] = *curve.rate_exponent;
  json["pieces"] = curve.pieces;
  return json;
}

Json to_json(const GoldenColumn& column) {
  Json json{{"topic", column.topic},
            {"column", column.column},
            {"unit", column.unit},
            {"tolerance", to_json(column.tolerance)},
            {"thinning", column.thinning}};
  if (column.curve) {
    json["curve"] = to_json(*column.curve);
    return json;
  }
  json["time_s"] = column.time_s;
  json["value"] = Json::array();
  for (const double value : column.value) json["value"].push_back(std::isnan(value) ? Json(nullptr) : Json(value));
  return json;
}

/// [source, name, time in s, number of its step], and the topic where it is not that of the program.
Json to_json(const GoldenEvent& event, const std::vector<std::string>& steps) {
  const auto step = std::ranges::find(steps, event.step);
  Json json{event.source, event.name, event.time_s, step == steps.end() ? -1 : step - steps.begin()};
  if (event.topic != kProgramTopic) json.push_back(event.topic);
  return json;
}

/// Each once, in the order in which they first happen.
std::vector<std::string> paths_of(const std::vector<GoldenEvent>& events) {
  std::vector<std::string> steps;
  for (const GoldenEvent& event : events)
    if (!event.step.empty() && std::ranges::find(steps, event.step) == steps.end()) steps.push_back(event.step);
  return steps;
}

Json to_json(const Golden& golden) {
  Json json;
  json["takt_golden"] = kVersion;
  json["scenario"] = golden.scenario;
  json["reason"] = golden.reason;
  json["fingerprint"] = golden.fingerprint;
  json["cycles"] = golden.cycles;
  json["end_s"] = golden.end_s;
  json["digest"] = golden.digest;
  json["event_tolerance"] = to_json(golden.event_tolerance);
  const std::vector<std::string> steps = paths_of(golden.events);
  json["steps"] = steps;
  json["events"] = Json::array();
  for (const GoldenEvent& event : golden.events) json["events"].push_back(to_json(event, steps));
  json["grids"] = Json::array();
  for (const auto& [topic, grid] : golden.grids)
    json["grids"].push_back({{"topic", topic},
                             {"start_s", seconds(grid.start)},
                             {"period_s", seconds(grid.period)},
                             {"samples", grid.samples}});
  json["columns"] = Json::array();
  for (const GoldenColumn& column : golden.columns) json["columns"].push_back(to_json(column));
  return json;
}

/// A whole number from 0 on.
bool is_count(const Json& json) { return json.is_number_integer() && json.get<double>() >= 0.0; }

/// Reads members with a type; every miss is a diagnostic at its pointer.
class MemberReader {
 public:
  explicit MemberReader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  std::string text(const Json& json, const std::string& at, const char* key) {
    const auto* member = find(json, at, key);
    if (member == nullptr) return {};
    if (member->is_string()) return member->get<std::string>();
    wrong(at, key, "a text");
    return {};
  }
  double number(const Json& json, const std::string& at, const char* key) {
    const auto* member = find(json, at, key);
    if (member == nullptr) return 0.0;
    if (member->is_number()) return member->get<double>();
    wrong(at, key, "a number");
    return 0.0;
  }
  const Json& list(const Json& json, const std::string& at, const char* key) {
    static const Json kEmpty = Json::array();
    const auto* member = find(json, at, key);
    if (member == nullptr) return kEmpty;
    if (member->is_array()) return *member;
    wrong(at, key, "an array");
    return kEmpty;
  }
  std::vector<double> numbers(const Json& json, const std::string& at, const char* key) {
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
  /// A whole number from 0 on, if it is there.
  std::size_t count(const Json& json, const std::string& at, const char* key, std::size_t otherwise) {
    if (!json.is_object() || !json.contains(key)) return otherwise;
    const Json& member = json.at(key);
    if (is_count(member)) return member.get<std::size_t>();
    wrong(at, key, "a whole number");
    return otherwise;
  }
  /// A power of ten.
  int exponent(const Json& json, const std::string& at, const char* key) {
    const double value = number(json, at, key);
    const bool fits = std::abs(value) <= 30.0 && value == std::floor(value);
    if (!fits) diagnostics_.error(Code::kOutOfRange, at + pointer_segment(key), "no exponent", "Choose -30 to 30");
    return fits ? static_cast<int>(value) : 0;
  }
  /// A list of so many members of one kind.
  const Json* list_of(const Json& json, const std::string& at, const char* key, std::size_t size) {
    const Json& all = list(json, at, key);
    if (all.size() == size) return &all;
    diagnostics_.error(Code::kWrongSize, at + pointer_segment(key), fmt::format("{} members", all.size()),
                       fmt::format("{} members", size));
    return nullptr;
  }
  Tolerance tolerance(const Json& json, const std::string& at, const char* key) {
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
  const Json* find(const Json& json, const std::string& at, const char* key) {
    if (json.is_object()) {
      if (const auto found = json.find(key); found != json.end()) return &*found;
    }
    diagnostics_.error(Code::kMissing, at, fmt::format("'{}' is missing", key));
    return nullptr;
  }
  void wrong(const std::string& at, const char* key, const char* wanted) {
    diagnostics_.error(Code::kWrongType, at + pointer_segment(key), "the value has another type",
                       fmt::format("Give the type {}", wanted));
  }

  Diagnostics& diagnostics_;
};

GoldenCurve read_curve(MemberReader& read, const Json& json, const std::string& at, Diagnostics& diagnostics) {
  GoldenCurve curve;
  if (json.contains("follows")) {
    const Json* names = read.list_of(json, at, "follows", 2);
    if (names != nullptr && names->at(0).is_string() && names->at(1).is_string()) {
      curve.follows_topic = names->at(0).get<std::string>();
      curve.follows_column = names->at(1).get<std::string>();
    } else if (names != nullptr) {
      diagnostics.error(Code::kWrongType, at + "/follows", "the value has another type", "Write [topic, column]");
    }
  }
  curve.rate = json.value("rate", Json(false)) == true;
  curve.delay = read.count(json, at, "delay", 0);
  if (json.contains("hold")) {
    const Json* hold = read.list_of(json, at, "hold", 2);
    const bool whole = hold != nullptr && is_count(hold->at(0)) && is_count(hold->at(1));
    if (whole) {
      curve.hold_every = std::max<std::size_t>(1, hold->at(0).get<std::size_t>());
      curve.hold_from = hold->at(1).get<std::size_t>();
    } else {
      diagnostics.error(Code::kWrongType, at + "/hold", "the value has another type", "Write [samples, first sample]");
    }
  }
  if (json.contains("pieces")) {
    curve.pieces = read.text(json, at, "pieces");
    curve.exponent = read.exponent(json, at, "exponent");
    if (json.contains("rate_exponent")) curve.rate_exponent = read.exponent(json, at, "rate_exponent");
  }
  return curve;
}

GoldenColumn read_column(MemberReader& read, const Json& json, const std::string& at, Diagnostics& diagnostics) {
  GoldenColumn column;
  column.topic = read.text(json, at, "topic");
  column.column = read.text(json, at, "column");
  column.unit = read.text(json, at, "unit");
  column.tolerance = read.tolerance(json, at, "tolerance");
  column.thinning = read.number(json, at, "thinning");
  if (json.is_object() && json.contains("curve")) {
    if (!json.at("curve").is_object()) {
      diagnostics.error(Code::kWrongType, at + "/curve", "the value has another type", "Give an object");
    } else {
      column.curve = read_curve(read, json.at("curve"), at + "/curve", diagnostics);
    }
    return column;
  }
  column.time_s = read.numbers(json, at, "time_s");
  column.value = read.numbers(json, at, "value");
  if (column.time_s.size() != column.value.size()) {
    diagnostics.error(Code::kWrongSize, at,
                      fmt::format("{} times and {} values", column.time_s.size(), column.value.size()));
  }
  const bool ascending = std::ranges::is_sorted(column.time_s) &&
                         std::ranges::none_of(column.time_s, [](double t) { return std::isnan(t); });
  if (!ascending) diagnostics.error(Code::kOutOfRange, at + "/time_s", "times do not ascend");
  return column;
}

GoldenEvent read_event(const Json& json, const std::vector<std::string>& steps, const std::string& at,
                       Diagnostics& diagnostics) {
  const bool fits = json.is_array() && (json.size() == 4 || json.size() == 5) && json[0].is_string() &&
                    json[1].is_string() && json[2].is_number() && json[3].is_number_integer() &&
                    (json.size() == 4 || json[4].is_string());
  if (!fits) {
    diagnostics.error(Code::kWrongType, at, "the value has another type",
                      "Write [source, name, time, step] and a topic");
    return {};
  }
  GoldenEvent event{.topic = json.size() == 5 ? json[4].get<std::string>() : std::string(kProgramTopic),
                    .source = json[0].get<std::string>(),
                    .name = json[1].get<std::string>(),
                    .time_s = json[2].get<double>()};
  const auto step = json[3].get<std::int64_t>();
  if (step >= static_cast<std::int64_t>(steps.size()))
    diagnostics.error(Code::kOutOfRange, at + "/3", fmt::format("there is no step {}", step),
                      fmt::format("Choose a number below {}, or -1", steps.size()));
  if (step >= 0 && step < static_cast<std::int64_t>(steps.size())) event.step = steps[static_cast<std::size_t>(step)];
  return event;
}

void read_grids(MemberReader& read, const Json& json, Golden& golden, Diagnostics& diagnostics) {
  std::size_t i = 0;
  for (const Json& item : read.list(json, "", "grids")) {
    const std::string at = fmt::format("/grids/{}", i++);
    const double start = read.number(item, at, "start_s"), period = read.number(item, at, "period_s");
    const GoldenGrid grid{.start = nanoseconds(std::clamp(start, -1e9, 1e9)),
                          .period = nanoseconds(std::clamp(period, 0.0, 1e6)),
                          .samples = read.count(item, at, "samples", 0)};
    if (grid.period <= 0)
      diagnostics.error(Code::kOutOfRange, at + "/period_s", "no period", "Choose a time above 0 s");
    golden.grids[read.text(item, at, "topic")] = grid;
  }
}

/// Whether all curves can be had: each piece read, each column that is followed found.
void check_curves(const Golden& golden, Diagnostics& diagnostics) {
  double samples = 0.0;
  for (const GoldenColumn& column : golden.columns) {
    const auto grid = golden.grids.find(column.topic);
    if (column.curve && grid != golden.grids.end()) samples += static_cast<double>(grid->second.samples);
  }
  if (samples > kMostSamples) {
    diagnostics.error(Code::kTooLarge, "/columns", fmt::format("{} samples in all", samples),
                      fmt::format("Keep it to at most {}", kMostSamples));
    return;
  }
  GoldenReader reader(golden);
  for (std::size_t i = 0; i < golden.columns.size(); ++i)
    if (!reader.read(golden.columns[i]))
      diagnostics.error(Code::kInvalidValue, fmt::format("/columns/{}/curve", i), "this is no curve on its grid",
                        "Bless the scenario again");
}

}  // namespace

std::string golden_to_text(const Golden& golden) {
  // One line per column and event: differences stay readable in a review.
  const Json json = to_json(golden);
  std::string text = "{";
  for (auto member = json.begin(); member != json.end(); ++member) {
    text += fmt::format("{}\n  {}: ", member == json.begin() ? "" : ",", Json(member.key()).dump());
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

Result<Golden> golden_from_json(const Json& json) {
  Diagnostics diagnostics;
  MemberReader read(diagnostics);
  if (!json.is_object() || !json.contains("takt_golden"))
    return failure(Code::kMissing, "", "this is not a golden: 'takt_golden' is missing");
  if (json.at("takt_golden") != kVersion)
    return failure(Code::kIncompatible, "/takt_golden",
                   fmt::format("version {} of goldens is not read", json.at("takt_golden").dump()),
                   fmt::format("Bless the scenario again, which writes version {}", kVersion));
  Golden golden;
  golden.scenario = read.text(json, "", "scenario");
  golden.reason = read.text(json, "", "reason");
  golden.cycles = static_cast<std::uint64_t>(std::clamp(read.number(json, "", "cycles"), 0.0, 1e15));
  golden.end_s = read.number(json, "", "end_s");
  golden.digest = read.text(json, "", "digest");
  golden.event_tolerance = read.tolerance(json, "", "event_tolerance");
  if (json.contains("fingerprint") && json.at("fingerprint").is_object()) {
    for (const auto& [key, value] : json.at("fingerprint").items()) {
      if (value.is_string()) golden.fingerprint[key] = value.get<std::string>();
    }
  }
  std::vector<std::string> steps;
  for (const Json& step : read.list(json, "", "steps"))
    steps.push_back(step.is_string() ? step.get<std::string>() : std::string());
  std::size_t i = 0;
  for (const Json& event : read.list(json, "", "events"))
    golden.events.push_back(read_event(event, steps, fmt::format("/events/{}", i++), diagnostics));
  read_grids(read, json, golden, diagnostics);
  i = 0;
  for (const Json& item : read.list(json, "", "columns"))
    golden.columns.push_back(read_column(read, item, fmt::format("/columns/{}", i++), diagnostics));
  if (!diagnostics.has_errors()) check_curves(golden, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return golden;
}

}  // namespace takt::record
