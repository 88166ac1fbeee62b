#include "record/compare_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>

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
  result.first_outside = result.time;
  result.first_a = result.a;
  result.first_b = result.b;
  result.note =
      first < common ? "first difference here" : fmt::format("{} samples against {}", a.time.size(), b.time.size());
}

constexpr double kNoFeature = std::numeric_limits<double>::quiet_NaN();

/// The way up and down, where turns smaller than `band` count as noise, and how often it turns.
struct Way {
  double length = 0.0;
  int turns = 0;
};

Way way_of(const CurveView& curve, double band) {
  Way way;
  double begin = kNoFeature, low = kNoFeature, high = kNoFeature;  // of the present rise or fall; its extremes
  int direction = 0;
  const auto turn = [&](int to, double at) {
    if (direction != 0) {
      way.length += std::abs(at - begin);
      ++way.turns;
    }
    begin = at;
    direction = to;
  };
  for (const double v : curve.value) {
    if (std::isnan(v)) continue;
    low = std::fmin(low, v);
    high = std::fmax(high, v);
    if (direction <= 0 && v - low > band) {
      turn(1, low);
      high = v;
    } else if (direction >= 0 && high - v > band) {
      turn(-1, high);
      low = v;
    }
  }
  if (direction != 0) way.length += std::abs((direction > 0 ? high : low) - begin);
  return way;
}

/// From when on it stays within `band` of its last value, s.
double settling_of(const CurveView& curve, double band, double last) {
  double settled = kNoFeature;
  for (std::size_t i = 0; i < curve.time.size(); ++i) {
    if (std::isnan(curve.value[i])) continue;
    if (std::abs(curve.value[i] - last) > band) {
      settled = kNoFeature;
    } else if (std::isnan(settled)) {
      settled = to_seconds(curve.time[i]);
    }
  }
  return settled;
}

double duration_of(const CurveView& curve) {
  const auto is_value = [](double v) { return !std::isnan(v); };
  const auto first = std::ranges::find_if(curve.value, is_value);
  if (first == curve.value.end()) return kNoFeature;
  const auto begin = static_cast<std::size_t>(first - curve.value.begin());
  std::size_t end = curve.value.size() - 1;
  while (std::isnan(curve.value[end])) --end;
  return to_seconds(curve.time[end] - curve.time[begin]);
}

struct Features {
  std::array<double, kFeatureCount> value;
  int turns = 0;
  double& operator[](Feature feature) { return value[static_cast<std::size_t>(feature)]; }
};

/// The mean is over time, so that a thinned reference has the same.
Features features_of(const CurveView& curve, double band) {
  Features f;
  f.value.fill(kNoFeature);
  double area = 0.0, span = 0.0;
  for (std::size_t i = 0; i < curve.time.size(); ++i) {
    const double v = curve.value[i];
    if (std::isnan(v)) continue;
    f[Feature::kMax] = std::fmax(f[Feature::kMax], v);
    f[Feature::kMin] = std::fmin(f[Feature::kMin], v);
    f[Feature::kPeak] = std::fmax(f[Feature::kPeak], std::abs(v));
    f[Feature::kEnd] = v;
    if (i == 0 || std::isnan(curve.value[i - 1])) continue;
    const double width = to_seconds(curve.time[i] - curve.time[i - 1]);
    area += 0.5 * (v + curve.value[i - 1]) * width;
    span += width;
  }
  if (span > 0.0) f[Feature::kMean] = area / span;
  const Way way = way_of(curve, band);
  f[Feature::kPath] = way.length;
  f.turns = way.turns;
  f[Feature::kSettling] = settling_of(curve, band, f[Feature::kEnd]);
  f[Feature::kDuration] = duration_of(curve);
  return f;
}

/// How far a feature may be off, in its own unit.
double freedom_of(Feature feature, const Tolerance& tolerance, int turns) {
  if (feature == Feature::kSettling || feature == Feature::kDuration) return to_seconds(tolerance.dt);
  return feature == Feature::kPath ? 2.0 * tolerance.dv * (turns + 1) : tolerance.dv;
}

void compare_features(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  const Features fa = features_of(a, result.tolerance.dv), fb = features_of(b, result.tolerance.dv);
  double worst = 0.0;  // in its tolerance
  for (std::size_t i = 0; i < kFeatureCount; ++i) {
    const auto feature = static_cast<Feature>(i);
    const double va = fa.value[i], vb = fb.value[i];
    const bool both_null = std::isnan(va) && std::isnan(vb);
    const double deviation = both_null ? 0.0 : std::abs(va - vb);
    const double freedom = freedom_of(feature, result.tolerance, fb.turns);
    const bool judged = result.tolerance.features.test(i), passed = deviation <= freedom || !judged;
    result.features.push_back({std::string(name_of(feature)), va, vb, passed, judged});
    result.passed = result.passed && passed;
    const double share = freedom > 0.0 ? deviation / freedom : deviation;
    if (!judged || share <= worst) continue;
    worst = std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
    result.max_deviation = deviation;
    result.note = fmt::format("largest in '{}'", name_of(feature));
    result.a = va;
    result.b = vb;
  }
}

void compare_in_tube(const CurveView& a, const CurveView& b, ColumnComparison& result) {
  const TubeResult tube = follow_tube(a, b, result.tolerance.dt, result.tolerance.dv);
  result.max_deviation = tube.max_deviation;
  result.samples_outside = tube.outside;
  if (tube.max_deviation > 0.0) set_place(a, b, tube.at, result);
  if (result.tolerance.kind != ToleranceKind::kTube || tube.outside == 0) return;
  result.passed = false;
  result.first_outside = a.time[tube.first];
  result.first_a = a.value[tube.first];
  result.first_b = value_at(b, a.time[tube.first]);
}

using Quaternion = std::array<double, 4>;

Quaternion orientation_at(const RotationView& curve, Nanoseconds time) {
  Quaternion q;
  for (std::size_t k = 0; k < 4; ++k) q[k] = value_at({curve.time, curve.wxyz[k]}, time);
  return q;
}

/// Between two orientations, rad; q and -q are the same one.
double angle_between(const Quaternion& p, const Quaternion& q) {
  if (p == q) return 0.0;
  const double w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  const double x = p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2];
  const double y = p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1];
  const double z = p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0];
  return 2.0 * std::atan2(std::hypot(x, y, z), std::abs(w));
}

/// The least angle to the reference within dt of a time.
double least_angle(const Quaternion& q, const RotationView& reference, Nanoseconds time, Nanoseconds dt) {
  double least = angle_between(q, orientation_at(reference, time));
  const auto try_at = [&](Nanoseconds t) { least = std::fmin(least, angle_between(q, orientation_at(reference, t))); };
  try_at(time - dt);
  try_at(time + dt);
  auto sample = std::ranges::lower_bound(reference.time, time - dt);
  for (; sample != reference.time.end() && *sample <= time + dt; ++sample) try_at(*sample);
  return least;
}

bool same_rotations(const RotationView& a, const RotationView& b) {
  bool same = true;
  for (std::size_t k = 0; k < 4; ++k) same = same && same_curves({a.time, a.wxyz[k]}, {b.time, b.wxyz[k]});
  return same;
}

}  // namespace

std::vector<StepMark> steps_of(const Recording& recording) {
  constexpr std::size_t kMost = 1000;
  std::vector<StepMark> steps;
  recording.for_each_event(kProgramTopic, [&steps](const RecordedEvent& event) {
    if (event.source == "program" && event.name == "begin") steps.push_back({to_seconds(event.time), event.text});
    return steps.size() < kMost;
  });
  return steps;
}

std::string_view name_of(Feature feature) {
  static constexpr std::array<std::string_view, kFeatureCount> kNames = {"max",  "min",      "mean", "end",
                                                                         "peak", "settling", "path", "duration"};
  return kNames[static_cast<std::size_t>(feature)];
}

std::vector<std::string> feature_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kFeatureCount; ++i) names.emplace_back(name_of(static_cast<Feature>(i)));
  return names;
}

void judge_feature(const std::string& name, const std::string& pointer, FeatureSet& features,
                   Diagnostics& diagnostics) {
  const std::vector<std::string> names = feature_names();
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) {
    features.set(static_cast<std::size_t>(found - names.begin()));
    return;
  }
  diagnostics.error(Code::kUnknownName, pointer, fmt::format("'{}' is not a feature", name),
                    nearest_choice(name, names));
}

std::optional<std::string> rotation_at(std::span<const std::string> columns, std::size_t first) {
  constexpr std::array<std::string_view, 4> kParts = {".qw", ".qx", ".qy", ".qz"};
  if (first + kParts.size() > columns.size() || !columns[first].ends_with(kParts[0])) return std::nullopt;
  std::string frame = columns[first].substr(0, columns[first].size() - kParts[0].size());
  for (std::size_t k = 1; k < kParts.size(); ++k)
    if (columns[first + k] != frame + std::string(kParts[k])) return std::nullopt;
  return frame;
}

ColumnComparison compare_rotation(const ColumnId& id, const RotationView& a, const RotationView& b,
                                  const Tolerance& tolerance, std::size_t plot_points) {
  std::vector<double> free(a.time.size()), none(a.time.size(), 0.0);
  double greatest = 0.0;
  const bool same = same_rotations(a, b);
  for (std::size_t i = 0; i < a.time.size() && !same; ++i) {
    const Quaternion q = orientation_at(a, a.time[i]), other = orientation_at(b, a.time[i]);
    if (std::isnan(q[0]) && std::isnan(other[0])) none[i] = kNoFeature;
    const double now = angle_between(q, other);
    greatest =
        std::isnan(now) && !std::isnan(none[i]) ? std::numeric_limits<double>::infinity() : std::fmax(greatest, now);
    free[i] = least_angle(q, b, a.time[i], tolerance.kind == ToleranceKind::kTube ? tolerance.dt : 0);
  }
  Tolerance at_once = tolerance;
  at_once.dt = tolerance.kind == ToleranceKind::kTube ? 0 : tolerance.dt;
  ColumnComparison result = compare_column(id, {a.time, free}, {a.time, none}, at_once, plot_points);
  result.tolerance = tolerance;
  result.max_difference = greatest;
  return result;
}

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
                                const std::vector<RecordedEvent>& b, const Tolerance& tolerance, Texts texts) {
  ColumnComparison result;
  result.topic = topic;
  result.column = "events";
  result.unit = "s";
  result.tolerance = tolerance;
  const bool judged = tolerance.kind != ToleranceKind::kReportOnly;
  const bool exact = tolerance.kind == ToleranceKind::kExact, with_texts = exact || texts == Texts::kJudged;
  const auto name_of = [](const RecordedEvent& e) { return fmt::format("{} {}", e.source, e.name); };
  const auto fail_at = [&](Nanoseconds time, std::string note) {
    if (!result.note.empty()) return;
    result.time = time;
    result.note = std::move(note);
    result.passed = !judged;
    if (judged) result.first_outside = time;
  };
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (name_of(a[i]) != name_of(b[i])) {
      fail_at(std::min(a[i].time, b[i].time),
              fmt::format("event {} is '{}', not '{}'", i + 1, name_of(a[i]), name_of(b[i])));
      ++result.samples_outside;
      return result;
    }
    const double shift = std::abs(to_seconds(a[i].time - b[i].time));
    result.max_difference = result.max_deviation = std::max(result.max_deviation, shift);
    const bool in_time = exact ? a[i].time == b[i].time : shift <= to_seconds(tolerance.dt);
    if (in_time && (!with_texts || a[i].text == b[i].text)) continue;
    ++result.samples_outside;
    fail_at(std::min(a[i].time, b[i].time),
            in_time ? fmt::format("'{}' says '{}', not '{}'", name_of(a[i]), a[i].text, b[i].text)
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
  if (!result.passed) result.first_outside = std::min(a, b);
  return result;
}

void note_missing(std::string text, Comparison& comparison) {
  constexpr std::size_t kMost = 10'000;  // nobody reads more
  if (comparison.missing.size() < kMost) comparison.missing.push_back(std::move(text));
}

void note_damage(const Recording& recording, std::string_view name, Comparison& comparison) {
  for (const std::string& lost : recording.lost()) note_missing(fmt::format("{}: {}", name, lost), comparison);
  if (recording.truncated_at())
    comparison.notes.push_back(fmt::format("{}: truncated at byte {}", name, *recording.truncated_at()));
}

void note_lost_rows(const Recording& recording, const std::string& topic, std::size_t rows, std::string_view name,
                    Comparison& comparison) {
  const std::size_t messages = recording.rows(topic);
  if (rows < messages)
    note_missing(fmt::format("{}: {} of {} messages of '{}' cannot be read", name, messages - rows, messages, topic),
                 comparison);
}

void note_lost_rows(const Recording& recording, const Table& table, std::string_view name, Comparison& comparison) {
  note_lost_rows(recording, table.topic, table.time.size(), name, comparison);
}

void note_hole(const std::string& topic, std::string_view name, const std::optional<Hole>& hole,
               Comparison& comparison) {
  if (!hole) return;
  note_missing(fmt::format("topic '{}': {} lacks {} {} from {:.6f} s to {:.6f} s", topic, name, hole->samples,
                           hole->samples == 1 ? "message" : "messages", to_seconds(hole->from), to_seconds(hole->to)),
               comparison);
}

JudgedShare judged_share(const Recording& recording, const Comparison& comparison) {
  std::set<std::string_view> topics;
  for (const ColumnComparison& column : comparison.columns)
    if (column.tolerance.kind != ToleranceKind::kReportOnly) topics.insert(column.topic);
  if (comparison.identical) topics.insert(recording.digest_topic());
  JudgedShare share{.messages_in_file = recording.message_count()};
  for (const ChannelInfo& channel : recording.channels()) {
    const std::size_t rows = recording.rows(channel.topic);
    if (rows == 0) continue;
    ++share.channels_in_file;
    if (!topics.contains(channel.topic)) continue;
    ++share.channels;
    share.messages += rows;
  }
  return share;
}

void note_unjudged(const Recording& a, const Recording& b, Comparison& comparison) {
  std::set<std::string> judged, others;
  for (const ColumnComparison& column : comparison.columns)
    if (column.tolerance.kind != ToleranceKind::kReportOnly) judged.insert(column.topic);
  for (const Recording* recording : {&a, &b})
    for (const ChannelInfo& channel : recording->channels())
      if (recording->rows(channel.topic) > 0 && !judged.contains(channel.topic)) others.insert(channel.topic);
  comparison.not_judged.assign(others.begin(), others.end());
  if (comparison.judged_a.messages > 0 || comparison.judged_b.messages > 0) return;
  const bool empty = a.message_count() == 0 && b.message_count() == 0;
  note_missing(empty ? "neither of both has messages" : "there is nothing that could be judged", comparison);
}

Nanoseconds common_end(const Comparison& comparison) {
  const Nanoseconds end = std::min(comparison.end_a, comparison.end_b);
  return comparison.end_a == comparison.end_b ? end : end - Tolerance{}.dt;
}

std::optional<Hole> find_hole(std::span<const Nanoseconds> times, std::span<const Nanoseconds> reference,
                              Nanoseconds end, Nanoseconds window) {
  const auto up_to_end = [end](std::span<const Nanoseconds> all) {
    return all.first(static_cast<std::size_t>(std::ranges::upper_bound(all, end) - all.begin()));
  };
  const bool is_subset = std::ranges::includes(up_to_end(reference), up_to_end(times));
  const auto reach = [&](std::size_t i) {
    if (is_subset) return Nanoseconds{0};
    const Nanoseconds before = i > 0 ? reference[i] - reference[i - 1] : 0;
    const Nanoseconds after = i + 1 < reference.size() ? reference[i + 1] - reference[i] : 0;
    return std::max({window, before, after});
  };
  std::optional<Hole> hole;
  std::size_t next = 0;  // the first of `times` at or after the sample
  for (std::size_t i = 0; i < reference.size() && reference[i] <= end; ++i) {
    while (next < times.size() && times[next] < reference[i]) ++next;
    const Nanoseconds width = reach(i);
    const bool found = (next < times.size() && times[next] - reference[i] <= width) ||
                       (next > 0 && reference[i] - times[next - 1] <= width);
    if (found && hole) break;
    if (found) continue;
    if (!hole) hole = Hole{.from = reference[i], .to = reference[i]};
    hole->to = reference[i];
    ++hole->samples;
  }
  return hole;
}

void note_differences(const Recording& a, std::string_view name_a,
                      const std::map<std::string, std::string>& fingerprint_b, Comparison& comparison) {
  note_damage(a, name_a, comparison);
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
