// The verdict of a comparison for a terminal and for machines.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "record/compare.h"
#include "record/report_parts.h"

namespace takt::record {

std::string tolerance_text(const ColumnComparison& c) {
  const std::string ms = fmt::format("{:g} ms", 1e3 * to_seconds(c.tolerance.dt));
  const std::string unit = c.unit.empty() ? "" : " " + c.unit;
  const bool in_time = c.unit == "s" && (c.column == "events" || c.column == "end");
  switch (c.tolerance.kind) {
    case ToleranceKind::kExact:
      return "exact";
    case ToleranceKind::kTube:
      return in_time ? "± " + ms : fmt::format("± {:g}{}, ± {}", c.tolerance.dv, unit, ms);
    case ToleranceKind::kFeatures:
      return fmt::format("features ± {:g}{}", c.tolerance.dv, unit);
    case ToleranceKind::kReportOnly:
      return "not judged";
  }
  return "";
}

std::string verdict_text(const Comparison& comparison) {
  if (comparison.identical && comparison.passed) return "identical";
  return comparison.passed ? "same within tolerances" : "different";
}

std::string digest_text(const Comparison& c) {
  if (!c.digests_compared) return "no digests to compare";
  if (c.identical) return fmt::format("digests equal over {} cycles", c.cycles_a);
  if (!c.first_difference) return fmt::format("digests differ; {} cycles against {}", c.cycles_a, c.cycles_b);
  const DigestDifference& first = *c.first_difference;
  std::string text = fmt::format("digests equal before cycle {}, which differs at {:.6f} s: {:016x} against {:016x}",
                                 first.cycle, to_seconds(first.time), first.a, first.b);
  const std::string& where = first.bit.empty() ? first.block : first.bit;
  if (!where.empty()) text += "; first in " + where;
  return text;
}

std::string departure_text(const Departure& departure) {
  std::string text = fmt::format("{:.3f} s", to_seconds(departure.time));
  if (!departure.step.empty()) text += fmt::format(", step '{}'", departure.step);
  text += fmt::format(": {} {}", departure.topic, departure.column);
  const std::string unit = departure.unit.empty() ? "" : " " + departure.unit;
  if (!std::isnan(departure.a) || !std::isnan(departure.b))
    text += fmt::format(" is {:.5g}{}, not {:.5g}{}", departure.a, unit, departure.b, unit);
  if (!departure.note.empty()) text += "; " + departure.note;
  return text;
}

std::string duration_text(const StepDuration& step) {
  const auto begins = fmt::format("'{}', from {:.3f} s on: ", step.step, to_seconds(step.begin));
  if (!step.b) return begins + fmt::format("{:.3f} s, only in A", to_seconds(*step.a));
  if (!step.a) return begins + fmt::format("{:.3f} s, only in B", to_seconds(*step.b));
  return begins + fmt::format("{:.3f} s, not {:.3f} s ({:+.3f} s)", to_seconds(*step.a), to_seconds(*step.b),
                              to_seconds(*step.a - *step.b));
}

std::string difference_text(const ScenarioDifference& difference) {
  const std::string& pointer = difference.pointer.empty() ? "(the whole)" : difference.pointer;
  if (difference.a.empty()) return fmt::format("{}: only in B: {}", pointer, difference.b);
  if (difference.b.empty()) return fmt::format("{}: only in A: {}", pointer, difference.a);
  return fmt::format("{}: {}, not {}", pointer, difference.a, difference.b);
}

std::string share_text(const Comparison& c) {
  const auto share = [](const JudgedShare& s) {
    return fmt::format("{} of {} channels, {} of {} messages", s.channels, s.channels_in_file, s.messages,
                       s.messages_in_file);
  };
  const std::string text = fmt::format("of A {}", share(c.judged_a));
  return c.judged_b.channels_in_file > 0 || c.judged_b.messages_in_file > 0
             ? fmt::format("{}; of B {}", text, share(c.judged_b))
             : text;
}

std::vector<const ColumnComparison*> failed_columns(const Comparison& comparison) {
  std::vector<const ColumnComparison*> failed;
  for (const ColumnComparison& column : comparison.columns)
    if (!column.passed) failed.push_back(&column);
  static constexpr Nanoseconds kLast = std::numeric_limits<Nanoseconds>::max();
  std::ranges::stable_sort(failed, {}, [](const ColumnComparison* c) { return c->first_outside.value_or(kLast); });
  return failed;
}

std::vector<const StepDuration*> other_durations(const Comparison& comparison) {
  std::vector<const StepDuration*> others;
  for (const StepDuration& step : comparison.durations)
    if (!step.same) others.push_back(&step);
  std::ranges::stable_sort(others, {}, [](const StepDuration* step) { return step->begin; });
  return others;
}

std::string to_text(const Comparison& comparison, std::size_t most) {
  std::string text = fmt::format("{}: {} against {}\n", verdict_text(comparison), comparison.name_a, comparison.name_b);
  if (comparison.departure) text += fmt::format("first departure: {}\n", departure_text(*comparison.departure));
  const auto add_limited = [&](std::size_t count, auto&& line_of) {
    for (std::size_t i = 0; i < std::min(count, most); ++i) text += line_of(i);
    if (count > most) text += fmt::format("  ... and {} more\n", count - most);
  };
  const auto others = other_durations(comparison);
  add_limited(others.size(), [&](std::size_t i) { return fmt::format("duration: {}\n", duration_text(*others[i])); });
  add_limited(comparison.scenario_differences.size(), [&](std::size_t i) {
    return fmt::format("scenario: {}\n", difference_text(comparison.scenario_differences[i]));
  });
  text += digest_text(comparison) + "\n";
  add_limited(comparison.missing.size(),
              [&](std::size_t i) { return fmt::format("missing: {}\n", comparison.missing[i]); });
  const auto failed = failed_columns(comparison);
  add_limited(failed.size(), [&](std::size_t i) {
    const ColumnComparison& c = *failed[i];
    const std::string first = c.first_outside && *c.first_outside != c.time
                                  ? fmt::format("from {:.4f} s, ", to_seconds(*c.first_outside))
                                  : "";
    return fmt::format("outside: {} {}: {}{:.4g}{} at {:.4f} s (tolerance {}){}\n", c.topic, c.column, first,
                       c.max_deviation, c.unit.empty() ? "" : " " + c.unit, to_seconds(c.time), tolerance_text(c),
                       c.note.empty() ? "" : "; " + c.note);
  });
  const auto judged = std::ranges::count_if(
      comparison.columns, [](const ColumnComparison& c) { return c.tolerance.kind != ToleranceKind::kReportOnly; });
  text += fmt::format("{} columns judged, {} outside: {}\n", judged, failed.size(), share_text(comparison));
  if (!comparison.not_judged.empty()) text += fmt::format("not judged: {}\n", fmt::join(comparison.not_judged, ", "));
  add_limited(comparison.notes.size(), [&](std::size_t i) { return fmt::format("note: {}\n", comparison.notes[i]); });
  return text;
}

namespace {

/// JSON has no infinity; null says that there is no number.
nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json to_json(const ColumnComparison& c) {
  nlohmann::ordered_json json{{"topic", c.topic},
                              {"column", c.column},
                              {"unit", c.unit},
                              {"tolerance", tolerance_text(c)},
                              {"passed", c.passed},
                              {"max_deviation", number(c.max_deviation)},
                              {"max_difference", number(c.max_difference)},
                              {"time_s", to_seconds(c.time)},
                              {"a", number(c.a)},
                              {"b", number(c.b)},
                              {"samples_outside", c.samples_outside},
                              {"first_outside_s", nullptr}};
  if (c.first_outside) json["first_outside_s"] = to_seconds(*c.first_outside);
  if (!c.note.empty()) json["note"] = c.note;
  for (const FeatureDifference& f : c.features) {
    json["features"].push_back(
        {{"name", f.name}, {"a", number(f.a)}, {"b", number(f.b)}, {"judged", f.judged}, {"passed", f.passed}});
  }
  return json;
}

nlohmann::ordered_json to_json(const Departure& departure) {
  nlohmann::ordered_json json{{"time_s", to_seconds(departure.time)},
                              {"step", departure.step},
                              {"topic", departure.topic},
                              {"column", departure.column},
                              {"unit", departure.unit},
                              {"a", number(departure.a)},
                              {"b", number(departure.b)}};
  if (!departure.note.empty()) json["note"] = departure.note;
  return json;
}

nlohmann::ordered_json to_json(const StepDuration& step) {
  const auto seconds = [](const std::optional<Nanoseconds>& time) {
    return time ? nlohmann::ordered_json(to_seconds(*time)) : nlohmann::ordered_json(nullptr);
  };
  return {{"step", step.step},
          {"begin_s", to_seconds(step.begin)},
          {"a_s", seconds(step.a)},
          {"b_s", seconds(step.b)},
          {"same", step.same}};
}

nlohmann::ordered_json to_json(const JudgedShare& share) {
  return {{"channels", share.channels},
          {"channels_in_file", share.channels_in_file},
          {"messages", share.messages},
          {"messages_in_file", share.messages_in_file}};
}

}  // namespace

nlohmann::ordered_json to_json(const Comparison& c) {
  nlohmann::ordered_json json{{"a", c.name_a},
                              {"b", c.name_b},
                              {"passed", c.passed},
                              {"identical", c.identical},
                              {"cycles_a", c.cycles_a},
                              {"cycles_b", c.cycles_b},
                              {"end_a_s", to_seconds(c.end_a)},
                              {"end_b_s", to_seconds(c.end_b)}};
  json["first_difference"] = nullptr;
  if (c.first_difference) {
    json["first_difference"] = {{"cycle", c.first_difference->cycle},
                                {"time_s", to_seconds(c.first_difference->time)},
                                {"digest_a", fmt::format("{:016x}", c.first_difference->a)},
                                {"digest_b", fmt::format("{:016x}", c.first_difference->b)},
                                {"block", c.first_difference->block},
                                {"bit", c.first_difference->bit}};
  }
  json["departure"] = c.departure ? to_json(*c.departure) : nlohmann::ordered_json(nullptr);
  json["durations"] = nlohmann::ordered_json::array();
  for (const StepDuration& step : c.durations) json["durations"].push_back(to_json(step));
  json["scenario_differences"] = nlohmann::ordered_json::array();
  for (const ScenarioDifference& one : c.scenario_differences)
    json["scenario_differences"].push_back({{"pointer", one.pointer}, {"a", one.a}, {"b", one.b}});
  json["judged"] = {{"a", to_json(c.judged_a)}, {"b", to_json(c.judged_b)}};
  json["not_judged"] = c.not_judged;
  json["missing"] = c.missing;
  json["notes"] = c.notes;
  json["columns"] = nlohmann::ordered_json::array();
  for (const ColumnComparison& column : c.columns) json["columns"].push_back(to_json(column));
  return json;
}

}  // namespace takt::record
