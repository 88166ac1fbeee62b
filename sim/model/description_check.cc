#include "sim/model/description_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "sim/model/solids.h"

namespace takt::sim {
namespace {

using kinematics::Joint;
using kinematics::JointType;
using kinematics::RobotModel;

/// One check run over a description; collects what is wrong.
class Checker {
 public:
  explicit Checker(const WorldDescription& description) : world_(description), bodies_(body_names(description)) {}

  Diagnostics run() {
    physics();
    for (const auto& robot : world_.robots) check(robot);
    for (const auto& object : world_.objects) check(object);
    for (const auto& camera : world_.cameras) check(camera);
    for (const auto& arm : world_.arms) check(arm);
    for (const auto& sensor : world_.force_torque_sensors) check(sensor);
    for (const auto& gripper : world_.grippers) check(gripper);
    for (const auto& side : world_.tool_sides) check(side);
    for (const auto& changer : world_.tool_changers) check(changer);
    for (const auto& beam : world_.beams) check(beam);
    check_signals();
    for (const auto& device : world_.devices) {
      name(devices_, place(device.pointer, "devices", device.name), device.name, true);
    }
    mount_loops();
    return std::move(diagnostics_);
  }

 private:
  void error(Code code, const std::string& at, std::string message, std::string hint = {}) {
    diagnostics_.error(code, at, std::move(message), std::move(hint));
  }
  void require(bool holds, const std::string& at, std::string_view what, double value, std::string_view allowed) {
    if (!holds) error(Code::kOutOfRange, at, fmt::format("{} is {}", what, value), std::string(allowed));
  }

  void physics() {
    const Physics& p = world_.physics;
    const std::string at = "/physics";
    if (p.timestep <= 0 || p.period <= 0 || p.period % p.timestep != 0) {
      error(Code::kOutOfRange, at,
            fmt::format("a period of {} ns does not hold whole physics steps of {} ns", p.period, p.timestep),
            "Make both > 0, and the period a whole multiple of the timestep");
    }
    require(p.gravity.allFinite(), at, "gravity", p.gravity.norm(), "finite, m/s^2");
    require(p.plant_mass_scale > 0.0 && std::isfinite(p.plant_mass_scale), at, "plant_mass_scale", p.plant_mass_scale,
            "> 0");
  }

  /// Bodies and cameras share one space of names, devices have their own.
  void name(std::set<std::string>& taken, const std::string& at, const std::string& given, bool slash_allowed) {
    if (given.empty()) error(Code::kMissing, at, "the name is empty");
    if (!slash_allowed && given.find('/') != std::string::npos) {
      error(Code::kInvalidName, at, fmt::format("the name '{}' holds a '/'", given),
            "Leave out '/', which separates robot and link");
    }
    if (!given.empty() && !taken.insert(given).second)
      error(Code::kDuplicate, at, fmt::format("the name '{}' is taken", given));
  }

  void mount(const std::string& at, const Mount& mount) {
    if (!mount.X_P.matrix().allFinite()) error(Code::kOutOfRange, at, "the pose is not finite");
    if (!mount.parent.empty() && std::ranges::find(bodies_, mount.parent) == bodies_.end()) {
      error(Code::kUnknownName, at, fmt::format("unknown parent '{}'", mount.parent),
            nearest_choice(mount.parent, bodies_));
    }
  }

  void contact(const std::string& at, const ContactParameters& c) {
    require(c.friction >= 0.0 && std::isfinite(c.friction), at, "friction", c.friction, ">= 0");
    require(c.stiffness > 0.0 && std::isfinite(c.stiffness), at, "the contact's stiffness", c.stiffness, "> 0 N/m");
    require(c.damping >= 0.0 && std::isfinite(c.damping), at, "the contact's damping", c.damping, ">= 0 N s/m");
    require(c.torsion >= 0.0 && std::isfinite(c.torsion), at, "the contact's torsion", c.torsion, ">= 0 m");
    require(c.rolling >= 0.0 && std::isfinite(c.rolling), at, "the contact's rolling", c.rolling, ">= 0 m");
  }

  void check(const RobotDescription& robot) {
    const std::string at = place(robot.pointer, "robots", robot.name);
    name(names_, at, robot.name, false);
    mount(at, robot.mount);
    contact(at, robot.contact);
    for (const auto& [link, surface] : robot.link_contacts) contact(at, surface);
    require(robot.stop_margin >= 0.0, at, "stop_margin", robot.stop_margin, ">= 0");
    for (const auto& [link, chamfer] : robot.chamfers) require(chamfer > 0.0, at, "a chamfer", chamfer, "> 0 m");
    if (robot.free && !robot.mount.parent.empty())
      error(Code::kConflict, at, fmt::format("a free model cannot have the parent '{}'", robot.mount.parent));
    if (!robot.model || robot.model->links.empty()) return error(Code::kMissing, at, "the robot has no model");
    const auto joints = movable_joints(*robot.model);
    if (!robot.q.empty() && robot.q.size() != joints.size()) {
      error(Code::kWrongSize, at,
            fmt::format("{} start positions for {} movable joints", robot.q.size(), joints.size()));
    }
    for (std::size_t i = 0; i < std::min(robot.q.size(), joints.size()); ++i) {
      const Joint& joint = *joints[i];
      const bool within = robot.q[i] >= joint.lower && robot.q[i] <= joint.upper;
      require(within, at, fmt::format("the start position of joint '{}'", joint.name), robot.q[i],
              fmt::format("{} to {}", joint.lower, joint.upper));
    }
    for (const auto& figures : robot.joints) check(at, joints, figures);
  }

  /// A body needs a mass, and an inertia that a solid can have: no axis has more than the other two together.
  void check(const std::string& at, const kinematics::Inertial& inertial) {
    require(inertial.mass > 0.0 && std::isfinite(inertial.mass), at, "the mass", inertial.mass, "> 0 kg");
    const Eigen::Vector3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertial.I_C).eigenvalues();
    require(principal[0] > 0.0 && principal[0] + principal[1] >= principal[2] * (1.0 - 1e-9), at,
            "the least principal moment of inertia", principal[0],
            "> 0 kg m^2, and none larger than the other two together");
  }

  void check(const std::string& at, const std::vector<const Joint*>& joints, const JointFigures& figures) {
    std::vector<std::string> known;
    for (const Joint* joint : joints) known.push_back(joint->name);
    if (std::ranges::find(known, figures.joint) == known.end()) {
      error(Code::kUnknownName, at, fmt::format("unknown joint '{}'", figures.joint),
            nearest_choice(figures.joint, known));
    }
    if (const auto& spring = figures.spring) {
      require(spring->stiffness > 0.0, at, fmt::format("stiffness of '{}'", figures.joint), spring->stiffness, "> 0");
      require(spring->damping >= 0.0, at, fmt::format("damping of '{}'", figures.joint), spring->damping, ">= 0");
      require(spring->preload >= 0.0, at, fmt::format("preload of '{}'", figures.joint), spring->preload, ">= 0");
    }
    require(figures.armature >= 0.0, at, fmt::format("armature of '{}'", figures.joint), figures.armature, ">= 0");
    for (const auto& friction : {figures.coulomb, figures.viscous}) {
      const double value = friction.value_or(0.0);
      require(value >= 0.0, at, fmt::format("friction of '{}'", figures.joint), value, ">= 0");
    }
  }

  void check(const ObjectDescription& object) {
    const std::string at = place(object.pointer, "objects", object.name);
    name(names_, at, object.name, false);
    mount(at, object.mount);
    contact(at, object.contact);
    if (object.free && !object.mount.parent.empty()) {
      error(Code::kConflict, at, fmt::format("a free object cannot have the parent '{}'", object.mount.parent),
            "Make it free, or mount it");
    }
    if (object.inertial) check(at, *object.inertial);
    if (object.free && !object.inertial)
      require(object.mass > 0.0, at, "the mass of a free object", object.mass, "> 0 kg");
    require(object.mass >= 0.0 && std::isfinite(object.mass), at, "the mass", object.mass, ">= 0 kg");
    if (object.shapes.empty()) error(Code::kMissing, at, "the object has no shape");
    if (object.screw) check(at, object, *object.screw);
    bool has_mesh = false;
    for (std::size_t i = 0; i < object.shapes.size(); ++i) {
      const ObjectGeometry& part = object.shapes[i];
      const std::string part_at = part.pointer.empty() ? at : part.pointer;
      check_solid(part, part_at, diagnostics_);
      threads(part_at, part);
      if (!(volume(part.shape) > 0.0)) error(Code::kOutOfRange, at, "a shape has a size that is not > 0");
      has_mesh = has_mesh || std::holds_alternative<kinematics::Mesh>(part.shape);
    }
    if (object.free && has_mesh && object.shapes.size() > 1) {
      error(Code::kConflict, at, "a free object of a mesh and other shapes: its mass cannot be spread",
            "Make it of one mesh, or of no mesh");
    }
  }

  void check(const std::string& at, const ObjectDescription& object, const ScrewDescription& screw) {
    if (screw.shank >= object.shapes.size() ||
        !std::holds_alternative<kinematics::Cylinder>(object.shapes[screw.shank].shape)) {
      error(Code::kInvalidValue, at, "the shank of the screw is no cylinder", "Give the number of one of its shapes");
    }
    const ThreadFigures& thread = screw.thread;
    const bool sizes = thread.pitch > 0.0 && thread.pitch_diameter > 0.0 && thread.pitch < thread.major;
    if (!sizes || thread.run_down < 0.0 || thread.friction < 0.0)
      error(Code::kOutOfRange, at, fmt::format("figures of the thread '{}'", thread.size), "Keep 0 < pitch < major");
  }

  /// A threaded bore has to hold a turn of the screws that may come into it.
  void threads(const std::string& at, const ObjectGeometry& part) {
    const Solid solid = make_solid(part.shape, part.chamfer, part.bores);
    for (std::size_t i = 0; i < part.bores.size(); ++i) {
      const auto fits = [&](const ObjectDescription& object) {
        return object.screw && object.screw->thread.size == part.bores[i].thread;
      };
      const auto screw = std::ranges::find_if(world_.objects, fits);
      if (screw == world_.objects.end()) continue;
      const DrilledBore& bore = solid.bores[i];
      const double threaded = bore.length - bore.chamfer * (bore.through ? 2.0 : 1.0);
      const double pitch = screw->screw->thread.pitch;
      if (threaded <= 0.0 || threaded >= pitch) continue;  // without a wall it has been reported
      error(Code::kOutOfRange, at + "/bores" + pointer_segment(i),
            fmt::format("a thread of {:.4g} m without its chamfer", threaded),
            fmt::format("Make it one turn of '{}' at least, {} m", part.bores[i].thread, pitch));
    }
  }

  static double volume(const ObjectShape& shape) {
    struct {
      double operator()(const kinematics::Box& s) const { return s.size.minCoeff(); }
      double operator()(const kinematics::Cylinder& s) const { return std::min(s.radius, s.length); }
      double operator()(const kinematics::Sphere& s) const { return s.radius; }
      double operator()(const Capsule& s) const { return std::min(s.radius, s.length); }
      double operator()(const kinematics::Mesh&) const { return 1.0; }
    } smallest;
    return std::visit(smallest, shape);
  }

  void check(const CameraDescription& camera) {
    const std::string at = place(camera.pointer, "cameras", camera.name);
    name(cameras_, at, camera.name, true);
    mount(at, camera.mount);
    const double view = camera.vertical_field_of_view;
    require(view > 0.0 && view < 3.0, at, "the field of view", view, "0 to 3 rad");
  }

  void check(const SimArmDescription& arm) {
    const std::string at = place(arm.pointer, "arms", arm.name);
    name(devices_, at, arm.name, true);
    const auto& c = arm.control;
    for (const double w : c.natural_frequency) require(w > 0.0, at, "natural_frequency", w, "> 0 rad/s");
    for (const double d : c.damping_ratio) require(d > 0.0, at, "damping_ratio", d, "> 0");
    require(c.friction_compensation >= 0.0 && c.friction_compensation <= 1.0, at, "friction_compensation",
            c.friction_compensation, "0 to 1");
    for (const double rate : c.friction_observer) require(rate >= 0.0, at, "friction_observer", rate, ">= 0 1/s");
    require(c.friction_uncertainty >= 0.0 && c.friction_uncertainty <= 1.0, at, "friction_uncertainty",
            c.friction_uncertainty, "0 to 1");
    std::vector<std::string> robots;
    for (const auto& robot : world_.robots) robots.push_back(robot.name);
    if (std::ranges::find(robots, arm.robot) == robots.end()) {
      error(Code::kUnknownName, at, fmt::format("unknown robot '{}'", arm.robot), nearest_choice(arm.robot, robots));
    } else if (const auto [other, fresh] = drivers_.emplace(arm.robot, arm.name); !fresh) {
      error(Code::kResourceConflict, at,
            fmt::format("the robot '{}' is driven by '{}' already", arm.robot, other->second));
    }
    if (arm.drive) check(at, arm, *arm.drive);
  }

  void check(const std::string& at, const SimArmDescription& arm, const SimDriveDescription& drive) {
    const OdometryError& e = drive.error;
    require(e.linear_scale > 0.0, at, "the odometry's linear scale", e.linear_scale, "> 0");
    require(e.angular_scale > 0.0, at, "the odometry's angular scale", e.angular_scale, "> 0");
    require(std::isfinite(e.heading_drift), at, "the odometry's heading drift", e.heading_drift, "a number");
    require(e.random_walk >= 0.0, at, "the odometry's random walk", e.random_walk, ">= 0");
    require(drive.grip > 0.0, at, "the friction of the wheels", drive.grip, "> 0");
    const auto robot = std::ranges::find(world_.robots, arm.robot, &RobotDescription::name);
    if (robot == world_.robots.end() || !robot->model) return;
    for (const std::string& wheel : drive.wheels) {
      const Joint* joint = robot->model->joint(wheel);
      if (!joint || joint->type != JointType::kContinuous)
        error(Code::kInvalidValue, at, fmt::format("'{}' is not a wheel", wheel));
    }
  }

  void check(const SimForceTorqueDescription& sensor) {
    const std::string at = place(sensor.pointer, "force_torque_sensors", sensor.name);
    name(devices_, at, sensor.name, true);
    if (std::ranges::find(bodies_, sensor.tool_side) == bodies_.end()) {
      error(Code::kUnknownName, at, fmt::format("unknown tool side '{}'", sensor.tool_side),
            nearest_choice(sensor.tool_side, bodies_));
    }
    const bool positive = sensor.force_range.minCoeff() > 0.0 && sensor.torque_range.minCoeff() > 0.0;
    if (!positive) error(Code::kOutOfRange, at, "a range is not > 0");
    if (sensor.force_noise.minCoeff() < 0.0 || sensor.torque_noise.minCoeff() < 0.0)
      error(Code::kOutOfRange, at, "a noise is < 0");
    whole_period(at, sensor.period);
  }

  void whole_period(const std::string& at, Nanoseconds period) {
    const bool whole = period > 0 && world_.physics.period > 0 && period % world_.physics.period == 0;
    if (whole) return;
    error(Code::kOutOfRange, at, fmt::format("a sensor period of {} ns", period),
          fmt::format("Choose a whole multiple of the cycle, {} ns", world_.physics.period));
  }

  void check(const SimGripperDescription& gripper) {
    const std::string at = place(gripper.pointer, "grippers", gripper.name);
    name(devices_, at, gripper.name, true);
    whole_period(at, gripper.period);
    require(gripper.finger_mass + gripper.finger_inertia > 0.0, at, "the mass of a finger", gripper.finger_mass, "> 0");
    require(gripper.acceleration > 0.0, at, "acceleration", gripper.acceleration, "> 0 m/s^2");
    require(gripper.force_max > 0.0, at, "force_max", gripper.force_max, "> 0 N");
    const auto robot = std::ranges::find(world_.robots, gripper.robot, &RobotDescription::name);
    if (robot == world_.robots.end() || !robot->model)
      return error(Code::kUnknownName, at, fmt::format("unknown robot '{}'", gripper.robot));
    for (const std::string& finger : gripper.fingers) {
      const Joint* joint = robot->model->joint(finger);
      if (!joint || joint->type != JointType::kPrismatic)
        error(Code::kInvalidValue, at, fmt::format("'{}' is not a sliding joint", finger));
    }
  }

  void known_body(const std::string& at, const std::string& body) {
    if (std::ranges::find(bodies_, body) == bodies_.end())
      error(Code::kUnknownName, at, fmt::format("unknown body '{}'", body), nearest_choice(body, bodies_));
  }

  void check(const SimToolSideDescription& side) {
    const std::string at = place(side.pointer, "tool_sides", side.name);
    name(devices_, at, side.name, true);
    known_body(at, side.body);
    require(side.number > 0, at, "the number", side.number, "1 or more");
  }

  void check(const SimToolChangerDescription& changer) {
    const std::string at = place(changer.pointer, "tool_changers", changer.name);
    name(devices_, at, changer.name, true);
    whole_period(at, changer.period);
    known_body(at, changer.body);
    require(changer.lock_time > 0.0, at, "lock_time", changer.lock_time, "> 0 s");
    const auto& tolerance = changer.tolerance;
    require(tolerance.offset > 0.0 && tolerance.gap > 0.0 && tolerance.angle > 0.0, at, "a tolerance",
            std::min({tolerance.offset, tolerance.gap, tolerance.angle}), "> 0");
    const auto fits = [&](const SimToolSideDescription& side) {
      return side.name == changer.coupled && side.size == changer.size;
    };
    if (!changer.coupled.empty() && std::ranges::none_of(world_.tool_sides, fits))
      error(Code::kUnknownName, at, fmt::format("no tool side '{}' of size '{}'", changer.coupled, changer.size));
  }

  void check(const SimBeamDescription& beam) {
    const std::string at = place(beam.pointer, "beams", beam.name);
    name(devices_, at, beam.name, true);
    whole_period(at, beam.period);
    known_body(at, beam.body);
    require(beam.range_max > beam.range_min, at, "the range's end", beam.range_max, "beyond its begin");
  }

  void check_signals() {
    std::vector<std::string> wires[2];  // digital, analog
    for (const auto& output : world_.outputs) {
      name(devices_, place(output.pointer, "outputs", output.name), output.name, true);
      wires[output.analog ? 1 : 0].push_back(output.name);
    }
    for (const auto& beam : world_.beams) wires[beam.measures_range ? 1 : 0].push_back(beam.name);
    for (const auto& input : world_.inputs) {
      const std::string at = place(input.pointer, "inputs", input.name);
      name(devices_, at, input.name, true);
      whole_period(at, input.period);
      const auto& possible = wires[input.analog ? 1 : 0];
      if (input.source.empty() || std::ranges::find(possible, input.source) != possible.end()) continue;
      error(
          Code::kUnknownName, at,
          fmt::format("there is no {} '{}'",
                      input.analog ? "analog output or range finder" : "digital output or light barrier", input.source),
          nearest_choice(input.source, possible));
    }
    const auto lamp = [&](const std::string& wire, const std::string& at) {
      if (wire.empty() || std::ranges::find(wires[0], wire) != wires[0].end()) return;
      error(Code::kUnknownName, at, fmt::format("there is no digital output or light barrier '{}'", wire),
            nearest_choice(wire, wires[0]));
    };
    for (const auto& robot : world_.robots) lamp(robot.lit_by, place(robot.pointer, "robots", robot.name));
    for (const auto& object : world_.objects) lamp(object.lit_by, place(object.pointer, "objects", object.name));
  }

  /// Root names of what is mounted, up to the world; a name met twice is a loop.
  void mount_loops() {
    std::map<std::string, std::pair<std::string, std::string>> parent_of;  // root -> its parent's root, place
    const auto root = [](const std::string& body) { return body.substr(0, body.find('/')); };
    for (const auto& r : world_.robots) parent_of[r.name] = {root(r.mount.parent), place(r.pointer, "robots", r.name)};
    for (const auto& o : world_.objects) {
      parent_of[o.name] = {root(o.mount.parent), place(o.pointer, "objects", o.name)};
    }
    for (const auto& [start, step] : parent_of) {
      std::string at = step.first;
      std::size_t steps = 0;
      while (!at.empty() && at != start && parent_of.contains(at) && ++steps <= parent_of.size()) {
        at = parent_of[at].first;
      }
      if (at == start)
        error(Code::kInvalidValue, step.second, fmt::format("'{}' is mounted on itself, in a loop", start));
    }
  }

  const WorldDescription& world_;
  std::vector<std::string> bodies_;
  std::set<std::string> names_, cameras_, devices_;
  std::map<std::string, std::string> drivers_;  // robot -> arm
  Diagnostics diagnostics_;
};

}  // namespace

std::string place(const std::string& pointer, std::string_view group, const std::string& name) {
  return pointer.empty() ? "/" + std::string(group) + pointer_segment(name) : pointer;
}

std::vector<std::string> body_names(const WorldDescription& description) {
  std::vector<std::string> names;
  for (const auto& robot : description.robots) {
    if (!robot.model) continue;
    for (const auto& link : robot.model->links) names.push_back(robot.name + "/" + link.name);
  }
  for (const auto& object : description.objects) names.push_back(object.name);
  return names;
}

std::vector<const Joint*> movable_joints(const RobotModel& model) {
  std::vector<const Joint*> joints;
  for (const auto& joint : model.joints) {
    if (joint.type != JointType::kFixed) joints.push_back(&joint);
  }
  return joints;
}

Diagnostics check(const WorldDescription& description) { return Checker(description).run(); }

}  // namespace takt::sim
