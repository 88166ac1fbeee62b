#include "core/device/set_point_series.h"

namespace takt::device {

namespace {

motion::JointSample state_of(const ArmSetPoint& point) { return {point.q, point.dq, point.ddq}; }

}  // namespace

motion::JointSample interpolate(const motion::JointSample& from, const motion::JointSample& to, double length,
                                double time) {
  if (time <= 0.0) return from;
  if (time >= length) return to;
  const double h = length, u = time / h;
  motion::JointSample out = from;
  for (Eigen::Index i = 0; i < from.q.size(); ++i) {
    // In u of [0, 1]: q = q0 + v0 u + a0/2 u^2 + c3 u^3 + c4 u^4 + c5 u^5 with v, a scaled to the interval.
    const double d = to.q[i] - from.q[i];
    const double v0 = h * from.dq[i], v1 = h * to.dq[i];
    const double a0 = h * h * from.ddq[i], a1 = h * h * to.ddq[i];
    const double c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
    const double c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
    const double c5 = 6.0 * d - 3.0 * (v0 + v1) - 0.5 * (a0 - a1);
    out.q[i] = from.q[i] + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))));
    out.dq[i] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h;
    out.ddq[i] = (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h);
  }
  return out;
}

void SetPointSeries::add(const ArmSetPoint& set_point) {
  if (size_ > 0 && set_point.stamp <= newest()) return;
  if (size_ == kCapacity) {
    first_ = (first_ + 1) % kCapacity;
    --size_;
  }
  points_[(first_ + size_) % kCapacity] = set_point;
  ++size_;
}

SetPointSeries::Place SetPointSeries::sample(Nanoseconds time, motion::JointSample& out) const {
  if (size_ == 0) return Place::kEmpty;
  if (time < at(0).stamp) {
    out = state_of(at(0));
    return Place::kBefore;
  }
  if (time >= newest()) {
    out = state_of(at(size_ - 1));
    return time == newest() ? Place::kInside : Place::kBeyond;
  }
  std::size_t low = 0, high = size_ - 1;  // at(low).stamp <= time < at(high).stamp
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (at(middle).stamp <= time ? low : high) = middle;
  }
  const ArmSetPoint &before = at(low), &after = at(high);
  out = interpolate(state_of(before), state_of(after), to_seconds(after.stamp - before.stamp),
                    to_seconds(time - before.stamp));
  return Place::kInside;
}

}  // namespace takt::device
