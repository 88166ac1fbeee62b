#include "core/command/actions/freedrive_action.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/velocity_action.h"
#include "core/device/description.h"
#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using device::ControlMode;
using Json = nlohmann::ordered_json;
using kinematics::JointVector;

Json joints_json(const JointVector& q) { return net::value_to_json(net::JointArray(q)); }
Json three(double value) { return net::value_to_json(net::Vector(net::Vector::Constant(value))); }

void check_positive(Diagnostics& diagnostics, const char* key, double value, const char* unit) {
  if (std::isfinite(value) && value > 0.0) return;
  diagnostics.error(Code::kOutOfRange, key, fmt::format("{:g} {}", value, unit),
                    fmt::format("Give more than 0 {}", unit));
}

void check_from_zero(Diagnostics& diagnostics, const char* key, double value, const char* unit) {
  if (std::isfinite(value) && value >= 0.0) return;
  diagnostics.error(Code::kOutOfRange, key, fmt::format("{:g} {}", value, unit),
                    fmt::format("Choose 0 {} or more", unit));
}

void check_bounds(Diagnostics& diagnostics, const GuidanceParameters& parameters) {
  check_positive(diagnostics, "/linear_max", parameters.linear_max, "m/s");
  check_positive(diagnostics, "/angular_max", parameters.angular_max, "rad/s");
}

/// "guided.value": a person holds the arm, and no end was requested. Never null.
void add_guided(expression::FragmentWriter& fragment, const std::optional<expression::State>& enabled) {
  fragment.add("held", "DefaultToBoolean", {{"fallback", false}});
  if (enabled) {
    fragment.feed(enabled->node(), "held.input");
  } else {
    fragment.set_parameter("held", "input", true);
  }
  fragment.add("goes_on", "Not");
  fragment.feed(fragment.cancel(), "goes_on.input");
  add_linked(fragment, "guided", "And", {{"a", "held.value"}, {"b", "goes_on.value"}});
}

/// The springs' rest position follows the measured joints: velocity = gain * (what they are bent by, less a band).
class BySprings final : public ActionModel {
 public:
  explicit BySprings(const GuidanceParameters& parameters) : parameters_(parameters) {}

  [[nodiscard]] std::string_view name() const override { return "freedrive"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kJoints; }
  [[nodiscard]] std::optional<ControlMode> mode() const override { return ControlMode::kJointImpedance; }
  [[nodiscard]] std::vector<std::string> states() const override { return {"enabled", "error", "settled"}; }
  [[nodiscard]] bool net_knows_stop_time() const override { return false; }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override {
    return time_to_rest(actuator, 1.0) + to_seconds(actuator.arm()->device->description().impedance.ramp);
  }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    return parameters_.enabled ? std::vector{parameters_.enabled->node()} : std::vector<expression::ExpressionPtr>();
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics;
    check_bounds(diagnostics, parameters_);
    check_positive(diagnostics, "/springs/stiffness", parameters_.springs.stiffness, "Nm/rad");
    check_from_zero(diagnostics, "/springs/torque", parameters_.springs.torque, "Nm");
    check_positive(diagnostics, "/springs/gain", parameters_.springs.gain, "1/s");
    check_from_zero(diagnostics, "/springs/margin", parameters_.springs.margin, "rad");
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    const auto& range = actuator.arm()->device->description().impedance.joint;
    const JointVector soft = JointVector::Constant(range.upper.stiffness.size(), parameters_.springs.stiffness)
                                 .cwiseMax(range.lower.stiffness)
                                 .cwiseMin(range.upper.stiffness);
    add_guided(fragment, parameters_.enabled);
    add_rates(fragment, actuator, soft);
    add_linked(fragment, "motion", "JointJog", {{"rates", "led.value"}},
               {{"device", actuator.name()},
                {"tool", net::value_to_json(net::Frame(actuator.arm()->X_FT))},
                {"linear_max", parameters_.linear_max},
                {"angular_max", parameters_.angular_max},
                {"margin", parameters_.springs.margin}});
    add_linked(fragment, "springs", "SelectJoints", {{"condition", "guided.value"}},
               {{"if_true", joints_json(soft)}, {"if_false", joints_json(range.upper.stiffness)}});
    SetPoint set_point{.kind = SetPointKind::kJoints, .ports = {}, .constants = {}};
    for (const char* port : {"q", "dq", "ddq"}) set_point.ports[port] = std::string("motion.") + port;
    set_point.ports["stiffness"] = "springs.value";
    set_point.mode = ControlMode::kJointImpedance;
    return {.set_point = std::move(set_point), .done = expression::Signal::at(add_rest(fragment))};
  }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "enabled") return "guided.value";
    if (name == "settled") return "arm.settled";
    add_linked(fragment, "silent", "IsNullJoints", {{"input", "state.q"}});
    return "silent.value";
  }

 private:
  void add_rates(expression::FragmentWriter& fragment, const ActuatorModel& actuator, const JointVector& soft) const {
    fragment.add("state", "ArmState", {{"device", actuator.name()}});
    add_linked(fragment, "bend", "SubtractJoints", {{"a", "state.q"}, {"b", "state.set_point_q"}});
    add_linked(fragment, "beyond", "DeadBandJoints", {{"input", "bend.value"}},
               {{"width", joints_json(parameters_.springs.torque * soft.cwiseInverse())}});
    fragment.add("gain", "ConstantReal", {{"value", parameters_.springs.gain}});
    add_linked(fragment, "rates", "ScaleJoints", {{"joints", "beyond.value"}, {"factor", "gain.value"}});
    add_linked(fragment, "led", "GateJoints", {{"input", "rates.value"}, {"open", "guided.value"}});
  }

  /// Cancelled, the springs are at rest and stiff. @return the port.
  static std::string add_rest(expression::FragmentWriter& fragment) {
    add_linked(fragment, "firm", "And", {{"a", add_standing(fragment, "motion")}, {"b", "arm.settled"}});
    return fragment.gate_with_cancel("done", "And", "firm.value");
  }

  GuidanceParameters parameters_;
};

/// Mass and damper at the tool centre point, in its own axes; the tool goes with their velocity.
class ByBody final : public VelocityModel {
 public:
  /// @param felt  weight removed, in the sensor's measuring frame; without bias if `tared`
  ByBody(const GuidanceParameters& parameters, const expression::WrenchSensor& felt, bool tared,
         const Eigen::Isometry3d& X_TS)
      : parameters_(parameters), felt_(felt.node()), tared_(tared), X_TS_(X_TS) {}

  [[nodiscard]] std::string_view name() const override { return "freedrive"; }
  [[nodiscard]] std::vector<std::string> states() const override { return {"enabled", "error"}; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas{felt_};
    if (parameters_.enabled) formulas.push_back(parameters_.enabled->node());
    return formulas;
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics;
    const GuidanceParameters::Body& body = parameters_.body;
    check_bounds(diagnostics, parameters_);
    check_positive(diagnostics, "/body/mass", body.mass, "kg");
    check_positive(diagnostics, "/body/damping", body.damping, "Ns/m");
    check_positive(diagnostics, "/body/inertia", body.inertia, "kg m^2");
    check_positive(diagnostics, "/body/rotational_damping", body.rotational_damping, "Nms/rad");
    check_from_zero(diagnostics, "/body/force", body.force, "N");
    check_from_zero(diagnostics, "/body/torque", body.torque, "Nm");
    check_positive(diagnostics, "/body/cutoff", body.cutoff, "Hz");
    check_positive(diagnostics, "/body/tare_time", body.tare_time, "s");
    return diagnostics;
  }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "enabled") return "guided.value";
    fragment.add("silent", "IsNullWrench");
    fragment.feed(felt_, "silent.input");
    return "silent.value";
  }

 private:
  [[nodiscard]] std::optional<ToolSpeed> speed() const override {
    return ToolSpeed{.linear = parameters_.linear_max, .angular = parameters_.angular_max};
  }
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    const GuidanceParameters::Body& body = parameters_.body;
    add_guided(fragment, parameters_.enabled);
    fragment.add("at_tool", "TransformWrench", {{"frame", net::value_to_json(net::Frame(X_TS_))}});
    add_contact(fragment, "at_tool.wrench");
    add_linked(fragment, "smooth", "LowPassWrench", {{"input", "at_tool.value"}}, {{"cutoff", body.cutoff}});
    add_linked(fragment, "hand", "DeadBandWrench", {{"input", "smooth.value"}},
               {{"force", body.force}, {"torque", body.torque}});
    // Let go, it begins anew: at rest.
    add_linked(fragment, "let_go", "Not", {{"input", "guided.value"}});
    add_linked(fragment, "law", "AdmittanceLaw", {{"wrench", "hand.value"}, {"reset", "let_go.value"}},
               {{"mass", three(body.mass)},
                {"damping", three(body.damping)},
                {"stiffness", three(0.0)},
                {"inertia", three(body.inertia)},
                {"rotational_damping", three(body.rotational_damping)},
                {"rotational_stiffness", three(0.0)}});
    add_tool(fragment, actuator, "tool", "set_point_q");
    add_linked(fragment, "in_base", "RotateTwist", {{"frame", "tool.frame"}, {"twist", "law.twist"}});
    add_linked(fragment, "led", "GateTwist", {{"input", "in_base.value"}, {"open", "guided.value"}});
    add_linked(fragment, "bounded", "LimitTwist", {{"input", "led.value"}},
               {{"linear_max", parameters_.linear_max}, {"angular_max", parameters_.angular_max}});
    add_caution(fragment, actuator);
    add_linked(fragment, "wanted", "ScaleTwist", {{"twist", "bounded.value"}, {"factor", "caution.value"}});
  }

  /// Near singular postures joints would have to change their rates faster than they can, and the tool would go astray:
  /// there it goes slower, but still out again. "caution.value", in [kSlowest, 1].
  static void add_caution(expression::FragmentWriter& fragment, const ActuatorModel& actuator) {
    constexpr double kNear = 0.25, kSlowest = 0.1;  // smallest singular value; share of the velocity
    add_linked(fragment, "posture", "Manipulability", {{"q", "state.set_point_q"}},
               {{"device", actuator.name()}, {"tool", net::value_to_json(net::Frame(actuator.arm()->X_FT))}});
    add_linked(fragment, "room", "Multiply", {{"a", "posture.smallest"}}, {{"b", 1.0 / kNear}});
    add_linked(fragment, "caution", "Saturation", {{"input", "room.value"}}, {{"lower", kSlowest}, {"upper", 1.0}});
  }

  /// What the hand exerts; nothing is known until an untared sensor has been tared.
  void add_contact(expression::FragmentWriter& fragment, const std::string& to) const {
    if (tared_) return fragment.feed(felt_, to);
    const double cycles = std::ceil(parameters_.body.tare_time / to_seconds(fragment.period()));
    fragment.add("tare", "Tare", {{"trigger", true}, {"cycles", static_cast<std::int64_t>(cycles)}});
    fragment.feed(felt_, "tare.wrench");
    fragment.link("tare.tared", to);
  }

  GuidanceParameters parameters_;
  expression::ExpressionPtr felt_;
  bool tared_;
  Eigen::Isometry3d X_TS_;
};

/// For arms that cannot be guided.
class NoFreedrive final : public ActionModel {
 public:
  [[nodiscard]] std::string_view name() const override { return "freedrive"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kJoints; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter&, const ActuatorModel&) const override { return {}; }
  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics;
    std::string modes = "none";
    if (actuator.arm() != nullptr) modes = actuator.arm()->device->description().modes.list();
    diagnostics.error(Code::kConflict, {},
                      fmt::format("C8: '{}' cannot be guided by hand: it has no force sensing (control modes: {})",
                                  actuator.name(), modes),
                      "Name an arm with the mode joint_impedance, or with a force/torque sensor on its flange");
    return diagnostics;
  }
};

const std::pair<const std::string, expression::MountedSensor>* sensor_on(const expression::Cell& cell,
                                                                         const std::string& arm) {
  const auto found = std::ranges::find_if(cell.sensors, [&arm](const auto& one) { return one.second.arm == arm; });
  return found == cell.sensors.end() ? nullptr : &*found;
}

}  // namespace

FreedriveKind freedrive_kind(const expression::Cell& cell, const std::string& arm) {
  const auto found = cell.arms.find(arm);
  if (found == cell.arms.end() || found->second.device == nullptr) return FreedriveKind::kNone;
  const device::ArmDescription& model = found->second.device->description();
  if (model.modes.has(ControlMode::kJointImpedance)) return FreedriveKind::kSprings;
  const bool feels = model.inverse != nullptr && sensor_on(cell, arm) != nullptr;
  return feels ? FreedriveKind::kBody : FreedriveKind::kNone;
}

Action freedrive(const expression::Cell& cell, const std::string& arm, const GuidanceParameters& parameters,
                 const expression::Biases& biases) {
  switch (freedrive_kind(cell, arm)) {
    case FreedriveKind::kSprings:
      return Action(std::make_shared<const BySprings>(parameters));
    case FreedriveKind::kBody: {
      const auto& [name, sensor] = *sensor_on(cell, arm);
      const Eigen::Isometry3d X_TS = cell.arms.find(arm)->second.X_FT.inverse() * sensor.X_FS;
      return Action(std::make_shared<const ByBody>(parameters, expression::contact_wrench(cell, name, biases),
                                                   biases.contains(name), X_TS));
    }
    case FreedriveKind::kNone:
      break;
  }
  return Action(std::make_shared<const NoFreedrive>());
}

}  // namespace takt::command
