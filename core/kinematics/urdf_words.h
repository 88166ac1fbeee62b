#pragma once

#include <set>
#include <string>
#include <string_view>

namespace takt::kinematics {

/// What may stand in an element of a URDF.
struct UrdfWord {
  std::set<std::string> attributes;
  std::set<std::string> children;
  bool foreign = false;  ///< belongs to another program: known, but neither read nor looked into
};

/// The entry for an element of that name, or null for an unknown one. Source: the URDF specification of ROS.
[[nodiscard]] const UrdfWord* urdf_word(std::string_view element);

}  // namespace takt::kinematics
