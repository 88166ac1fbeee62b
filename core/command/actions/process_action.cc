#include "core/command/actions/process_action.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/motion/motion_state.h"
#include "core/motion/path_clock.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kProcessStates[] = {"process", "not_started", "lost"};

class MotionWithProcess final : public ActionModel {
 public:
  MotionWithProcess(std::shared_ptr<const ActionModel> motion, expression::ExpressionPtr running,
                    const ProcessParameters& parameters)
      : motion_(std::move(motion)), running_(std::move(running)), parameters_(parameters) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::optional<device::ControlMode> mode() const override { return motion_->mode(); }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas = motion_->formulas();
    formulas.push_back(running_);
    return formulas;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states = motion_->states();
    states.insert(states.end(), std::begin(kProcessStates), std::end(kProcessStates));
    return states;
  }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    const bool own = std::ranges::find(kProcessStates, name) != std::end(kProcessStates);
    return own ? "process." + name : motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] std::vector<device::Seam> ends() const override { return motion_->ends(); }
  /// Braking from a rate of 1 or -1, and the finishing time.
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override {
    return 2.0 * motion_->stop_time(actuator) + parameters_.finish_time + kCycles;
  }
  [[nodiscard]] bool net_knows_stop_time() const override { return false; }
  [[nodiscard]] PlannedPath planned_path() const override { return motion_->planned_path(); }
  [[nodiscard]] const PlannedMotion* planned_motion() const override { return motion_->planned_motion(); }
  [[nodiscard]] double duration() const override { return motion_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return motion_->needs_plan(); }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q) const override {
    auto planned = motion_->plan(actuator, q);
    if (!planned) return planned;
    return std::make_shared<const MotionWithProcess>(std::move(*planned), running_, parameters_);
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics = motion_->check(actuator);
    if (!motion_->needs_plan() && motion_->planned_path().motion == nullptr)
      diagnostics.error(Code::kConflict, {}, fmt::format("C8: {} has no path that a process could go with", name()),
                        "Use a planned motion of one arm");
    const auto check_range = [&](const char* key, double value, double high) {
      if (value >= 0.0 && value <= high) return;
      diagnostics.error(Code::kOutOfRange, std::string("/") + key, fmt::format("unexpected value {:g}", value),
                        fmt::format("Choose 0 to {:g}", high));
    };
    check_range("start_timeout", parameters_.start_timeout, kLongest);
    check_range("finish_time", parameters_.finish_time, kLongest);
    check_range("overlap", parameters_.overlap, kLongest);
    check_range("restarts", parameters_.restarts, kMostRestarts);
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    const std::string& clock = contribution.path_clock;
    fragment.add("process", "ProcessOnPath",
                 {{"start_timeout", parameters_.start_timeout},
                  {"finish_time", parameters_.finish_time},
                  {"overlap", parameters_.overlap},
                  {"restarts", parameters_.restarts}});
    fragment.feed(running_, "process.running");
    fragment.feed(fragment.cancel(), "process.cancel");
    fragment.link(fragment.take_link(clock + ".target_rate"), "process.speed");
    fragment.link("process.rate", clock + ".target_rate");
    fragment.set_parameter(clock, "retraceable", true);
    fragment.link_delayed(clock + ".time", "process.time", 0.0);
    fragment.link_delayed(clock + ".at_end", "process.at_end", false);
    fragment.link_delayed(clock + ".standstill", "process.standstill", true);
    contribution.done = expression::Signal::at("process.done");
    return contribution;
  }

 private:
  static constexpr double kCycles = 0.01;     ///< s, for links that are delayed
  static constexpr double kLongest = 3600.0;  ///< s
  static constexpr double kMostRestarts = 1000.0;

  std::shared_ptr<const ActionModel> motion_;
  expression::ExpressionPtr running_;
  ProcessParameters parameters_;
};

class FollowState final : public ActionModel {
 public:
  explicit FollowState(expression::ExpressionPtr state) : state_(std::move(state)) {}
  [[nodiscard]] std::string_view name() const override { return "follow state"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kBoolean; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return {state_}; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment, const ActuatorModel&) const override {
    fragment.add("wanted", "DefaultToBoolean", {{"fallback", false}});
    fragment.feed(state_, "wanted.input");
    fragment.add("done", "Or", {{"a", false}});
    fragment.feed(fragment.cancel(), "done.b");
    return {.set_point = {.kind = SetPointKind::kBoolean, .ports = {{"value", "wanted.value"}}, .constants = {}},
            .done = expression::Signal::at("done.value")};
  }

 private:
  expression::ExpressionPtr state_;
};

}  // namespace

Action while_process(const Action& motion, const expression::State& running, const ProcessParameters& parameters) {
  return Action(std::make_shared<const MotionWithProcess>(motion.shared_model(), running.node(), parameters));
}

Action follow_state(const expression::State& state) {
  return Action(std::make_shared<const FollowState>(state.node()));
}

}  // namespace takt::command
