#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/expectation_kinds.h"
#include "cell/judge/limit_monitor.h"
#include "core/net/description.h"
#include "core/net/registry.h"

namespace takt::cell {
namespace {

class LimitsExpectation final : public Expectation {
 public:
  explicit LimitsExpectation(ExpectationReader& from) : arm_(from.arm()) {
    const BuiltCell& built = from.built;
    const auto found = built.cell.arms.find(arm_);
    if (found == built.cell.arms.end()) return;
    const device::ArmDescription& description = found->second.device->description();
    monitor_.emplace(description.limits, description.joint_names, to_seconds(built.core->period()), description.effort);
  }

  void watch(const BuiltCell& built) override {
    monitor_->watch(*built.cell.arms.find(arm_)->second.device);
    if (const sim::SimArm* machine = built.world->arm(arm_)) monitor_->add_torque(machine->wanted_torque());
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    const LimitMonitor::Worst worst = monitor_->worst();
    ExpectationResult result;
    result.value = worst.share;
    result.passed = monitor_->held();
    result.upper = 1.0;
    result.measured = fmt::format("{:.1f} % of a limit at most: {}", 100 * worst.share, worst.what);
    return result;
  }

 private:
  std::string arm_;
  std::optional<LimitMonitor> monitor_;
};

/// Ids of the monitors of a net, those inside fragments with their path.
std::vector<std::string> monitors_of(const net::NetDescription& net, const std::string& path = {}) {
  std::vector<std::string> ids;
  for (const auto& primitive : net.primitives) {
    const net::PrimitiveInfo* info = net::Registry::global().find(primitive.type);
    if (info != nullptr && info->monitor) ids.push_back(path + primitive.id);
  }
  for (const auto& fragment : net.fragments)
    std::ranges::copy(monitors_of(fragment.net, path + fragment.id + "/"), std::back_inserter(ids));
  return ids;
}

class MonitorExpectation final : public Expectation {
 public:
  explicit MonitorExpectation(ExpectationReader& reader)
      : net_(reader.name("net", keys_of(reader.built.cell.nets))), monitor_(reader.text("monitor")) {
    if (const auto* is = reader.object().child("is")) is_ = *is;
    at_least_ = reader.number("at_least", at_least_);
    at_most_ = reader.number("at_most", at_most_);
    const auto& nets = reader.built.cell.nets;
    const auto net = nets.find(net_);
    if (net != nets.end()) check_monitor(*net->second, reader);
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const auto net = outcome.variables.monitors.find(net_);
    if (net == outcome.variables.monitors.end()) return {.measured = fmt::format("net '{}' did not run", net_)};
    const auto shown = net->second.find(monitor_);
    if (shown == net->second.end()) return {.measured = fmt::format("'{}' of '{}' showed nothing", monitor_, net_)};
    const std::string& text = shown->second;
    const auto value = nlohmann::ordered_json::parse(text);
    ExpectationResult result;
    result.measured = fmt::format("'{}' of '{}' ended as {}", monitor_, net_, text);
    if (value.is_number()) result.value = value.get<double>();
    if (std::isfinite(at_least_)) result.lower = at_least_;
    if (std::isfinite(at_most_)) result.upper = at_most_;
    result.passed = is_ ? value == *is_ : value.is_number() && result.value >= at_least_ && result.value <= at_most_;
    return result;
  }

 private:
  void check_monitor(const net::NetDescription& net, FormReader& reader) const {
    std::vector<std::string> ids = monitors_of(net);
    if (std::ranges::find(ids, monitor_) != ids.end()) return;
    reader.diagnostics().error(Code::kUnknownName, reader.at("monitor"),
                               fmt::format("net '{}' has no monitor '{}'", net_, monitor_),
                               nearest_choice(monitor_, ids));
  }

  std::string net_, monitor_;
  std::optional<nlohmann::ordered_json> is_;
  double at_least_ = -std::numeric_limits<double>::infinity(), at_most_ = std::numeric_limits<double>::infinity();
};

class DurationExpectation final : public Expectation {
 public:
  explicit DurationExpectation(ExpectationReader& from) : below_s_(from.number("below_s")), during_(from.during()) {}

  void steps_run(std::span<const std::string> paths) override { during_.look(paths); }
  void watch(const BuiltCell&) override { cycles_ += during_.inside() ? 1 : 0; }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const bool always = during_.name().empty();
    if (!always && cycles_ == 0) return {.measured = fmt::format("'{}' did not run", during_.name())};
    ExpectationResult result;
    result.value = always ? outcome.sim_time : to_seconds(cycles_ * outcome.built.core->period());
    result.passed = result.value < below_s_;
    result.unit = "s";
    result.upper = below_s_;
    result.measured = fmt::format("{:.3f} s{} (below {:g})", result.value,
                                  always ? "" : fmt::format(" in '{}'", during_.name()), below_s_);
    return result;
  }

 private:
  double below_s_;
  StepWindow during_;
  std::int64_t cycles_ = 0;  ///< in which it ran
};

class StepExpectation final : public Expectation {
 public:
  explicit StepExpectation(ExpectationReader& from) : step_(from.step("step")) {}
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result;
    result.value = static_cast<double>(std::ranges::count(outcome.steps_begun, step_));
    result.passed = result.value > 0;
    result.measured = fmt::format("step '{}' ran {:g} times", step_, result.value);
    return result;
  }

 private:
  std::string step_;
};

class RepeatsExpectation final : public Expectation {
 public:
  explicit RepeatsExpectation(ExpectationReader&) {}
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    if (!outcome.run_again) return {.judged = false, .measured = "not run a second time"};
    const std::string second = outcome.run_again();
    ExpectationResult result;
    result.passed = second == outcome.digest;
    result.measured = result.passed ? "a second run has the same digest"
                                    : fmt::format("a second run has digest {}, this one {}", second, outcome.digest);
    return result;
  }
};

}  // namespace

ExpectationKind limits_expectation() {
  return expectation_kind<LimitsExpectation>(
      "limits", {"No set point that was sent exceeded the joint limits (position, velocity, acceleration, jerk, by "
                 "differences), and no motor was commanded more torque than it has.",
                 {arm_key()}});
}

ExpectationKind monitor_expectation() {
  return expectation_kind<MonitorExpectation>(
      "monitor", {"The last value of a monitor of a net; one of 'at_least', 'at_most' and 'is' is required.",
                  {text_key("net", "One of 'nets'."), text_key("monitor", "Id of the monitor."),
                   number_key("at_least", "", kAnyNumber, "Lower bound.").optional(),
                   number_key("at_most", "", kAnyNumber, "Upper bound.").optional(),
                   any_key("is", "", "Exactly this value; may be null.").optional()},
                  {at_least_one({"at_least", "at_most", "is"})}});
}

ExpectationKind duration_expectation() {
  return expectation_kind<DurationExpectation>("duration",
                                               {"The run, or what runs in it, takes less simulated time.",
                                                {number_key("below_s", "s", kPositive, "Upper bound."), during_key()}});
}

ExpectationKind step_expectation() {
  return expectation_kind<StepExpectation>(
      "step", {"A step of this name was started.", {text_key("step", "Name of the step.")}});
}

ExpectationKind repeats_expectation() {
  return expectation_kind<RepeatsExpectation>("repeats",
                                              {"A second run gives the same digest; takes as long as the first run."});
}

}  // namespace takt::cell
