#include "core/kinematics/arm_angle.h"

#include <cmath>
#include <numbers>

namespace takt::kinematics {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Sines below this have no direction.
constexpr double kNoDirection = 1e-6;

/// The axes of a frame with x along `along` and y in the half plane of `towards`; nothing if these are in line.
std::optional<Matrix3d> frame(const Vector3d& along, const Vector3d& towards) {
  const Vector3d across = along.cross(towards);
  if (across.norm() <= kNoDirection * along.norm() * towards.norm()) return std::nullopt;
  Matrix3d R;
  R.col(0) = along.normalized();
  R.col(2) = across.normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

}  // namespace

std::optional<ArmAngle> ArmAngle::recognise(const Chain& chain) {
  if (chain.joint_count() != 7) return std::nullopt;
  for (int i = 0; i < 7; ++i) {
    if (chain.is_prismatic(i)) return std::nullopt;
  }
  ArmAngle arm;
  arm.chain_ = &chain;
  Isometry3d X_BF;
  arm.lines_ = joint_lines(chain, JointVector::Zero(7), &X_BF);
  arm.X_FB_zero_ = X_BF.inverse();
  const auto shoulder = common_point(arm.line(2), arm.line(1), arm.line(0));
  const auto wrist = common_point(arm.line(4), arm.line(5), arm.line(6));
  if (!shoulder || !wrist || parallel(arm.line(0).axis, arm.line(1).axis)) return std::nullopt;
  arm.shoulder_ = *shoulder;
  arm.wrist_ = *wrist;
  arm.elbow_ = foot(*shoulder, arm.line(3));
  if (lies_on(*shoulder, arm.line(3)) || lies_on(*wrist, arm.line(3))) return std::nullopt;
  return arm;
}

std::optional<double> ArmAngle::of(const JointVector& q) const {
  const auto lines = joint_lines(*chain_, q);
  const Vector3d elbow = foot(shoulder_, lines[3]);
  const auto wrist = meeting(lines[4], lines[5]);
  if (!wrist) return std::nullopt;
  const auto zero = frame(*wrist - shoulder_, line(0).axis);
  const auto here = frame(*wrist - shoulder_, elbow - shoulder_);
  if (!zero || !here) return std::nullopt;
  return std::atan2(here->col(1).dot(zero->col(2)), here->col(1).dot(zero->col(1)));
}

std::vector<JointVector> ArmAngle::solve(const Isometry3d& X_BF, double angle) const {
  std::vector<JointVector> found;
  const Isometry3d T = X_BF * X_FB_zero_;
  const Vector3d goal = T * wrist_ - shoulder_;
  const auto zero = frame(goal, line(0).axis);
  if (!zero) return found;
  const Matrix3d wanted = turn(zero->col(0), angle) * *zero;
  const Line& axis4 = line(3);
  for (const double q4 : onto_sphere(axis4.axis, wrist_ - axis4.point, shoulder_ - axis4.point, goal.norm())) {
    // The triangle shoulder, elbow, wrist is rigid now; joints 1 to 3 turn it about the shoulder to where it belongs.
    const Matrix3d bend = turn(axis4.axis, q4);
    const Vector3d wrist = axis4.point + bend * (wrist_ - axis4.point);
    const auto from = frame(wrist - shoulder_, elbow_ - shoulder_);
    if (!from) continue;
    const Matrix3d upper = wanted * from->transpose();
    const ThreeTurns shoulder = three_turns(line(0).axis, line(1).axis, line(2).axis, upper);
    const ThreeTurns hand = three_turns(line(4).axis, line(5).axis, line(6).axis,
                                        Matrix3d(bend.transpose() * (upper.transpose() * T.linear())));
    for (int i = 0; i < shoulder.count; ++i) {
      for (int k = 0; k < hand.count; ++k) {
        const auto& a = shoulder.angles[static_cast<std::size_t>(i)];
        const auto& b = hand.angles[static_cast<std::size_t>(k)];
        JointVector q(7);
        q << a[0], a[1], a[2], q4, b[0], b[1], b[2];
        for (double& value : q) value = std::remainder(value, 2.0 * std::numbers::pi);
        found.push_back(q);
      }
    }
  }
  return found;
}

}  // namespace takt::kinematics
