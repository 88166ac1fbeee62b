#include "core/kinematics/urdf_words.h"

#include <functional>
#include <map>

namespace takt::kinematics {

const UrdfWord* urdf_word(std::string_view element) {
  static const std::map<std::string, UrdfWord, std::less<>> kWords = {
      {"robot",
       {{"name", "version", "xmlns:xacro"}, {"link", "joint", "material", "transmission", "gazebo", "sensor"}}},
      {"link", {{"name", "type"}, {"inertial", "visual", "collision"}}},
      {"inertial", {{}, {"origin", "mass", "inertia"}}},
      {"mass", {{"value"}, {}}},
      {"inertia", {{"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}, {}}},
      {"visual", {{"name"}, {"origin", "geometry", "material"}}},
      {"collision", {{"name"}, {"origin", "geometry"}}},
      {"geometry", {{}, {"box", "cylinder", "sphere", "mesh"}}},
      {"box", {{"size"}, {}}},
      {"cylinder", {{"radius", "length"}, {}}},
      {"sphere", {{"radius"}, {}}},
      {"mesh", {{"filename", "scale"}, {}}},
      {"material", {{"name"}, {"color", "texture"}}},
      {"color", {{"rgba"}, {}}},
      {"texture", {{"filename"}, {}}},
      {"origin", {{"xyz", "rpy"}, {}}},
      {"joint",
       {{"name", "type"},
        {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"}}},
      {"parent", {{"link"}, {}}},
      {"child", {{"link"}, {}}},
      {"axis", {{"xyz"}, {}}},
      {"limit", {{"lower", "upper", "velocity", "effort"}, {}}},
      {"dynamics", {{"damping", "friction"}, {}}},
      {"transmission", {{}, {}, true}},
      {"gazebo", {{}, {}, true}},
      {"sensor", {{}, {}, true}},
  };
  const auto found = kWords.find(element);
  return found == kWords.end() ? nullptr : &found->second;
}

}  // namespace takt::kinematics
