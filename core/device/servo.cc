#include "core/device/servo.h"

#include <cmath>

#include <Eigen/Dense>

#include "core/kinematics/chain.h"

namespace takt::device {
namespace {

using kinematics::JointMatrix;
using kinematics::Vector6;

/// Of the position loops where the device file says nothing.
constexpr double kUsualFrequency = 60.0;  // rad/s
/// 1/kg: what a direction that hardly moves counts with.
constexpr double kLeastMobilityOfTool = 1e-6;

JointVector or_else(const JointVector& figures, Eigen::Index n, double value) {
  return figures.size() == n ? figures : JointVector(JointVector::Constant(n, value));
}

/// What a force of 1 N along a direction does to springs or dampers in series: the deflection, or its velocity.
double yield(const JointVector& felt, const JointVector& strength) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < felt.size(); ++i)
    if (felt[i] != 0.0) sum += felt[i] * felt[i] / strength[i];
  return sum;
}

/// A body of this mobility on a spring and a damper that yield by this much.
ServoResponse response_of(double mobility, double by_force, double by_force_and_time) {
  if (!(std::isfinite(by_force) && by_force > 0.0)) return {};
  const double frequency = std::sqrt(mobility / by_force);
  return {.stiffness = 1.0 / by_force,
          .natural_frequency = frequency,
          .damping_ratio = mobility / (2.0 * frequency * by_force_and_time)};
}

}  // namespace

ServoResponse servo_response(const ArmDescription& arm, const Compliance& compliance, const ServoPosture& posture,
                             const Eigen::Vector3d& direction_B) {
  const Eigen::Index n = posture.q.size();
  JointMatrix M = arm.chain->mass_matrix(posture.q, posture.payload);
  M.diagonal() += or_else(arm.armature, n, 0.0);
  const Eigen::LDLT<JointMatrix> inertia(M);
  const JointVector torques = posture.J_BT.topRows<3>().transpose() * direction_B;
  const JointVector accelerations = inertia.solve(torques);
  const double mobility = std::max(torques.dot(accelerations), kLeastMobilityOfTool);

  if (compliance.mode == ControlMode::kPosition) {
    const JointVector w = or_else(arm.natural_frequency, n, kUsualFrequency);
    const JointVector damping = 2.0 * or_else(arm.damping_ratio, n, 1.0).cwiseProduct(w);
    return response_of(mobility, torques.dot(accelerations.cwiseQuotient(w.cwiseProduct(w))),
                       torques.dot(accelerations.cwiseQuotient(damping)));
  }
  const auto dampers = [&](const JointVector& masses, Eigen::Index count) {
    JointVector result(count);
    for (Eigen::Index i = 0; i < count; ++i)
      result[i] = 2.0 * compliance.damping_ratio[i] * std::sqrt(compliance.stiffness[i] * masses[i]);
    return result;
  };
  if (compliance.mode == ControlMode::kJointImpedance)
    return response_of(mobility, yield(torques, compliance.stiffness),
                       yield(torques, dampers(JointVector(M.diagonal()), n)));
  const JointVector felt =
      compliance.in_tool_axes ? Eigen::Vector3d(posture.R_BT.transpose() * direction_B) : direction_B;
  return response_of(mobility, yield(felt, compliance.stiffness),
                     yield(felt, dampers(JointVector(JointVector::Constant(3, 1.0 / mobility)), 3)));
}

ServoResponse through_tip(const ServoResponse& arm, double compliance) {
  if (!(arm.stiffness > 0.0 && compliance > 0.0)) return arm;
  return {.stiffness = 1.0 / (1.0 / arm.stiffness + compliance),
          .natural_frequency = arm.natural_frequency * std::max(1.0, arm.stiffness * compliance),
          .damping_ratio = arm.damping_ratio};
}

}  // namespace takt::device
