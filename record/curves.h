#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace takt::record {

/// Samples over time, joined by straight lines; times do not go back. NaN = null; a stretch between two samples of
/// which one is null is null.
struct CurveView {
  std::span<const Nanoseconds> time;
  std::span<const double> value;
};

/// The value at `time`; held before the first and after the last sample; NaN if null or if the curve is empty.
[[nodiscard]] double value_at(const CurveView& curve, Nanoseconds time);

/// How a curve lies in the tube of a reference: within `dv` of what the reference is somewhere in [t - dt, t + dt].
struct TubeResult {
  double max_deviation = 0.0;  ///< distance from the reference with the freedom dt; inf: null against value
  std::size_t at = 0;          ///< the sample of max_deviation
  std::size_t outside = 0;     ///< samples with a deviation above dv
  std::size_t first = 0;       ///< the first of them
};
/// Cost O(samples of both). Realtime: setup.
[[nodiscard]] TubeResult follow_tube(const CurveView& curve, const CurveView& reference, Nanoseconds dt, double dv);

/// The samples to keep so that straight lines between them stay within `tolerance` of every sample left out. First and
/// last are kept, changes between value and null too. Returns indices, ascending.
[[nodiscard]] std::vector<std::size_t> thin(const CurveView& curve, double tolerance);

/// The samples to draw: of about points/2 equal stretches of time the least and the greatest, and every change to null.
[[nodiscard]] std::vector<std::size_t> choose_for_plot(const CurveView& curve, std::size_t points);

/// True if `text` matches `pattern`, in which '*' stands for any run of characters.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);

}  // namespace takt::record
