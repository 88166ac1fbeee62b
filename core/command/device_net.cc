#include "core/command/device_net.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/command/condition_net.h"

namespace takt::command {
namespace {

using net::NetDescription;

/// Fingers that stand for so long, in s, have answered: a command that is new shows as not answered after one cycle.
constexpr double kStanding_s = 0.002;

NetDescription set_digital(const std::string& output, bool value) {
  NetDescription net;
  net.name = "set " + output;
  net.add("output", "DigitalOutput", {{"device", output}, {"value", value}});
  net.add("end", "Termination", {{"condition", true}});
  return net;
}

/// sent + clamp(goal - sent, +-step), until sent is the goal.
NetDescription set_analog(const std::string& output, double goal, const device::AnalogOutput& device, double period) {
  const auto& description = device.description();
  NetDescription net;
  net.name = "set " + output;
  net.add("output", "AnalogOutput", {{"device", output}});
  if (!std::isfinite(description.rate_max)) {
    net.add("value", "ConstantReal", {{"value", goal}});
    net.link("value.value", "output.value");
    net.add("end", "Termination", {{"condition", true}});
    return net;
  }
  const double step = description.rate_max * period;
  net.add("state", "AnalogOutputState", {{"device", output}});
  net.add("to_go", "Subtract", {{"a", goal}});
  net.link("state.sent", "to_go.b");
  net.add("step", "Saturation", {{"lower", -step}, {"upper", step}});
  net.link("to_go.value", "step.input");
  net.add("next", "Add");
  net.link("state.sent", "next.a");
  net.link("step.value", "next.b");
  net.link("next.value", "output.value");
  // Sums of steps round: what is left then is far below any resolution, and the output stays within its rate.
  net.add("rest", "Abs");
  net.link("to_go.value", "rest.input");
  net.add("there", "LessThan", {{"b", 1e-9 * std::max(1.0, std::abs(goal))}});
  net.link("rest.value", "there.a");
  net.add("cancel", "Cancel");
  add_end(net, add_gate(net, "done", "Or", "cancel.requested", "there.value"));
  return net;
}

}  // namespace

NetDescription grip_net(const GripCommand& command) {
  NetDescription net;
  net.name = "grip " + command.gripper;
  net.add("command", "GripperCommand",
          {{"device", command.gripper}, {"width", command.width}, {"speed", command.speed}, {"force", command.force}});
  net.add("state", "GripperState", {{"device", command.gripper}});
  net.add("standing", "Not");
  net.link("state.moving", "standing.input");
  net.add("stood", "OnDelay", {{"delay", kStanding_s}});
  net.link("standing.value", "stood.input");
  net.add("cancel", "Cancel");
  add_end(net, add_gate(net, "done", "Or", "cancel.requested", "stood.value"));
  return net;
}

NetDescription set_net(const std::string& output, const SignalValue& value, const Cell& cell, double period) {
  if (const bool* level = std::get_if<bool>(&value)) return set_digital(output, *level);
  return set_analog(output, std::get<double>(value), *cell.analog_outputs.find(output)->second, period);
}

WaitNet wait_net(const Condition& condition, std::optional<double> timeout, const Cell& cell, const Biases& biases) {
  WaitNet wait;
  NetDescription& net = wait.net;
  net.name = "wait";
  wait.condition_port = add_condition(net, condition, "until", cell, biases);
  net.add("cancel", "Cancel");
  std::string done = add_gate(net, "holds", "Or", "cancel.requested", wait.condition_port);
  if (timeout) {
    net.add("late", "OnDelay", {{"delay", *timeout}, {"input", true}});
    done = add_gate(net, "done", "Or", done, "late.value");
  }
  add_end(net, done);
  return wait;
}

}  // namespace takt::command
