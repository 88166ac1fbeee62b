#include "core/expression/device_sensors.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/channel.h"
#include "core/expression/frame_sensors.h"
#include "core/expression/tool_coupling.h"
#include "core/net/value_json.h"

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;
using net::ValueType;

template <class Map>
std::string choices(const std::string& name, const Map& map) {
  std::vector<std::string> names;
  for (const auto& [key, value] : map) names.push_back(key);
  return names.empty() ? "the cell has none" : nearest_choice(name, names);
}

template <class Map>
ExpressionPtr unknown(ValueType type, const char* what, const std::string& name, const Map& map) {
  return broken(Code::kUnknownName, type, fmt::format("there is no {} '{}'", what, name), choices(name, map));
}

Operand constant(const Eigen::Isometry3d& X) {
  return {.node = nullptr, .constant = net::value_to_json(net::Frame(X))};
}
Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }

template <class T>
Sensor<T> arm_output(const Cell& cell, const std::string& arm, const char* output) {
  const auto found = cell.arms.find(arm);
  if (found == cell.arms.end()) return Sensor<T>(unknown(net::kValueType<T>, "arm", arm, cell.arms));
  return Sensor<T>(
      read_resource(net::kValueType<T>, "ArmState", "device", arm, found->second.device, output, id_of("state", arm)));
}

using Operands = std::vector<std::pair<std::string, Operand>>;

/// A primitive of an arm over its joints, or what is wrong with them.
template <class T>
Sensor<T> over_joints(const Cell& cell, const std::string& arm, const net::PrimitiveDescription& primitive,
                      const Operands& operands, const char* output) {
  const auto found = cell.arms.find(arm);
  if (found == cell.arms.end()) return Sensor<T>(unknown(net::kValueType<T>, "arm", arm, cell.arms));
  auto node =
      std::make_shared<Expression>(*apply(net::kValueType<T>, primitive.type, operands, primitive.parameters, output));
  node->primitive.id = primitive.id;
  node->resource = found->second.device;
  node->resource_name = arm;
  return Sensor<T>(node);
}

template <class T>
Sensor<T> kinematics(const Cell& cell, const std::string& arm, const std::string& id, const Eigen::Isometry3d& X_FM,
                     const Operands& operands, const char* output) {
  return over_joints<T>(cell, arm,
                        {.id = id,
                         .type = "ForwardKinematics",
                         .parameters = {{"device", arm}, {"tool", net::value_to_json(net::Frame(X_FM))}}},
                        operands, output);
}

template <class T>
Sensor<T> link_kinematics(const Cell& cell, const std::string& arm, const std::string& link,
                          const Eigen::Isometry3d& X_LM, const char* output) {
  return over_joints<T>(
      cell, arm,
      {.id = id_of(output, arm + "/" + link),
       .type = "LinkKinematics",
       .parameters = {{"device", arm}, {"link", link}, {"offset", net::value_to_json(net::Frame(X_LM))}}},
      {{"q", {.node = measured_joints(cell, arm).node()}}, {"dq", {.node = measured_velocities(cell, arm).node()}}},
      output);
}

Eigen::Isometry3d tool_of(const Cell& cell, const std::string& arm) {
  const auto found = cell.arms.find(arm);
  return found == cell.arms.end() ? Eigen::Isometry3d::Identity() : found->second.X_FT;
}

template <class Map>
ExpressionPtr device_output(ValueType type, const char* primitive, const Map& devices, const char* what,
                            const std::string& name, const std::string& output, const std::string& id) {
  const auto found = devices.find(name);
  if (found == devices.end()) return unknown(type, what, name, devices);
  return read_resource(type, primitive, "device", name, found->second, output, id);
}

ExpressionPtr gripper_output(ValueType type, const Cell& cell, const std::string& gripper, const std::string& output) {
  const auto found = cell.grippers.find(gripper);
  if (found == cell.grippers.end()) return unknown(type, "gripper", gripper, cell.grippers);
  return read_resource(type, "GripperState", "device", gripper, found->second.device, output,
                       id_of("gripper", gripper));
}

/// What a tool holds; of a changer also what the tools hold that it has coupled. In the flange.
world::MassProperties load_behind(const Cell& cell, const std::string& tool) {
  world::MassProperties sum = cell.load_in(tool);
  const std::string side = coupled_side(cell, tool);
  for (const auto& [name, one] : cell.tools)
    if (!side.empty() && one.side == side) sum = combine(sum, cell.load_in(name));
  return sum;
}

/// All that hangs on the measuring side of a sensor, and what its grippers hold now, in its measuring frame.
world::MassProperties carried_by(const Cell& cell, const MountedSensor& sensor) {
  world::MassProperties sum{.mass = sensor.tool_mass, .p_OC = sensor.p_SC};
  for (const std::string& gripper : sensor.grippers)
    sum = combine(sum, transform(sensor.X_FS.inverse(), load_behind(cell, gripper)));
  return sum;
}

}  // namespace

std::string id_of(std::string_view kind, std::string_view device) {
  std::string id = fmt::format("{}-", kind);
  for (const char c : device) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte > 0x20 && byte != 0x7f && c != '.' && c != '/' && c != '%';
    id += plain ? std::string(1, c) : fmt::format("%{:02x}", byte);
  }
  return id;
}

JointsSensor measured_joints(const Cell& cell, const std::string& arm) {
  return arm_output<net::JointArray>(cell, arm, "q");
}
JointsSensor measured_velocities(const Cell& cell, const std::string& arm) {
  return arm_output<net::JointArray>(cell, arm, "dq");
}
JointsSensor measured_torques(const Cell& cell, const std::string& arm) {
  return arm_output<net::JointArray>(cell, arm, "tau");
}
JointsSensor commanded_joints(const Cell& cell, const std::string& arm) {
  return arm_output<net::JointArray>(cell, arm, "set_point_q");
}
JointsSensor commanded_velocities(const Cell& cell, const std::string& arm) {
  return arm_output<net::JointArray>(cell, arm, "set_point_dq");
}

FrameSensor flange_fixed_pose(const Cell& cell, const std::string& arm, const Eigen::Isometry3d& X_FM) {
  return kinematics<net::Frame>(cell, arm, id_of("pose", arm), X_FM,
                                {{"q", {.node = measured_joints(cell, arm).node()}}}, "frame");
}
FrameSensor link_fixed_pose(const Cell& cell, const std::string& arm, const std::string& link,
                            const Eigen::Isometry3d& X_LM) {
  return link_kinematics<net::Frame>(cell, arm, link, X_LM, "frame");
}
TwistSensor link_fixed_twist(const Cell& cell, const std::string& arm, const std::string& link,
                             const Eigen::Isometry3d& X_LM) {
  return link_kinematics<net::Twist>(cell, arm, link, X_LM, "twist");
}
FrameSensor tool_pose(const Cell& cell, const std::string& arm) {
  return flange_fixed_pose(cell, arm, tool_of(cell, arm));
}
FrameSensor commanded_tool_pose(const Cell& cell, const std::string& arm) {
  return kinematics<net::Frame>(cell, arm, id_of("commanded_pose", arm), tool_of(cell, arm),
                                {{"q", {.node = commanded_joints(cell, arm).node()}}}, "frame");
}
TwistSensor tool_twist(const Cell& cell, const std::string& arm) {
  return kinematics<net::Twist>(
      cell, arm, id_of("twist", arm), tool_of(cell, arm),
      {{"q", {.node = measured_joints(cell, arm).node()}}, {"dq", {.node = measured_velocities(cell, arm).node()}}},
      "twist");
}

WrenchSensor raw_wrench(const Cell& cell, const std::string& sensor) {
  const auto found = cell.sensors.find(sensor);
  if (found == cell.sensors.end()) {
    return WrenchSensor(unknown(ValueType::kWrench, "force/torque sensor", sensor, cell.sensors));
  }
  return WrenchSensor(read_resource(ValueType::kWrench, "ForceTorqueSensor", "device", sensor, found->second.device,
                                    "wrench", id_of("sensor", sensor) + "-raw"));
}

WrenchSensor compensated_wrench(const Cell& cell, const std::string& name) {
  const WrenchSensor raw = raw_wrench(cell, name);
  const auto found = cell.sensors.find(name);
  if (found == cell.sensors.end()) return raw;
  const MountedSensor& sensor = found->second;
  const world::MassProperties carried = carried_by(cell, sensor);
  const FrameSensor X_BS(
      named(flange_fixed_pose(cell, sensor.arm, sensor.X_FS).node(), id_of("sensor", name) + "-pose"));
  const auto X_WB = cell.frames.pose(sensor.arm);  // nothing: its base moves
  const Operand base = X_WB ? constant(*X_WB) : Operand{.node = pose_between(cell, sensor.arm, "world").node()};
  const ExpressionPtr X_WS =
      named(apply(ValueType::kFrame, "Compose", {{"left", base}, {"right", {.node = X_BS.node()}}}),
            id_of("sensor", name) + "-in-world");
  const ExpressionPtr compensated =
      apply(ValueType::kWrench, "PayloadCompensation", {{"wrench", {.node = raw.node()}}, {"frame", {.node = X_WS}}},
            {{"mass", carried.mass},
             {"centre", vector_json(carried.p_OC)},
             {"gravity", vector_json(cell.gravity_W)},
             {"acceleration", vector_json(Eigen::Vector3d::Zero())}},
            "compensated");
  return WrenchSensor(named(compensated, id_of("sensor", name) + "-weight"));
}

WrenchSensor contact_wrench(const Cell& cell, const std::string& name, const Biases& biases) {
  const auto bias = biases.find(name);
  const WrenchSensor contact =
      compensated_wrench(cell, name) - Term<net::Wrench>(bias == biases.end() ? net::Wrench{} : bias->second);
  return WrenchSensor(named(contact.node(), id_of("sensor", name) + "-contact"));
}

bool ContactConstants::operator==(const ContactConstants& other) const {
  const auto same = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) { return a.matrix() == b.matrix(); };
  return sensor == other.sensor && arm == other.arm && frames == other.frames && same(X_FS, other.X_FS) &&
         X_WB.has_value() == other.X_WB.has_value() && (!X_WB || same(*X_WB, *other.X_WB)) &&
         carried.mass == other.carried.mass && carried.p_OC == other.carried.p_OC && bias.force == other.bias.force &&
         bias.torque == other.bias.torque;
}

ContactConstants contact_constants(const Cell& cell, const std::string& name, const Biases& biases) {
  ContactConstants constants{.sensor = name};
  const auto found = cell.sensors.find(name);
  if (found == cell.sensors.end()) return constants;
  const MountedSensor& sensor = found->second;
  constants.arm = sensor.arm;
  constants.frames = cell.frames.changes();
  constants.X_FS = sensor.X_FS;
  if (const auto X_WB = cell.frames.pose(sensor.arm)) constants.X_WB = *X_WB;
  constants.carried = carried_by(cell, sensor);
  if (const auto bias = biases.find(name); bias != biases.end()) constants.bias = bias->second;
  return constants;
}

RealSensor gripper_width(const Cell& cell, const std::string& gripper) {
  return RealSensor(gripper_output(ValueType::kReal, cell, gripper, "width"));
}
RealSensor gripper_force(const Cell& cell, const std::string& gripper) {
  return RealSensor(gripper_output(ValueType::kReal, cell, gripper, "force"));
}
State gripper_state(const Cell& cell, const std::string& gripper, const std::string& state) {
  static constexpr std::array<std::string_view, 5> kStates = {"moving", "holding", "lost", "open", "closed"};
  if (std::ranges::find(kStates, state) == kStates.end()) {
    return State(broken(Code::kUnknownName, ValueType::kBoolean, fmt::format("a gripper has no state '{}'", state),
                        nearest_choice(state, {kStates.begin(), kStates.end()})));
  }
  return State(gripper_output(ValueType::kBoolean, cell, gripper, state));
}

State digital_input(const Cell& cell, const std::string& input) {
  return State(device_output(ValueType::kBoolean, "DigitalInput", cell.digital_inputs, "digital input", input, "value",
                             id_of("input", input)));
}
RealSensor analog_input(const Cell& cell, const std::string& input) {
  return RealSensor(device_output(ValueType::kReal, "AnalogInput", cell.analog_inputs, "analog input", input, "value",
                                  id_of("input", input)));
}
State digital_output(const Cell& cell, const std::string& output) {
  return State(device_output(ValueType::kBoolean, "DigitalOutputState", cell.digital_outputs, "digital output", output,
                             "sent", id_of("output", output)));
}
RealSensor analog_output(const Cell& cell, const std::string& output) {
  return RealSensor(device_output(ValueType::kReal, "AnalogOutputState", cell.analog_outputs, "analog output", output,
                                  "sent", id_of("output", output)));
}

template <class T>
Sensor<T> channel(const Cell& cell, const std::string& name) {
  constexpr ValueType type = net::kValueType<T>;
  const auto found = cell.channels.find(name);
  if (found == cell.channels.end()) return Sensor<T>(unknown(type, "channel", name, cell.channels));
  const ValueType declared = found->second->description().type;
  if (declared != type) {
    return Sensor<T>(broken(Code::kTypeMismatch, type,
                            fmt::format("channel '{}' carries {}", name, net::name_of(declared)),
                            fmt::format("Name a channel of type {}", net::name_of(type))));
  }
  return Sensor<T>(read_resource(type, "Input" + std::string(net::name_of(type)), "channel", name, found->second,
                                 "value", id_of("channel", name)));
}

template Sensor<net::Boolean> channel(const Cell&, const std::string&);
template Sensor<net::Integer> channel(const Cell&, const std::string&);
template Sensor<net::Real> channel(const Cell&, const std::string&);
template Sensor<net::Text> channel(const Cell&, const std::string&);
template Sensor<net::Vector> channel(const Cell&, const std::string&);
template Sensor<net::Rotation> channel(const Cell&, const std::string&);
template Sensor<net::Frame> channel(const Cell&, const std::string&);
template Sensor<net::Twist> channel(const Cell&, const std::string&);
template Sensor<net::Wrench> channel(const Cell&, const std::string&);
template Sensor<net::JointArray> channel(const Cell&, const std::string&);

}  // namespace takt::expression
