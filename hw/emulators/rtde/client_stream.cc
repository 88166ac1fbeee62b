#include "hw/emulators/rtde/client_stream.h"

#include <array>

namespace takt::hw::rtde {

namespace {

constexpr std::uint8_t kRobotState = 16, kRobotMessage = 20;
constexpr std::uint8_t kFromController = 0xfe, kNoSource = 0xff;  // int8 -2 and -1
constexpr double kVoltage = 48.0, kTemperatureC = 30.0;
constexpr std::int32_t kBoardVersion = 0;

/// Denavit-Hartenberg figures of an arm, as the controller tells them.
struct DhTable {
  std::array<double, 6> a, d, alpha;
  std::int32_t type;
};
constexpr double kQuarter = 1.5707963267948966;
constexpr std::array<double, 6> kAlpha = {kQuarter, 0.0, 0.0, kQuarter, -kQuarter, 0.0};
constexpr DhTable kUr5 = {
    {0.0, -0.425, -0.39225, 0.0, 0.0, 0.0}, {0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823}, kAlpha, 1};

/// A value of one of the output fields of RTDE.
const FieldValue& value_of(Controller& c, std::string_view name) { return c.fields()[output_fields().at(name)]; }
double number_of(Controller& c, std::string_view name) { return value_of(c, name)[0]; }

std::uint64_t microseconds(Nanoseconds time) { return static_cast<std::uint64_t>(time / 1000); }

/// A part of a package: uint32 size with itself, uint8 type.
void append_part(std::string& bytes, std::uint8_t type, const std::string& body) {
  append(bytes, static_cast<std::uint32_t>(body.size() + 5));
  append(bytes, type);
  bytes += body;
}
std::string whole_package(std::uint8_t type, const std::string& body) {
  std::string bytes;
  append_part(bytes, type, body);
  return bytes;
}
void append_bool(std::string& bytes, bool value) { append(bytes, static_cast<std::uint8_t>(value ? 1 : 0)); }
template <class Range>
void append_all(std::string& bytes, const Range& values) {
  for (const double value : values) append(bytes, value);
}
void append_zeros(std::string& bytes, int count) {
  for (int i = 0; i < count; ++i) append(bytes, 0.0);
}

std::string mode_part(Controller& c) {
  const PowerState& power = c.power();
  std::string body;
  append(body, microseconds(c.time()));
  append_bool(body, true);
  append_bool(body, true);
  append_bool(body, power.mode() >= RobotMode::kPowerOn);
  append_bool(body, (status_bits(power.safety()) & kEmergencyBit) != 0);
  append_bool(body, power.safety() == SafetyMode::kProtectiveStop);
  append_bool(body, c.programs().running());
  append_bool(body, c.programs().state() == RuntimeState::kPaused);
  append(body, static_cast<std::int8_t>(power.mode()));
  append(body, static_cast<std::uint8_t>(c.settings().freedrive ? 1 : 0));
  append(body, c.settings().slider);
  append(body, number_of(c, "speed_scaling"));
  append(body, 1.0);
  append(body, std::uint8_t{0});
  return body;
}

std::string joint_part(Controller& c) {
  std::string body;
  for (std::size_t i = 0; i < 6; ++i) {
    append(body, value_of(c, "actual_q")[i]);
    append(body, value_of(c, "target_q")[i]);
    append(body, value_of(c, "actual_qd")[i]);
    append(body, static_cast<float>(value_of(c, "actual_current")[i]));
    append(body, static_cast<float>(value_of(c, "actual_joint_voltage")[i]));
    append(body, static_cast<float>(kTemperatureC));
    append(body, static_cast<float>(kTemperatureC));
    append(body, static_cast<std::uint8_t>(value_of(c, "joint_mode")[i]));
  }
  return body;
}

std::string tool_part(Controller& c) {
  std::string body;
  append(body, std::int8_t{0});
  append(body, std::int8_t{0});
  append(body, c.io().tool_analog_in[0]);
  append(body, c.io().tool_analog_in[1]);
  append(body, static_cast<float>(kVoltage));
  append(body, static_cast<std::uint8_t>(c.io().tool_voltage));
  append(body, 0.0F);
  append(body, static_cast<float>(kTemperatureC));
  append(body, static_cast<std::uint8_t>(number_of(c, "tool_mode")));
  return body;
}

std::string board_part(Controller& c) {
  const Terminals& io = c.io();
  std::string body;
  append(body, io.digital_in);
  append(body, io.digital_out);
  const auto voltage = [&](int bit) { return static_cast<std::int8_t>(io.analog_types >> bit & 1); };
  append(body, voltage(0));
  append(body, voltage(1));
  append_all(body, io.analog_in);
  append(body, voltage(2));
  append(body, voltage(3));
  append(body, number_of(c, "standard_analog_output0"));
  append(body, number_of(c, "standard_analog_output1"));
  append(body, static_cast<float>(kTemperatureC));
  append(body, static_cast<float>(kVoltage));
  append(body, static_cast<float>(number_of(c, "actual_robot_current")));
  append(body, 0.0F);
  append(body, static_cast<std::uint8_t>(c.power().safety()));
  append_bool(body, c.power().safety() == SafetyMode::kReduced);
  append(body, std::uint8_t{0});  // no Euromap67
  append(body, std::uint32_t{0});
  append(body, std::uint8_t{0});  // no operational mode selector
  append(body, std::uint8_t{0});  // no three-position switch
  append(body, std::uint8_t{0});
  return body;
}

std::string cartesian_part(Controller& c) {
  std::string body;
  append_all(body, value_of(c, "actual_TCP_pose"));
  append_all(body, value_of(c, "tcp_offset"));
  return body;
}

std::string kinematics_part() {
  std::string body;
  for (std::uint32_t i = 0; i < 6; ++i) append(body, i + 1);  // checksums of a calibration: none is
  append_zeros(body, 6);                                      // theta
  append_all(body, kUr5.a);
  append_all(body, kUr5.d);
  append_all(body, kUr5.alpha);
  append(body, std::uint32_t{0});
  return body;
}

std::string configuration_part(Controller& c) {
  const device::ArmDescription& arm = c.motion().kinematics().arm();
  std::string body;
  for (int i = 0; i < 6; ++i) {
    append(body, arm.limits.lower[i]);
    append(body, arm.limits.upper[i]);
  }
  for (int i = 0; i < 6; ++i) {
    append(body, arm.limits.velocity[i]);
    append(body, arm.limits.acceleration[i]);
  }
  for (const double value : {1.05, 1.4, 0.25, 1.2, 0.25})
    append(body, value);  // defaults of moves; radius of a turn, m
  append_all(body, kUr5.a);
  append_all(body, kUr5.d);
  append_all(body, kUr5.alpha);
  append_zeros(body, 6);
  append(body, kBoardVersion);
  append(body, std::int32_t{c.is_e_series() ? 4 : 2});  // control box
  append(body, kUr5.type);
  append(body, std::int32_t{1});
  return body;
}

std::string force_part(Controller& c) {
  std::string body;
  append_all(body, value_of(c, "actual_TCP_force"));
  append(body, 0.0);
  return body;
}

std::string additional_part(Controller& c) {
  std::string body;
  append_bool(body, false);
  append_bool(body, true);
  append_bool(body, c.settings().freedrive);
  if (c.is_e_series()) append(body, std::uint8_t{0});  // reserved
  return body;
}

std::string event_body(const ControllerEvent& event) {
  using Kind = ControllerEvent::Kind;
  std::string body;
  switch (event.kind) {
    case Kind::kText:
      break;
    case Kind::kKey:
      append(body, event.code);
      append(body, event.argument);
      append(body, static_cast<std::uint8_t>(event.title.size()));
      body += event.title;
      break;
    case Kind::kError:
      append(body, event.code);
      append(body, event.argument);
      append(body, event.level);
      append(body, std::uint32_t{0});
      append(body, std::uint32_t{0});
      break;
    case Kind::kRuntimeException:
      append(body, event.line);
      append(body, event.column);
      break;
    case Kind::kSafetyMode:
      append(body, std::int32_t{0});
      append(body, std::int32_t{0});
      append(body, static_cast<std::uint8_t>(event.argument));
      append(body, std::uint32_t{0});
      append(body, std::uint32_t{0});
      break;
  }
  return body + event.text;
}

std::uint8_t type_of(ControllerEvent::Kind kind) {
  static constexpr std::array<std::uint8_t, 5> kTypes = {0, 7, 6, 10, 5};
  return kTypes[static_cast<std::size_t>(kind)];
}

}  // namespace

std::string make_robot_state(Controller& c) {
  std::string body;
  append_part(body, 0, mode_part(c));
  append_part(body, 1, joint_part(c));
  append_part(body, 2, tool_part(c));
  append_part(body, 3, board_part(c));
  append_part(body, 4, cartesian_part(c));
  append_part(body, 5, kinematics_part());
  append_part(body, 6, configuration_part(c));
  append_part(body, 7, force_part(c));
  append_part(body, 8, additional_part(c));
  return whole_package(kRobotState, body);
}

std::string make_version_message(Controller& c) {
  static constexpr std::string_view kProject = "URControl", kDate = "01-01-2024, 00:00:00";
  const Version& version = c.options().version;
  std::string body;
  append(body, microseconds(c.time()));
  append(body, kNoSource);
  append(body, std::uint8_t{3});
  append(body, static_cast<std::int8_t>(kProject.size()));
  body += kProject;
  append(body, static_cast<std::uint8_t>(version.major));
  append(body, static_cast<std::uint8_t>(version.minor));
  append(body, static_cast<std::int32_t>(version.bugfix));
  append(body, static_cast<std::int32_t>(version.build));
  body += kDate;
  return whole_package(kRobotMessage, body);
}

std::string make_message(const ControllerEvent& event) {
  std::string body;
  append(body, microseconds(event.time));
  append(body, kFromController);
  append(body, type_of(event.kind));
  return whole_package(kRobotMessage, body + event_body(event));
}

std::string make_realtime_state(Controller& c) {
  const bool newest = c.options().version >= Version{5, 10, 0, 0};
  std::string body;
  append(body, to_seconds(c.time()));
  for (const auto name : {"target_q", "target_qd", "target_qdd", "target_current", "target_moment", "actual_q",
                          "actual_qd", "actual_current", "joint_control_output", "actual_TCP_pose", "actual_TCP_speed",
                          "actual_TCP_force", "target_TCP_pose", "target_TCP_speed"})
    append_all(body, value_of(c, name));
  append(body, number_of(c, "actual_digital_input_bits"));
  append_all(body, value_of(c, "joint_temperatures"));
  append(body, number_of(c, "actual_execution_time"));
  append(body, 0.0);  // for the maker's tests
  append(body, number_of(c, "robot_mode"));
  append_all(body, value_of(c, "joint_mode"));
  append(body, number_of(c, "safety_mode"));
  append_zeros(body, 6);
  for (std::size_t i = 0; i < 3; ++i) append(body, value_of(c, "actual_tool_accelerometer")[i]);
  append_zeros(body, 6);
  append(body, number_of(c, "speed_scaling"));
  append_zeros(body, 3);  // momentum, and two for the maker
  append(body, number_of(c, "actual_main_voltage"));
  append(body, number_of(c, "actual_robot_voltage"));
  append(body, number_of(c, "actual_robot_current"));
  append_all(body, value_of(c, "actual_joint_voltage"));
  append(body, number_of(c, "actual_digital_output_bits"));
  append(body, number_of(c, "runtime_state"));
  append_zeros(body, 6);  // elbow: position, velocity
  append(body, number_of(c, "safety_status"));
  if (newest) append_zeros(body, 13);
  std::string bytes;
  append(bytes, static_cast<std::int32_t>(body.size() + sizeof(std::int32_t)));
  return bytes + body;
}

}  // namespace takt::hw::rtde
