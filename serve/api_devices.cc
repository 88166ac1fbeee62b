// The devices of the cell: what they are, and how they are.
#include <cmath>
#include <type_traits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/site_devices.h"
#include "core/net/value_json.h"
#include "serve/api.h"
#include "serve/cell_json.h"

namespace takt::serve {
namespace {

using DeviceJson = nlohmann::ordered_json;

DeviceJson joints_json(const device::JointVector& joints) {
  DeviceJson list = DeviceJson::array();
  for (Eigen::Index i = 0; i < joints.size(); ++i) list.push_back(joints[i]);
  return list;
}

/// A bound that is not finite is none.
DeviceJson bound_json(double bound) { return std::isfinite(bound) ? DeviceJson(bound) : DeviceJson(nullptr); }

// -- What they are ----------------------------------------------------------------------------------------------------

DeviceJson sheet_of(const device::ArmDescription& arm) {
  DeviceJson modes = DeviceJson::array();
  for (const device::ControlMode mode : arm.modes.modes) modes.push_back(name_of(mode));
  return {{"joint_names", arm.joint_names},
          {"lower", joints_json(arm.limits.lower)},
          {"upper", joints_json(arm.limits.upper)},
          {"velocity", joints_json(arm.limits.velocity)},
          {"acceleration", joints_json(arm.limits.acceleration)},
          {"jerk", joints_json(arm.limits.jerk)},
          {"home", joints_json(arm.home)},
          {"modes", std::move(modes)},
          {"measures_torque", arm.torque_noise.size() > 0},
          {"payload_max_kg", arm.payload_max > 0.0 ? DeviceJson(arm.payload_max) : DeviceJson(nullptr)},
          {"period_s", to_seconds(arm.cycle)},
          {"sample_age_max_s", to_seconds(arm.sample_age_max)}};
}

DeviceJson sheet_of(const device::ForceTorqueDescription& sensor) {
  return {{"range", net::value_to_json(sensor.range)},
          {"noise", net::value_to_json(sensor.noise)},
          {"period_s", to_seconds(sensor.cycle)},
          {"sample_age_max_s", to_seconds(sensor.sample_age_max)}};
}

DeviceJson sheet_of(const device::GripperDescription& gripper) {
  return {{"stroke_m", gripper.stroke},
          {"speed_min_m_s", gripper.speed_min},
          {"speed_max_m_s", gripper.speed_max},
          {"force_min_N", gripper.force_min},
          {"force_max_N", gripper.force_max},
          {"period_s", to_seconds(gripper.cycle)},
          {"sample_age_max_s", to_seconds(gripper.sample_age_max)}};
}

DeviceJson sheet_of(const expression::MountedChanger& changer) {
  return {{"size", changer.size}, {"lock_s", changer.lock_time}};
}

template <class T>
DeviceJson sheet_of(const device::SignalInput<T>& input) {
  return {{"unit", input.description().unit}, {"sample_age_max_s", to_seconds(input.description().sample_age_max)}};
}

template <class T>
DeviceJson sheet_of(const device::SignalOutput<T>& output) {
  const device::SignalOutputDescription<T>& known = output.description();
  DeviceJson sheet{{"unit", known.unit}, {"stop", known.stop ? DeviceJson(*known.stop) : DeviceJson(nullptr)}};
  if constexpr (std::is_same_v<T, double>) {
    sheet["lower"] = bound_json(known.lower);
    sheet["upper"] = bound_json(known.upper);
    sheet["rate_max_1_s"] = bound_json(known.rate_max);
  }
  return sheet;
}

// -- How they are -----------------------------------------------------------------------------------------------------

DeviceJson state_of(const ArmView& arm) {
  return {{"q_measured", joints_json(arm.q_measured)},
          {"dq_measured", joints_json(arm.dq_measured)},
          {"tau_measured", joints_json(arm.tau_measured)},
          {"q_commanded", joints_json(arm.q_commanded)},
          {"mode", name_of(arm.mode)},
          {"ready", arm.ready},
          {"at_rest", arm.at_rest},
          {"held", arm.held},
          {"fault", arm.fault}};
}

DeviceJson state_of(const SensorView& sensor) {
  return {{"wrench", sensor.wrench ? net::value_to_json(*sensor.wrench) : DeviceJson(nullptr)}};
}

DeviceJson state_of(const GripperView& gripper) {
  DeviceJson state{{"held", gripper.held}, {"ready", false}};
  if (!gripper.sample) return state;
  const device::GripperSample& sample = *gripper.sample;
  state["ready"] = sample.ready;
  state["state"] = name_of(sample.state);
  state["width_m"] = sample.width;
  state["speed_m_s"] = sample.speed;
  state["force_N"] = sample.force;
  state["fault"] = sample.fault;
  return state;
}

DeviceJson state_of(const SignalView& signal) { return {{"value", to_json(signal.value)}, {"held", signal.held}}; }

}  // namespace

void Api::add_device_routes() {
  routes_.push_back({.method = "GET",
                     .path = "/v1/devices",
                     .id = "devices",
                     .summary = "All devices with their data sheets.",
                     .answer = {{"devices", "array",
                                 "name, kind, reality (SIM, EMULATED or HARDWARE) and data_sheet of each; `arm`: on "
                                 "whose flange it is"}},
                     .handle = [this](const Call&, const Respond& respond) { respond(devices()); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/devices/state",
                     .id = "device_states",
                     .summary = "The states of all devices after one cycle.",
                     .answer = {{"cycle", "integer", "after which the states were copied"},
                                {"devices", "object", "by name; null is what is not known"}},
                     .handle = [this](const Call&, const Respond& respond) { respond(device_states()); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/arms/{arm}",
                     .id = "arm",
                     .summary = "State and data sheet of an arm: rad or m, in the joint order of its URDF.",
                     .answer = {{"name", "string", ""},
                                {"cycle", "integer", "after which the state was copied"},
                                {"state", "object", "positions, velocities, torques, mode, rest"},
                                {"data_sheet", "object", "joints with their limits, modes of control"}},
                     .handle = [this](const Call& call, const Respond& respond) { respond(arm(call)); }});
}

HttpResponse Api::devices() const {
  const cell::BuiltCell& built = cell_.built();
  const expression::Cell& cell = built.cell;
  const auto realities = built.site->realities();
  DeviceJson list = DeviceJson::array();
  const auto add = [&](const std::string& name, const char* kind, DeviceJson sheet, const std::string& arm) {
    const auto found = realities.find(name.substr(0, name.find('/')));
    DeviceJson one{{"name", name},
                   {"kind", kind},
                   {"reality", name_of(found == realities.end() ? device::BackendMode::kSimulated : found->second)},
                   {"data_sheet", std::move(sheet)}};
    if (!arm.empty()) one["arm"] = arm;
    list.push_back(std::move(one));
  };
  for (const auto& [name, arm] : cell.arms) add(name, "arm", sheet_of(arm.device->description()), {});
  for (const auto& [name, sensor] : cell.sensors)
    add(name, "force/torque sensor", sheet_of(sensor.device->description()), sensor.arm);
  for (const auto& [name, gripper] : cell.grippers)
    add(name, "gripper", sheet_of(gripper.device->description()), gripper.arm);
  for (const auto& [name, changer] : cell.changers) add(name, "tool changer", sheet_of(changer), changer.arm);
  const auto add_signals = [&add](const auto& signals, const char* kind) {
    for (const auto& [name, signal] : signals) add(name, kind, sheet_of(*signal), {});
  };
  add_signals(cell.digital_inputs, "digital input");
  add_signals(cell.analog_inputs, "analog input");
  add_signals(cell.digital_outputs, "digital output");
  add_signals(cell.analog_outputs, "analog output");
  return json_answer(200, {{"devices", list}});
}

HttpResponse Api::device_states() const {
  const CellView view = cell_.view();
  DeviceJson states = DeviceJson::object();
  const auto add = [&states](const auto& views) {
    for (const auto& one : views) states[one.name] = state_of(one);
  };
  add(view.arms);
  add(view.sensors);
  add(view.grippers);
  add(view.signals);
  return json_answer(200, {{"cycle", view.cycle}, {"devices", std::move(states)}});
}

HttpResponse Api::arm(const Call& call) const {
  const std::string& name = call.path.at("arm");
  const CellView view = cell_.view();
  std::vector<std::string> names;
  for (const ArmView& arm : view.arms) {
    names.push_back(arm.name);
    if (arm.name != name) continue;
    return json_answer(200, {{"name", name},
                             {"cycle", view.cycle},
                             {"state", state_of(arm)},
                             {"data_sheet", sheet_of(cell_.built().cell.arms.at(name).device->description())}});
  }
  Diagnostics why;
  why.error(Code::kUnknownName, "", fmt::format("the cell has no arm '{}'", name), nearest_choice(name, names));
  return problem(404, "there is no such arm", why);
}

}  // namespace takt::serve
