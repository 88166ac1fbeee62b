// Expectation "fan_speed": at the end a fan turns with the speed that is told.
#include <fmt/format.h>

#include "cell/judge/expectation_kind.h"
#include "sim_fan.h"

namespace fan {
namespace {

using namespace takt;

class FanSpeed final : public cell::Expectation {
 public:
  explicit FanSpeed(cell::ExpectationReader& from)
      : at_least_(from.number("at_least_rad_s")), at_most_(from.number("at_most_rad_s")) {
    const std::string name = from.text("fan");
    fan_ = dynamic_cast<SimFan*>(from.built.world->device(name));
    if (!name.empty() && fan_ == nullptr)
      from.diagnostics().error(Code::kUnknownName, from.at("fan"), fmt::format("there is no fan '{}'", name),
                               "Name a device of kind \"fan\"");
  }
  cell::ExpectationResult judge(const cell::Outcome&) const override {
    cell::ExpectationResult result;
    result.value = fan_->read().value_or(0.0);
    result.passed = result.value >= at_least_ && result.value <= at_most_;
    result.unit = "rad/s";
    result.lower = at_least_;
    result.upper = at_most_;
    result.measured = fmt::format("{:.1f} rad/s ({:g} to {:g})", result.value, at_least_, at_most_);
    return result;
  }

 private:
  SimFan* fan_ = nullptr;
  double at_least_, at_most_;  // rad/s
};

cell::ExpectationKind fan_speed() {
  return cell::expectation_kind<FanSpeed>(
      "fan_speed", {"At the end a fan turns with this speed.",
                    {text_key("fan", "Which fan.", 1),
                     number_key("at_least_rad_s", "rad/s", kNotNegative, "Lower bound.").by_default(0.0),
                     number_key("at_most_rad_s", "rad/s", kPositive, "Upper bound.")}});
}

TAKT_EXPECTATION(fan_speed);

}  // namespace
}  // namespace fan
