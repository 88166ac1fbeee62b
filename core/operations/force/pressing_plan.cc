#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/kinematics/chain.h"
#include "core/operations/force/pressing.h"
#include "core/operations/table/contact_figures.h"

namespace takt::operations {
namespace {

using device::ControlMode;
using kinematics::JointVector;

/// Of the approach velocity: how fast the tool may follow a surface that yields.
constexpr double kMostVelocity = 5.0;
constexpr double kMostAcceleration = 1.0;  ///< m/s^2

Result<Eigen::Vector3d> direction_in_base(const Pressing& pressing, const expression::Cell& cell,
                                          const Eigen::Isometry3d& X_BT) {
  if (pressing.in == "tcp") return Eigen::Vector3d((X_BT.linear() * pressing.direction).normalized());
  const auto X_BI = cell.frames.pose(pressing.in, pressing.arm);
  if (!X_BI) return std::unexpected(X_BI.error());
  return Eigen::Vector3d((X_BI->linear() * pressing.direction).normalized());
}

// -- Springs ---------------------------------------------------------------------------------------------------------

/// The compliance of the arm while it presses.
device::Compliance springs_of(const Pressing& pressing, const device::Arm& arm) {
  return pressing.compliance ? springs_of(*pressing.compliance, arm.description()) : arm.compliance();
}

/// A force of the tool along a direction of the base as the axes of the springs have it: joints, or x, y, z.
JointVector as_springs_feel(const device::Compliance& springs, const expression::MountedArm& arm,
                            const Eigen::Vector3d& direction_B, const JointVector& q) {
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  arm.device->description().chain->jacobian(q, X_BF, J);
  if (springs.mode == ControlMode::kCartesianImpedance)
    return springs.in_tool_axes ? Eigen::Vector3d((X_BF.linear() * arm.X_FT.linear()).transpose() * direction_B)
                                : direction_B;
  kinematics::Vector6 at_flange;
  at_flange << direction_B, (X_BF.linear() * arm.X_FT.translation()).cross(direction_B);
  return J.transpose() * at_flange;
}

/// What springs do to a tool along a direction.
struct ToolCompliance {
  double by = 0.0;      ///< by how much a force deflects the tool, m/N; infinite: nothing holds it
  double beside = 0.0;  ///< how far what the arm exerts beside the springs pushes it, m
};
ToolCompliance softness_along(const device::Compliance& springs, const JointVector& felt) {
  constexpr double kNone = 1e-9;
  ToolCompliance softness;
  for (Eigen::Index i = 0; i < felt.size(); ++i) {
    if (std::abs(felt[i]) < kNone) continue;
    softness.by += felt[i] * felt[i] / springs.stiffness[i];
    softness.beside += felt[i] * springs.feed_forward[i] / springs.stiffness[i];
  }
  return softness;
}

/// The largest of any direction across; nothing: the arm is stiff.
std::optional<double> softness_across(const Pressing& pressing, const expression::MountedArm& arm,
                                      const Eigen::Vector3d& direction_B, const JointVector& q) {
  const device::Compliance springs = springs_of(pressing, *arm.device);
  if (springs.mode == ControlMode::kPosition) return std::nullopt;
  const Eigen::Vector3d x = direction_B.unitOrthogonal();
  double most = 0.0;
  for (const Eigen::Vector3d& across : {x, Eigen::Vector3d(direction_B.cross(x))})
    most = std::max(most, softness_along(springs, as_springs_feel(springs, arm, across, q)).by);
  return std::isfinite(most) ? most : 0.0;
}

/// How fast the approach may begin, m/s^2: the sensor feels half of what counts as contact when the heaviest load of
/// the arm is accelerated like that. 0: the arm does not say what it may carry.
double approach_acceleration(const expression::MountedArm& arm, double contact_force) {
  const double heaviest = arm.device->description().payload_max;
  return heaviest > 0.0 ? 0.5 * contact_force / heaviest : 0.0;
}

/// Springs that are bent by more than the tool may be sent never press with the force.
Diagnostics check_bend(const Pressing& pressing, const expression::MountedArm& arm, const Eigen::Vector3d& direction_B,
                       const JointVector& q) {
  Diagnostics diagnostics;
  const device::Compliance springs = springs_of(pressing, *arm.device);
  if (springs.mode == ControlMode::kPosition) return diagnostics;
  const ToolCompliance softness = softness_along(springs, as_springs_feel(springs, arm, direction_B, q));
  if (!std::isfinite(softness.by)) {
    diagnostics.error(Code::kRequires, "/force_N", "the tool has no stiffness along the direction",
                      "Give a stiffness above 0 there");
    return diagnostics;
  }
  const double bent = softness.by * pressing.force - softness.beside;
  if (!(bent <= pressing.travel))
    diagnostics.error(
        Code::kLimitExceeded, "/travel_m",
        fmt::format("a force of {:g} N deflects the springs by {:.4g} m, and the set point moves by {:g} m at most",
                    pressing.force, bent, pressing.travel),
        "Increase the travel, stiffen the springs along the direction, or let springs beside them take a part of the "
        "force");
  return diagnostics;
}

}  // namespace

bool Pressing::needs_place() const {
  const bool own_springs = compliance && compliance->mode != ControlMode::kPosition;
  return path || in == "tcp" ||
         (own_springs && (compliance->mode == ControlMode::kJointImpedance || compliance->in_tool_axes));
}

Result<PlannedPressing> plan_pressing(const Pressing& pressing, const expression::Cell& cell, const JointVector& q) {
  const expression::MountedArm& arm = cell.arms.find(pressing.arm)->second;
  const Eigen::Isometry3d X_BT = tool_pose(arm, q);
  const auto direction = direction_in_base(pressing, cell, X_BT);
  if (!direction) return std::unexpected(direction.error());
  if (Diagnostics wrong = check_bend(pressing, arm, *direction, q); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  command::PressControlParameters control{.force = {.force = pressing.force,
                                                    .approach_velocity = pressing.approach,
                                                    .band = pressing.tolerance,
                                                    // A surface that the tool slides along comes and goes; one that it
                                                    // rests on shows how hard it is.
                                                    .surface_moves = pressing.path != nullptr,
                                                    .measures_stiffness = pressing.path == nullptr,
                                                    .velocity_max = kMostVelocity * pressing.approach,
                                                    .acceleration_max = kMostAcceleration},
                                          .travel = pressing.travel,
                                          .sink = pressing.drop,
                                          .deepest = pressing.depth,
                                          .softness_across = softness_across(pressing, arm, *direction, q)};
  set_contact_figures(control.force, cell, pressing.sensor);
  control.force.approach_acceleration = approach_acceleration(arm, control.force.contact_force);
  if (pressing.path) {
    auto path = pressing.path({.cell = cell, .direction_B = *direction, .X_BT = X_BT, .q = q});
    if (!path) return std::unexpected(path.error());
    control.path = std::make_shared<const motion::Motion>(std::move(path->motion));
  }
  return PlannedPressing{*direction, std::move(control)};
}

}  // namespace takt::operations
