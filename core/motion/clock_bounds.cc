#include "core/motion/clock_bounds.h"

#include <algorithm>
#include <cmath>

namespace takt::motion {
namespace {

// Beyond this pace a rate goes from rest to full within two milliseconds: no cycle could tell the difference.
constexpr double kPaceMax = 1000.0;

// The rates are tried on a grid: between two of its points a load is at most 0.5 % higher (second derivative of the
// load over the grid's step), and the plan is sampled at instants: together 1 % is kept.
constexpr double kAllowed = 0.99;

/// True if no rate on the grid can show a load that a clock of that pace does not allow, whose rate changes by no more
/// than `change`: most loads of a plan are far from that.
bool harmless(const ClockSearch::Load& load, double change, double pace) {
  constexpr double kLargestRateTimesChange = 0.5444;  // of (1 - u^2 / 2) u
  const double acceleration = load.second_by_acceleration + load.first_by_acceleration * change;
  const double jerk =
      load.third_by_jerk + pace * (3.0 * kLargestRateTimesChange * load.second_by_jerk + load.first_by_jerk * pace);
  return acceleration <= kAllowed && jerk <= kAllowed;
}

}  // namespace

ClockSearch::ClockSearch() {
  constexpr std::array<double, kShapes> kFactors = {1.0, 0.8, 0.6};
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    Shape& shape = shapes_[i];
    shape.k = kFactors[i];
    shape.pace = kPaceMax;
    for (int n = 0; n < kRates; ++n) {
      const double u = shape.k * static_cast<double>(n) / (kRates - 1);
      shape.change[n] = u;
      shape.rate[n] = 1.0 - u * u / 2;
    }
    shape.rate_change = shape.rate * shape.change;
    shape.rate_squared = shape.rate.square();
    shape.rate_cubed = shape.rate.cube();
  }
  note_most();
}

void ClockSearch::note_most() {
  most_change_ = most_pace_ = 0.0;
  for (const Shape& shape : shapes_) {
    most_change_ = std::max(most_change_, shape.k * shape.pace);
    most_pace_ = std::max(most_pace_, shape.pace);
  }
}

bool ClockSearch::Shape::may_break(const Load& load) const {
  constexpr double kAllowedForSure = kAllowed * (1.0 - 1e-12);
  const double acceleration =
      (load.second_by_acceleration * rate_squared + (load.first_by_acceleration * pace) * change).maxCoeff();
  const double jerk = (load.third_by_jerk * rate_cubed + (3.0 * load.second_by_jerk * pace) * rate_change).maxCoeff() +
                      load.first_by_jerk * pace * pace;
  return acceleration > kAllowedForSure || jerk > kAllowedForSure;
}

void ClockSearch::add(const Load& load) {
  if (harmless(load, most_change_, most_pace_)) return;
  for (Shape& shape : shapes_) {
    if (harmless(load, shape.k * shape.pace, shape.pace) || !shape.may_break(load)) continue;
    for (int n = 0; n < kRates; ++n) {
      const double u = shape.change[n];
      const double r = shape.rate[n];
      const double room = kAllowed - load.second_by_acceleration * r * r;
      const double slope = load.first_by_acceleration * u;
      if (slope * shape.pace > room) shape.pace = std::max(0.0, room / slope);

      // c + 2 b w + a w^2 <= 1
      const double c = load.third_by_jerk * r * r * r - kAllowed;
      const double b = 1.5 * load.second_by_jerk * r * u;
      const double a = load.first_by_jerk;
      if (c + shape.pace * (2 * b + a * shape.pace) > 0.0) {
        shape.pace = c < 0.0 ? -c / (b + std::sqrt(b * b - a * c)) : 0.0;
      }
    }
  }
  note_most();
}

ClockBounds ClockSearch::bounds() const {
  // The shape that brings full rate to rest first: time = (k + 1 / k) / w.
  const auto best = std::max_element(shapes_.begin(), shapes_.end(), [](const Shape& x, const Shape& y) {
    return x.pace / (x.k + 1 / x.k) < y.pace / (y.k + 1 / y.k);
  });
  return {.acceleration_max = best->k * best->pace, .jerk_max = best->pace * best->pace};
}

}  // namespace takt::motion
