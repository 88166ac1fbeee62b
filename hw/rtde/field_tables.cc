// Which fields there are. Facts of Universal Robots' RTDE guide and of clients in common use; names, types, and the
// first versions of CB3 (3.x) and e-Series (5.x) that have them.
#include <fmt/format.h>

#include "hw/rtde/field.h"

namespace takt::hw::rtde {

namespace {

using enum FieldType;

constexpr Version kAlways3 = {3, 0, 0, 0}, kAlways5 = {5, 0, 0, 0};
constexpr Version kNone = {};

/// A field, or with `last` >= 0 one for each number from `first` to `last`, which stands behind the name.
struct Row {
  std::string_view name;
  FieldType type;
  Version cb3 = kAlways3, e = kAlways5;
  int first = 0, last = -1;
};

// Registers: the lower half came with 3.4, the upper one with 3.9 and 5.3. Bits 0 to 63 exist only as words.
constexpr Version kLower3 = {3, 4, 0, 0}, kUpper3 = {3, 9, 0, 0}, kUpper5 = {5, 3, 0, 0};

constexpr Row kOutputs[] = {
    {"timestamp", kDouble},
    {"target_q", kVector6d},
    {"target_qd", kVector6d},
    {"target_qdd", kVector6d},
    {"target_current", kVector6d},
    {"target_moment", kVector6d},
    {"actual_q", kVector6d},
    {"actual_qd", kVector6d},
    {"actual_current", kVector6d},
    {"actual_current_window", kVector6d},
    {"joint_control_output", kVector6d},
    {"actual_TCP_pose", kVector6d},
    {"actual_TCP_speed", kVector6d},
    {"actual_TCP_force", kVector6d},
    {"target_TCP_pose", kVector6d},
    {"target_TCP_speed", kVector6d},
    {"actual_digital_input_bits", kUint64},
    {"joint_temperatures", kVector6d},
    {"actual_execution_time", kDouble},
    {"target_execution_time", kDouble},
    {"robot_mode", kInt32},
    {"joint_mode", kVector6Int32},
    {"safety_mode", kInt32},
    {"safety_status", kInt32, {3, 10, 0, 0}, {5, 4, 0, 0}},
    {"actual_tool_accelerometer", kVector3d},
    {"speed_scaling", kDouble},
    {"target_speed_fraction", kDouble},
    {"actual_momentum", kDouble},
    {"actual_main_voltage", kDouble},
    {"actual_robot_voltage", kDouble},
    {"actual_robot_current", kDouble},
    {"actual_joint_voltage", kVector6d},
    {"actual_digital_output_bits", kUint64},
    {"actual_configurable_digital_input_bits", kUint64},
    {"actual_configurable_digital_output_bits", kUint64},
    {"runtime_state", kUint32},
    {"elbow_position", kVector3d, {3, 5, 0, 0}},
    {"elbow_velocity", kVector3d, {3, 5, 0, 0}},
    {"robot_status_bits", kUint32},
    {"safety_status_bits", kUint32},
    {"analog_io_types", kUint32},
    {"standard_analog_input0", kDouble},
    {"standard_analog_input1", kDouble},
    {"standard_analog_output0", kDouble},
    {"standard_analog_output1", kDouble},
    {"io_current", kDouble},
    {"euromap67_input_bits", kUint32},
    {"euromap67_output_bits", kUint32},
    {"euromap67_24V_voltage", kDouble},
    {"euromap67_24V_current", kDouble},
    {"tool_mode", kUint32},
    {"tool_output_mode", kUint8, kNone, {5, 2, 0, 0}},
    {"tool_digital_output0_mode", kUint8, kNone, {5, 2, 0, 0}},
    {"tool_digital_output1_mode", kUint8, kNone, {5, 2, 0, 0}},
    {"tool_analog_input_types", kUint32},
    {"tool_analog_input0", kDouble},
    {"tool_analog_input1", kDouble},
    {"tool_output_voltage", kInt32},
    {"tool_output_current", kDouble},
    {"tool_temperature", kDouble},
    {"tcp_force_scalar", kDouble},
    {"joint_position_deviation_ratio", kDouble},
    {"collision_detection_ratio", kDouble},
    {"time_scale_source", kInt32},
    {"encoder0_raw", kInt32},
    {"encoder1_raw", kInt32},
    {"wrench_calc_from_currents", kVector6d},
    {"payload", kDouble, {3, 11, 0, 0}, {5, 5, 1, 0}},
    {"payload_cog", kVector3d, {3, 11, 0, 0}, {5, 5, 1, 0}},
    {"payload_inertia", kVector6d, {3, 15, 0, 0}, {5, 11, 0, 0}},
    {"script_control_line", kUint32, {3, 14, 0, 0}, {5, 9, 0, 0}},
    {"tcp_offset", kVector6d, {3, 12, 3, 0}, {5, 5, 1, 0}},
    {"ft_raw_wrench", kVector6d, kNone, {5, 9, 0, 0}},
    {"actual_current_as_torque", kVector6d, kNone, {5, 23, 0, 0}},
    {"output_bit_registers0_to_31", kUint32},
    {"output_bit_registers32_to_63", kUint32},
    {"output_bit_register_", kBool, kUpper3, kUpper5, 64, 127},
    {"output_int_register_", kInt32, kLower3, kAlways5, 0, 23},
    {"output_int_register_", kInt32, kUpper3, kUpper5, 24, 47},
    {"output_double_register_", kDouble, kLower3, kAlways5, 0, 23},
    {"output_double_register_", kDouble, kUpper3, kUpper5, 24, 47},
    {"input_bit_registers0_to_31", kUint32, kLower3},
    {"input_bit_registers32_to_63", kUint32, kLower3},
    {"input_bit_register_", kBool, kUpper3, kUpper5, 64, 127},
    {"input_int_register_", kInt32, kLower3, kAlways5, 0, 23},
    {"input_int_register_", kInt32, kUpper3, kUpper5, 24, 47},
    {"input_double_register_", kDouble, kLower3, kAlways5, 0, 23},
    {"input_double_register_", kDouble, kUpper3, kUpper5, 24, 47},
};

constexpr Row kInputs[] = {
    {"speed_slider_mask", kUint32},
    {"speed_slider_fraction", kDouble},
    {"standard_digital_output_mask", kUint8},
    {"standard_digital_output", kUint8},
    {"configurable_digital_output_mask", kUint8},
    {"configurable_digital_output", kUint8},
    {"tool_digital_output_mask", kUint8},
    {"tool_digital_output", kUint8},
    {"standard_analog_output_mask", kUint8},
    {"standard_analog_output_type", kUint8},
    {"standard_analog_output_0", kDouble},
    {"standard_analog_output_1", kDouble},
    {"input_bit_registers0_to_31", kUint32},
    {"input_bit_registers32_to_63", kUint32},
    {"input_bit_register_", kBool, kUpper3, kUpper5, 64, 127},
    {"input_int_register_", kInt32, kLower3, kAlways5, 0, 23},
    {"input_int_register_", kInt32, kUpper3, kUpper5, 24, 47},
    {"input_double_register_", kDouble, kLower3, kAlways5, 0, 23},
    {"input_double_register_", kDouble, kUpper3, kUpper5, 24, 47},
    {"external_force_torque", kVector6d, {3, 3, 0, 0}},
};

template <std::size_t count>
FieldTable expanded(const Row (&rows)[count]) {
  std::vector<Field> fields;
  for (const Row& row : rows) {
    if (row.last < 0) fields.push_back({std::string(row.name), row.type, row.cb3, row.e});
    for (int i = row.first; i <= row.last; ++i)
      fields.push_back({fmt::format("{}{}", row.name, i), row.type, row.cb3, row.e});
  }
  return FieldTable(std::move(fields));
}

}  // namespace

const FieldTable& output_fields() {
  static const FieldTable table = expanded(kOutputs);
  return table;
}

const FieldTable& input_fields() {
  static const FieldTable table = expanded(kInputs);
  return table;
}

}  // namespace takt::hw::rtde
