#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/kinematics/chain.h"
#include "core/kinematics/robot_model.h"
#include "tools/import/draft.h"

namespace takt::tools {

/// What the rotors add to the joints, kg m^2 or kg, in the order of the chain: of the file, or a guess.
[[nodiscard]] kinematics::JointVector armature_of(const kinematics::Chain& chain, const Draft& draft);

/// Torque limits for joints whose file has none: twice what holding the arm costs in its worst posture and what it
/// takes to speed up well, Nm or N; in the order of the chain.
[[nodiscard]] std::vector<double> guess_effort(const kinematics::Chain& chain, const kinematics::JointVector& armature);

/// A torque limit that files have in place of one: 1 or less, and the joint could not even hold the arm.
struct Placeholder {
  int joint;
  double effort, holding;  ///< Nm or N
};
[[nodiscard]] std::vector<Placeholder> placeholder_efforts(const kinematics::Chain& chain);

/// A posture with room on all sides: of those with the flange straight down in front of the base, elbow up, the one
/// whose neighbours, a hand's width and a good turn away, are farthest from singular postures and limits. The middle of
/// the ranges where there is none. rad or m.
[[nodiscard]] kinematics::JointVector guess_home(const kinematics::RobotModel& robot, const kinematics::Chain& chain);

/// The device file with conservative figures; each is noted in the draft.
[[nodiscard]] nlohmann::ordered_json guess_device(const std::string& name, const kinematics::RobotModel& robot,
                                                  const kinematics::Chain& chain, Draft& draft);

}  // namespace takt::tools
