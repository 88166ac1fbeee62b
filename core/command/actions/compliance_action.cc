#include "core/command/actions/compliance_action.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/device/description.h"

namespace takt::command {
namespace {

using device::ControlMode;
using Json = nlohmann::ordered_json;
using kinematics::JointVector;

/// A requested value of the compliance, and its limits in the device.
struct SpringValue {
  const char* port;  ///< of the set point
  expression::Operand wanted;
  const char* unit;
  std::function<JointVector(const device::Compliance&)> of;  ///< element by element, as `wanted` counts them
};
using SpringValues = std::vector<SpringValue>;

template <class T>
void add(SpringValues& values, const char* port, const std::optional<expression::Term<T>>& wanted, const char* unit,
         std::function<JointVector(const device::Compliance&)> of) {
  if (wanted) values.push_back({port, wanted->operand(), unit, std::move(of)});
}

JointVector one(double value) { return JointVector::Constant(1, value); }

SpringValues values_of(const Stiff&) { return {}; }

SpringValues values_of(const JointCompliance& parameters) {
  SpringValues values;
  add(values, "stiffness", parameters.stiffness, "Nm/rad", [](const auto& c) { return c.stiffness; });
  add(values, "damping_ratio", parameters.damping_ratio, "1", [](const auto& c) { return c.damping_ratio; });
  add(values, "torque", parameters.torque, "Nm", [](const auto& c) { return c.feed_forward; });
  return values;
}

SpringValues values_of(const CartesianCompliance& parameters) {
  SpringValues values;
  add(values, "stiffness", parameters.stiffness, "N/m", [](const auto& c) { return JointVector(c.stiffness.head(3)); });
  add(values, "rotational_stiffness", parameters.rotational_stiffness, "Nm/rad",
      [](const auto& c) { return JointVector(c.stiffness.segment(3, 3)); });
  add(values, "damping_ratio", parameters.damping_ratio, "1", [](const auto& c) { return one(c.damping_ratio[0]); });
  add(values, "wrench", parameters.wrench, "N, Nm", [](const auto& c) { return c.feed_forward; });
  add(values, "nullspace_stiffness", parameters.nullspace_stiffness, "Nm/rad",
      [](const auto& c) { return one(c.nullspace_stiffness); });
  return values;
}

SpringValues values_of(const SpringParameters& parameters) {
  return std::visit([](const auto& kind) { return values_of(kind); }, parameters);
}
bool takes_tool_axes(const SpringParameters& parameters) {
  const auto* cartesian = std::get_if<CartesianCompliance>(&parameters);
  return cartesian != nullptr && cartesian->in_tool_axes;
}

/// The numbers of a constant in order: a number, a list, or a wrench.
void collect(const Json& constant, std::vector<double>& numbers) {
  if (constant.is_number()) numbers.push_back(constant.get<double>());
  if (!constant.is_structured()) return;
  for (const Json& part : constant) collect(part, numbers);
}

void check_constant(const SpringValue& value, const device::ComplianceRange& range, const std::string& arm,
                    Diagnostics& diagnostics) {
  const JointVector lower = value.of(range.lower), upper = value.of(range.upper);
  std::vector<double> numbers;
  collect(value.wanted.constant, numbers);
  const std::string pointer = std::string("/compliance/") + value.port;
  if (numbers.size() != static_cast<std::size_t>(upper.size()))
    return diagnostics.error(Code::kWrongSize, pointer, fmt::format("{} values for '{}'", numbers.size(), arm),
                             fmt::format("Give {} values", upper.size()));
  for (Eigen::Index i = 0; i < upper.size(); ++i) {
    const double number = numbers[static_cast<std::size_t>(i)];
    if (number >= lower[i] && number <= upper[i]) continue;  // false for NaN
    diagnostics.error(Code::kOutOfRange, fmt::format("{}/{}", pointer, i),
                      fmt::format("{:g} {} for '{}'", number, value.unit, arm),
                      fmt::format("Choose {:g} to {:g} {}", lower[i], upper[i], value.unit));
  }
}

void check_constants(const SpringValues& values, ControlMode mode, const device::ArmDescription& description,
                     const std::string& arm, Diagnostics& diagnostics) {
  if (mode == ControlMode::kPosition || !description.modes.has(mode)) return;
  for (const SpringValue& value : values)
    if (!value.wanted.node) check_constant(value, description.impedance.range(mode), arm, diagnostics);
}

class Compliant final : public ActionModel {
 public:
  Compliant(std::shared_ptr<const ActionModel> action, const SpringParameters& parameters)
      : action_(std::move(action)),
        mode_(mode_of(parameters)),
        values_(values_of(parameters)),
        in_tool_axes_(takes_tool_axes(parameters)) {}

  [[nodiscard]] std::string_view name() const override { return action_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return action_->gives(actuator); }
  [[nodiscard]] std::optional<ControlMode> mode() const override { return mode_; }
  [[nodiscard]] int via_count() const override { return action_->via_count(); }
  [[nodiscard]] PlannedPath planned_path() const override { return action_->planned_path(); }
  [[nodiscard]] const PlannedMotion* planned_motion() const override { return action_->planned_motion(); }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return action_->stop_time(actuator); }
  [[nodiscard]] bool net_knows_stop_time() const override { return action_->net_knows_stop_time(); }
  [[nodiscard]] double duration() const override { return action_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return action_->needs_plan(); }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return action_->begins(); }
  [[nodiscard]] std::vector<device::Seam> ends() const override { return action_->ends(); }

  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q_start) const override {
    auto planned = action_->plan(actuator, q_start);
    if (!planned) return planned;
    auto own = std::make_shared<Compliant>(std::move(*planned), Stiff{});
    own->mode_ = mode_;
    own->values_ = values_;
    own->in_tool_axes_ = in_tool_axes_;
    return own;
  }

  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas = action_->formulas();
    for (const SpringValue& value : values_)
      if (value.wanted.node) formulas.push_back(value.wanted.node);
    return formulas;
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics = action_->check(actuator);
    if (const auto other = action_->mode(); other && *other != mode_)
      diagnostics.error(Code::kConflict, {},
                        fmt::format("{} for mode {} is to be for mode {}", name(), name_of(*other), name_of(mode_)),
                        "Give one compliance");
    const auto arms = actuator.compliant_arms();
    for (const expression::MountedArm* arm : arms)
      check_constants(values_, mode_, arm->device->description(), arm->device->name(), diagnostics);
    if (arms.size() > 1) check_of_two(diagnostics);
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    Contribution contribution = action_->add_to(fragment, actuator);
    SetPoint& set_point = contribution.set_point;
    set_point.mode = mode_;
    set_point.in_tool_axes = in_tool_axes_;
    for (const SpringValue& value : values_) {
      if (value.wanted.node) {
        set_point.sensors[value.port] = value.wanted.node;
      } else {
        set_point.constants[value.port] = value.wanted.constant;
      }
    }
    return contribution;
  }

  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states = action_->states();
    if (mode_ != ControlMode::kPosition) states.emplace_back(kSettled);
    return states;
  }
  /// The springs are those of what drives the arm, in the same fragment.
  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    if (name != kSettled) return action_->add_state(fragment, name, parameters);
    std::vector<std::string> settled;
    for (const char* id : {"arm", "arm_1", "arm_2"})
      if (fragment.type_of(id).ends_with("ImpedanceCommand")) settled.push_back(std::string(id) + ".settled");
    if (settled.size() == 1) return settled.front();
    add_linked(fragment, "both_settled", "And", {{"a", settled.at(0)}, {"b", settled.at(1)}});
    return "both_settled.value";
  }

 private:
  /// A force of both would press on what they hold from two sides, without a bound.
  void check_of_two(Diagnostics& diagnostics) const {
    for (const SpringValue& value : values_) {
      if (std::string_view(value.port) != "wrench" && std::string_view(value.port) != "torque") continue;
      diagnostics.error(Code::kConflict, std::string("/compliance/") + value.port,
                        "two arms as one have stiffness only, no force", "Give a stiffness only, or move one arm");
    }
  }

  static constexpr const char* kSettled = "settled";

  std::shared_ptr<const ActionModel> action_;
  ControlMode mode_;
  SpringValues values_;
  bool in_tool_axes_;
};

}  // namespace

ControlMode mode_of(const SpringParameters& parameters) {
  if (std::holds_alternative<JointCompliance>(parameters)) return ControlMode::kJointImpedance;
  if (std::holds_alternative<CartesianCompliance>(parameters)) return ControlMode::kCartesianImpedance;
  return ControlMode::kPosition;
}

bool same(const std::optional<SpringParameters>& a, const std::optional<SpringParameters>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  if (a->index() != b->index() || takes_tool_axes(*a) != takes_tool_axes(*b)) return false;
  return std::ranges::equal(values_of(*a), values_of(*b), [](const SpringValue& x, const SpringValue& y) {
    return std::string_view(x.port) == y.port && x.wanted.node == y.wanted.node &&
           x.wanted.constant == y.wanted.constant;
  });
}

Diagnostics check_compliance(const SpringParameters& parameters, const device::ArmDescription& description,
                             const std::string& arm) {
  Diagnostics diagnostics;
  check_constants(values_of(parameters), mode_of(parameters), description, arm, diagnostics);
  return diagnostics;
}

Action with_compliance(const Action& action, const SpringParameters& parameters) {
  return Action(std::make_shared<const Compliant>(action.shared_model(), parameters));
}

}  // namespace takt::command
