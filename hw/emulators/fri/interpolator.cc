#include "hw/emulators/fri/interpolator.h"

#include <algorithm>
#include <cmath>

namespace takt::hw::fri {
namespace {

/// rad/s: how fast an offset fades. 1 degree, the most with which command state begins, costs 11 rad/s^2.
constexpr double kFading = 25.0;
/// rad: less than that is no offset; binary32 does not show it.
constexpr double kNoOffset = 1e-8;

}  // namespace

Interpolator::Interpolator(double cycle) : cycle_(cycle), fading_(std::exp(-kFading * cycle)) {}

void Interpolator::stand(const Joints& q) {
  told_.stand(q);
  wanted_.stand(q);
  missing_ = 0;
}

void Interpolator::go(const Joints& q) {
  if (missing_ > 0) return end_bridge(q);
  wanted_.go(q);
  tell();
}

void Interpolator::bridge() {
  ++missing_;
  wanted_.go(wanted_.next());
  tell();
}

/// Either the commands have changed meanwhile, or they go on as before and are late, since their sender counts the
/// messages that it saw. What takes less acceleration is taken.
void Interpolator::end_bridge(const Joints& q) {
  const Joints off = q - wanted_.next();
  Interpolator late = *this;
  correct_bridge(off);
  late.wanted_.shift(off);
  for (Interpolator* one : {this, &late}) {
    one->missing_ = 0;
    one->wanted_.go(q);
    one->tell();
  }
  if (late.acceleration().cwiseAbs().maxCoeff() < acceleration().cwiseAbs().maxCoeff()) *this = late;
}

/// What the bridge lacked is a jerk, so it has grown with the third power of time since the last command.
void Interpolator::correct_bridge(const Joints& off) {
  const auto share = [&](int back) {
    const double x = std::max(0.0, static_cast<double>(missing_ - back) / (missing_ + 1));
    return x * x * x;
  };
  wanted_.to += share(0) * off;
  wanted_.from += share(1) * off;
  wanted_.before += share(2) * off;
}

/// Both tracks but for the newest point of `told_` are known.
void Interpolator::tell() {
  const Joints last = told_.to - wanted_.from, before = told_.from - wanted_.before;
  const Joints offset = 2.0 * fading_ * last - fading_ * fading_ * before;
  const bool none = offset.cwiseAbs().maxCoeff() < kNoOffset && last.cwiseAbs().maxCoeff() < kNoOffset;
  told_.go(none ? wanted_.to : Joints(wanted_.to + offset));
}

motion::JointSample Interpolator::at(double time) const {
  const Joints mean = (told_.to - told_.before) / (2.0 * cycle_), change = acceleration();
  return {told_.from + time * mean + (0.5 * time * time) * change, mean + time * change, change};
}

}  // namespace takt::hw::fri
