#pragma once

#include <optional>
#include <vector>

#include "core/device/description.h"
#include "tools/cli.h"

/// Kinematics of an arm for the verb `model`: what it answers to --fk and --ik.
namespace takt::tools {

/// What --fk asks: joint positions, rad or m.
int print_forward(const device::ArmDescription& arm, const std::vector<double>& q, const Common& common);

/// What --ik asks.
struct InverseQuestion {
  std::vector<double> pose;         ///< x, y, z in m, quaternion w, x, y, z
  std::optional<double> arm_angle;  ///< rad
  std::optional<double> held;       ///< value of the redundant joint, rad or m
  bool turns = true;                ///< turns of 2 pi count as solutions of their own
};
int print_inverse(const device::ArmDescription& arm, const InverseQuestion& question, const Common& common);

/// "closed form: ...", "elimination", "search": how all solutions of a pose are found.
[[nodiscard]] std::string way_to_solutions(const device::ArmDescription& arm);

}  // namespace takt::tools
