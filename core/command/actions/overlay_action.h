#pragma once

#include "core/command/actions/online_action.h"
#include "core/command/actions/weave_plan.h"

/// What is laid over planned motions of a frame, between their set points and the actuator. Realtime: setup.
namespace takt::command {

/// The motion with a weave. Only motions of a frame (LIN, CIRC, splines of poses) can weave; a weave with which the
/// path would be beyond a limit of the tool or of a joint is refused (plan_weaves). Offers what the motion offers.
[[nodiscard]] Action weave(const Action& motion, const WeaveParameters& parameters = {});
/// The same for a sequence: each of its motions with a weave of its own, or without one.
[[nodiscard]] Action weave_each(const Action& motion, const Weaves& weaves);
/// The same for a motion whose weaves are planned already.
[[nodiscard]] Action woven(const Action& motion, const WeavePlan& plan);

/// A force that is held while a path is followed, as in polishing or along a seam: the path is shifted along a
/// direction of the frame that moves, as far as the force wants it and the range allows.
struct ForceOffsetControlParameters {
  ForceControlParameters force = {};  ///< with its bounds of velocity and acceleration
  double jerk_max = 10.0;  ///< of the offset, m/s^3; where the path leaves less, that, but no less than a quarter
  Eigen::Vector3d direction_M = Eigen::Vector3d::UnitZ();  ///< of the force that the tool exerts; length 1
  double reach = 0.005;                                    ///< along the direction at most, m, >= 0
  double retreat = 0.005;                                  ///< against it at most, m, >= 0
  double lost_max = 0.5;               ///< s without contact, once it has been touched, until `lost_contact`
  std::optional<double> off_max = {};  ///< s out of its band, once it was at force, until `off_force`; nothing: never

  bool operator==(const ForceOffsetControlParameters&) const = default;
};

/// The motion with a force offset. Only motions of a frame (LIN, CIRC, splines of poses), which leave the offset what
/// it may need of the limits: what velocity, acceleration (PlanParameters::acceleration below 1) and jerk of the path
/// and of the offset come to together is checked joint by joint all along the path, and refused where it is too much.
///
/// A motion that is paused goes on holding the force. While the force is not known the offset comes to rest and stays,
/// and the motion stops on its path (row N3). At the end, and after a cancel, both come to rest: where that is shows
/// in the run.
/// @param pressing  with which the tool presses along the direction, N (pressing_along)
/// Offers what the motion offers, `in_contact`, `at_force`, `no_force`: the force is not known, and `lost_contact` and
/// `off_force`: contact, or the band of the force, has been left for longer than may be, on the path.
/// @param first  of a sequence: the motion with which it begins, from 0; in the middle of the blend before, or, where
///               that is one of joints, at its end. From there to the end it is one and the same.
[[nodiscard]] Action force_offset(const Action& motion, const expression::RealSensor& pressing,
                                  const ForceOffsetControlParameters& parameters = {}, std::size_t first = 0);

/// With how much force a tool presses along a direction of a frame M that is fixed to the flange: a sensor on that arm
/// feels the opposite. @param X_FM  M in the flange, m
[[nodiscard]] expression::RealSensor pressing_along(const expression::Cell& cell, const std::string& sensor,
                                                    const Eigen::Vector3d& direction_M, const Eigen::Isometry3d& X_FM,
                                                    const expression::Biases& biases = {});

}  // namespace takt::command
