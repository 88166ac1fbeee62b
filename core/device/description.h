#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/control_mode.h"
#include "core/kinematics/types.h"
#include "core/motion/limits.h"

namespace takt::kinematics {
struct RobotModel;
class Chain;
class LinkPaths;
class InverseKinematics;
}  // namespace takt::kinematics

namespace takt::device {

/// What is known of every model of a device: where it lies, and its URDF. Immutable after reading; shared by all
/// devices of the model.
struct ModelDescription {
  virtual ~ModelDescription() = default;
  std::string model;             ///< name of the model's folder
  std::string title;             ///< for people
  std::filesystem::path folder;  ///< where it lies
  std::filesystem::path urdf;    ///< full path
  std::shared_ptr<const kinematics::RobotModel> robot;
};

/// What is known of an arm model: its URDF, and the device file that adds what URDF lacks. Joint arrays are in the
/// order of the chain.
struct ArmDescription : ModelDescription {
  std::string base_link, flange_link;
  std::shared_ptr<const kinematics::Chain> chain;      ///< base link to flange link
  std::shared_ptr<const kinematics::LinkPaths> links;  ///< of the chain's joints; null without a chain
  std::shared_ptr<const kinematics::InverseKinematics> inverse;
  std::vector<std::string> joint_names;
  motion::JointLimits limits;  ///< range and velocity from the URDF; acceleration and jerk from the device file
  motion::CartesianLimits cartesian;
  JointVector effort;                 ///< Nm or N, from the URDF
  JointVector home;                   ///< rad or m, inside the range
  JointVector armature;               ///< rotor inertia seen at the joint, kg m^2 (kg)
  JointVector damping;                ///< viscous friction, Nm s/rad (N s/m), from the URDF
  JointVector friction;               ///< Coulomb friction, Nm (N), from the URDF
  JointVector natural_frequency;      ///< of the position controller, rad/s
  JointVector damping_ratio;          ///< of the position controller, 1
  JointVector friction_observer;      ///< of the position controller, 1/s: its integral part; 0: none
  ControlModes modes;                 ///< what its controller can do
  ImpedanceDescription impedance;     ///< of the modes of impedance that it has
  double position_resolution = 0.0;   ///< rad or m
  double velocity_noise = 0.0;        ///< standard deviation, rad/s or m/s
  JointVector torque_noise;           ///< standard deviation, Nm; size 0: the arm has no torque sensors
  JointVector torque_bias;            ///< standard deviation of the constant offset, Nm; size 0 likewise
  bool torque_at_motor = false;       ///< known from the motors' currents, friction and rotors included; else of joints
  Nanoseconds measurement_delay = 0;  ///< from a measurement to when it can be read
  Nanoseconds measurement_period = 0;  ///< between measurements that can be read; 0: every cycle
  double payload_max = 0.0;            ///< kg; 0: not told
  double payload_rated = 0.0;          ///< kg: with it torque limits leave full accelerations nearly everywhere
  double start_tolerance = 0.01;       ///< rad or m: how far measured and assumed start may lie apart (row S5)
  double following_error = 0.1;        ///< rad or m: how far measured and sent positions may lie apart, delays left out
  Nanoseconds cycle = kMillisecond;    ///< of the device
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// What is known of a six-axis force/torque sensor model.
struct ForceTorqueDescription : ModelDescription {
  std::string mount_link;      ///< the side that is screwed to the flange
  std::string measuring_link;  ///< origin and axes of the reading (frame S); its children hang on the measuring side
  std::string tool_link;       ///< what the next part is screwed to
  Eigen::Isometry3d X_MS = Eigen::Isometry3d::Identity();  ///< measuring frame in the mount frame, m
  Eigen::Isometry3d X_MT = Eigen::Isometry3d::Identity();  ///< tool side in the mount frame, m
  net::Wrench range;                                       ///< largest magnitude per channel, N and Nm
  net::Wrench noise;                                       ///< standard deviation per channel
  net::Wrench bias;                                        ///< standard deviation of the constant offset per channel
  double low_pass_hz = 0.0;                                ///< of the analogue side; 0 = none
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// What is at the tool centre point T of a tool.
struct ToolTip {
  double ball_radius = 0.0;  ///< of a probing ball around T, m; 0: none
  /// By how much springs of the tool give way to a force on T, along each axis of T, m/N.
  Eigen::Vector3d compliance_T = Eigen::Vector3d::Zero();
};

/// What is known of a passive tool: where it acts and what it weighs.
struct ToolDescription : ModelDescription {
  std::string mount_link;
  std::string tcp_link;
  Eigen::Isometry3d X_MT = Eigen::Isometry3d::Identity();  ///< tool centre point in the mount frame, m
  ToolTip tip;
  PayloadSetting payload;  ///< from the URDF, in mount axes
};

/// One terminal of an I/O block. A digital value counts as 0 or 1.
struct IoChannel {
  enum class Kind { kDigitalInput, kDigitalOutput, kAnalogInput, kAnalogOutput };
  Kind kind = Kind::kDigitalInput;
  std::string name;
  std::string unit;                                           ///< of an analog value, as ports write units
  double lower = 0.0, upper = 1.0;                            ///< in that unit
  double resolution = 0.0;                                    ///< of an analog input; 0: exact
  double noise = 0.0;                                         ///< of an analog input: standard deviation per sample
  double initial = 0.0;                                       ///< of an output, before a net has set it
  std::optional<double> stop;                                 ///< of an output; nothing: it holds
  double rate_max = std::numeric_limits<double>::infinity();  ///< of an analog output, unit/s

  [[nodiscard]] bool is_output() const { return kind == Kind::kDigitalOutput || kind == Kind::kAnalogOutput; }
  [[nodiscard]] bool is_analog() const { return kind == Kind::kAnalogInput || kind == Kind::kAnalogOutput; }
};

/// What is known of a block of digital and analog terminals.
struct IoDescription : ModelDescription {
  std::string mount_link;
  std::vector<IoChannel> channels;
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// What is known of a device that looks along a beam: a light barrier or a laser range finder. The beam leaves the
/// origin of its link along z.
struct BeamDescription : ModelDescription {
  std::string mount_link;
  std::string beam_link;
  bool measures_range = false;              ///< false: a light barrier, which only says interrupted or not
  double range_min = 0.0, range_max = 0.0;  ///< m; of a light barrier: to its reflector, at most
  double resolution = 0.0;                  ///< m; 0: exact
  double noise = 0.0;                       ///< m, standard deviation per sample
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// Mass, centre and inertia of all links of a rigid model, about its centre of mass, in the axes of its root link.
/// Realtime: setup.
[[nodiscard]] PayloadSetting rigid_payload(const kinematics::RobotModel& robot);

/// The two rigid bodies as one; both in the same axes. Realtime: setup.
[[nodiscard]] PayloadSetting combine(const PayloadSetting& a, const PayloadSetting& b);

/// The body seen from another frame: `payload` is given in frame M, the result in A with X_AM. Realtime: setup.
[[nodiscard]] PayloadSetting transform(const Eigen::Isometry3d& X_AM, const PayloadSetting& payload);

}  // namespace takt::device
