// What the controller says of itself: every output field of RTDE, filled once in a frame.
#include <numeric>

#include "core/kinematics/chain.h"
#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

constexpr double kMainVoltage = 48.0, kIoVoltage = 24.0, kTemperature = 30.0;
constexpr int kJointRunning = 253, kJointIdle = 255, kJointOff = 239;
// Nm per A at the joint, of the size that UR5 motors have with their gears.
constexpr std::array<double, 6> kTorquePerCurrent = {13.26, 13.26, 11.13, 10.62, 11.03, 11.47};
/// What an analog output gives at its full share.
constexpr double kFullVoltage = 10.0, kLowCurrent = 0.004, kCurrentRange = 0.016;

FieldValue as_field(const Vector6& vector) {
  FieldValue value{};
  std::copy(vector.begin(), vector.end(), value.begin());
  return value;
}
FieldValue as_field(const JointVector& vector) {
  FieldValue value{};
  std::copy(vector.begin(), vector.begin() + std::min<Eigen::Index>(vector.size(), 6), value.begin());
  return value;
}
FieldValue all_six(double number) {
  FieldValue value;
  value.fill(number);
  return value;
}
FieldValue as_field(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z(), 0.0, 0.0, 0.0}; }

int joint_mode(const PowerState& power) {
  if (power.drives_on()) return kJointRunning;
  return power.mode() == RobotMode::kIdle ? kJointIdle : kJointOff;
}

}  // namespace

void Controller::set_field(std::string_view name, const FieldValue& value) {
  fields_[output_fields().at(name)] = value;
}
void Controller::set_joints(std::string_view name, const JointVector& values) { set_field(name, as_field(values)); }

void Controller::fill_fields() {
  set_field("timestamp", to_seconds(time()));
  fill_motion_fields();
  fill_mode_fields();
  fill_io_fields();
  fill_register_fields("output", outputs_);
  fill_register_fields("input", inputs_);
}

void Controller::fill_motion_fields() {
  const ToolKinematics& tool = motion_.kinematics();
  set_joints("target_q", told_.q);
  set_joints("target_qd", told_.dq);
  set_joints("target_qdd", told_.ddq);
  set_joints("actual_q", plant_.q);
  set_joints("actual_qd", plant_.dq);
  const Eigen::Vector3d gravity(0.0, 0.0, -9.81);
  const auto& chain = *tool.arm().chain;
  const kinematics::Payload payload{settings_.payload, settings_.payload_cog, Eigen::Matrix3d::Zero()};
  const JointVector moment = chain.inverse_dynamics(told_.q, told_.dq, told_.ddq, gravity, payload);
  FieldValue current{};
  for (std::size_t i = 0; i < current.size(); ++i)
    current[i] = power_.drives_on() ? moment[static_cast<Eigen::Index>(i)] / kTorquePerCurrent[i] : 0.0;
  set_joints("target_moment", moment);
  set_joints("actual_current_as_torque", moment);
  for (const auto name : {"target_current", "actual_current", "joint_control_output"}) set_field(name, current);
  set_field("actual_current_window", all_six(1.0));
  set_field("actual_TCP_pose", to_pose(tool.X_BT(plant_.q)));
  set_field("target_TCP_pose", to_pose(tool.X_BT(told_.q)));
  set_field("actual_TCP_speed", as_field(tool.twist(plant_.q, plant_.dq)));
  set_field("target_TCP_speed", as_field(tool.twist(told_.q, told_.dq)));
  const Vector6 force = tcp_force();
  set_field("actual_TCP_force", as_field(force));
  set_field("ft_raw_wrench", as_field(wrench_));
  set_field("wrench_calc_from_currents", as_field(wrench_));
  set_field("tcp_force_scalar", force.head<3>().norm());
  set_field("tcp_offset", to_pose(tool.tool()));
  set_field("payload", settings_.payload);
  set_field("payload_cog", as_field(settings_.payload_cog));
  set_field("payload_inertia", settings_.payload_inertia);
  set_field("actual_tool_accelerometer",
            as_field(Eigen::Vector3d(tool.X_BT(plant_.q).linear().transpose() * -gravity)));
}

void Controller::fill_mode_fields() {
  const bool on = power_.mode() >= RobotMode::kPowerOn;
  set_field("robot_mode", static_cast<double>(power_.mode()));
  set_field("joint_mode", all_six(joint_mode(power_)));
  set_field("safety_mode", static_cast<double>(power_.safety()));
  set_field("safety_status", static_cast<double>(power_.safety()));
  set_field("safety_status_bits", status_bits(power_.safety()));
  set_field("runtime_state", static_cast<double>(programs_.state()));
  const bool teach = settings_.freedrive;
  set_field("robot_status_bits", (on ? kPowerOnBit : 0u) |
                                     (programs_.state() == RuntimeState::kPlaying ? kProgramRunningBit : 0u) |
                                     (teach ? kTeachBit : 0u));
  set_field("speed_scaling", power_.can_move() ? 1.0 : 0.0);
  set_field("target_speed_fraction", settings_.slider);
  set_field("script_control_line", programs_.line());
  set_field("actual_main_voltage", kMainVoltage);
  set_field("actual_robot_voltage", on ? kMainVoltage : 0.0);
  set_field("actual_robot_current", on ? 1.0 : 0.0);
  set_field("actual_joint_voltage", all_six(on ? kMainVoltage : 0.0));
  set_field("joint_temperatures", all_six(kTemperature));
  set_field("tool_temperature", kTemperature);
  set_field("actual_execution_time", 1e-3);
  set_field("target_execution_time", to_seconds(cycle()));
  set_field("tool_mode", power_.drives_on() ? kJointRunning : kJointIdle);
}

void Controller::fill_io_fields() {
  set_field("actual_digital_input_bits", io_.digital_in);
  set_field("actual_digital_output_bits", io_.digital_out);
  set_field("actual_configurable_digital_input_bits", io_.digital_in >> Terminals::kConfigurable & 0xff);
  set_field("actual_configurable_digital_output_bits", io_.digital_out >> Terminals::kConfigurable & 0xff);
  set_field("analog_io_types", io_.analog_types);
  set_field("standard_analog_input0", io_.analog_in[0]);
  set_field("standard_analog_input1", io_.analog_in[1]);
  const auto analog_out = [this](unsigned i) {
    const bool voltage = (io_.analog_types >> (2 + i) & 1u) != 0;
    return voltage ? kFullVoltage * io_.analog_out[i] : kLowCurrent + kCurrentRange * io_.analog_out[i];
  };
  set_field("standard_analog_output0", analog_out(0));
  set_field("standard_analog_output1", analog_out(1));
  set_field("tool_analog_input0", io_.tool_analog_in[0]);
  set_field("tool_analog_input1", io_.tool_analog_in[1]);
  set_field("tool_analog_input_types", io_.tool_analog_types);
  set_field("tool_output_voltage", io_.tool_voltage);
  set_field("euromap67_24V_voltage", kIoVoltage);
}

void Controller::fill_register_fields(std::string_view direction, const Registers& registers) {
  const bool out = direction == "output";
  static const FieldTable::Id kOut[] = {
      output_fields().at("output_int_register_0"), output_fields().at("output_double_register_0"),
      output_fields().at("output_bit_register_64"), output_fields().at("output_bit_registers0_to_31")};
  static const FieldTable::Id kIn[] = {
      output_fields().at("input_int_register_0"), output_fields().at("input_double_register_0"),
      output_fields().at("input_bit_register_64"), output_fields().at("input_bit_registers0_to_31")};
  const FieldTable::Id* first = out ? kOut : kIn;
  for (std::size_t i = 0; i < Registers::kCount; ++i) {
    fields_[first[0] + i][0] = registers.ints[i];
    fields_[first[1] + i][0] = registers.reals[i];
  }
  for (std::size_t i = 64; i < Registers::kBits; ++i) fields_[first[2] + i - 64][0] = registers.bits[i] ? 1.0 : 0.0;
  fields_[first[3]][0] = registers.word(0);
  fields_[first[3] + 1u][0] = registers.word(32);
}

}  // namespace takt::hw::rtde
