#include "core/kinematics/posture.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "core/kinematics/lines.h"

namespace takt::kinematics {
namespace {

using Eigen::Vector3d;

/// A number whose sign is the branch and whose size is the distance from the singular posture between the branches.
struct Sign {
  double value = 0.0;
  [[nodiscard]] std::string_view name(std::string_view plus, std::string_view minus) const {
    return value >= 0.0 ? plus : minus;
  }
};

/// (a x c) . b: the sine of joint b between its neighbours, where b is square to both.
Sign sine_between(const Line& a, const Line& b, const Line& c) { return {a.axis.cross(c.axis).dot(b.axis)}; }

/// The signs of an arm at its posture.
struct Signs {
  enum class Kind { kSphericalWrist, kThreeParallel, kShoulderElbowWrist } kind;
  Sign shoulder, elbow, wrist;
  double shoulder_and_wrist = 1.0;  ///< S-R-S only: another way to be singular
  double stretched_shoulder = 1.0, stretched_wrist = 1.0;
};

/// Where axes 1 and 2 lead: axis 1 points down in some files, so its upward half in B counts.
Vector3d forward_of(const std::array<Line, kMaxJoints>& l) {
  const double up = l[0].axis.z() < -kAlmost ? -1.0 : 1.0;
  return up * l[1].axis.cross(l[0].axis).normalized();
}

/// How far `wrist` is ahead of axis 1, over the reach: to the side where axis 2 is set off from axis 1, else where
/// joint 2 leans with positive angles.
Sign ahead(const std::array<Line, kMaxJoints>& l, const Vector3d& wrist, double reach) {
  const Vector3d forward = forward_of(l);
  const double offset = forward.dot(l[1].point - l[0].point);
  const double sense = offset < -kAlmost ? -1.0 : 1.0;
  return {sense * (wrist - l[0].point).dot(forward) / reach};
}

/// The sine of the angle at the elbow of the triangle from axis 2 over axis 3 to `end`; positive where the elbow is up
/// as long as `end` is ahead.
Sign bend(const std::array<Line, kMaxJoints>& l, const Vector3d& end) {
  const Vector3d h = l[1].axis;
  const auto across = [&](const Vector3d& v) { return Vector3d(v - h * h.dot(v)); };
  const Vector3d upper = across(l[2].point - l[1].point);
  const Vector3d lower = across(end - l[2].point);
  const double lengths = upper.norm() * lower.norm();
  return {lengths > 0.0 ? upper.cross(lower).dot(h) / lengths : 0.0};
}

std::optional<Signs> signs_of_six(const Chain& chain, const std::array<Line, kMaxJoints>& l) {
  const auto meet = meeting(l[4], l[5]);
  if (!meet || !parallel(l[1].axis, l[2].axis) || parallel(l[0].axis, l[1].axis)) return std::nullopt;
  Signs signs{};
  signs.wrist = sine_between(l[3], l[4], l[5]);
  signs.shoulder = ahead(l, *meet, chain.reach());
  // Turned round axis 1 and bent the other way the arm looks the same: up is up in front and behind.
  const double leaning = (*meet - l[0].point).dot(forward_of(l));
  const double side = leaning >= 0.0 ? 1.0 : -1.0;
  if (common_point(l[3], l[4], l[5])) {
    signs.kind = Signs::Kind::kSphericalWrist;
    signs.elbow = {side * bend(l, *meet).value};
    return signs;
  }
  if (!parallel(l[1].axis, l[3].axis) || parallel(l[3].axis, l[4].axis)) return std::nullopt;
  signs.kind = Signs::Kind::kThreeParallel;
  const double offset = (*meet - l[0].point).dot(l[1].axis);
  signs.shoulder = {std::copysign(signs.shoulder.value, side * offset)};
  signs.elbow = {side * bend(l, l[3].point).value};
  return signs;
}

std::optional<Signs> signs_of_seven(const Chain& chain, const std::array<Line, kMaxJoints>& l) {
  if (!common_point(l[2], l[1], l[0]) || !common_point(l[4], l[5], l[6])) return std::nullopt;
  Signs signs{};
  signs.kind = Signs::Kind::kShoulderElbowWrist;
  // Positive: as if the arm, upright at zero, bent towards x of the base.
  const auto zero = joint_lines(chain, JointVector::Zero(chain.joint_count()));
  const auto towards_x = [&](std::size_t i) {
    return Sign{(zero[i].axis.y() < 0.0 ? -1.0 : 1.0) * sine_between(l[i - 1], l[i], l[i + 1]).value};
  };
  signs.shoulder = towards_x(1);
  signs.elbow = towards_x(3);
  signs.wrist = towards_x(5);
  // Joint 2 at zero is singular only with axes 2 and 4 square to each other, or with joint 6 at zero too; likewise at
  // the wrist.
  signs.stretched_shoulder = std::hypot(signs.shoulder.value, l[1].axis.dot(l[3].axis));
  signs.stretched_wrist = std::hypot(signs.wrist.value, l[3].axis.dot(l[5].axis));
  signs.shoulder_and_wrist = std::hypot(signs.shoulder.value, signs.wrist.value);
  return signs;
}

std::optional<Signs> signs_of(const Chain& chain, const JointVector& q) {
  const int n = chain.joint_count();
  if (n != 6 && n != 7) return std::nullopt;
  for (int i = 0; i < n; ++i) {
    if (chain.is_prismatic(i)) return std::nullopt;
  }
  const auto lines = joint_lines(chain, q);
  return n == 6 ? signs_of_six(chain, lines) : signs_of_seven(chain, lines);
}

Jacobian weighted_jacobian(const Chain& chain, const JointVector& q) {
  Eigen::Isometry3d X_BF;
  Jacobian J;
  chain.jacobian(q, X_BF, J);
  J.topRows<3>() /= std::max(chain.reach(), 1e-3);
  return J;
}

/// The two joints that move most in the motion that the flange notices least.
std::string opposed_joints(const Chain& chain, const Jacobian& J) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::VectorXd size = svd.matrixV().col(svd.matrixV().cols() - 1).cwiseAbs();
  Eigen::Index first = 0, second = 0;
  size.maxCoeff(&first);
  size[first] = -1.0;
  size.maxCoeff(&second);
  const auto& names = chain.joint_names();
  const auto [low, high] = std::minmax(first, second);
  return low == high ? names[static_cast<std::size_t>(low)]
                     : fmt::format("{} against {}", names[static_cast<std::size_t>(low)],
                                   names[static_cast<std::size_t>(high)]);
}

}  // namespace

std::string Posture::name() const {
  if (!aspect.empty()) return fmt::format("aspect {}", aspect);
  if (shoulder.empty()) return "";
  return fmt::format("{}, {}, {}", shoulder, elbow, wrist);
}

Posture posture(const Chain& chain, const JointVector& q) {
  Posture posture;
  if (const auto signs = signs_of(chain, q)) {
    const bool sideways = signs->kind == Signs::Kind::kThreeParallel;
    posture.shoulder = sideways ? signs->shoulder.name("left", "right") : signs->shoulder.name("front", "back");
    posture.elbow = signs->elbow.name("up", "down");
    posture.wrist = signs->wrist.name("no flip", "flip");
  } else if (chain.joint_count() == 6) {
    const Eigen::Matrix<double, 6, 6> J = weighted_jacobian(chain, q);
    posture.aspect = J.determinant() >= 0.0 ? "+" : "-";
  }
  return posture;
}

Singularity singularity(const Chain& chain, const JointVector& q) {
  Singularity result;
  const Jacobian J = weighted_jacobian(chain, q);
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues();
  result.measure = values.minCoeff();
  result.manipulability = values.prod();
  result.condition = result.measure / values.maxCoeff();
  result.singular = result.measure < kSingularMeasure;
  const auto signs = signs_of(chain, q);
  if (!signs) {
    result.nearest = opposed_joints(chain, J);
    result.distance = result.measure;
    return result;
  }
  const bool seven = signs->kind == Signs::Kind::kShoulderElbowWrist;
  const std::pair<double, const char*> kinds[] = {
      {std::abs(signs->elbow.value), "elbow"},
      {seven ? signs->stretched_shoulder : std::abs(signs->shoulder.value), "shoulder"},
      {seven ? signs->stretched_wrist : std::abs(signs->wrist.value), "wrist"},
      {seven ? signs->shoulder_and_wrist : 2.0, "shoulder and wrist"}};
  result.distance = std::numeric_limits<double>::infinity();
  for (const auto& [distance, name] : kinds) {
    if (distance >= result.distance) continue;
    result.distance = distance;
    result.nearest = name;
  }
  return result;
}

LimitMargin limit_margin(const Chain& chain, const JointVector& q) {
  LimitMargin margin{std::numeric_limits<double>::infinity(), -1};
  for (int i = 0; i < chain.joint_count(); ++i) {
    const double distance = std::min(q[i] - chain.lower()[i], chain.upper()[i] - q[i]);
    if (distance < margin.distance) margin = {distance, i};
  }
  return margin;
}

}  // namespace takt::kinematics
