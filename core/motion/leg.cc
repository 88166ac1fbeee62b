#include "core/motion/leg.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/joint_range.h"
#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

using Eigen::Vector3d;

/// A pose of M further than this from the spline's reference would come near the half turn, where a rotation vector
/// has no direction.
constexpr double kLargestTurn = 170.0 * std::numbers::pi / 180.0;

Diagnostics check_start(const ArmModel& arm, const JointVector& q_start, bool cartesian) {
  Diagnostics diagnostics;
  check_limits(arm.chain, arm.limits, diagnostics);
  check_configuration(arm.chain, arm.limits, q_start, "/start", diagnostics);
  if (cartesian && arm.inverse == nullptr)
    diagnostics.error(Code::kRequires, "/goal", "the arm has no inverse kinematics", "Use a joint motion");
  return diagnostics;
}

Leg leg_of(Geometry geometry) {
  Leg leg;
  leg.pieces.push_back({.geometry = std::move(geometry)});
  return leg;
}

/// How M turns on an arc that is otherwise complete.
void set_orientation(CartesianArc& arc, ArcOrientation orientation, const Eigen::Isometry3d& X_goal) {
  if (orientation == ArcOrientation::kTangential) {
    arc.axis = arc.normal;
    arc.angle = arc.arc;
  } else if (orientation == ArcOrientation::kToGoal) {
    const FixedAxisTurn turn = short_turn(arc.R_start, Eigen::Quaterniond(X_goal.linear()).normalized());
    arc.axis = turn.axis;
    arc.angle = turn.angle;
  }
}

CartesianArc arc_from(const ArmModel& arm, const JointVector& q_start) {
  const Eigen::Isometry3d X_start = arm.chain.forward(q_start) * arm.X_FM;
  CartesianArc arc;
  arc.p_start = X_start.translation();
  arc.R_start = Eigen::Quaterniond(X_start.linear()).normalized();
  arc.held_start = arc.held_goal = arm.inverse->held(q_start);
  return arc;
}

/// Knots from 0 to 1 whose spacing goes with the square root of the ways between the points (centripetal).
/// @return empty if two points in a row are the same, told in the diagnostics.
std::vector<double> centripetal(const std::vector<double>& ways, Diagnostics& diagnostics) {
  std::vector<double> knots{0.0};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    constexpr double kNoWay = 1e-9;
    if (ways[i] < kNoWay) {
      diagnostics.error(Code::kInvalidValue, "/points" + pointer_segment(i), "the point is the same as the one before",
                        "Choose points that differ");
    }
    knots.push_back(knots.back() + std::sqrt(ways[i]));
  }
  for (double& knot : knots) knot /= knots.back();
  knots.back() = 1.0;
  return knots;
}

/// One piece per span, made from value, first and second derivative by the span's own parameter at both ends.
template <class MakeSpan>
Leg spline_of(const std::vector<double>& knots, const Eigen::MatrixXd& rows, MakeSpan make_span) {
  const SplineKnots slopes = interpolate(knots, rows);
  Leg leg;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double h = knots[i + 1] - knots[i];
    const auto jet = [&](std::size_t k) -> Jet<Eigen::VectorXd> {
      const auto row = static_cast<Eigen::Index>(k);
      return {.value = rows.row(row), .first = h * slopes.first.row(row), .second = h * h * slopes.second.row(row)};
    };
    const auto polynomial = Quintic<Eigen::VectorXd>::between(jet(i), jet(i + 1));
    leg.pieces.push_back({.geometry = make_span(polynomial), .s_begin = knots[i], .s_end = knots[i + 1]});
  }
  return leg;
}

}  // namespace

Result<Leg> ptp_leg(const ArmModel& arm, const JointVector& q_start, const JointVector& q_goal) {
  Diagnostics diagnostics = check_start(arm, q_start, false);
  if (!diagnostics.has_errors()) check_configuration(arm.chain, arm.limits, q_goal, "/goal", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return leg_of(
      JointLine{.q_start = q_start, .q_goal = kinematics::into_range(q_goal, arm.limits.lower, arm.limits.upper)});
}

Result<Leg> lin_leg(const ArmModel& arm, const JointVector& q_start, const Eigen::Isometry3d& X_BM_goal) {
  Diagnostics diagnostics = check_start(arm, q_start, true);
  check_pose(X_BM_goal, "/goal", diagnostics);
  if (!diagnostics.has_errors())
    check_directions(*arm.inverse, q_start, X_BM_goal * arm.X_FM.inverse(), "/goal", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const JointVector held = arm.inverse->held(q_start);
  return leg_of(CartesianLine::between(arm.chain.forward(q_start) * arm.X_FM, X_BM_goal, held, held));
}

Result<Leg> circ_leg(const ArmModel& arm, const JointVector& q_start, const ArcThrough& wanted) {
  Diagnostics diagnostics = check_start(arm, q_start, true);
  check_pose(wanted.X_BM_goal, "/goal", diagnostics);
  if (!wanted.p_via.allFinite()) diagnostics.error(Code::kOutOfRange, "/via", "the point is not finite");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  CartesianArc arc = arc_from(arm, q_start);
  const Vector3d a = wanted.p_via - arc.p_start;
  const Vector3d b = wanted.X_BM_goal.translation() - arc.p_start;
  const Vector3d normal = a.cross(b);
  constexpr double kLeastHeight = 1e-6;  // m: of the triangle of the three points
  const double longest = std::max({a.norm(), b.norm(), (a - b).norm()});
  if (!(normal.norm() > kLeastHeight * longest)) {
    diagnostics.error(Code::kInvalidValue, "/via", "start, via point and goal lie on one line",
                      "Give three points of a circle, or use LIN");
    return std::unexpected(std::move(diagnostics));
  }
  // Centre of the circle through 0, a, b.
  const Vector3d out =
      (a.squaredNorm() * b.cross(normal) + b.squaredNorm() * normal.cross(a)) / (2.0 * normal.squaredNorm());
  arc.centre = arc.p_start + out;
  arc.normal = normal.normalized();
  const Vector3d from = -out;
  const Vector3d to = b - out;
  const double angle = std::atan2(arc.normal.dot(from.cross(to)), from.dot(to));
  arc.arc = angle > 0.0 ? angle : angle + 2.0 * std::numbers::pi;
  set_orientation(arc, wanted.orientation, wanted.X_BM_goal);
  return leg_of(std::move(arc));
}

Result<Leg> circ_leg(const ArmModel& arm, const JointVector& q_start, const ArcAbout& wanted) {
  Diagnostics diagnostics = check_start(arm, q_start, true);
  if (!wanted.centre.allFinite()) diagnostics.error(Code::kOutOfRange, "/centre", "the point is not finite");
  if (!(wanted.axis.allFinite() && wanted.axis.norm() > 1e-9))
    diagnostics.error(Code::kOutOfRange, "/axis", "the axis has no direction");
  constexpr double kMostTurns = 100.0;
  if (!(std::abs(wanted.angle) <= kMostTurns * 2.0 * std::numbers::pi)) {
    diagnostics.error(Code::kOutOfRange, "/angle", fmt::format("{} rad", wanted.angle),
                      "Give a finite angle of at most 100 turns");
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  CartesianArc arc = arc_from(arm, q_start);
  // The circle lies in the plane through the start, whatever the height of the given centre on its axis.
  arc.normal = wanted.axis.normalized() * (wanted.angle < 0.0 ? -1.0 : 1.0);
  arc.centre = wanted.centre + arc.normal * arc.normal.dot(arc.p_start - wanted.centre);
  arc.arc = std::abs(wanted.angle);
  constexpr double kLeastRadius = 1e-6;  // m
  if ((arc.p_start - arc.centre).norm() < kLeastRadius) {
    diagnostics.error(Code::kOutOfRange, "/centre", "the start lies on the axis of the circle",
                      "Keep a radius of at least 1 um");
    return std::unexpected(std::move(diagnostics));
  }
  set_orientation(arc, wanted.orientation, Eigen::Isometry3d::Identity());
  return leg_of(std::move(arc));
}

Result<Leg> spline_leg(const ArmModel& arm, const JointVector& q_start, const std::vector<JointVector>& points) {
  Diagnostics diagnostics = check_start(arm, q_start, false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    check_configuration(arm.chain, arm.limits, points[i], "/points" + pointer_segment(i), diagnostics);
  }
  if (points.size() < 2)
    diagnostics.error(Code::kWrongSize, "/points", fmt::format("{} points", points.size()),
                      "Give two or more, or use PTP");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd rows(n + 1, q_start.size());
  rows.row(0) = q_start.transpose();
  std::vector<double> ways;
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointVector& point = points[static_cast<std::size_t>(i)];
    rows.row(i + 1) = kinematics::into_range(point, arm.limits.lower, arm.limits.upper).transpose();
    const Eigen::RowVectorXd way = rows.row(i + 1) - rows.row(i);
    ways.push_back((way.transpose().cwiseAbs().cwiseQuotient(arm.limits.velocity)).maxCoeff());
  }
  const std::vector<double> knots = centripetal(ways, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return spline_of(knots, rows, [](const Quintic<Eigen::VectorXd>& span) -> Geometry {
    JointCurve curve;
    for (std::size_t k = 0; k < 6; ++k) curve.q.c[k] = span.c[k];
    return curve;
  });
}

Result<Leg> spline_leg(const ArmModel& arm, const JointVector& q_start,
                       const std::vector<Eigen::Isometry3d>& poses_BM) {
  Diagnostics diagnostics = check_start(arm, q_start, true);
  for (std::size_t i = 0; i < poses_BM.size(); ++i) {
    check_pose(poses_BM[i], "/points" + pointer_segment(i), diagnostics);
  }
  if (poses_BM.size() < 2)
    diagnostics.error(Code::kWrongSize, "/points", fmt::format("{} points", poses_BM.size()),
                      "Give two or more, or use LIN");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  std::vector<Eigen::Isometry3d> poses{arm.chain.forward(q_start) * arm.X_FM};
  poses.insert(poses.end(), poses_BM.begin(), poses_BM.end());
  const Eigen::Matrix3d R_ref = poses[poses.size() / 2].linear();
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(poses.size()), 6);
  std::vector<double> ways;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3d phi = log_rotation(poses[i].linear() * R_ref.transpose());
    if (phi.norm() > kLargestTurn) {
      diagnostics.error(
          Code::kInvalidValue, "/points" + pointer_segment(i == 0 ? 0 : i - 1),
          fmt::format("the spline turns by {:.0f} degrees against its middle", phi.norm() * 180 / std::numbers::pi),
          "Keep it to 170 at most; two splines with a blend between them turn further");
    }
    rows.row(static_cast<Eigen::Index>(i)) << poses[i].translation().transpose(), phi.transpose();
    if (i == 0) continue;
    const double way = (poses[i].translation() - poses[i - 1].translation()).norm() / arm.cartesian.linear_velocity;
    const double turn = log_rotation(poses[i].linear() * poses[i - 1].linear().transpose()).norm();
    ways.push_back(std::max(way, turn / arm.cartesian.angular_velocity));
  }
  const std::vector<double> knots = centripetal(ways, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const JointVector held = arm.inverse->held(q_start);
  const JointVector none = JointVector::Zero(held.size());
  return spline_of(knots, rows, [&](const Quintic<Eigen::VectorXd>& span) -> Geometry {
    CartesianCurve curve;
    curve.R_ref = Eigen::Quaterniond(R_ref).normalized();
    for (std::size_t k = 0; k < 6; ++k) {
      curve.p.c[k] = span.c[k].head<3>();
      curve.phi.c[k] = span.c[k].tail<3>();
      curve.held_curve.c[k] = k == 0 ? held : none;
    }
    return curve;
  });
}

}  // namespace takt::motion
