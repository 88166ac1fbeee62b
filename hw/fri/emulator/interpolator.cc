#include "hw/fri/emulator/interpolator.h"

namespace takt::hw::fri {
namespace {

/// From 0 to 1 by the polynomial of fifth degree, at rest at both ends. @param x  in [0, 1]
double blend(double x) { return x * x * x * (10.0 + x * (6.0 * x - 15.0)); }

}  // namespace

void Interpolator::stand(const Joints& q) {
  told_.stand(q);
  missing_ = gap_cycles_ = since_gap_ = 0;
}

void Interpolator::go(const Joints& q) {
  if (missing_ > 0) {
    // Long enough that taking over costs little acceleration, short enough to follow soon.
    gap_cycles_ = 8 + 2 * missing_;
    since_gap_ = missing_ = 0;
    bridge_ = told_;
  }
  if (since_gap_ >= gap_cycles_) return told_.go(q);
  bridge_.go(bridge_.next());
  const double share = blend(static_cast<double>(since_gap_++) / gap_cycles_);
  told_.go(bridge_.to + share * (q - bridge_.to));
}

void Interpolator::bridge() {
  ++missing_;
  told_.go(told_.next());
}

motion::JointSample Interpolator::at(double time) const {
  const Joints mean = (told_.to - told_.before) / (2.0 * cycle_), change = acceleration();
  return {told_.from + time * mean + (0.5 * time * time) * change, mean + time * change, change};
}

}  // namespace takt::hw::fri
