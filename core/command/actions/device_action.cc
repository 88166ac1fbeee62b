#include "core/command/actions/device_action.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// Fingers that are at rest for so long, in s, have answered: a new command shows as not answered after one cycle.
constexpr double kStanding_s = 0.002;

class SetDigital final : public ActionModel {
 public:
  explicit SetDigital(bool value) : value_(value) {}
  [[nodiscard]] std::string_view name() const override { return "set value"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kBoolean; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter&, const ActuatorModel&) const override {
    return {.set_point = {.kind = SetPointKind::kBoolean, .ports = {}, .constants = {{"value", value_}}},
            .done = expression::Signal::always(true)};
  }

 private:
  bool value_;
};

/// Adds sent + clamp(goal - sent, +-step) as "next.value": the goal, as near as the rate of the output allows.
/// @param link_goal  joins the goal with an input
void add_step(expression::FragmentWriter& fragment, const device::SignalOutputDescription<double>& output,
              const std::function<void(const std::string& to)>& link_goal) {
  const double step = output.rate_max * to_seconds(fragment.period());
  fragment.add("to_go", "Subtract");
  link_goal("to_go.a");
  fragment.link("state.sent", "to_go.b");
  add_linked(fragment, "step", "Saturation", {{"input", "to_go.value"}}, {{"lower", -step}, {"upper", step}});
  add_linked(fragment, "next", "Add", {{"a", "state.sent"}, {"b", "step.value"}});
}

/// Until sent is the goal.
class SetAnalog final : public ActionModel {
 public:
  explicit SetAnalog(double value) : value_(value) {}
  [[nodiscard]] std::string_view name() const override { return "set value"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kReal; }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics;
    const auto& output = *actuator.analog_output();
    if (value_ >= output.lower && value_ <= output.upper) return diagnostics;
    diagnostics.error(Code::kOutOfRange, {},
                      fmt::format("{:g} {} is not for '{}'", value_, output.unit, actuator.name()),
                      fmt::format("Choose {:g} to {:g} {}", output.lower, output.upper, output.unit));
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    const auto& output = *actuator.analog_output();
    SetPoint set_point{.kind = SetPointKind::kReal, .ports = {}, .constants = {}};
    if (!std::isfinite(output.rate_max)) {
      set_point.constants["value"] = value_;
      return {.set_point = set_point, .done = expression::Signal::always(true)};
    }
    fragment.add("state", "AnalogOutputState", {{"device", actuator.name()}});
    add_step(fragment, output, [&](const std::string&) { fragment.set_parameter("to_go", "a", value_); });
    // Sums of steps round: what is left then is far below any resolution, and the output stays within its rate.
    add_linked(fragment, "rest", "Abs", {{"input", "to_go.value"}});
    add_linked(fragment, "there", "LessThan", {{"a", "rest.value"}}, {{"b", 1e-9 * std::max(1.0, std::abs(value_))}});
    set_point.ports["value"] = "next.value";
    return {.set_point = set_point,
            .done = expression::Signal::at(fragment.gate_with_cancel("done", "Or", "there.value"))};
  }

 private:
  double value_;
};

/// What the sensor says, brought into the range; without it what was sent last.
class TrackValue final : public ActionModel {
 public:
  explicit TrackValue(expression::ExpressionPtr value) : value_(std::move(value)) {}
  [[nodiscard]] std::string_view name() const override { return "track value"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kReal; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return {value_}; }
  [[nodiscard]] std::vector<std::string> states() const override { return {"error"}; }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    constexpr double kLargest = std::numeric_limits<double>::max();
    const auto& output = *actuator.analog_output();
    fragment.add("state", "AnalogOutputState", {{"device", actuator.name()}});
    fragment.add("wanted", "DefaultToReal");
    fragment.feed(value_, "wanted.input");
    fragment.link("state.sent", "wanted.fallback");
    add_linked(fragment, "in_range", "Saturation", {{"input", "wanted.value"}},
               {{"lower", std::max(output.lower, -kLargest)}, {"upper", std::min(output.upper, kLargest)}});
    fragment.add("done", "Or", {{"a", false}});
    fragment.feed(fragment.cancel(), "done.b");
    std::string port = "in_range.value";
    if (std::isfinite(output.rate_max)) {
      add_step(fragment, output, [&](const std::string& to) { fragment.link("in_range.value", to); });
      port = "next.value";
    }
    return {.set_point = {.kind = SetPointKind::kReal, .ports = {{"value", port}}, .constants = {}},
            .done = expression::Signal::at("done.value")};
  }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string&,
                                      const Json&) const override {
    return fragment.add_null_test("wanted.input", net::ValueType::kReal);
  }

 private:
  expression::ExpressionPtr value_;
};

class FollowValue final : public ActionModel {
 public:
  explicit FollowValue(expression::ExpressionPtr value) : value_(std::move(value)) {}
  [[nodiscard]] std::string_view name() const override { return "follow value"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kReal; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return {value_}; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment, const ActuatorModel&) const override {
    fragment.add("done", "Or", {{"a", false}});
    fragment.feed(fragment.cancel(), "done.b");
    return {.set_point = {.kind = SetPointKind::kReal, .ports = {}, .constants = {}, .sensors = {{"value", value_}}},
            .done = expression::Signal::at("done.value")};
  }

 private:
  expression::ExpressionPtr value_;
};

double speed_of(const FingerParameters& parameters, const device::GripperDescription& gripper) {
  return parameters.speed.value_or(0.25 * gripper.speed_max);
}

class GripModel final : public ActionModel {
 public:
  GripModel(bool opens, const FingerParameters& parameters) : opens_(opens), parameters_(parameters) {}
  [[nodiscard]] std::string_view name() const override { return opens_ ? "release" : "grip"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kGrip; }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics;
    const device::GripperDescription& gripper = *actuator.gripper();
    const auto check = [&](const char* key, double value, double low, double high) {
      if (value >= low && value <= high) return;
      diagnostics.error(Code::kOutOfRange, key, fmt::format("{:g} is not for '{}'", value, actuator.name()),
                        fmt::format("Choose {:g} to {:g}", low, high));
    };
    check("/width", width(gripper), 0.0, gripper.stroke);
    check("/speed", speed(gripper), gripper.speed_min, gripper.speed_max);
    check("/force", force(gripper), gripper.force_min, gripper.force_max);
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    const device::GripperDescription& gripper = *actuator.gripper();
    fragment.add("state", "GripperState", {{"device", actuator.name()}});
    add_linked(fragment, "standing", "Not", {{"input", "state.moving"}});
    add_linked(fragment, "stood", "OnDelay", {{"input", "standing.value"}}, {{"delay", kStanding_s}});
    add_linked(fragment, "at_rest", "DefaultToBoolean", {{"input", "stood.value"}}, {{"fallback", false}});
    fragment.add("time_over", "OnDelay", {{"input", true}, {"delay", finger_timeout(parameters_, gripper)}});
    add_linked(fragment, "ended", "Or", {{"a", "at_rest.value"}, {"b", "time_over.value"}});
    add_linked(fragment, "not_at_rest", "Not", {{"input", "at_rest.value"}});
    add_linked(fragment, "late", "And", {{"a", "time_over.value"}, {"b", "not_at_rest.value"}});
    return {
        .set_point = {.kind = SetPointKind::kGrip,
                      .ports = {},
                      .constants = {{"width", width(gripper)}, {"speed", speed(gripper)}, {"force", force(gripper)}}},
        .done = expression::Signal::at(fragment.gate_with_cancel("done", "Or", "ended.value"))};
  }

  [[nodiscard]] std::vector<std::string> states() const override { return {"holding", "error", "overdue", "width"}; }
  [[nodiscard]] std::string add_state(expression::FragmentWriter&, const std::string& name,
                                      const Json&) const override {
    if (name == "overdue") return "late.value";
    return name == "error" ? "state.lost" : "state." + name;
  }

 private:
  double width(const device::GripperDescription& g) const {
    return parameters_.width.value_or(opens_ ? g.stroke : 0.0);
  }
  double speed(const device::GripperDescription& g) const { return speed_of(parameters_, g); }
  double force(const device::GripperDescription& g) const { return parameters_.force.value_or(0.5 * g.force_max); }

  bool opens_;
  FingerParameters parameters_;
};

/// The set point of the cycle before the first one, again and again.
class Hold final : public ActionModel {
 public:
  [[nodiscard]] std::string_view name() const override { return "hold"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kJoints; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    fragment.add("state", "ArmState", {{"device", actuator.name()}});
    add_linked(fragment, "there", "SnapshotJoints", {{"input", "state.set_point_q"}}, {{"trigger", true}});
    const auto zero = net::value_to_json(
        net::JointArray(kinematics::JointVector(kinematics::JointVector::Zero(actuator.arm()->device->joint_count()))));
    SetPoint set_point{.kind = SetPointKind::kJoints, .ports = {{"q", "there.value"}}, .constants = {}};
    set_point.constants["dq"] = zero;
    set_point.constants["ddq"] = zero;
    fragment.add("done", "Or", {{"a", false}});
    fragment.feed(fragment.cancel(), "done.b");
    return {.set_point = set_point, .done = expression::Signal::at("done.value")};
  }
};

}  // namespace

Action set_value(bool value) { return Action(std::make_shared<const SetDigital>(value)); }
Action set_value(double value) { return Action(std::make_shared<const SetAnalog>(value)); }
Action track_value(const expression::RealSensor& sensor) {
  return Action(std::make_shared<const TrackValue>(sensor.node()));
}
Action follow_value(const expression::RealSensor& sensor) {
  return Action(std::make_shared<const FollowValue>(sensor.node()));
}
double finger_timeout(const FingerParameters& parameters, const device::GripperDescription& gripper) {
  constexpr double kMargin = 2.0;  // what accelerates, or obeys a lower speed than it is told
  constexpr double kToAnswer_s = 1.0;
  return parameters.timeout.value_or(kMargin * gripper.stroke / speed_of(parameters, gripper) + kToAnswer_s);
}
Action grip(const FingerParameters& parameters) { return Action(std::make_shared<const GripModel>(false, parameters)); }
Action release(const FingerParameters& parameters) {
  return Action(std::make_shared<const GripModel>(true, parameters));
}
Action hold() { return Action(std::make_shared<const Hold>()); }

}  // namespace takt::command
