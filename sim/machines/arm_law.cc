#include "sim/machines/arm_law.h"

#include <cmath>

#include <Eigen/Dense>

namespace takt::sim {
namespace {

using device::ControlMode;
using kinematics::JointMatrix;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = kinematics::Vector6;

/// Where a direction has (nearly) no mobility its inertia would be infinite; this mobility, 1/kg or 1/(kg m^2), bounds
/// what the damping is computed from.
constexpr double kLeastMobility = 1e-4;
/// Stiffness (Nm/rad) below which the damping of a posture is not lowered any more: a free elbow must not swing for
/// ever.
constexpr double kLeastPostureStiffness = 1.0;

/// Damping of an axis by itself: ratio of the critical one for this stiffness and inertia.
double damping(double ratio, double stiffness, double inertia) { return 2.0 * ratio * std::sqrt(stiffness * inertia); }

/// The vector about which, and by how much, R turns.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// Pose of the tool T and its Jacobian, linear and angular rows in the axes R_BA.
struct Tool {
  Eigen::Isometry3d X_BT;
  kinematics::Jacobian J;

  Tool(const kinematics::Chain& chain, const JointVector& q, const Eigen::Isometry3d& X_FT) {
    Eigen::Isometry3d X_BF;
    chain.jacobian(q, X_BF, J);
    const Eigen::Vector3d p_FT_B = X_BF.linear() * X_FT.translation();
    X_BT = X_BF * X_FT;
    for (Eigen::Index i = 0; i < J.cols(); ++i) J.col(i).head<3>() += J.col(i).tail<3>().cross(p_FT_B);
  }
};

Matrix6 blocks(const Eigen::Matrix3d& R) {
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = R;
  return both;
}

}  // namespace

JointVector ArmLaw::torque(const ArmTask& task) const {
  switch (task.compliance.mode) {
    case ControlMode::kJointImpedance:
      return joint_impedance(task);
    case ControlMode::kCartesianImpedance:
      return cartesian_impedance(task);
    case ControlMode::kPosition:
      break;
  }
  return position(task);
}

JointVector ArmLaw::position(const ArmTask& task) const {
  const JointVector& w = control_.natural_frequency;
  const JointVector damping = 2.0 * control_.damping_ratio.cwiseProduct(w);
  const JointVector acceleration =
      task.ddq_r + damping.cwiseProduct(task.dq_r - task.dq) + w.cwiseProduct(w).cwiseProduct(task.q_r - task.q);
  // Of the measured motion: a joint that creeps to its goal is helped over its friction, and one that stands at a
  // contact does not push with a friction that is not there.
  JointVector friction = task.q;
  drives_.friction(task.dq, friction);
  JointVector torque = plant_.chain.inverse_dynamics(task.q, task.dq, acceleration, plant_.gravity_B, task.payload);
  torque += plant_.armature.cwiseProduct(acceleration) + control_.friction_compensation * friction;
  return torque;
}

JointVector ArmLaw::dynamics(const ArmTask& task) const {
  // Who gives way moves without being told to, so the friction that is compensated is that of the measured motion.
  JointVector friction = task.q;
  drives_.friction(task.dq, friction);
  JointVector torque = plant_.chain.inverse_dynamics(task.q, task.dq, task.ddq_r, plant_.gravity_B, task.payload);
  torque += plant_.armature.cwiseProduct(task.ddq_r) + control_.friction_compensation * friction;
  return torque;
}

JointMatrix ArmLaw::inertia(const ArmTask& task) const {
  JointMatrix M = plant_.chain.mass_matrix(task.q, task.payload);
  M.diagonal() += plant_.armature;
  return M;
}

JointVector ArmLaw::joint_impedance(const ArmTask& task) const {
  const device::Compliance& c = task.compliance;
  const JointMatrix M = inertia(task);
  JointVector torque = dynamics(task) + c.feed_forward;
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    const double d = damping(c.damping_ratio[i], c.stiffness[i], M(i, i));
    torque[i] += c.stiffness[i] * (task.q_r[i] - task.q[i]) + d * (task.dq_r[i] - task.dq[i]);
  }
  return torque;
}

/// A spring and a damper in each direction of the tool, made by J^T; a posture spring in what the tool does not feel,
/// by the dynamically consistent projection (Khatib 1987).
JointVector ArmLaw::cartesian_impedance(const ArmTask& task) const {
  const device::Compliance& c = task.compliance;
  const Tool now(plant_.chain, task.q, task.X_FT), wanted(plant_.chain, task.q_r, task.X_FT);
  const Matrix6 to_axes =
      c.in_tool_axes ? Matrix6(blocks(now.X_BT.linear().transpose())) : Matrix6(Matrix6::Identity());

  Vector6 error;
  error.head<3>() = wanted.X_BT.translation() - now.X_BT.translation();
  error.tail<3>() = rotation_vector(wanted.X_BT.linear() * now.X_BT.linear().transpose());
  error = to_axes * error;
  const kinematics::Jacobian J = to_axes * now.J;
  const Vector6 twist_error = to_axes * (wanted.J * task.dq_r) - J * task.dq;

  const JointMatrix M = inertia(task);
  const Eigen::LDLT<JointMatrix> solver(M);
  using Transposed = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::ColMajor, kinematics::kMaxJoints, 6>;
  const Transposed MinvJt = solver.solve(Transposed(J.transpose()));
  Matrix6 mobility = J * MinvJt;
  mobility.diagonal().array() += kLeastMobility;
  const Matrix6 Lambda = mobility.ldlt().solve(Matrix6::Identity());

  Vector6 wrench = c.feed_forward;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const double d = damping(c.damping_ratio[i], c.stiffness[i], Lambda(i, i));
    wrench[i] += c.stiffness[i] * error[i] + d * twist_error[i];
  }
  JointVector posture = task.q;
  for (Eigen::Index i = 0; i < posture.size(); ++i) {
    const double k = c.nullspace_stiffness;
    const double d = damping(c.nullspace_damping_ratio, std::max(k, kLeastPostureStiffness), M(i, i));
    posture[i] = k * (task.q_r[i] - task.q[i]) + d * (task.dq_r[i] - task.dq[i]);
  }
  const Vector6 felt = Lambda * (MinvJt.transpose() * posture);
  return dynamics(task) + J.transpose() * (wrench - felt) + posture;
}

ExternalTorqueObserver::ExternalTorqueObserver(int joint_count)
    : estimate_(JointVector::Zero(joint_count)), last_dq_(JointVector::Zero(joint_count)) {}

void ExternalTorqueObserver::update(const JointVector& inertial, const JointVector& torque, const JointVector& gain,
                                    double h) {
  estimate_ += (gain * h).cwiseMin(1.0).cwiseProduct(inertial - torque - estimate_);
}

JointVector ExternalTorqueObserver::acceleration(const JointVector& dq, double h) {
  const JointVector a = begun_ ? JointVector((dq - last_dq_) / h) : JointVector(JointVector::Zero(dq.size()));
  last_dq_ = dq;
  begun_ = true;
  return a;
}

void ExternalTorqueObserver::reset() {
  estimate_.setZero();
  begun_ = false;
}

void ExternalTorqueObserver::stream(StateStream& state) {
  state.vector(estimate_);
  state.vector(last_dq_);
  state(begun_);
}

}  // namespace takt::sim
