#include "core/kinematics/closed_form.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace takt::kinematics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Axes count as meeting or parallel within this, m and rad: real arms are exact in their tables, calibrated ones are
/// not of these families.
constexpr double kExact = 1e-9;

Matrix3d turn(const Vector3d& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

// --- the subproblems -------------------------------------------------------------------------------------------------

/// The angle about `axis` that takes p as near as possible to q.
double onto_point(const Vector3d& axis, const Vector3d& p, const Vector3d& q) {
  return std::atan2(q.dot(axis.cross(p)), q.dot(p) - axis.dot(q) * axis.dot(p));
}

/// One or two angles.
struct Angle2 {
  std::array<double, 2> value{};
  int count = 0;
  [[nodiscard]] const double* begin() const { return value.data(); }
  [[nodiscard]] const double* end() const { return value.data() + count; }
};

/// The angles about `axis` for which the turned p has the component d along h. None if it never has; the margin keeps
/// touching cases, which rounding could lose.
Angle2 onto_plane(const Vector3d& axis, const Vector3d& p, const Vector3d& h, double d) {
  const double c = h.dot(axis) * axis.dot(p);
  const double a = h.dot(p) - c;
  const double b = h.dot(axis.cross(p));
  const double radius = std::hypot(a, b);
  if (radius < 1e-12) return std::abs(d - c) < 1e-9 ? Angle2{{0.0, 0.0}, 1} : Angle2{};
  const double ratio = (d - c) / radius;
  if (std::abs(ratio) > 1.0 + 1e-9) return {};
  const double middle = std::atan2(b, a);
  const double half = std::acos(std::clamp(ratio, -1.0, 1.0));
  return {{middle + half, middle - half}, half == 0.0 ? 1 : 2};
}

/// The angles about `axis` for which the turned p lies at `distance` from q.
Angle2 onto_sphere(const Vector3d& axis, const Vector3d& p, const Vector3d& q, double distance) {
  return onto_plane(axis, p, q, 0.5 * (p.squaredNorm() + q.squaredNorm() - distance * distance));
}

// --- geometry of axes ------------------------------------------------------------------------------------------------

struct Line {
  Vector3d point, axis;
};

bool parallel(const Vector3d& a, const Vector3d& b) { return a.cross(b).norm() < kExact; }

/// Where two lines meet, if they do in one point.
std::optional<Vector3d> meeting(const Line& a, const Line& b) {
  const Vector3d normal = a.axis.cross(b.axis);
  const double square = normal.squaredNorm();
  if (square < kExact) return std::nullopt;
  const Vector3d between = b.point - a.point;
  if (std::abs(between.dot(normal)) > kExact * std::sqrt(square)) return std::nullopt;
  return a.point + a.axis * (between.cross(b.axis).dot(normal) / square);
}

bool lies_on(const Vector3d& p, const Line& line) { return (p - line.point).cross(line.axis).norm() < kExact; }

}  // namespace

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
  Jacobian J;
  chain.jacobian(form.q_held_, form.X_BF_zero_, J);
  for (std::size_t i = 0; i < 6; ++i) {
    const Vector6 column = J.col(form.free_[i]);
    form.axes_[i] = column.tail<3>();
    // v = w x (p_F - p): the point of the axis that is nearest to F.
    form.points_[i] = form.X_BF_zero_.translation() + form.axes_[i].cross(column.head<3>());
  }
  const auto family = form.family();
  if (!family) return std::nullopt;
  form.family_ = *family;
  return form;
}

std::optional<ClosedForm::Family> ClosedForm::family() {
  const auto line = [&](int i) { return Line{point(i), axis(i)}; };
  const auto last = meeting(line(4), line(5));
  if (!last) return std::nullopt;
  wrist_ = *last;
  if (lies_on(wrist_, line(3)) && !parallel(axis(3), axis(4))) {
    if (const auto shoulder = meeting(line(0), line(1))) {
      shoulder_ = *shoulder;
      return Family::kWristAxesMeet;
    }
    if (parallel(axis(1), axis(2)) && !parallel(axis(0), axis(1))) return Family::kWristAxesParallel;
  }
  if (parallel(axis(1), axis(2)) && parallel(axis(1), axis(3)) && !parallel(axis(0), axis(1)) &&
      !parallel(axis(3), axis(4)))
    return Family::kThreeParallel;
  return std::nullopt;
}

std::vector<JointVector> ClosedForm::solve(const Eigen::Isometry3d& X_BF) const {
  // What all joints together do to a body that starts at zero: T = turn 1 * turn 2 * ... * turn 6.
  const Eigen::Isometry3d T = X_BF * X_BF_zero_.inverse();
  std::vector<Angles> found;
  switch (family_) {
    case Family::kWristAxesMeet:
      solve_shoulder_first(T, found);
      break;
    case Family::kWristAxesParallel:
      solve_elbow_first(T, found);
      break;
    case Family::kThreeParallel:
      solve_three_parallel(T, found);
      break;
  }
  std::vector<JointVector> solutions;
  for (const Angles& angles : found) {
    JointVector q = q_held_;
    for (std::size_t i = 0; i < 6; ++i) q[free_[i]] = std::remainder(angles[i], 2.0 * std::numbers::pi);
    solutions.push_back(q);
  }
  return solutions;
}

void ClosedForm::solve_shoulder_first(const Eigen::Isometry3d& T, std::vector<Angles>& found) const {
  // The wrist must come to `goal`. Joints 1 and 2 do not change its distance from the shoulder; joint 3 alone makes it.
  const Vector3d goal = T * wrist_ - shoulder_;
  for (const double q3 : onto_sphere(axis(2), wrist_ - point(2), shoulder_ - point(2), goal.norm())) {
    const Vector3d arm = point(2) + turn(axis(2), q3) * (wrist_ - point(2)) - shoulder_;
    // Joint 1 does not change the component along its axis; joint 2 alone makes it.
    for (const double q2 : onto_plane(axis(1), arm, axis(0), axis(0).dot(goal))) {
      const double q1 = onto_point(axis(0), turn(axis(1), q2) * arm, goal);
      solve_wrist(T, {q1, q2, q3, 0.0, 0.0, 0.0}, found);
    }
  }
}

void ClosedForm::solve_elbow_first(const Eigen::Isometry3d& T, std::vector<Angles>& found) const {
  // Joints 2 and 3 do not change the wrist's component along their common direction; joint 1 alone makes it.
  const Vector3d goal = T * wrist_ - point(0);
  for (const double minus_q1 : onto_plane(axis(0), goal, axis(1), axis(1).dot(wrist_ - point(0)))) {
    const Vector3d back = turn(axis(0), minus_q1) * goal + point(0) - point(1);
    // In the plane across axis 2: joint 3 makes the distance from axis 2, joint 2 the direction.
    const Vector3d arm = wrist_ - point(2);
    for (const double q3 : onto_sphere(axis(2), arm, point(1) - point(2), back.norm())) {
      const Vector3d bent = point(2) + turn(axis(2), q3) * arm - point(1);
      solve_wrist(T, {-minus_q1, onto_point(axis(1), bent, back), q3, 0.0, 0.0, 0.0}, found);
    }
  }
}

void ClosedForm::solve_wrist(const Eigen::Isometry3d& T, Angles angles, std::vector<Angles>& found) const {
  const Matrix3d arm = turn(axis(0), angles[0]) * turn(axis(1), angles[1]) * turn(axis(2), angles[2]);
  const Matrix3d rest = arm.transpose() * T.linear();
  // Axis 6 turns with joints 4 and 5 only, and its angle to axis 4 with joint 5 only.
  const Vector3d last = rest * axis(5);
  const Vector3d across = axis(5).unitOrthogonal();
  for (const double q5 : onto_plane(axis(4), axis(5), axis(3), axis(3).dot(last))) {
    const double q4 = onto_point(axis(3), turn(axis(4), q5) * axis(5), last);
    const Matrix3d both = turn(axis(3), q4) * turn(axis(4), q5);
    const double q6 = onto_point(axis(5), across, both.transpose() * rest * across);
    found.push_back({angles[0], angles[1], angles[2], q4, q5, q6});
  }
}

void ClosedForm::solve_three_parallel(const Eigen::Isometry3d& T, std::vector<Angles>& found) const {
  const Vector3d& h = axis(1);
  // Joints 5 and 6 leave the meeting point of their axes, joints 2 to 4 its component along h; joint 1 alone makes it.
  const Vector3d goal = T * wrist_ - point(0);
  for (const double minus_q1 : onto_plane(axis(0), goal, h, h.dot(wrist_ - point(0)))) {
    const Matrix3d back = turn(axis(0), minus_q1);
    // Seen from joint 1, the angle of axis 6 to h is joint 5's, and that of h, seen from axis 6's end, joint 6's.
    for (const double q5 : onto_plane(axis(4), axis(5), h, h.dot(back * T.linear() * axis(5)))) {
      const Vector3d h_5 = turn(axis(4), -q5) * h;
      const Vector3d h_6 = T.linear().transpose() * back.transpose() * h;
      const double q6 = -onto_point(axis(5), h_5, h_6);
      // What joints 2 to 4 do, in the plane across h: to axis 4 first, then the rest of the angle.
      const Matrix3d R = back * T.linear() * turn(axis(5), -q6) * turn(axis(4), -q5);
      const Vector3d wrist_to_4 = R * (point(3) - wrist_);
      const Vector3d at = back * goal + point(0) + wrist_to_4 - point(1);
      const Vector3d in_plane = at - h * h.dot(at - (point(3) - point(1)));
      const Vector3d arm = point(3) - point(2);
      const double whole = onto_point(h, h.unitOrthogonal(), R * h.unitOrthogonal());
      for (const double q3 : onto_sphere(h, arm, point(1) - point(2), in_plane.norm())) {
        const Vector3d bent = point(2) + turn(h, q3) * arm - point(1);
        const double q2 = onto_point(h, bent, in_plane);
        // Axes 2 to 4 may point either way along h.
        const auto sign = [&](int i) { return axis(i).dot(h) > 0.0 ? 1.0 : -1.0; };
        found.push_back({-minus_q1, q2, sign(2) * q3, sign(3) * (whole - q2 - q3), q5, q6});
      }
    }
  }
}

}  // namespace takt::kinematics
