#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>

#include "core/activity/activity_model.h"
#include "core/command/actions/compliance_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/actions/overlay_action.h"
#include "core/command/actions/weave_plan.h"

/// Motions of one arm as activities. Realtime: setup.
namespace takt::activity {

/// Where a motion may be left for the next one: at a share of its time, or of its path.
struct BlendingCondition {
  std::optional<double> time_share = {};  ///< 0.7: when 70 % of its time have passed; [0.5, 1)
  motion::Blend along_path = {};          ///< a distance from its goal, or a share of its path

  BlendingCondition() = default;
  BlendingCondition(double share) : time_share(share) {}  // NOLINT: reads as in the paper: {.blend = 0.7}
  explicit BlendingCondition(const motion::Blend& blend) : along_path(blend) {}
  [[nodiscard]] static BlendingCondition at_distance(double metres);
  [[nodiscard]] bool wanted() const { return time_share || along_path.kind != motion::Blend::Kind::kNone; }
};

/// A force that is held along a direction of the tool while a path is followed.
struct HeldForce {
  std::string sensor;            ///< that feels it
  command::RealSensor pressing;  ///< with how much the tool presses along the direction, N
  command::ForceOffsetControlParameters parameters;
};

/// What planning needs to know of how a motion is to be carried out; programs and files have MotionParameters
/// (core/operations/motion.h). Shares are of the limits of the arm.
struct MotionOptions {
  double velocity = 1.0;                       ///< (0, 1]
  double acceleration = 1.0;                   ///< (0, 1]
  std::optional<double> linear_velocity = {};  ///< of the tool centre point, m/s
  BlendingCondition blend = {};                ///< into the motion after it; not with `until`
  /// The arm brakes on its path when this holds (or is unknown, row N3): a guarded motion.
  std::optional<command::State> until = {};
  bool must_touch = true;  ///< it fails where it comes to its goal and `until` has not held
  /// Must not hold while this motion is done, nor on what a successor does of it: the arm brakes on its path then, or
  /// when it is null (row N3), and the run fails (RunFailure::kAborted). It may be blended.
  std::optional<command::State> abort_if = {};
  std::optional<Eigen::Isometry3d> X_FM = {};  ///< the frame that moves, in the flange; default: the arm's tool
  /// Compliance of the arm meanwhile; it has to be in that control mode. Default: as the arm is.
  std::optional<command::SpringParameters> compliance = {};
  /// Laid over the path, which has at most kShareWithOverlay of the accelerations then. Neighbours in one plan hand it
  /// on (command::plan_weaves); where the next motion takes over in the run it ends at rest before.
  std::optional<command::WeaveParameters> weave = {};
  std::optional<HeldForce> force_offset = {};  ///< laid over the path, in place of a weave
};

/// Is the blend one that can be? Diagnostics at "/blend".
void check_blend(const MotionOptions& options, Diagnostics& diagnostics);

/// Geometry from where the arm will be.
using LegOf = std::function<Result<motion::Leg>(const motion::ArmModel&, const kinematics::JointVector& q)>;

/// A motion of one arm. @param kind  for people: "LIN"
[[nodiscard]] ActivityPtr motion_activity(std::string kind, std::string arm, LegOf leg, MotionOptions parameters);

using command::path_rate_channel;
using command::path_time_channel;
/// The channel by which people set the speed of an arm's motions.
[[nodiscard]] std::string speed_channel(const std::string& arm);  ///< 1; the rate that is aimed at, [0, 1]

}  // namespace takt::activity
