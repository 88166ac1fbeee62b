#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/command/actions/motion_action.h"
#include "core/command/single_net.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/motion/path_clock.h"

/// The net of one motion, guarded or not, as the mapping makes it from a command.
namespace takt::test {

using expression::Biases;
using expression::Cell;
using expression::Condition;

/// One planned motion of one arm, optionally until a condition over sensors holds: then the arm brakes on its path and
/// the net ends at rest.
struct MotionCommand {
  std::string name;
  std::string arm;
  const motion::Motion* motion = nullptr;                  ///< planned from the arm's set point
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();  ///< LIN: the frame that moves on the line, in the flange
  std::optional<Condition> until;
  double until_from = 0.0;  ///< s of path time from which the condition counts: motions before may be blended into it
};

/// Output ports of a net made by motion_net(); all but the last one only with a condition, read when the net has ended.
namespace motion_ports {
/// Boolean: the condition held, or nobody knew whether it did (row N3); the arm braked on its path.
inline constexpr std::string_view kStopped = "motion-cancel.value";
/// Boolean: the condition held. False beside a true kStopped: a sensor did not answer.
inline constexpr std::string_view kTouched = "touch-first.value";
/// Frame: T in the arm's base, measured, in the cycle in which the condition first held; null before.
inline constexpr std::string_view kTouchFrame = "touch.value";
/// Real, s: how far on its plan the motion is. In every net.
inline constexpr std::string_view kPathTime = "motion/clock.time";
}  // namespace motion_ports

/// A request to cancel and the condition set the clock's target rate to zero in the cycle in which they hold; else it
/// is what the cell's override channel says.
inline net::NetDescription motion_net(const MotionCommand& wanted, const Cell& cell, const Biases& biases) {
  // The plan is written into the net; nothing refers to it afterwards.
  const std::shared_ptr<const motion::Motion> motion(wanted.motion, [](const motion::Motion*) {});
  const command::Action action =
      command::planned({.motion = motion, .X_FM = wanted.X_FM, .handed_over = {wanted.until_from}});
  command::RuntimeCommand moved("motion", command::arm(cell, wanted.arm), action);
  if (wanted.until) {
    expression::State until = expression::state_of(*wanted.until, cell, biases);
    if (wanted.until_from > 0.0) until = until && action.via_passed(0);
    moved.on_entered(until, cancel(moved));
    // A sensor that is silent stops the arm, but it has not felt anything.
    moved.capture("touch", expression::tool_pose(cell, wanted.arm), until);
  }
  return command::single_net(moved, wanted.name).value().net;
}

/// Cycles from a request to cancel to the end of a motion's net, at most (row L6).
inline std::int64_t cancel_bound_cycles(const motion::Motion& motion, Nanoseconds period) {
  const double stop_s = motion::PathClock(motion.clock, motion.duration(), false).stop_time_bound();
  // The net hears of the cancel one cycle after it was asked for, and the clock stands at the end of a whole cycle.
  return static_cast<std::int64_t>(std::ceil(stop_s / to_seconds(period))) + 2;
}

}  // namespace takt::test
