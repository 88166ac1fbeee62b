#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/control_mode.h"
#include "core/device/tool_changer.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/types.h"
#include "core/kinematics/wheel_drive.h"
#include "core/motion/limits.h"
#include "core/world/bore.h"

struct mjSpec_;
struct mjModel_;

/// What a simulated world is made of, as plain data: robots and objects, where they stand, the simulated devices on
/// them. No word of scenarios or files here. Units are SI; frames: W world (z up), P parent body, B root of a robot,
/// O object, L link, F flange, S sensor.
namespace takt::sim {

using Pose = Eigen::Isometry3d;
using kinematics::JointVector;

/// Where something is fixed. The names of bodies: "ROBOT/LINK" for a link of a robot, "OBJECT" for an object.
struct Mount {
  std::string parent;           ///< name of a body; empty: the world
  Pose X_P = Pose::Identity();  ///< the mounted root (robot root link, object, camera) in the parent body
};

/// How a surface answers a touch, in an engineer's units. What two surfaces do together: sim/contact/contact_law.h.
struct ContactParameters {
  std::string material = {};     ///< by which rules for pairs find it; empty: none
  double stiffness = 6e5;        ///< N/m, of this side
  double damping = 600.0;        ///< N s/m, of this side
  double friction = 0.6;         ///< sliding coefficient
  double torsion = 0.0;          ///< m: torque about the normal over friction force; 0: a point that turns freely
  double rolling = 0.0;          ///< m: torque against rolling over normal force
  bool own_stiffness = false;    ///< stiffness and damping are those of its contacts, whatever it touches
  bool own_friction = false;     ///< the friction is not that of the material, and no rule replaces it,
  bool by_rules = false;         ///< unless rules do
  bool oiled = false;            ///< its contacts have the oiled friction of the pair
  double oiled_friction = 0.15;  ///< sliding coefficient of the material against itself, oiled

  bool operator==(const ContactParameters&) const = default;
};

/// What two materials do together, where it is not what combine() makes of them (sim/contact/contact_law.h).
struct ContactRule {
  std::array<std::string, 2> between;
  std::optional<double> stiffness = {};  ///< N/m, of the contact
  std::optional<double> damping = {};    ///< N s/m
  std::optional<double> friction = {};
  std::optional<double> oiled_friction = {};
};

/// A spring that holds a joint at zero, within the range of the URDF, whose ends are stops.
struct JointSpring {
  double stiffness = 0.0;  ///< N/m or Nm/rad
  double damping = 0.0;    ///< N s/m or Nm s/rad
  double preload = 0.0;    ///< N or Nm, onto the stop at zero

  bool operator==(const JointSpring&) const = default;
};

/// What a URDF does not say about a joint of the machine. Absent figures come from the URDF (damping, friction) or are
/// zero (armature).
struct JointFigures {
  std::string joint;                   ///< name in the URDF
  double armature = 0.0;               ///< kg m^2 or kg: rotor inertia times gear ratio squared
  std::optional<double> coulomb = {};  ///< Nm or N
  std::optional<double> viscous = {};  ///< Nms/rad or Ns/m
  std::optional<JointSpring> spring = {};
};

/// A machine from a URDF: an arm, a sensor body, a tool. Joints that no device drives move freely.
struct RobotDescription {
  std::string name;
  std::string pointer;  ///< where it stands in the user's file; diagnostics are placed there
  std::shared_ptr<const kinematics::RobotModel> model;
  Mount mount;
  std::vector<JointFigures> joints;
  std::vector<double> q;  ///< start position of the movable joints in the order of the URDF; empty: zeros
  ContactParameters contact;
  std::map<std::string, ContactParameters> link_contacts = {};  ///< by link, where it differs
  std::map<std::string, double> chamfers = {};  ///< m, by link: of both ends of its cylinders, at 45 degrees
  std::set<std::string> bits = {};              ///< links that turn screws; with a chamfer
  std::string lit_by = {};      ///< digital wire at which its shapes of material "light" burn; empty: they never do
  bool free = false;            ///< its root moves freely (only without a parent); otherwise fixed to its parent
  bool self_collision = false;  ///< whether links of this robot (and of what is mounted on it) can touch each other
  double stop_margin = 0.035;   ///< rad or m: the mechanical stops lie this far beyond the limits of the URDF

  [[nodiscard]] const ContactParameters& surface(const std::string& link) const {
    const auto own = link_contacts.find(link);
    return own == link_contacts.end() ? contact : own->second;
  }
};

struct Capsule {
  double radius = 0.0;
  double length = 0.0;  ///< of the cylindrical part
};
using ObjectShape = std::variant<kinematics::Box, kinematics::Cylinder, kinematics::Sphere, Capsule, kinematics::Mesh>;

/// A part of an object.
struct ObjectGeometry {
  ObjectShape shape;
  Pose X_OG = Pose::Identity();
  Eigen::Vector4d rgba = Eigen::Vector4d(0.6, 0.6, 0.62, 1.0);
  std::string material = {};  ///< name of a material of the stage; empty: rgba
  bool visible = true;
  bool solid = true;     ///< takes part in contacts
  double mass = 0.0;     ///< kg; if one shape has one, the shapes have theirs and ObjectDescription::mass is their sum
  double chamfer = 0.0;  ///< m, at 45 degrees, of both ends of a cylinder
  std::vector<world::Bore> bores = {};  ///< in a box or a cylinder (sim/model/solids.h)
  std::string pointer = {};             ///< where it is in the user's file; empty: that of the object
};

/// A metric thread, in m and Nm (docs/threads.md).
struct ThreadFigures {
  std::string size;             ///< "M6"
  double pitch = 0.0;           ///< a turn
  double major = 0.0;           ///< outer diameter of the screw
  double pitch_diameter = 0.0;  ///< where the flanks meet
  double run_down = 0.0;        ///< what turning the free screw takes
  double friction = 0.0;        ///< of the flanks
};

/// What makes an object a screw.
struct ScrewDescription {
  ThreadFigures thread;
  Pose X_OT = Pose::Identity();  ///< the end of its shank, z towards its head
  std::size_t shank = 0;         ///< number of the shape that has the thread
};

struct ObjectDescription {
  std::string name;
  std::string pointer;
  Mount mount;
  std::vector<ObjectGeometry> shapes;
  double mass = 0.0;  ///< kg, spread evenly over the shapes by volume; must be > 0 if the object is free
  std::optional<kinematics::Inertial> inertial = {};  ///< in O; instead of the mass spread over the shapes
  bool free = false;  ///< moves freely (only without a parent); otherwise fixed to its parent
  ContactParameters contact;
  std::string lit_by = {};                     ///< digital wire at which it burns; empty: it is no lamp
  std::optional<ScrewDescription> screw = {};  ///< fixed: a bolt (sim/contact/thread_law.h)
};

/// A camera looks along its own -z, +y is up in the picture.
struct CameraDescription {
  std::string name;
  std::string pointer;
  Mount mount;
  double vertical_field_of_view = 0.785;  ///< rad
};

/// Pose of a camera in the frame in which `eye`, `target` and `up` are given.
[[nodiscard]] Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                           const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// The simulated controller of an arm (docs/simulation.md, "The controller"). Joint vectors in the order of the chain;
/// size 0 stands for the default.
struct ArmControlParameters {
  JointVector natural_frequency;       ///< rad/s of the position loop; default 60
  JointVector damping_ratio;           ///< default 1
  double friction_compensation = 0.8;  ///< share of the joint friction that the controller feeds forward, 0..1
  JointVector friction_observer;       ///< 1/s: how fast it learns the friction that it does not know; default 0: not
  double friction_uncertainty = 0.25;  ///< share of the joint friction that this can be at most, 0..1
  double following_error_limit = 0.1;  ///< rad or m between set point and joint; beyond it the brakes close
  double overspeed_factor = 1.3;       ///< times the velocity limit; beyond it the brakes close
  double brake_factor = 1.5;           ///< holding torque of the brakes over the effort limit
  device::ControlModes modes;          ///< and the classes of change, which the device keeps by itself
  device::ImpedanceDescription impedance;
  motion::JointLimits limits;     ///< of its own stops; without figures it can only brake (category 0)
  JointVector protective_torque;  ///< Nm or N: external torque at which it stops by itself; default: never
};

/// What the arm's own sensors make of the truth. Noise is normal, independent in each sample.
struct ArmMeasurement {
  double position_resolution = 0.0;  ///< rad or m; 0: exact
  double velocity_noise = 0.0;       ///< sigma, rad/s or m/s
  bool torque_sensors = true;        ///< without them ArmSample::tau and tau_external have size 0
  bool torque_at_motor = false;  ///< read from the motors' currents, friction and rotors included; else behind gears
  double observer_gain = 50.0;   ///< 1/s: how fast the estimate of external torques follows
  Nanoseconds delay = 0;         ///< from a sample to when it can be read; whole cycles
  Nanoseconds period = 0;        ///< between samples that can be read; whole cycles; 0: every cycle
  JointVector torque_noise;      ///< sigma, Nm or N; size 0: none
  JointVector torque_bias;       ///< sigma of the constant offset that the seed draws, Nm or N; size 0: none
};

/// By how much the odometry of a base counts wrong. The default is right.
struct OdometryError {
  double linear_scale = 1.0;   ///< counted way over true way
  double angular_scale = 1.0;  ///< counted turn over true turn
  double heading_drift = 0.0;  ///< turn that is counted and not there, rad per metre of way
  double random_walk = 0.0;    ///< sigma of the counted way along x and y, m per square root of a metre

  bool operator==(const OdometryError&) const = default;
};

/// What makes an arm of the joints x, y, yaw a base on wheels.
struct SimDriveDescription {
  kinematics::WheelDrive drive;
  std::vector<std::string> wheels;  ///< joints of the robot, in the order of the drive; they turn with the motion
  Pose X_FD = Pose::Identity();     ///< middle of the wheels in the flange, on the floor
  double grip = 0.7;                ///< friction of the wheels on the floor
  OdometryError error = {};
};

/// Name of the sensor of what the floor does to the wheels of a base; "/force" and "/torque" of it in the model.
[[nodiscard]] inline std::string support_sensor(const std::string& device) { return device + "/support"; }

struct SimArmDescription {
  std::string name;  ///< of the device
  std::string pointer;
  std::string robot;      ///< name of the robot it drives
  std::string base_link;  ///< the chain that the controller computes with
  std::string flange_link;
  ArmControlParameters control;
  ArmMeasurement measurement;
  /// What the controller is told to carry at the start; absent: what the URDFs of all that is fixed to the flange say.
  std::optional<device::PayloadSetting> payload;
  double payload_mass_error = 0.0;                ///< kg added to the controller's belief, never to the plant
  std::optional<SimDriveDescription> drive = {};  ///< of a mobile base
};

/// A six-axis sensor between the tool-side body and that body's parent.
struct SimForceTorqueDescription {
  std::string name;  ///< of the device
  std::string pointer;
  std::string tool_side;                                          ///< body "ROBOT/LINK" on the side of the tool
  Pose X_LS = Pose::Identity();                                   ///< measuring frame S in that body
  Eigen::Vector3d force_range = Eigen::Vector3d::Constant(1e9);   ///< N, symmetric; readings are clipped there
  Eigen::Vector3d torque_range = Eigen::Vector3d::Constant(1e9);  ///< Nm
  Eigen::Vector3d force_noise = Eigen::Vector3d::Zero();          ///< N, sigma per sample
  Eigen::Vector3d torque_noise = Eigen::Vector3d::Zero();         ///< Nm
  Eigen::Vector3d force_bias = Eigen::Vector3d::Zero();           ///< N, sigma of the offset that the seed draws
  Eigen::Vector3d torque_bias = Eigen::Vector3d::Zero();          ///< Nm
  double low_pass_Hz = 0.0;                                       ///< first-order corner; 0: none
  Nanoseconds period = kMillisecond;  ///< between samples; a whole multiple of the world's period
};

/// A parallel gripper with its controller (sim/machines/gripper.h). Two joints of a robot, zero where it is closed.
struct SimGripperDescription {
  std::string name;  ///< of the device
  std::string pointer;
  std::string robot;                   ///< name of the robot whose fingers it drives
  std::array<std::string, 2> fingers;  ///< joints in its URDF
  double finger_mass = 0.0;            ///< kg: the heavier of the two, as the URDF says
  double finger_inertia = 0.0;         ///< kg: what the drive adds to each
  double speed_max = 0.0;              ///< of the width, m/s
  double acceleration = 0.0;           ///< of the width, m/s^2
  double force_min = 0.0;              ///< N, sum over the fingers
  double force_max = 0.0;              ///< N
  double width_resolution = 0.0;       ///< m; 0: exact
  Nanoseconds period = kMillisecond;   ///< between samples; a whole multiple of the world's period
};

/// The tool side of a tool changer: a free robot whose root is its coupling face.
struct SimToolSideDescription {
  std::string name;  ///< of the device
  std::string pointer;
  std::string body;  ///< "ROBOT/LINK", the root of the robot
  std::string size;
  int number = 0;  ///< that a changer reads, from 1
};

/// The robot side of a tool changer (sim/machines/tool_changer.h).
struct SimToolChangerDescription {
  std::string name;  ///< of the device
  std::string pointer;
  std::string body;              ///< "ROBOT/LINK" that carries the coupling face
  Pose X_LC = Pose::Identity();  ///< coupling face in that body, z towards the tool
  std::string size;              ///< of tool sides that fit
  device::CouplingTolerance tolerance;
  double lock_time = 0.1;             ///< s, of the lock from one end to the other
  std::string coupled = {};           ///< the tool side that hangs on it at the start; empty: none, and it is unlocked
  Nanoseconds period = kMillisecond;  ///< between samples; a whole multiple of the world's period
};

/// An output terminal. Its wire has its name.
struct SimOutputDescription {
  std::string name;
  std::string pointer;
  bool analog = false;
  double initial = 0.0;  ///< digital: 0 or 1
};

/// An input terminal.
struct SimInputDescription {
  struct Step {
    Nanoseconds from = 0;
    double value = 0.0;
  };
  std::string name;
  std::string pointer;
  bool analog = false;
  double lower = 0.0, upper = 1.0;    ///< readings are clipped there
  double resolution = 0.0;            ///< 0: exact
  double noise = 0.0;                 ///< sigma per sample
  std::string source;                 ///< name of an output or a beam; empty: the script
  std::vector<Step> script;           ///< sorted by time; before the first: 0
  Nanoseconds period = kMillisecond;  ///< between samples; a whole multiple of the world's period
};

/// A light barrier or a laser range finder. Its wire has its name.
struct SimBeamDescription {
  std::string name;
  std::string pointer;
  std::string body;             ///< the beam leaves its origin along z
  bool measures_range = false;  ///< false: light barrier
  double range_min = 0.0;       ///< m
  double range_max = 0.0;       ///< m; of a light barrier: to its reflector
  double resolution = 0.0;      ///< m
  double noise = 0.0;           ///< m, sigma per sample
  Nanoseconds period = kMillisecond;
};

class SimDevice;
struct WorldDescription;

/// The wires that light something, each once, in the order of the description. Their number in this list is that of
/// their value in the userdata of a state that is drawn; a shape that burns with wire i has i + 1 as its userdata.
/// Realtime: setup.
[[nodiscard]] std::vector<std::string> lamp_wires(const WorldDescription& description);

/// A simulated device of a kind of its own: whoever describes it also makes it.
struct SimDeviceDescription {
  std::string name;
  std::string pointer;
  /// Adds to the specification what the device needs, under names that begin with its own; may be empty. Called for the
  /// plant and for the pictures.
  std::function<void(mjSpec_&)> extend;
  /// Makes the device from the compiled plant. @return it, or what is wrong with it.
  std::function<Result<std::unique_ptr<SimDevice>>(const mjModel_&, const WorldDescription&)> make;
};

enum class Integrator { kEuler, kImplicitFast, kRungeKutta4 };

struct Physics {
  Nanoseconds period = kMillisecond;                           ///< one control cycle = one World::step
  Nanoseconds timestep = kMillisecond;                         ///< of the physics; divides the period
  Eigen::Vector3d gravity = Eigen::Vector3d(0.0, 0.0, -9.81);  ///< m/s^2 in W
  Integrator integrator = Integrator::kEuler;
  bool search_all_pairs = false;  ///< for contacts, also those of bodies that can never meet (sim/world/reach.h)
  /// Trees of bodies that no contact and no constraint joins are solved apart, with sparse matrices where there are
  /// many bodies (sim/contact/islands.h); false: all bodies in one dense system, for comparisons.
  bool islands = true;
  bool rest = true;  ///< free objects that lie still fall asleep (sim/contact/rest.h); only with islands
  int solver_iterations = 20;
  double solver_tolerance = 1e-10;
  double plant_mass_scale = 1.0;  ///< multiplies mass and inertia of all robots in the plant only (row D6)
};

struct WorldDescription {
  Physics physics;
  std::vector<RobotDescription> robots;
  std::vector<ObjectDescription> objects;
  std::vector<CameraDescription> cameras;
  std::vector<SimArmDescription> arms;
  std::vector<SimForceTorqueDescription> force_torque_sensors;
  std::vector<SimGripperDescription> grippers;
  std::vector<SimToolSideDescription> tool_sides;
  std::vector<SimToolChangerDescription> tool_changers;
  std::vector<SimOutputDescription> outputs;
  std::vector<SimInputDescription> inputs;
  std::vector<SimBeamDescription> beams;
  std::vector<SimDeviceDescription> devices;
  std::vector<ContactRule> contact_rules;
  std::uint64_t seed = 1;  ///< of all noise; each device draws from a stream of its own name
};

}  // namespace takt::sim
