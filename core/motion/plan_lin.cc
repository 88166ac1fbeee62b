#include <limits>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/joint_range.h"
#include "core/motion/path_planner.h"
#include "core/motion/plan_checks.h"
#include "core/motion/planner.h"

namespace takt::motion {
namespace {

using kinematics::Chain;
using kinematics::InverseKinematics;

void check_held(const InverseKinematics& inverse, const JointLimits& limits, const JointVector& held,
                Diagnostics& diagnostics) {
  const auto& joints = inverse.held_joints();
  if (held.size() != static_cast<Eigen::Index>(joints.size())) {
    diagnostics.error(Code::kWrongSize, "/held_goal", fmt::format("{} values", held.size()),
                      fmt::format("Give one for each of the {} held joints", joints.size()));
    return;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double q = held[static_cast<Eigen::Index>(i)];
    const int joint = joints[i];
    if (kinematics::is_in_range(q, limits.lower[joint], limits.upper[joint])) continue;
    range_diagnostic(inverse.chain(), limits, joint, q, "/held_goal" + pointer_segment(i), "", diagnostics);
  }
}

}  // namespace

Result<Motion> plan_lin(const Chain& chain, const InverseKinematics& inverse, const JointLimits& limits,
                        const CartesianLimits& cartesian_limits, const JointVector& q_start,
                        const Eigen::Isometry3d& X_BM_goal, const std::optional<JointVector>& held_goal,
                        const MotionOptions& options) {
  Diagnostics diagnostics;
  check_limits(chain, limits, diagnostics);
  check_cartesian(cartesian_limits, diagnostics);
  check_options(options, diagnostics);
  check_pose(X_BM_goal, "/goal", diagnostics);
  check_pose(options.X_FM, "/options/X_FM", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  check_configuration(chain, limits, q_start, "/start", diagnostics);
  if (held_goal) check_held(inverse, limits, *held_goal, diagnostics);
  check_directions(inverse, q_start, X_BM_goal * options.X_FM.inverse(), "/goal", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  const JointVector held_start = inverse.held(q_start);
  const CartesianLine line = CartesianLine::between(chain.forward(q_start) * options.X_FM, X_BM_goal, held_start,
                                                    held_goal.value_or(held_start));
  const bool stands = line.length == 0.0 && line.angle == 0.0 && line.held_start.isApprox(line.held_goal, 1e-14);
  if (stands)
    return Motion{.path = line, .law = {}, .clock = {}, .q_start = q_start, .q_goal = q_start, .shares = {{}}};
  PlannedPiece piece{
      .piece = {.geometry = line},
      .shares = {.velocity = options.velocity,
                 .acceleration = options.acceleration,
                 .linear_velocity = options.linear_velocity.value_or(std::numeric_limits<double>::infinity())}};
  std::size_t failed = 0;
  const DriveLoad* load = options.load ? &*options.load : nullptr;
  return PathPlanner(chain, &inverse, limits, cartesian_limits, options.X_FM, load)
      .plan({piece}, q_start, "/goal", failed);
}

}  // namespace takt::motion
