#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/command/cell.h"
#include "core/command/condition.h"
#include "core/command/press_action.h"
#include "core/motion/planner.h"
#include "core/net/description.h"

/// Nets in which a contact force is controlled along one direction. Realtime: setup.
namespace takt::command {

/// Moves along a direction until something is touched, then presses with a force, and follows a path across the
/// direction if there is one. The orientation and, without a path, the measured place across are held.
struct PressCommand {
  std::string name, arm;
  std::string sensor;                    ///< force/torque sensor on this arm
  Eigen::Vector3d direction_B;           ///< of the force that the tool exerts, in the arm's base; of length 1
  double force = 10.0;                   ///< N
  double approach = 0.002;               ///< m/s, until the touch
  double travel = 0.05;                  ///< m along the direction at most
  const motion::Motion* path = nullptr;  ///< as PressWish::path; nullptr: none
  std::optional<double> hold;            ///< s of contact without a break; without a path
  std::optional<double> drop;  ///< m: it has found something when it sinks so much deeper than where it touched
  std::optional<Condition> until;
};

/// Outputs of a net made by press_net(), read when it has ended: Booleans that say why. The first three may not be
/// there.
namespace press_ports {
inline constexpr std::string_view kHeld = "held-first.value";        ///< with `hold`: pressed for so long
inline constexpr std::string_view kFound = "found-first.value";      ///< with `drop`
inline constexpr std::string_view kUntil = "until-first.value";      ///< with `until`: the condition held
inline constexpr std::string_view kTouched = "touched-first.value";  ///< there was contact
inline constexpr std::string_view kTooFar = "too-far-first.value";   ///< the travel was used up
inline constexpr std::string_view kSilent = "silent-first.value";    ///< the force sensor did not answer
}  // namespace press_ports

/// How the command presses, as a wish of press(); it refers to the command's path.
[[nodiscard]] PressWish press_wish(const PressCommand& command, const Cell& cell);
/// @param biases  of the sensors; without a tare the sensor's own offset counts as force
[[nodiscard]] net::NetDescription press_net(const PressCommand& command, const Cell& cell, const Biases& biases);

}  // namespace takt::command
