#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/time.h"
#include "core/command/cell.h"
#include "core/command/condition.h"
#include "core/command/motion_action.h"
#include "core/motion/planner.h"
#include "core/net/description.h"

namespace takt::command {

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

/// The net of a motion: path clock, time law, path, inverse kinematics where the path is Cartesian, arm. A request to
/// cancel and the condition set the clock's target rate to zero in the cycle in which they hold; else it is what the
/// cell's override channel says (nothing there: a pause), or 1 without one.
/// @param command  names an arm, and sensors, that the cell has
/// @param biases   of the sensors in the condition; a sensor that was never tared has none. Realtime: setup.
[[nodiscard]] net::NetDescription motion_net(const MotionCommand& command, const Cell& cell, const Biases& biases);

/// What acts on the clocks of all planned motions of a cell: its override channel; where that says nothing they stand.
[[nodiscard]] ClockInputs clock_inputs(const Cell& cell);

/// Cycles from a request to cancel to the end of a motion's net, at most (row L6). Realtime: setup.
[[nodiscard]] std::int64_t cancel_bound_cycles(const motion::Motion& motion, Nanoseconds period);

/// The net that averages a sensor's reading, tool weight taken out, over `cycles` cycles while the arms stand still.
/// Its result is on kBias; null if the sensor was silent for half a second, or the net was cancelled. Realtime: setup.
[[nodiscard]] net::NetDescription tare_net(const std::string& sensor, std::int64_t cycles, const Cell& cell);
namespace tare_ports {
inline constexpr std::string_view kBias = "tare.bias";  ///< Wrench in the measuring frame
}

}  // namespace takt::command
