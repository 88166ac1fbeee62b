#include "record/curves.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

namespace takt::record {

namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Least and greatest value of a reference over a window that only moves forward.
class SlidingRange {
 public:
  explicit SlidingRange(const CurveView& curve) : curve_(curve) {}

  struct Range {
    double low = kInfinite, high = -kInfinite;
    bool has_null = false;
    void take(double value) {
      if (std::isnan(value)) {
        has_null = true;
      } else {
        low = std::min(low, value);
        high = std::max(high, value);
      }
    }
  };

  Range over(Nanoseconds from, Nanoseconds to) {
    while (next_ < curve_.time.size() && curve_.time[next_] <= to) push(next_++);
    while (!samples_.empty() && curve_.time[samples_.front()] < from) pop();
    Range range;
    if (!lows_.empty()) range.take(curve_.value[lows_.front()]);
    if (!highs_.empty()) range.take(curve_.value[highs_.front()]);
    range.has_null = nulls_ > 0;
    // The lines go on to the ends of the window.
    range.take(value_at(curve_, from));
    range.take(value_at(curve_, to));
    return range;
  }

 private:
  void push(std::size_t i) {
    const double value = curve_.value[i];
    samples_.push_back(i);
    if (std::isnan(value)) {
      ++nulls_;
      return;
    }
    while (!lows_.empty() && curve_.value[lows_.back()] >= value) lows_.pop_back();
    while (!highs_.empty() && curve_.value[highs_.back()] <= value) highs_.pop_back();
    lows_.push_back(i);
    highs_.push_back(i);
  }
  void pop() {
    const std::size_t i = samples_.front();
    samples_.pop_front();
    if (std::isnan(curve_.value[i])) --nulls_;
    if (!lows_.empty() && lows_.front() == i) lows_.pop_front();
    if (!highs_.empty() && highs_.front() == i) highs_.pop_front();
  }

  CurveView curve_;
  std::size_t next_ = 0;
  std::size_t nulls_ = 0;
  std::deque<std::size_t> samples_, lows_, highs_;  ///< indices in the window; ascending, descending values
};

double deviation_of(double value, const SlidingRange::Range& range) {
  if (std::isnan(value)) return range.has_null ? 0.0 : kInfinite;
  if (range.low > range.high) return kInfinite;
  return std::max({0.0, value - range.high, range.low - value});
}

}  // namespace

double value_at(const CurveView& curve, Nanoseconds time) {
  if (curve.time.empty()) return kNoValue;
  const auto after = std::ranges::lower_bound(curve.time, time);
  if (after == curve.time.end()) return curve.value.back();
  const auto i = static_cast<std::size_t>(after - curve.time.begin());
  if (curve.time[i] == time || i == 0) return curve.value[i];
  const double share =
      static_cast<double>(time - curve.time[i - 1]) / static_cast<double>(curve.time[i] - curve.time[i - 1]);
  return curve.value[i - 1] + share * (curve.value[i] - curve.value[i - 1]);
}

TubeResult follow_tube(const CurveView& curve, const CurveView& reference, Nanoseconds dt, double dv) {
  TubeResult result;
  SlidingRange window(reference);
  for (std::size_t i = 0; i < curve.time.size(); ++i) {
    const double deviation = deviation_of(curve.value[i], window.over(curve.time[i] - dt, curve.time[i] + dt));
    if (deviation > dv && ++result.outside == 1) result.first = i;
    if (deviation > result.max_deviation) {
      result.max_deviation = deviation;
      result.at = i;
    }
  }
  return result;
}

std::vector<std::size_t> thin(const CurveView& curve, double tolerance) {
  // From the last kept sample every further one opens a cone of slopes that pass within the tolerance; while the line
  // to the newest sample lies in all cones, the ones before need not be kept. One pass, and the bound is exact.
  std::vector<std::size_t> kept;
  const std::size_t count = curve.time.size();
  if (count == 0) return kept;
  kept.push_back(0);
  double lowest = -kInfinite, highest = kInfinite;
  const auto keep = [&](std::size_t i) {
    if (kept.back() != i) kept.push_back(i);
    lowest = -kInfinite;
    highest = kInfinite;
  };
  for (std::size_t i = 1; i < count; ++i) {
    const bool null = std::isnan(curve.value[i]);
    if (null && std::isnan(curve.value[i - 1])) continue;
    if (null != std::isnan(curve.value[i - 1])) {
      keep(i - 1);
      keep(i);
      continue;
    }
    for (;;) {
      const std::size_t start = kept.back();
      const double span = std::max(1.0, static_cast<double>(curve.time[i] - curve.time[start]));
      const double rise = curve.value[i] - curve.value[start];
      if (rise / span >= lowest && rise / span <= highest) {
        lowest = std::max(lowest, (rise - tolerance) / span);
        highest = std::min(highest, (rise + tolerance) / span);
        break;
      }
      keep(i - 1);
    }
  }
  keep(count - 1);
  return kept;
}

std::vector<std::size_t> choose_for_plot(const CurveView& curve, std::size_t points) {
  std::vector<std::size_t> chosen;
  const std::size_t count = curve.time.size();
  const std::size_t stretches = std::max<std::size_t>(points / 2, 1);
  if (count <= 2 * stretches) {
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(i);
    return chosen;
  }
  const auto add = [&](std::size_t i) {
    if (chosen.empty() || chosen.back() < i) chosen.push_back(i);
  };
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t from = s * count / stretches, to = (s + 1) * count / stretches;
    std::size_t low = to, high = to, null = to;
    for (std::size_t i = from; i < to; ++i) {
      if (std::isnan(curve.value[i])) {
        if (null == to) null = i;
        continue;
      }
      if (low == to || curve.value[i] < curve.value[low]) low = i;
      if (high == to || curve.value[i] > curve.value[high]) high = i;
    }
    std::vector<std::size_t> found;
    for (const std::size_t i : {low, high, null}) {
      if (i != to) found.push_back(i);
    }
    std::ranges::sort(found);
    for (const std::size_t i : found) add(i);
  }
  add(count - 1);
  return chosen;
}

bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0, star = std::string_view::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace takt::record
