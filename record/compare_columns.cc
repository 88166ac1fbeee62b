#include "record/compare_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace takt::record {

namespace {

PlotCurve plot_curve(const CurveView& curve, std::size_t points) {
  PlotCurve plot;
  for (const std::size_t i : choose_for_plot(curve, points)) {
    plot.time_s.push_back(to_seconds(curve.time[i]));
    plot.value.push_back(curve.value[i]);
  }
  return plot;
}

bool same_bits(std::span<const double> a, std::span<const double> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool same_curves(const CurveView& a, const CurveView& b) {
  return std::ranges::equal(a.time, b.time) && same_bits(a.value, b.value);
}

/// Where two curves differ most at equal times; null against value counts as infinite.
void find_max_difference(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  for (std::size_t i = 0; i < a.time.size(); ++i) {
    const double other = value_at(b, a.time[i]);
    if (std::isnan(a.value[i]) && std::isnan(other)) continue;
    double difference = std::abs(a.value[i] - other);
    if (std::isnan(difference)) difference = std::numeric_limits<double>::infinity();
    result.max_difference = std::max(result.max_difference, difference);
  }
}

void set_place(const CurveView& a, const CurveView& b, std::size_t i, ColumnComparison& result) {
  if (i >= a.time.size()) return;
  result.time = a.time[i];
  result.a = a.value[i];
  result.b = value_at(b, a.time[i]);
}

void compare_exactly(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  if (same_curves(a, b)) return;
  result.passed = false;
  result.max_deviation = result.max_difference;
  const std::size_t common = std::min(a.time.size(), b.time.size());
  std::size_t first = common;
  for (std::size_t i = common; i-- > 0;) {
    if (a.time[i] != b.time[i] || std::memcmp(&a.value[i], &b.value[i], sizeof(double)) != 0) {
      first = i;
      ++result.samples_outside;
    }
  }
  set_place(a, b, first, result);
  result.note =
      first < common ? "first difference here" : fmt::format("{} samples against {}", a.time.size(), b.time.size());
}

struct Features {
  double max = std::numeric_limits<double>::quiet_NaN(), min = max, mean = max, end = max;
};

/// The mean is over time, so that a thinned reference has the same.
Features features_of(const CurveView& curve) {
  Features f;
  double area = 0.0, span = 0.0;
  for (std::size_t i = 0; i < curve.time.size(); ++i) {
    const double v = curve.value[i];
    if (std::isnan(v)) continue;
    f.max = std::fmax(f.max, v);
    f.min = std::fmin(f.min, v);
    f.end = v;
    if (i == 0 || std::isnan(curve.value[i - 1])) continue;
    const double width = to_seconds(curve.time[i] - curve.time[i - 1]);
    area += 0.5 * (v + curve.value[i - 1]) * width;
    span += width;
  }
  if (span > 0.0) f.mean = area / span;
  return f;
}

void compare_features(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  const Features fa = features_of(a), fb = features_of(b);
  const auto add = [&](const char* name, double va, double vb) {
    const bool both_null = std::isnan(va) && std::isnan(vb);
    const double deviation = both_null ? 0.0 : std::abs(va - vb);
    const bool passed = deviation <= result.tolerance.dv;
    result.features.push_back({name, va, vb, passed});
    result.passed = result.passed && passed;
    if (!(deviation <= result.max_deviation)) {
      result.max_deviation = deviation;
      result.note = fmt::format("largest in '{}'", name);
      result.a = va;
      result.b = vb;
    }
  };
  add("max", fa.max, fb.max);
  add("min", fa.min, fb.min);
  add("mean", fa.mean, fb.mean);
  add("end", fa.end, fb.end);
}

void compare_in_tube(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  const TubeResult tube = follow_tube(a, b, result.tolerance.dt, result.tolerance.dv);
  result.max_deviation = tube.max_deviation;
  result.samples_outside = tube.outside;
  if (tube.max_deviation > 0.0) set_place(a, b, tube.at, result);
  if (result.tolerance.kind == ToleranceKind::kTube) result.passed = tube.outside == 0;
}

}  // namespace

Tolerance choose_tolerance(const std::vector<ToleranceRule>& rules, std::string_view topic, std::string_view column,
                           const Tolerance& otherwise) {
  for (const ToleranceRule& rule : rules) {
    if (matches(rule.topic, topic) && matches(rule.column, column)) return rule.tolerance;
  }
  return otherwise;
}

ColumnComparison compare_column(const ColumnId& id, const CurveView& a, const CurveView& b, const Tolerance& tolerance,
                                std::size_t plot_points) {
  ColumnComparison result;
  result.topic = id.topic;
  result.column = id.column;
  result.unit = id.unit;
  result.tolerance = tolerance;
  if (!same_curves(a, b)) {
    find_max_difference(a, b, result);
    if (plot_points > 0) result.curve_b = plot_curve(b, plot_points);
    if (tolerance.kind == ToleranceKind::kExact) {
      compare_exactly(a, b, result);
    } else if (tolerance.kind == ToleranceKind::kFeatures) {
      compare_features(a, b, result);
    } else if (a.time.empty() != b.time.empty()) {
      result.passed = tolerance.kind == ToleranceKind::kReportOnly;
      result.note = a.time.empty() ? "no samples in A" : "no samples in B";
    } else {
      compare_in_tube(a, b, result);
    }
  }
  if (plot_points > 0) result.curve_a = plot_curve(a, plot_points);
  return result;
}

ColumnComparison compare_events(std::string_view topic, const std::vector<RecordedEvent>& a,
                                const std::vector<RecordedEvent>& b, const Tolerance& tolerance) {
  ColumnComparison result;
  result.topic = topic;
  result.column = "events";
  result.unit = "s";
  result.tolerance = tolerance;
  const bool judged = tolerance.kind != ToleranceKind::kReportOnly;
  const bool exact = tolerance.kind == ToleranceKind::kExact;
  const auto name_of = [](const RecordedEvent& e) { return fmt::format("{} {}", e.source, e.name); };
  const auto fail_at = [&](Nanoseconds time, std::string note) {
    if (!result.note.empty()) return;
    result.time = time;
    result.note = std::move(note);
    result.passed = !judged;
  };
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (name_of(a[i]) != name_of(b[i])) {
      fail_at(a[i].time, fmt::format("event {} is '{}', not '{}'", i + 1, name_of(a[i]), name_of(b[i])));
      ++result.samples_outside;
      return result;
    }
    const double shift = std::abs(to_seconds(a[i].time - b[i].time));
    result.max_difference = result.max_deviation = std::max(result.max_deviation, shift);
    const bool in_time = exact ? a[i].time == b[i].time : shift <= to_seconds(tolerance.dt);
    if (in_time && (!exact || a[i].text == b[i].text)) continue;
    ++result.samples_outside;
    fail_at(a[i].time, in_time ? fmt::format("'{}' says '{}', not '{}'", name_of(a[i]), a[i].text, b[i].text)
                               : fmt::format("'{}' at {:.6f} s, not {:.6f} s", name_of(a[i]), to_seconds(a[i].time),
                                             to_seconds(b[i].time)));
  }
  if (a.size() != b.size()) {
    const auto& longer = a.size() > b.size() ? a : b;
    const RecordedEvent& extra = longer[std::min(a.size(), b.size())];
    result.samples_outside += longer.size() - std::min(a.size(), b.size());
    fail_at(extra.time, fmt::format("{} events, not {}; '{}' at {:.6f} s is only in {}", a.size(), b.size(),
                                    name_of(extra), to_seconds(extra.time), a.size() > b.size() ? "A" : "B"));
  }
  return result;
}

ColumnComparison compare_end(Nanoseconds a, Nanoseconds b, const Tolerance& tolerance) {
  ColumnComparison result;
  result.topic = "run";
  result.column = "end";
  result.unit = "s";
  result.tolerance = tolerance;
  result.a = to_seconds(a);
  result.b = to_seconds(b);
  result.time = a;
  result.max_difference = result.max_deviation = std::abs(result.a - result.b);
  if (tolerance.kind != ToleranceKind::kReportOnly) {
    result.passed = std::abs(a - b) <= (tolerance.kind == ToleranceKind::kExact ? 0 : tolerance.dt);
  }
  return result;
}

void note_differences(const Recording& a, std::string_view name_a,
                      const std::map<std::string, std::string>& fingerprint_b, Comparison& comparison) {
  for (const std::string& damage : a.damage()) comparison.notes.push_back(fmt::format("{}: {}", name_a, damage));
  const auto found = a.metadata().find("takt.fingerprint");
  const std::map<std::string, std::string> fingerprint_a =
      found == a.metadata().end() ? std::map<std::string, std::string>{} : found->second;
  for (const auto& [key, value] : fingerprint_b) {
    const auto other = fingerprint_a.find(key);
    const std::string value_a = other == fingerprint_a.end() ? "nothing" : other->second;
    if (value_a != value) comparison.notes.push_back(fmt::format("{}: '{}' in A, '{}' in B", key, value_a, value));
  }
}

void judge(const CompareOptions& options, Comparison& comparison) {
  comparison.passed = comparison.missing.empty() &&
                      std::ranges::all_of(comparison.columns, &ColumnComparison::passed) &&
                      (!options.require_equal_digests || comparison.identical);
}

}  // namespace takt::record
