// The verdict of a comparison for a terminal and for machines.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

std::string to_text(const Comparison& comparison, std::size_t most) {
  std::string text = fmt::format("{}: {} against {}\n{}\n", verdict_text(comparison), comparison.name_a,
                                 comparison.name_b, digest_text(comparison));
  const auto add_limited = [&](std::size_t count, auto&& line_of) {
    for (std::size_t i = 0; i < std::min(count, most); ++i) text += line_of(i);
    if (count > most) text += fmt::format("  ... and {} more\n", count - most);
  };
  add_limited(comparison.missing.size(),
              [&](std::size_t i) { return fmt::format("missing: {}\n", comparison.missing[i]); });
  std::vector<const ColumnComparison*> failed;
  for (const ColumnComparison& column : comparison.columns) {
    if (!column.passed) failed.push_back(&column);
  }
  add_limited(failed.size(), [&](std::size_t i) {
    const ColumnComparison& c = *failed[i];
    return fmt::format("outside: {} {}: {:.4g}{} at {:.4f} s (tolerance {}){}\n", c.topic, c.column, c.max_deviation,
                       c.unit.empty() ? "" : " " + c.unit, to_seconds(c.time), tolerance_text(c),
                       c.note.empty() ? "" : "; " + c.note);
  });
  const auto judged = std::ranges::count_if(
      comparison.columns, [](const ColumnComparison& c) { return c.tolerance.kind != ToleranceKind::kReportOnly; });
  text += fmt::format("{} columns judged, {} outside\n", judged, failed.size());
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
                              {"samples_outside", c.samples_outside}};
  if (!c.note.empty()) json["note"] = c.note;
  for (const FeatureDifference& f : c.features) {
    json["features"].push_back(
        {{"name", f.name}, {"a", number(f.a)}, {"b", number(f.b)}, {"judged", f.judged}, {"passed", f.passed}});
  }
  return json;
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
  json["missing"] = c.missing;
  json["notes"] = c.notes;
  json["columns"] = nlohmann::ordered_json::array();
  for (const ColumnComparison& column : c.columns) json["columns"].push_back(to_json(column));
  return json;
}

}  // namespace takt::record
