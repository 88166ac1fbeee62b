#include "sim/machines/friction_observer.h"

#include <utility>

namespace takt::sim {
namespace {

/// rad/s. Slower joints creep: there friction is least known, and what is not compensated softens a touch.
constexpr double kCreep = 0.02;

}  // namespace

FrictionObserver::FrictionObserver(JointVector rate, double share)
    : rate_(std::move(rate)),
      share_(share),
      active_(rate_.size() > 0 && rate_.maxCoeff() > 0.0),
      observer_(static_cast<int>(rate_.size())) {}

void FrictionObserver::update(const JointVector& needed, const JointVector& torque, double h) {
  observer_.update(needed, torque, rate_, h);
}

JointVector FrictionObserver::compensation(const JointVector& friction, const JointVector& dq) const {
  JointVector most = share_ * friction.cwiseAbs();
  for (Eigen::Index i = 0; i < most.size(); ++i) most[i] *= dq[i] * dq[i] / (dq[i] * dq[i] + kCreep * kCreep);
  return (-observer_.estimate()).cwiseMin(most).cwiseMax(-most);
}

void FrictionObserver::stream(StateStream& state) {
  if (active_) observer_.stream(state);
}

}  // namespace takt::sim
