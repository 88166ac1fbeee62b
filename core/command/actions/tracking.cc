#include "core/command/actions/tracking.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/planned_path.h"

namespace takt::command {

Diagnostics check_figures(std::initializer_list<Figure> figures) {
  Diagnostics diagnostics;
  for (const auto& [name, value, unit] : figures) {
    if (value > 0.0 && std::isfinite(value)) continue;
    diagnostics.error(Code::kOutOfRange, pointer_segment(name), fmt::format("{:g} {}", value, unit),
                      "Give a number above 0, and finite");
  }
  return diagnostics;
}

Diagnostics check_tracking(const TrackingParameters& parameters) {
  return check_figures({{"linear_max", parameters.linear_max, "m/s"},
                        {"angular_max", parameters.angular_max, "rad/s"},
                        {"gain", parameters.gain, "1/s"},
                        {"distance", parameters.distance, "m"},
                        {"angle", parameters.angle, "rad"}});
}

std::vector<expression::ExpressionPtr> with_speed(std::vector<expression::ExpressionPtr> formulas,
                                                  const TrackingParameters& parameters) {
  if (parameters.speed) formulas.push_back(parameters.speed->node());
  return formulas;
}

void add_with_speed(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                    const TrackingParameters& parameters, const std::function<void(const std::string& id)>& limited) {
  const auto speed = speed_on(actuator, parameters.speed);
  limited(speed ? "limited" : "wanted");
  if (!speed) return;
  add_linked(fragment, "wanted", "ScaleTwist", {{"twist", "limited.value"}});
  fragment.feed(speed->node(), "wanted.factor");
}

void add_tracking(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                  const TrackingParameters& parameters, const std::string& target_twist) {
  fragment.add("gain", "ConstantReal", {{"value", parameters.gain}});
  add_linked(fragment, "correction", "ScaleTwist", {{"twist", "difference.value"}, {"factor", "gain.value"}});
  const nlohmann::ordered_json bounds{{"linear_max", parameters.linear_max}, {"angular_max", parameters.angular_max}};
  add_with_speed(fragment, actuator, parameters, [&](const std::string& id) {
    if (target_twist.empty()) {
      add_linked(fragment, id, "LimitTwist", {{"input", "correction.value"}}, bounds);
    } else {
      add_linked(fragment, id, "CorrectTwist", {{"base", target_twist}, {"correction", "correction.value"}}, bounds);
    }
  });
}

}  // namespace takt::command
