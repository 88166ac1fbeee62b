#include "core/command/actions/joint_jog_action.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/planned_path.h"
#include "core/command/actions/velocity_action.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

class JogJoints final : public ActionModel {
 public:
  JogJoints(const expression::JointsSensor& rates, const expression::State& enabled, const TrackingParameters& bounds)
      : rates_(rates.node()), enabled_(enabled.node()), bounds_(bounds) {}

  [[nodiscard]] std::string_view name() const override { return "jog"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kJoints; }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return time_to_rest(actuator, 1.0); }
  [[nodiscard]] bool net_knows_stop_time() const override { return false; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> all = {rates_, enabled_};
    if (bounds_.speed) all.push_back(bounds_.speed->node());
    return all;
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics;
    for (const auto& [key, value] : {std::pair("linear_max", bounds_.linear_max), {"angular_max", bounds_.angular_max}})
      if (!(value > 0.0 && std::isfinite(value)))
        diagnostics.error(Code::kOutOfRange, pointer_segment(key), fmt::format("{:g}", value),
                          "Give a number above 0, and finite");
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    fragment.add("held", "GateJoints");
    fragment.feed(rates_, "held.input");
    fragment.feed(enabled_, "held.open");
    std::string wanted = "held.value";
    if (const auto speed = speed_on(actuator, bounds_.speed)) {
      add_linked(fragment, "slowed", "ScaleJoints", {{"joints", wanted}});
      fragment.feed(speed->node(), "slowed.factor");
      wanted = "slowed.value";
    }
    fragment.add("go", "Not");
    fragment.feed(fragment.cancel(), "go.input");
    add_linked(fragment, "rates", "GateJoints", {{"input", wanted}, {"open", "go.value"}});
    add_linked(fragment, "motion", "JointJog", {{"rates", "rates.value"}},
               {{"device", actuator.name()},
                {"tool", net::value_to_json(net::Frame(actuator.arm()->X_FT))},
                {"linear_max", bounds_.linear_max},
                {"angular_max", bounds_.angular_max}});
    SetPoint set_point{.kind = SetPointKind::kJoints, .ports = {}, .constants = {}};
    for (const char* port : {"q", "dq", "ddq"}) set_point.ports[port] = std::string("motion.") + port;
    return {.set_point = std::move(set_point),
            .done = expression::Signal::at(fragment.gate_with_cancel("done", "And", add_standing(fragment, "motion")))};
  }

 private:
  expression::ExpressionPtr rates_, enabled_;
  TrackingParameters bounds_;
};

}  // namespace

Action jog(const expression::JointsSensor& rates, const expression::State& enabled, const TrackingParameters& bounds) {
  return Action(std::make_shared<const JogJoints>(rates, enabled, bounds));
}

}  // namespace takt::command
