#include "core/kinematics/closed_form.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/kinematics/position_quartic.h"

namespace takt::kinematics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Sine of the angle between two axes below which a joint about one does what a joint about the other does: what is
/// between them, a pose no longer tells.
constexpr double kInLine = 1e-8;

/// Into (-pi, pi], for angles of a few turns at most.
double wrapped(double angle) {
  constexpr double kPi = std::numbers::pi;
  while (angle > kPi) angle -= 2.0 * kPi;
  while (angle <= -kPi) angle += 2.0 * kPi;
  return angle;
}

}  // namespace

std::string_view to_string(ArmFamily family) {
  switch (family) {
    case ArmFamily::kWristShoulderMeets:
      return "spherical wrist, meeting shoulder axes";
    case ArmFamily::kWristElbowParallel:
      return "spherical wrist, parallel elbow";
    case ArmFamily::kWristAnyArm:
      return "spherical wrist";
    case ArmFamily::kThreeParallel:
      return "three parallel axes";
  }
  return "";
}

std::optional<ClosedForm> ClosedForm::recognise(const Chain& chain, const JointVector& q_held,
                                                const std::vector<int>& held) {
  if (chain.joint_count() != static_cast<int>(held.size()) + 6) return std::nullopt;
  ClosedForm form;
  form.q_held_ = JointVector::Zero(chain.joint_count());
  std::size_t k = 0;
  for (int i = 0; i < chain.joint_count(); ++i) {
    const bool is_held = std::find(held.begin(), held.end(), i) != held.end();
    if (is_held) form.q_held_[i] = q_held[i];
    if (!is_held && chain.is_prismatic(i)) return std::nullopt;
    if (!is_held) form.free_[k++] = i;
  }
  Eigen::Isometry3d X_BF;
  const auto lines = joint_lines(chain, form.q_held_, &X_BF);
  form.X_FB_zero_ = X_BF.inverse();
  for (std::size_t i = 0; i < 6; ++i) form.lines_[i] = lines[static_cast<std::size_t>(form.free_[i])];
  if (form.find_family()) return form;
  form.reverse();
  if (form.find_family()) return form;
  return std::nullopt;
}

void ClosedForm::reverse() {
  // From T = turn 1 ... turn 6 follows T^-1 = turn -6 ... turn -1: the same problem with the axes in the other order
  // and pointing the other way.
  std::reverse(lines_.begin(), lines_.end());
  for (Line& line : lines_) line.axis = -line.axis;
  reversed_ = !reversed_;
}

bool ClosedForm::find_family() {
  const auto last = meeting(lines_[4], lines_[5]);
  if (!last) return false;
  wrist_ = *last;
  const bool elbow_parallel = parallel(axis(1), axis(2)) && !parallel(axis(0), axis(1));
  if (common_point(lines_[3], lines_[4], lines_[5])) {
    const auto shoulder = meeting(lines_[0], lines_[1]);
    shoulder_ = shoulder.value_or(Vector3d::Zero());
    family_ = elbow_parallel ? ArmFamily::kWristElbowParallel
              : shoulder     ? ArmFamily::kWristShoulderMeets
                             : ArmFamily::kWristAnyArm;
    const bool inner = parallel(axis(0), axis(1));
    const bool outer = parallel(axis(1), axis(2)) || meeting(lines_[1], lines_[2]);
    return family_ != ArmFamily::kWristAnyArm || !(inner && outer);
  }
  family_ = ArmFamily::kThreeParallel;
  return elbow_parallel && parallel(axis(1), axis(3)) && !parallel(axis(3), axis(4));
}

void ClosedForm::solve(const Eigen::Isometry3d& X_BF, Candidates& found) const {
  // What all joints together do to a body that starts at zero: T = turn 1 * turn 2 * ... * turn 6.
  const Eigen::Isometry3d forwards = X_BF * X_FB_zero_;
  const Eigen::Isometry3d T = reversed_ ? forwards.inverse() : forwards;
  found.count = 0;
  switch (family_) {
    case ArmFamily::kWristShoulderMeets:
      solve_shoulder_first(T, found);
      break;
    case ArmFamily::kWristElbowParallel:
      solve_elbow_first(T, found);
      break;
    case ArmFamily::kWristAnyArm:
      solve_any_arm(T, found);
      break;
    case ArmFamily::kThreeParallel:
      solve_three_parallel(T, found);
      break;
  }
  for (int i = 0; i < found.count; ++i) {
    Angles& angles = found.angles[static_cast<std::size_t>(i)];
    if (reversed_) std::reverse(angles.begin(), angles.end());
    for (double& angle : angles) angle = wrapped(angle);
  }
}

JointVector ClosedForm::joints(const Angles& angles) const {
  JointVector q = q_held_;
  for (std::size_t i = 0; i < 6; ++i) q[free_[i]] = angles[i];
  return q;
}

void ClosedForm::solve_shoulder_first(const Eigen::Isometry3d& T, Candidates& found) const {
  // The wrist must come to `goal`. Joints 1 and 2 do not change its distance from the shoulder; joint 3 alone makes it.
  const Vector3d goal = T * wrist_ - shoulder_;
  for (const double q3 : onto_sphere(axis(2), wrist_ - point(2), shoulder_ - point(2), goal.norm(), found.margin)) {
    const Vector3d arm = point(2) + turn(axis(2), q3) * (wrist_ - point(2)) - shoulder_;
    // Joint 1 does not change the component along its axis; joint 2 alone makes it.
    for (const double q2 : onto_cone(axis(1), arm, axis(0), slant(goal, axis(0)), found.margin)) {
      const double q1 = onto_point_exactly(axis(0), turn(axis(1), q2) * arm, goal);
      solve_wrist(T, q1, q2, q3, found);
    }
  }
}

void ClosedForm::solve_elbow_first(const Eigen::Isometry3d& T, Candidates& found) const {
  // Joints 2 and 3 do not change the wrist's component along their common direction; joint 1 alone makes it.
  const Vector3d goal = T * wrist_ - point(0);
  for (const double minus_q1 : onto_plane(axis(0), goal, axis(1), axis(1).dot(wrist_ - point(0)), found.margin)) {
    const Vector3d back = turn(axis(0), minus_q1) * goal + point(0) - point(1);
    // In the plane across axis 2: joint 3 makes the distance from axis 2, joint 2 the direction.
    const Vector3d arm = wrist_ - point(2);
    for (const double q3 : onto_sphere(axis(2), arm, point(1) - point(2), back.norm(), found.margin)) {
      const Vector3d bent = point(2) + turn(axis(2), q3) * arm - point(1);
      solve_wrist(T, -minus_q1, onto_point_exactly(axis(1), bent, back), q3, found);
    }
  }
}

void ClosedForm::solve_any_arm(const Eigen::Isometry3d& T, Candidates& found) const {
  const ArmAngles arm = position_angles(lines_, wrist_, T * wrist_);
  for (int i = 0; i < arm.count; ++i) {
    const auto& q = arm.angles[static_cast<std::size_t>(i)];
    solve_wrist(T, q[0], q[1], q[2], found);
  }
}

void ClosedForm::solve_wrist(const Eigen::Isometry3d& T, double q1, double q2, double q3, Candidates& found) const {
  const Matrix3d arm = turn(axis(0), q1) * turn(axis(1), q2) * turn(axis(2), q3);
  const ThreeTurns wrist = three_turns(axis(3), axis(4), axis(5), arm.transpose() * T.linear(), found.margin);
  for (int i = 0; i < wrist.count; ++i) {
    const auto& q = wrist.angles[static_cast<std::size_t>(i)];
    found.add({q1, q2, q3, q[0], q[1], q[2]});
  }
}

void ClosedForm::solve_three_parallel(const Eigen::Isometry3d& T, Candidates& found) const {
  const Vector3d& h = axis(1);
  // Joints 5 and 6 leave the meeting point of their axes, joints 2 to 4 its component along h; joint 1 alone makes it.
  const Vector3d goal = T * wrist_ - point(0);
  for (const double minus_q1 : onto_plane(axis(0), goal, h, h.dot(wrist_ - point(0)), found.margin)) {
    // Seen from joint 1, the angle of axis 6 to h is joint 5's, and that of h, seen from axis 6's end, joint 6's.
    const Vector3d h_seen = turn(axis(0), -minus_q1) * h;
    const Vector3d h_6 = T.linear().transpose() * h_seen;
    for (const double q5 : onto_cone(axis(4), axis(5), h, slant(h_6, axis(5)), found.margin)) {
      const Vector3d h_5 = turn(axis(4), -q5) * h;
      solve_planar(T, -minus_q1, q5, -onto_point_exactly(axis(5), h_5, h_6), found);
      if (axis(5).cross(h_5).norm() < kInLine) solve_free_turn(T, -minus_q1, q5, found);
    }
  }
}

void ClosedForm::solve_free_turn(const Eigen::Isometry3d& T, double q1, double q5, Candidates& found) const {
  const Vector3d& h = axis(1);
  const auto place = [&](double q6) { return planar_goal(T, q1, q5, q6).place; };
  // Axis 4 goes round a circle; it comes nearest to axis 2 and farthest from it where its centre and both are in line.
  const Vector3d centre = 0.5 * (place(0.0) + place(std::numbers::pi)), arm = place(0.0) - centre;
  const double sense = h.dot(arm.cross(place(0.5 * std::numbers::pi) - centre)) < 0.0 ? -1.0 : 1.0;
  const double towards = sense * onto_point_exactly(h, arm, -centre);
  constexpr int kShares = 6;  // of a turn, the first towards axis 2
  for (int k = 0; k < kShares; ++k) solve_planar(T, q1, q5, towards + 2.0 * std::numbers::pi * k / kShares, found);
}

ClosedForm::PlanarGoal ClosedForm::planar_goal(const Eigen::Isometry3d& T, double q1, double q5, double q6) const {
  const Vector3d& h = axis(1);
  const Matrix3d back = turn(axis(0), -q1);
  // What joints 2 to 4 do, in the plane across h: to axis 4 first, then the rest of the angle.
  const Matrix3d R = back * (T.linear() * (turn(axis(5), -q6) * turn(axis(4), -q5)));
  const Vector3d at = back * (T * wrist_ - point(0)) + point(0) + R * (point(3) - wrist_) - point(1);
  return {R, at - h * h.dot(at - (point(3) - point(1)))};
}

void ClosedForm::solve_planar(const Eigen::Isometry3d& T, double q1, double q5, double q6, Candidates& found) const {
  const Vector3d& h = axis(1);
  const auto [R, in_plane] = planar_goal(T, q1, q5, q6);
  const Vector3d arm = point(3) - point(2);
  const Vector3d across = h.unitOrthogonal();
  const double whole = onto_point_exactly(h, across, R * across);
  for (const double q3 : onto_sphere(h, arm, point(1) - point(2), in_plane.norm(), found.margin)) {
    const Vector3d bent = point(2) + turn(h, q3) * arm - point(1);
    const double q2 = onto_point_exactly(h, bent, in_plane);
    // Axes 2 to 4 may point either way along h.
    const auto sign = [&](int i) { return axis(i).dot(h) > 0.0 ? 1.0 : -1.0; };
    found.add({q1, q2, sign(2) * q3, sign(3) * (whole - q2 - q3), q5, q6});
  }
}

}  // namespace takt::kinematics
