#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/object_reader.h"
#include "core/device/description.h"

namespace takt::kinematics {
struct RobotModel;
}

namespace takt::device {

/// A joint that no drive moves and a spring holds at zero: a sprung probe, a compliant finger.
struct SpringJoint {
  std::string joint;       ///< of the URDF; its range is the travel
  double stiffness = 0.0;  ///< N/m, or Nm/rad of a revolute joint
  double damping = 0.0;    ///< N s/m, or Nm s/rad
  double preload = 0.0;    ///< N or Nm, onto the stop at zero: the joint does not move for less
};

/// What a device file says of the machine itself, which only its simulation needs (docs/contacts.md).
struct PlantDescription {
  std::string material = "steel";       ///< of its surfaces
  std::string pad_material = "rubber";  ///< of a gripper's fingers
  std::vector<SpringJoint> springs;
  std::map<std::string, double> chamfers;  ///< m, by link: of both ends of its cylinders
  std::vector<double> protective_torque;   ///< Nm or N per joint; empty: not given
  bool protective_stop_off = false;        ///< the file says why
};

/// By how much springs between the root and a link give way to a force on the link's origin, along each of its axes,
/// m/N; preloads do not count. Realtime: setup.
[[nodiscard]] Eigen::Vector3d compliance_of(const kinematics::RobotModel& robot,
                                            const std::vector<SpringJoint>& springs, const std::string& link);

/// Asks the reader for the keys that belong to a plant; what is wrong with them becomes diagnostics. Realtime: setup.
/// @param robot  null where the URDF could not be read
/// @param kind   "arm", "gripper", ...: keys of other kinds stay unknown
PlantDescription read_plant_keys(ObjectReader& reader, const kinematics::RobotModel* robot, const std::string& kind);

}  // namespace takt::device
