#include "hw/fri/emulator/interpolator.h"

namespace takt::hw::fri {

void Interpolator::stand(const Joints& q) {
  before_ = from_ = to_ = q;
  missing_ = gap_cycles_ = since_gap_ = 0;
}

void Interpolator::shift(const Joints& to) {
  before_ = from_;
  from_ = to_;
  to_ = to;
}

/// From 1 to 0 by the polynomial of fifth degree, at rest at both ends.
double Interpolator::share_of_gap() const {
  if (since_gap_ >= gap_cycles_) return 0.0;
  const double x = static_cast<double>(since_gap_) / gap_cycles_;
  return 1.0 - x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

void Interpolator::go(const Joints& q) {
  if (missing_ > 0) {
    // Long enough that closing the gap costs little acceleration, short enough to follow soon.
    gap_cycles_ = 8 + 2 * missing_;
    since_gap_ = 0;
    gap_ = q - next();
    missing_ = 0;
  }
  const double share = share_of_gap();
  ++since_gap_;
  shift(share > 0.0 ? Joints(q - share * gap_) : q);
}

void Interpolator::bridge() {
  ++missing_;
  shift(next());
}

motion::JointSample Interpolator::at(double time) const {
  const Joints mean = (to_ - before_) / (2.0 * cycle_), change = acceleration();
  return {from_ + time * mean + (0.5 * time * time) * change, mean + time * change, change};
}

}  // namespace takt::hw::fri
