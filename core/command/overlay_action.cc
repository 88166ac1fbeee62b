#include "core/command/overlay_action.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/description.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// What plans leave of the acceleration and of the jerk (docs/motion.md).
constexpr double kAccelerationLeft = 0.2, kJerkLeft = 0.3;

class Woven final : public ActionModel {
 public:
  Woven(std::shared_ptr<const ActionModel> motion, const WeaveWish& wish) : motion_(std::move(motion)), wish_(wish) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::vector<ExpressionPtr> formulas() const override { return motion_->formulas(); }
  [[nodiscard]] std::vector<std::string> states() const override { return motion_->states(); }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::string add_state(FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    return motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::optional<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] std::optional<device::Seam> ends() const override { return motion_->ends(); }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return motion_->stop_time(actuator); }
  [[nodiscard]] bool needs_plan() const override { return motion_->needs_plan(); }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const kinematics::JointVector& q) const override {
    auto planned = motion_->plan(actuator, q);
    if (!planned) return planned;
    return std::make_shared<const Woven>(std::move(*planned), wish_);
  }

  [[nodiscard]] Findings check(const ActuatorModel& actuator) const override {
    Findings findings = motion_->check(actuator);
    if (motion_->gives(actuator) != SetPointKind::kPose) {
      findings.error({}, fmt::format("C8: {} moves joints, so there is nothing to weave beside", name()),
                     "a motion of a frame");
      return findings;
    }
    if (!check_figures(findings)) return findings;
    const auto& limits = actuator.arm()->device->description().cartesian;
    const double omega = 2.0 * std::numbers::pi * wish_.frequency;
    check_share(findings, "acceleration", wish_.amplitude * omega * omega,
                kAccelerationLeft * limits.linear_acceleration, "m/s^2");
    check_share(findings, "jerk", wish_.amplitude * omega * omega * omega, kJerkLeft * limits.linear_jerk, "m/s^3");
    return findings;
  }

  [[nodiscard]] Contribution add_to(FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    fragment.add("weave", "Weave",
                 {{"amplitude", wish_.amplitude},
                  {"frequency", wish_.frequency},
                  {"duration", contribution.duration},
                  {"ramp", wish_.ramp}});
    fragment.link_all(contribution.path_clock, "weave", {"time", "rate", "rate_derivative"});
    fragment.add("offset", "OffsetFrame", {{"direction", net::value_to_json(net::Vector(wish_.direction_M))}});
    for (const char* port : {"frame", "twist", "acceleration"}) {
      contribution.set_point.feed(fragment, port, std::string("offset.") + port);
      contribution.set_point.ports[port] = std::string("offset.moved_") + port;
    }
    fragment.link("weave.value", "offset.offset");
    fragment.link("weave.velocity", "offset.offset_velocity");
    fragment.link("weave.acceleration", "offset.offset_acceleration");
    return contribution;
  }

 private:
  bool check_figures(Findings& findings) const {
    const bool before = findings.has_errors();
    const auto check = [&](const char* name, double value, const char* unit) {
      if (value > 0.0 && std::isfinite(value)) return;
      findings.error(pointer_segment(name), fmt::format("{:g} {}", value, unit), "above 0 and finite");
    };
    check("amplitude", wish_.amplitude, "m");
    check("frequency", wish_.frequency, "Hz");
    check("ramp", wish_.ramp, "s");
    const double length = wish_.direction_M.norm();
    if (!(std::abs(length - 1.0) < 1e-6))
      findings.error("/direction", fmt::format("a direction of length {:g}", length), "length 1");
    return before || !findings.has_errors();
  }

  static void check_share(Findings& findings, const char* what, double value, double most, const char* unit) {
    if (value <= most) return;
    findings.error({}, fmt::format("a weave with an {} of {:.3g} {}", what, value, unit),
                   fmt::format("at most {:.3g} {}: a smaller amplitude or frequency", most, unit));
  }

  std::shared_ptr<const ActionModel> motion_;
  WeaveWish wish_;
};

}  // namespace

Action weave(const Action& motion, const WeaveWish& wish) {
  return Action(std::make_shared<const Woven>(motion.shared_model(), wish));
}

}  // namespace takt::command
