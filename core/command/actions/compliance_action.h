#pragma once

#include <optional>
#include <string>
#include <variant>

#include "core/command/action.h"

/// Compliance of an arm while it does something else (docs/control-modes.md). Realtime: setup.
namespace takt::command {

/// As a stiff servo: control mode "position".
struct Stiff {};

/// As a spring and a damper in each joint. One entry per joint; what is not given is the device's standard.
struct JointCompliance {
  std::optional<expression::Term<net::JointArray>> stiffness = {};      ///< Nm/rad, of a sliding joint N/m
  std::optional<expression::Term<net::JointArray>> damping_ratio = {};  ///< of critical damping
  std::optional<expression::Term<net::JointArray>> torque = {};         ///< added to that of the springs, Nm or N
};

/// As a spring and a damper at the tool centre point. What is not given is the device's standard.
struct CartesianCompliance {
  std::optional<expression::VectorTerm> stiffness = {};             ///< along x, y, z, N/m
  std::optional<expression::VectorTerm> rotational_stiffness = {};  ///< about x, y, z, Nm/rad
  std::optional<expression::RealTerm> damping_ratio = {};           ///< of critical damping, of all axes
  std::optional<expression::Term<net::Wrench>> wrench = {};  ///< that the tool exerts beside the spring, N and Nm
  std::optional<expression::RealTerm> nullspace_stiffness =
      {};                     ///< of the posture in what the tool does not feel, Nm/rad
  bool in_tool_axes = false;  ///< stiffness and wrench, else in the axes of the base
};

using SpringParameters = std::variant<Stiff, JointCompliance, CartesianCompliance>;
/// The control mode that it needs.
[[nodiscard]] device::ControlMode mode_of(const SpringParameters& parameters);
/// Both ask for the same, equal constants and the same formulas, or neither asks for anything.
[[nodiscard]] bool same(const std::optional<SpringParameters>& a, const std::optional<SpringParameters>& b);

/// Constants that the device does not allow, at "/compliance/PORT" and below. @param arm  for people
[[nodiscard]] Diagnostics check_compliance(const SpringParameters& parameters,
                                           const device::ArmDescription& description, const std::string& arm);

/// The action on an arm with this compliance, whatever it is: a motion, a hold, a jog. Stiffness, damping and
/// wrench may be formulas; they are approached with the rates of the device, and null there ends the net (row N4).
/// Constants that the device does not allow are refused, values of formulas are the guard's. Offers what the action
/// offers, and `settled`: stiffness and damping are as requested. An arm without that mode is refused (rule C8).
/// START checks in which mode the arm is. Two arms as one have the same springs, each in its own axes, and exert
/// nothing beside them.
[[nodiscard]] Action with_compliance(const Action& action, const SpringParameters& parameters);

}  // namespace takt::command
