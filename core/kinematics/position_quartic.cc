#include "core/kinematics/position_quartic.h"

#include <complex>

#include <Eigen/Dense>

namespace takt::kinematics {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// v(angle) = constant + cosine * cos + sine * sin: a point that goes round an axis.
struct Round {
  Vector3d constant, cosine, sine;
};

Round round(const Line& line, const Vector3d& point, double sense) {
  const Vector3d middle = foot(point, line);
  const Vector3d arm = point - middle;
  return {middle, arm, sense * line.axis.cross(arm)};
}

/// Two numbers of a point that joint 2 does not change: the component along its axis, and the square of the distance
/// from a point on it (which is linear in cos and sin, as the point goes round another axis).
struct Invariants {
  Vector2d constant;
  Matrix2d trig;  ///< columns: cos, sin
};

Invariants invariants(const Round& round, const Line& axis, double length) {
  const Vector3d from = round.constant - axis.point;
  Invariants out;
  out.constant << axis.axis.dot(from), (from.squaredNorm() + round.cosine.squaredNorm()) / length;
  out.trig << axis.axis.dot(round.cosine), axis.axis.dot(round.sine),  //
      2.0 * from.dot(round.cosine) / length, 2.0 * from.dot(round.sine) / length;
  return out;
}

/// Angles x with |a + B (cos x, sin x)| = 1: with the half angle's tangent a polynomial of degree four, whose real
/// roots are wanted. The tangent is taken from an angle `shift` on, so that no root is at infinity.
void circle_meets_ellipse(const Vector2d& a, const Matrix2d& B, double shift, std::array<double, 4>& angles,
                          int& count) {
  const Eigen::Rotation2Dd turned(shift);
  const Matrix2d C = B * turned.toRotationMatrix();
  // (1 + t^2) (a + C (cos, sin)) = p + q t + r t^2
  const Vector2d p = a + C.col(0);
  const Vector2d q = 2.0 * C.col(1);
  const Vector2d r = a - C.col(0);
  const std::array<double, 5> k{p.squaredNorm() - 1.0, 2.0 * p.dot(q), q.squaredNorm() + 2.0 * p.dot(r) - 2.0,
                                2.0 * q.dot(r), r.squaredNorm() - 1.0};
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.diagonal(-1).setOnes();
  for (int i = 0; i < 4; ++i) companion(i, 3) = -k[static_cast<std::size_t>(i)] / k[4];
  if (!companion.allFinite()) return;
  const Eigen::EigenSolver<Eigen::Matrix4d> roots(companion, false);
  if (roots.info() != Eigen::Success) return;
  for (int i = 0; i < 4; ++i) {
    const std::complex<double> t = roots.eigenvalues()[i];
    if (std::abs(t.imag()) > 1e-4 * (1.0 + std::abs(t))) continue;
    angles[static_cast<std::size_t>(count++)] = shift + 2.0 * std::atan(t.real());
  }
}

}  // namespace

ArmAngles position_angles(const std::array<Line, 6>& lines, const Vector3d& point, const Vector3d& goal) {
  ArmAngles result;
  const double length = std::max(1e-3, (goal - lines[1].point).norm() + (point - lines[1].point).norm());
  // Joint 3 carries the point round its axis, joint 1 backwards the goal; joint 2 joins the two circles.
  const Round outer = round(lines[2], point, 1.0);
  const Round inner = round(lines[0], goal, -1.0);
  const Invariants a = invariants(outer, lines[1], length);
  const Invariants b = invariants(inner, lines[1], length);
  // a.constant + a.trig u3 = b.constant + b.trig u1: solve for the pair that is the better determined one.
  const bool for_joint_1 = std::abs(b.trig.determinant()) > std::abs(a.trig.determinant());
  const Invariants& known = for_joint_1 ? a : b;
  const Invariants& solved = for_joint_1 ? b : a;
  const double determinant = solved.trig.determinant();
  if (std::abs(determinant) < 1e-9 * length) return result;
  const Matrix2d back = solved.trig.inverse();
  const Vector2d offset = back * (known.constant - solved.constant);
  const Matrix2d slope = back * known.trig;
  std::array<double, 4> angles{};
  int count = 0;
  // The leading coefficient is the polynomial at the far point of the circle: 0.7 rad is a place like any other.
  circle_meets_ellipse(offset, slope, 0.7, angles, count);
  for (int i = 0; i < count; ++i) {
    const double x = angles[static_cast<std::size_t>(i)];
    const Vector2d other = offset + slope * Vector2d(std::cos(x), std::sin(x));
    const double y = std::atan2(other.y(), other.x());
    const double q1 = for_joint_1 ? y : x;
    const double q3 = for_joint_1 ? x : y;
    const Vector3d from = outer.constant + outer.cosine * std::cos(q3) + outer.sine * std::sin(q3) - lines[1].point;
    const Vector3d to = inner.constant + inner.cosine * std::cos(q1) + inner.sine * std::sin(q1) - lines[1].point;
    result.angles[static_cast<std::size_t>(result.count++)] = {q1, onto_point(lines[1].axis, from, to), q3};
  }
  return result;
}

}  // namespace takt::kinematics
