#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/device/arm.h"
#include "core/device/channel.h"
#include "core/device/force_torque_sensor.h"
#include "core/device/gripper.h"
#include "core/device/signal.h"
#include "core/device/tool_changer.h"
#include "core/motion/leg.h"
#include "core/net/value.h"
#include "core/world/belief.h"

namespace takt::net {
struct NetDescription;
class Resource;
}  // namespace takt::net
namespace takt::collision {
struct CellShapes;
}

namespace takt::expression {

/// An arm as it is mounted in the cell. Its base is the frame of its name in the frame graph.
struct MountedArm {
  device::Arm* device = nullptr;                           ///< owned by the control core
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< tool centre point in force, in the flange, m
  device::ToolTip tip = {};                                ///< at the tool centre point in force
  kinematics::JointVector start;                           ///< where the arm is before the program, rad or m
  Eigen::Vector3d gravity_B{0.0, 0.0, -9.81};              ///< m/s^2 in its base
  std::string tool_name = {};  ///< of its default tool, a key of Cell::tools; empty: the flange alone
  /// What it carries without parts: tools, sensors, grippers. Nothing: what it was told first.
  std::optional<device::PayloadSetting> unloaded = {};
  double told_mass = 0.0;  ///< kg at the tool centre point, as a program said without a grip (Actuator::carry)

  /// What was last sent to the arm, rad or m; empty: nothing yet.
  [[nodiscard]] const kinematics::JointVector& set_point() const { return told ? told->q : device->set_point().q; }
  /// The load that the arm is set to; in a rehearsal what it will be set to.
  [[nodiscard]] const device::ToolSetting& tool() const {
    return told ? told->tool : expected ? *expected : device->tool();
  }
  [[nodiscard]] device::ControlMode mode() const { return told ? told->mode : device->mode(); }

  /// Of a copy of the cell for another thread: the settings of the device when the copy was made. It does not change
  /// while the device goes on.
  struct ConfiguredMass {
    kinematics::JointVector q;
    device::ToolSetting tool;
    device::ControlMode mode;
  };
  std::optional<ConfiguredMass> told = {};
  std::optional<device::ToolSetting> expected = {};  ///< of a rehearsal; nothing: that of the device
};

/// What the planners of motions need to know of an arm. It refers to the arm's description.
/// @param X_FM  the frame that Cartesian motions move, in the flange; default: the tool centre point
/// @param tool  what it will carry then; default: what it carries now. Realtime: setup.
[[nodiscard]] motion::ArmModel planning_model(const MountedArm& arm,
                                              const std::optional<Eigen::Isometry3d>& X_FM = std::nullopt,
                                              const std::optional<device::ToolSetting>& tool = std::nullopt);

/// Pose X_BT of the tool centre point of an arm in its base at q (rad or m). Realtime: setup.
[[nodiscard]] Eigen::Isometry3d tool_pose(const MountedArm& arm, const kinematics::JointVector& q);

/// The name of the frame that rides on the flange of an arm, of a base on its body. No name of a file has a '/'.
[[nodiscard]] inline std::string flange_frame(std::string_view arm) { return std::string(arm) + "/flange"; }
/// The frame of one of its links.
[[nodiscard]] inline std::string link_frame(std::string_view arm, std::string_view link) {
  return std::string(arm) + "/" + std::string(link);
}

/// A force/torque sensor on the flange of an arm.
struct MountedSensor {
  device::ForceTorqueSensor* device = nullptr;             ///< owned by the control core
  std::string arm;                                         ///< name of the arm it is mounted on
  Eigen::Isometry3d X_FS = Eigen::Isometry3d::Identity();  ///< measuring frame in the flange, m
  double tool_mass = 0.0;                                  ///< of all that is mounted on the measuring side, kg
  Eigen::Vector3d p_SC = Eigen::Vector3d::Zero();          ///< its centre of mass in the measuring frame, m
  std::vector<std::string> grippers = {};                  ///< on the measuring side: what they hold it feels, too
};

/// A tool on the flange of an arm, or of a sensor on it: whatever has a tool centre point, driven or not.
struct MountedTool {
  static constexpr std::string_view kOwnTcp = "tcp";  ///< that of the model

  std::string arm;                                                  ///< that carries it; empty: it is not coupled
  std::map<std::string, Eigen::Isometry3d, std::less<>> X_FT = {};  ///< tool centre points by name, in the flange, m
  std::string tcp = std::string(kOwnTcp);                           ///< the one that counts where none is named
  device::ToolTip tip = {};                                         ///< at the tool centre points
  /// The tool side of a tool changer that it is mounted on; empty: it is fixed to its arm.
  std::string side = {};
  std::map<std::string, Eigen::Isometry3d, std::less<>> X_ST = {};  ///< tool centre points in that tool side, m
};

/// A gripper on the flange of an arm.
struct MountedGripper {
  device::Gripper* device = nullptr;  ///< owned by the control core
  std::string arm;                    ///< name of the arm it is mounted on; empty: it is not coupled
};

/// The robot side of a tool changer on the flange of an arm. It is a tool of the arm as well, with its coupling face as
/// tool centre point.
struct MountedChanger {
  std::string arm;                                         ///< that carries it
  Eigen::Isometry3d X_FC = Eigen::Isometry3d::Identity();  ///< coupling face in the flange, m
  std::string size = {};                                   ///< tool sides of the same size fit
  device::CouplingTolerance tolerance = {};                ///< within which it couples
  double lock_time = 0.0;                                  ///< s, that its lock takes from one end to the other
};

/// The tool side of a tool changer: what Belief::held says hangs on the changer. An object of the belief has its name;
/// the frame of the object is the coupling face.
struct ToolSide {
  std::string size = {};
  int number = 0;  ///< that the changer reads when it is coupled, from 1
};

/// What the application knows of its cell: what it believes of the world, and its devices. Where things really are only
/// sensors report. Names are unique over all members. Thread: the program's.
struct Cell : world::Belief {
  std::map<std::string, MountedArm, std::less<>> arms;
  std::map<std::string, MountedSensor, std::less<>> sensors;
  std::map<std::string, MountedGripper, std::less<>> grippers;
  std::map<std::string, MountedTool, std::less<>> tools;  ///< grippers included
  std::map<std::string, MountedChanger, std::less<>> changers;
  std::map<std::string, ToolSide, std::less<>> tool_sides;
  // Signals, owned by the control core; null where only names are known.
  std::map<std::string, device::DigitalInput*, std::less<>> digital_inputs;
  std::map<std::string, device::AnalogInput*, std::less<>> analog_inputs;
  std::map<std::string, device::DigitalOutput*, std::less<>> digital_outputs;
  std::map<std::string, device::AnalogOutput*, std::less<>> analog_outputs;
  std::map<std::string, device::Channel*, std::less<>> channels;                        ///< owned by the control core
  std::map<std::string, std::shared_ptr<const net::NetDescription>, std::less<>> nets;  ///< written by hand
  std::string override_channel;                         ///< scales the rate of all planned motions, 0 to 1; empty: none
  Eigen::Vector3d gravity_W{0.0, 0.0, -9.81};           ///< m/s^2
  std::shared_ptr<const collision::CellShapes> shapes;  ///< for checks of collisions; null: nothing is checked
  net::Resource* solids = nullptr;                      ///< the same for nets, owned by the control core; null likewise
};

/// Joint positions by device, rad or m.
using Places = std::map<std::string, kinematics::JointVector, std::less<>>;

/// Constant offsets of sensors as found by taring: sensor name to wrench in its measuring frame.
using Biases = std::map<std::string, net::Wrench, std::less<>>;

}  // namespace takt::expression
