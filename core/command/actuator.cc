#include "core/command/actuator.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::initializer_list<const char*> kFramePorts = {"frame", "twist",         "acceleration",
                                                            "held",  "held_velocity", "held_acceleration"};
constexpr std::initializer_list<const char*> kJointPorts = {"q", "dq", "ddq"};

/// Which primitive drives an arm in a mode, and what it takes beside the set point.
struct Driver {
  const char* primitive;
  std::vector<const char*> springs = {};
};
Driver driver_in(std::optional<device::ControlMode> mode) {
  using enum device::ControlMode;
  if (mode == kJointImpedance) return {"JointImpedanceCommand", {"stiffness", "damping_ratio", "torque"}};
  if (mode == kCartesianImpedance)
    return {"CartesianImpedanceCommand",
            {"stiffness", "rotational_stiffness", "damping_ratio", "wrench", "nullspace_stiffness"}};
  return {"ArmCommand"};
}

/// What drives an arm in the fragment, in the mode of the set point and with its compliance.
void add_driver(expression::FragmentWriter& fragment, const std::string& id, const std::string& arm,
                const SetPoint& set_point) {
  const Driver driver = driver_in(set_point.mode);
  Json parameters = {{"device", arm}};
  if (set_point.mode == device::ControlMode::kPosition) parameters["mode"] = std::string(name_of(*set_point.mode));
  if (set_point.in_tool_axes) parameters["axes"] = "tool";
  fragment.add(id, driver.primitive, parameters);
  for (const char* port : driver.springs) set_point.feed(fragment, port, fmt::format("{}.{}", id, port));
}

std::optional<expression::RealSensor> slower(const std::optional<expression::RealSensor>& a,
                                             const std::optional<expression::RealSensor>& b) {
  if (a && b) return expression::min(*a, *b);
  return a ? a : b;
}

/// The same of one arm, without the operator's override.
std::optional<expression::RealSensor> own_speed(const expression::Cell& cell, const std::string& arm) {
  const std::string name = speed_channel(arm);
  return cell.channels.contains(name) ? std::optional(channel<net::Real>(cell, name)) : std::nullopt;
}

/// Primitive "arm" in the fragment, that of the control mode; inverse kinematics before it where the set point is a
/// pose.
class ArmActuator final : public ActuatorModel {
 public:
  ArmActuator(const expression::Cell& cell, const std::string& name)
      : ActuatorModel(name),
        arm_(cell.arms.find(name)->second),
        speed_(own_speed(cell, name)),
        states_{
            {"completed", expression::near(expression::measured_joints(cell, name),
                                           expression::commanded_joints(cell, name), tolerance()) &&
                              is_less(expression::largest(expression::commanded_velocities(cell, name)), kStanding)},
            {"emergency_stop",
             !expression::State(expression::read_resource(net::ValueType::kBoolean, "ArmState", "device", name,
                                                          arm_.device, "ready", expression::id_of("state", name)))}} {
    if (cell.override_channel.empty()) return;
    const expression::RealSensor by_operator =
        expression::min(expression::max(channel<net::Real>(cell, cell.override_channel), 0.0), 1.0);
    speed_ = speed_ ? *speed_ * by_operator : by_operator;
  }

  [[nodiscard]] std::vector<SetPointKind> takes() const override {
    return {SetPointKind::kJoints, SetPointKind::kPose, SetPointKind::kPath, SetPointKind::kTwist};
  }
  [[nodiscard]] std::vector<device::ControlMode> modes() const override {
    return arm_.device->description().modes.modes;
  }
  [[nodiscard]] std::map<std::string, expression::State> states() const override { return states_; }
  [[nodiscard]] const expression::MountedArm* arm() const override { return &arm_; }
  [[nodiscard]] std::optional<expression::RealSensor> speed() const override { return speed_; }
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter& fragment) const override {
    return fragment.add_null_test("arm.q", net::ValueType::kJoints);
  }

  void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const override {
    add_driver(fragment, "arm", name(), set_point);
    switch (set_point.kind) {
      case SetPointKind::kJoints:
        for (const char* port : kJointPorts) set_point.feed(fragment, port, std::string("arm.") + port);
        return;
      case SetPointKind::kPose:
        fragment.add("inverse", "InverseKinematics", kinematics_of(set_point));
        for (const char* port : kFramePorts) set_point.feed(fragment, port, std::string("inverse.") + port);
        return fragment.link_all("inverse", "arm", kJointPorts);
      case SetPointKind::kPath:
        return add_both_spaces(fragment, set_point);
      default:
        fragment.add("inverse", "DifferentialInverseKinematics", kinematics_of(set_point));
        if (set_point.speed) {
          fragment.set_parameter("inverse", "linear_max", set_point.speed->linear);
          fragment.set_parameter("inverse", "angular_max", set_point.speed->angular);
        }
        set_point.feed(fragment, "twist", "inverse.twist");
        fragment.link_all("inverse", "arm", kJointPorts);
    }
  }

 private:
  static constexpr double kStanding = 1e-9;  ///< rad/s

  [[nodiscard]] double tolerance() const { return arm_.device->description().start_tolerance; }
  [[nodiscard]] Json kinematics_of(const SetPoint& set_point) const {
    return {{"device", name()}, {"tool", net::value_to_json(net::Frame(set_point.X_FM))}};
  }

  /// Inverse kinematics that is active on Cartesian pieces only, so that it begins at the arm's set point whenever the
  /// path enters one; else the joints of the path.
  void add_both_spaces(expression::FragmentWriter& fragment, const SetPoint& set_point) const {
    net::FragmentDescription follow;
    follow.id = "follow_frame";
    follow.when_inactive = net::WhenInactive::kReset;
    follow.net.add("inverse", "InverseKinematics", kinematics_of(set_point));
    for (const char* port : kFramePorts) follow.inputs.emplace_back(port, std::string("inverse.") + port);
    for (const char* port : kJointPorts) follow.outputs.emplace_back(port, std::string("inverse.") + port);
    fragment.nest(std::move(follow));
    set_point.feed(fragment, "cartesian", "follow_frame.active");
    for (const char* port : kFramePorts) set_point.feed(fragment, port, std::string("follow_frame.") + port);
    for (const char* port : kJointPorts) {
      const std::string id = std::string("choose_") + port;
      fragment.add(id, "SelectJoints");
      set_point.feed(fragment, "cartesian", id + ".condition");
      fragment.link(std::string("follow_frame.") + port, id + ".if_true");
      set_point.feed(fragment, port, id + ".if_false");
      fragment.link(id + ".value", std::string("arm.") + port);
    }
  }

  expression::MountedArm arm_;
  std::optional<expression::RealSensor> speed_;
  std::map<std::string, expression::State> states_;
};

/// One of the joints of an arm. Which joints move is up to the action.
class JointActuator final : public ActuatorModel {
 public:
  JointActuator(Actuator arm, int joint)
      : ActuatorModel(fmt::format("{} joint {}", arm.name(), joint)), arm_(std::move(arm)), joint_(joint) {}

  [[nodiscard]] std::vector<std::string> devices() const override { return arm_.model().devices(); }
  [[nodiscard]] std::vector<SetPointKind> takes() const override {
    return {SetPointKind::kJoints, SetPointKind::kPath};
  }
  [[nodiscard]] std::vector<device::ControlMode> modes() const override { return arm_.model().modes(); }
  [[nodiscard]] std::map<std::string, expression::State> states() const override { return arm_.model().states(); }
  [[nodiscard]] const expression::MountedArm* arm() const override { return arm_.model().arm(); }
  [[nodiscard]] std::optional<int> joint() const override { return joint_; }
  [[nodiscard]] std::optional<expression::RealSensor> speed() const override { return arm_.model().speed(); }
  [[nodiscard]] std::optional<Diagnostic> fault() const override {
    if (auto missing_arm = arm_.model().fault()) return missing_arm;
    const Eigen::Index count = arm()->device->description().limits.velocity.size();
    if (joint_ >= 0 && joint_ < count) return std::nullopt;
    return expression::fault_of(Code::kOutOfRange, fmt::format("'{}' has no joint {}", arm_.name(), joint_),
                                fmt::format("Choose 0 to {}", count - 1));
  }
  void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const override {
    arm_.model().add_consumer(fragment, set_point);
  }
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter& fragment) const override {
    return arm_.model().add_invalid(fragment);
  }

 private:
  Actuator arm_;
  int joint_;
};

/// Stands for its parts until a command says which of them its action is for (RuntimeCommand).
class ComposedActuator final : public ActuatorModel {
 public:
  ComposedActuator(std::string name, std::vector<Actuator> parts)
      : ActuatorModel(std::move(name)), parts_(std::move(parts)) {}

  [[nodiscard]] std::vector<Actuator> parts() const override { return parts_; }
  [[nodiscard]] std::vector<std::string> devices() const override { return {}; }
  [[nodiscard]] std::vector<SetPointKind> takes() const override { return {}; }
  /// Completed: all of them are; in an emergency stop: one of them is.
  [[nodiscard]] std::map<std::string, expression::State> states() const override {
    std::map<std::string, expression::State> states = parts_.front().model().states();
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      states.at("completed") = states.at("completed") && parts_[i].completed();
      states.at("emergency_stop") = states.at("emergency_stop") || parts_[i].emergency_stop();
    }
    return states;
  }
  void add_consumer(expression::FragmentWriter&, const SetPoint&) const override {}
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter&) const override { return {}; }

 private:
  std::vector<Actuator> parts_;
};

/// Two arms that are fed each with its part of the set point. Both are compliant alike; of a base and its arm the arm.
class PairActuator final : public ActuatorModel {
 public:
  PairActuator(const Actuator& leader, const Actuator& follower, bool is_carried = false)
      : ActuatorModel(leader.name() + "+" + follower.name()),
        names_{leader.name(), follower.name()},
        arms_{leader.model().arm(), follower.model().arm()},
        kept_{leader, follower},
        is_carried_(is_carried),
        states_{{"completed", leader.completed() && follower.completed()},
                {"emergency_stop", leader.emergency_stop() || follower.emergency_stop()}} {
    if (leader.name() == follower.name())
      fault_ = expression::fault_of(Code::kDuplicate, fmt::format("'{}' twice", leader.name()), "Name two arms");
    for (const Actuator* arm : {&leader, &follower})
      if (auto fault = arm->model().fault(); fault && !fault_) fault_ = std::move(fault);
  }

  [[nodiscard]] std::vector<std::string> devices() const override { return names_; }
  [[nodiscard]] std::vector<SetPointKind> takes() const override { return {SetPointKind::kPair}; }
  /// Those that all have that take a compliance.
  [[nodiscard]] std::vector<device::ControlMode> modes() const override {
    if (is_carried_) return kept_.back().model().modes();
    std::vector<device::ControlMode> both = kept_.front().model().modes();
    const auto others = kept_.back().model().modes();
    std::erase_if(both, [&](device::ControlMode mode) { return std::ranges::find(others, mode) == others.end(); });
    return both;
  }
  [[nodiscard]] std::map<std::string, expression::State> states() const override { return states_; }
  [[nodiscard]] std::optional<Diagnostic> fault() const override { return fault_; }
  [[nodiscard]] std::vector<const expression::MountedArm*> arms() const override {
    return fault_ ? std::vector<const expression::MountedArm*>() : arms_;
  }
  [[nodiscard]] std::vector<const expression::MountedArm*> compliant_arms() const override {
    return is_carried_ && !fault_ ? std::vector<const expression::MountedArm*>{arms_.back()} : arms();
  }
  [[nodiscard]] std::optional<expression::RealSensor> speed() const override {
    return slower(kept_.front().model().speed(), kept_.back().model().speed());
  }

  void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const override {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const SetPoint& part = set_point.parts.at(i);
      const std::string arm = fmt::format("arm_{}", i + 1), inverse = fmt::format("inverse_{}", i + 1);
      SetPoint springs = set_point;
      if (is_carried_ && i == 0) springs.mode = {};
      add_driver(fragment, arm, names_[i], springs);
      if (part.kind == SetPointKind::kJoints) {
        for (const char* port : kJointPorts) part.feed(fragment, port, arm + "." + port);
        continue;
      }
      fragment.add(inverse, "InverseKinematics",
                   {{"device", names_[i]}, {"tool", net::value_to_json(net::Frame(part.X_FM))}});
      for (const char* port : kFramePorts) part.feed(fragment, port, inverse + "." + port);
      fragment.link_all(inverse, arm, kJointPorts);
    }
  }

  [[nodiscard]] std::string add_invalid(expression::FragmentWriter& fragment) const override {
    fragment.add("no_pair", "Or");
    fragment.link(fragment.add_null_test("arm_1.q", net::ValueType::kJoints), "no_pair.a");
    fragment.link(fragment.add_null_test("arm_2.q", net::ValueType::kJoints), "no_pair.b");
    return "no_pair.value";
  }

 private:
  std::vector<std::string> names_;
  std::vector<const expression::MountedArm*> arms_;
  std::vector<Actuator> kept_;  ///< who owns them
  bool is_carried_;             ///< the first one carries the second
  std::map<std::string, expression::State> states_;
  std::optional<Diagnostic> fault_;
};

class GripperActuator final : public ActuatorModel {
 public:
  GripperActuator(const expression::Cell& cell, const std::string& name)
      : ActuatorModel(name),
        gripper_(cell.grippers.find(name)->second.device),
        states_{{"completed", !expression::gripper_state(cell, name, "moving")},
                {"emergency_stop", !expression::State(expression::read_resource(
                                       net::ValueType::kBoolean, "GripperState", "device", name, gripper_, "ready",
                                       expression::id_of("gripper", name)))}} {}
  [[nodiscard]] const device::GripperDescription* gripper() const override { return &gripper_->description(); }
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter& fragment) const override {
    return fragment.add_null_test("command.width", net::ValueType::kReal);
  }

  [[nodiscard]] std::vector<SetPointKind> takes() const override { return {SetPointKind::kGrip}; }
  [[nodiscard]] std::map<std::string, expression::State> states() const override { return states_; }
  void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const override {
    fragment.add("command", "GripperCommand", {{"device", name()}});
    for (const char* port : {"width", "speed", "force"}) {
      set_point.feed(fragment, port, std::string("command.") + port);
    }
  }

 private:
  device::Gripper* gripper_;
  std::map<std::string, expression::State> states_;
};

/// A digital or an analog output. It has a value one cycle after it was sent.
class OutputActuator final : public ActuatorModel {
 public:
  OutputActuator(const expression::Cell& cell, const std::string& name)
      : ActuatorModel(name),
        digital_(cell.digital_outputs.contains(name)),
        analog_(digital_ ? nullptr : cell.analog_outputs.find(name)->second),
        ready_(ready(cell, name, digital_)) {}
  [[nodiscard]] const device::SignalOutputDescription<double>* analog_output() const override {
    return analog_ == nullptr ? nullptr : &analog_->description();
  }
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter& fragment) const override {
    return fragment.add_null_test("output.value", digital_ ? net::ValueType::kBoolean : net::ValueType::kReal);
  }

  [[nodiscard]] std::vector<SetPointKind> takes() const override {
    return {digital_ ? SetPointKind::kBoolean : SetPointKind::kReal};
  }
  [[nodiscard]] std::map<std::string, expression::State> states() const override {
    return {{"completed", ready_}, {"emergency_stop", !ready_}};
  }
  void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const override {
    fragment.add("output", digital_ ? "DigitalOutput" : "AnalogOutput", {{"device", name()}});
    set_point.feed(fragment, "value", "output.value");
  }

 private:
  static expression::State ready(const expression::Cell& cell, const std::string& name, bool digital) {
    net::Resource* device = nullptr;
    if (digital) device = cell.digital_outputs.find(name)->second;
    if (!digital) device = cell.analog_outputs.find(name)->second;
    return expression::State(expression::read_resource(net::ValueType::kBoolean,
                                                       digital ? "DigitalOutputState" : "AnalogOutputState", "device",
                                                       name, device, "ready", expression::id_of("output", name)));
  }

  bool digital_;
  device::AnalogOutput* analog_;
  expression::State ready_;
};

/// Stands for a device that the cell does not have.
class MissingActuator final : public ActuatorModel {
 public:
  MissingActuator(const std::string& what, const std::string& name, const std::vector<std::string>& names)
      : ActuatorModel(name),
        fault_(expression::fault_of(Code::kUnknownName, fmt::format("there is no {} '{}'", what, name),
                                    names.empty() ? "the cell has none" : nearest_choice(name, names))) {}
  MissingActuator(std::string name, Diagnostic why) : ActuatorModel(std::move(name)), fault_(std::move(why)) {}
  [[nodiscard]] std::vector<SetPointKind> takes() const override { return {}; }
  [[nodiscard]] std::map<std::string, expression::State> states() const override {
    const expression::State never(
        expression::broken(fault_.code, net::ValueType::kBoolean, fault_.message, fault_.hint));
    return {{"completed", never}, {"emergency_stop", never}};
  }
  void add_consumer(expression::FragmentWriter&, const SetPoint&) const override {}
  [[nodiscard]] std::string add_invalid(expression::FragmentWriter&) const override { return {}; }
  [[nodiscard]] std::optional<Diagnostic> fault() const override { return fault_; }

 private:
  Diagnostic fault_;
};

template <class Map>
void add_names(const Map& map, std::vector<std::string>& names) {
  for (const auto& [name, device] : map) names.push_back(name);
}

template <class Model>
Actuator make(const expression::Cell& cell, const std::string& name, const char* what,
              const std::vector<std::string>& names) {
  if (std::ranges::find(names, name) != names.end()) return Actuator(std::make_shared<const Model>(cell, name));
  return Actuator(std::make_shared<const MissingActuator>(what, name, names));
}

}  // namespace

std::vector<Actuator> ActuatorModel::parts() const { return {}; }

std::vector<const expression::MountedArm*> ActuatorModel::arms() const {
  return arm() == nullptr ? std::vector<const expression::MountedArm*>()
                          : std::vector<const expression::MountedArm*>{arm()};
}

std::string_view name_of(SetPointKind kind) {
  static constexpr std::array<std::string_view, 8> kNames = {"joints",        "pose",         "path", "twist",
                                                             "digital value", "analog value", "grip", "pair"};
  return kNames.at(static_cast<std::size_t>(kind));
}

void SetPoint::feed(expression::FragmentWriter& fragment, std::string_view name, const std::string& to) const {
  if (const auto port = ports.find(name); port != ports.end()) return fragment.link(port->second, to);
  if (const auto sensor = sensors.find(name); sensor != sensors.end()) return fragment.feed(sensor->second, to);
  const auto constant = constants.find(name);
  if (constant == constants.end()) return;
  const auto dot = to.find('.');
  fragment.set_parameter(to.substr(0, dot), to.substr(dot + 1), constant->second);
}

expression::State Actuator::completed() const { return model_->states().at("completed"); }
expression::State Actuator::invalid_set_point() const {
  const auto subject =
      std::make_shared<const expression::Subject>(expression::Subject{expression::Subject::Kind::kActuator, name()});
  return expression::State(expression::leaf(net::ValueType::kBoolean, subject, "invalid_set_point"));
}
expression::State Actuator::emergency_stop() const { return model_->states().at("emergency_stop"); }

std::string speed_channel(const std::string& arm) { return arm + ".speed"; }

Actuator arm(const expression::Cell& cell, const std::string& name) {
  std::vector<std::string> names;
  add_names(cell.arms, names);
  return make<ArmActuator>(cell, name, "arm", names);
}

Actuator joint(const expression::Cell& cell, const std::string& name, int index) {
  return Actuator(std::make_shared<const JointActuator>(arm(cell, name), index));
}

Actuator composed(std::string name, const std::vector<Actuator>& parts) {
  if (parts.empty()) {
    Diagnostic nothing =
        expression::fault_of(Code::kMissing, fmt::format("'{}' has no parts", name), "Name at least one actuator");
    return missing(std::move(name), std::move(nothing));
  }
  return Actuator(std::make_shared<const ComposedActuator>(std::move(name), parts));
}

Actuator arm_pair(const expression::Cell& cell, const std::string& leader, const std::string& follower) {
  return Actuator(std::make_shared<const PairActuator>(arm(cell, leader), arm(cell, follower)));
}
Actuator carried_pair(const expression::Cell& cell, const std::string& base, const std::string& rider) {
  return Actuator(std::make_shared<const PairActuator>(arm(cell, base), arm(cell, rider), true));
}

Actuator gripper(const expression::Cell& cell, const std::string& name) {
  std::vector<std::string> names;
  add_names(cell.grippers, names);
  return make<GripperActuator>(cell, name, "gripper", names);
}

Actuator missing(std::string name, Diagnostic why) {
  return Actuator(std::make_shared<const MissingActuator>(std::move(name), std::move(why)));
}

Actuator output(const expression::Cell& cell, const std::string& name) {
  std::vector<std::string> names;
  add_names(cell.digital_outputs, names);
  add_names(cell.analog_outputs, names);
  return make<OutputActuator>(cell, name, "output", names);
}

}  // namespace takt::command
