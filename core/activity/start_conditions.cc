#include "core/activity/start_conditions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/command/command_tree.h"
#include "core/motion/path_clock.h"

namespace takt::activity {
namespace {

using rcc::NetState;

/// Path time that a clock needs at most until its rate is steady: half the time from rest to full rate.
double time_to_steady(const motion::Motion& motion) {
  constexpr double kShare = 0.6;
  return kShare * motion::PathClock(motion.clock, motion.duration(), false).stop_time_bound();
}

/// The motion is where its plan says that it is in a whole cycle.
bool is_as_planned(double time, double rate, double period) {
  constexpr double kRounding = 1e-6;  // of a cycle
  const double cycles = time / period;
  return rate == 1.0 && std::abs(cycles - std::round(cycles)) < kRounding;
}

}  // namespace

bool is_busy(const device::Arm& arm) {
  return arm.phase() == device::Arm::Phase::kBraking || arm.phase() == device::Arm::Phase::kChanging;
}

bool has_fault(const device::Arm& arm) {
  const bool was_ready = arm.set_point().q.size() > 0;
  return arm.lost() && (was_ready || (arm.has_sample() && arm.sample().fault != 0));
}

RunsBefore StartConditions::runs_before(const ActivityRun& run, std::span<const std::shared_ptr<ActivityRun>> runs) {
  RunsBefore before;
  for (const auto& other : runs) {
    if (other.get() == &run) break;
    if (other->over() || other->carrier_ != nullptr || !other->shares_actuator(run)) continue;
    if (other->state() != RunState::kRunning) {
      before.wait = true;
      continue;
    }
    before.running.push_back(other.get());
    // Who changes control modes begins when all before have ended; no net shows its own end.
    before.wait = before.wait || run.model_->begins_alone() || other->model_->begins_alone();
  }
  return before;
}

std::string StartConditions::fault_of(const ActivityRun& run) const {
  for (const std::string& actuator : run.model_->actuators()) {
    const auto arm = cell_.arms.find(actuator);
    if (arm != cell_.arms.end() && has_fault(*arm->second.device))
      return fmt::format("{} ({})", arm->second.device->fault().view(), arm->second.device->fault_text());
  }
  return {};
}

std::optional<PlanningContext> StartConditions::planning_context(const ActivityRun& run,
                                                                 const RunsBefore& before) const {
  PlanningContext planning{.cell = cell_,
                           .period = core_.period(),
                           .predecessors = {},
                           .checks_collisions = options_.checks_collisions || run.alone_};
  bool wait = false, all_leave = true;
  const auto own = run.model_->actuators();
  for (const std::string& actuator : own) {
    auto one = predecessor(actuator, before, wait);
    if (wait || !one) return std::nullopt;
    // Where a predecessor leaves it is not known yet: that one has to end first.
    if (cell_.arms.contains(actuator) && !one->at_end.rests()) return std::nullopt;
    planning.predecessors[actuator] = std::move(*one);
  }
  for (const ActivityRun* other : before.running) {
    for (const std::string& actuator : other->model_->actuators()) {
      const auto end_state = other->planned_.end_states.find(actuator);
      if (end_state != other->planned_.end_states.end() && end_state->second.released) continue;
      const auto found = planning.predecessors.find(actuator);
      all_leave = all_leave && found != planning.predecessors.end() && found->second.leaving.has_value();
    }
  }
  if (!all_leave) {
    for (auto& [name, one] : planning.predecessors) one.leaving.reset();
  }
  // Where it may have failed only its end says whether the next one may begin.
  const auto can_fail = [](const ActivityRun* other) { return other->planned_.can_fail; };
  if (!all_leave && std::ranges::any_of(before.running, can_fail)) return std::nullopt;
  // Without a seam only the end itself says that the next one may begin.
  const bool only_arms = std::ranges::all_of(own, [this](const auto& name) { return cell_.arms.contains(name); });
  if (!before.running.empty() && !only_arms) return std::nullopt;
  return planning;
}

std::vector<ConcurrentMotion> StartConditions::motions_beside(
    const ActivityRun& run, std::span<const std::shared_ptr<ActivityRun>> runs) const {
  std::vector<ConcurrentMotion> beside;
  if (!options_.checks_collisions) return beside;
  for (const auto& other : runs) {
    const bool is_planned = other->state() == RunState::kLoaded || other->state() == RunState::kRunning;
    if (other.get() == &run || other->carrier_ != nullptr || !is_planned || !other->planned_.command ||
        other->shares_actuator(run))
      continue;
    const command::CommandTree tree(*other->planned_.command);
    for (const command::CommandTree::Entry& entry : tree.entries()) {
      const command::PlannedMotion* motion = entry.node->is_runtime() ? entry.node->model().planned_motion() : nullptr;
      if (motion == nullptr) continue;
      beside.push_back({.name = other->name(),
                        .motion = *motion,
                        .actuator = *entry.node->actuator,
                        .begin = begin_of(*other, entry.node->subject, tree.size() == 1),
                        .touching = other->planned_.touching});
    }
  }
  return beside;
}

std::optional<double> StartConditions::begin_of(const ActivityRun& run, const expression::SubjectPtr& command,
                                                bool alone) const {
  const ActivityRun::Clock* clock = run.clock_of(command);
  if (run.state() == RunState::kRunning && clock != nullptr && clock->runs())
    return clock->is_steady() && clock->rate->value == 1.0 ? std::optional(-clock->time->value) : std::nullopt;
  // One that waits for what still runs on its arms begins when that ends.
  const auto own = run.model_->actuators();
  const bool waits = std::ranges::any_of(own, [this](const std::string& name) {
    const auto arm = cell_.arms.find(name);
    return arm != cell_.arms.end() && arm->second.device->held();
  });
  if (run.state() != RunState::kLoaded || !alone || waits) return std::nullopt;
  return static_cast<double>(std::max<std::int64_t>(0, run.due_cycle_ - core_.cycle())) * to_seconds(core_.period());
}

std::optional<Predecessor> StartConditions::predecessor(const std::string& actuator, const RunsBefore& before,
                                                        bool& wait) const {
  for (const ActivityRun* run : before.running) {
    const auto end_state = run->planned_.end_states.find(actuator);
    if (end_state == run->planned_.end_states.end()) continue;
    Predecessor predecessor{.at_end = end_state->second.after, .leaving = leaving(*run, end_state->second)};
    // It may be left, but has not come to the motion that may.
    wait = wait || (!end_state->second.last.empty() && !predecessor.leaving);
    return predecessor;
  }
  const auto arm = cell_.arms.find(actuator);
  return arm == cell_.arms.end() ? Predecessor{} : at_rest(*arm->second.device);
}

/// Nothing: no sample yet, or it moves.
std::optional<Predecessor> StartConditions::at_rest(const device::Arm& arm) const {
  if (arm.set_point().q.size() == 0 || !arm.at_rest() || is_busy(arm)) return std::nullopt;
  Predecessor predecessor{.at_end = ActuatorState::at_rest(arm.set_point().q), .leaving = std::nullopt};
  predecessor.at_end.mode = name_of(arm.mode());
  return predecessor;
}

std::optional<Predecessor::BlendOut> StartConditions::leaving(const ActivityRun& run, const EndState& end_state) const {
  const double period = to_seconds(core_.period());
  if (run.carries()) return std::nullopt;  // its own motion has not come yet
  for (const auto& [command, motion] : end_state.last) {
    const ActivityRun::Clock* clock = run.clock_of(command);
    if (clock == nullptr || !clock->runs()) continue;
    const double time = clock->time->value;
    double soonest = time / period + static_cast<double>(options_.latency_cycles + options_.margin_cycles);
    if (!clock->is_steady()) soonest += time_to_steady(*motion.motion) / period;
    return Predecessor::BlendOut{.motion = motion,
                                 .tau = std::ceil(soonest) * period,
                                 .lead = static_cast<double>(options_.lead_cycles) * period,
                                 .exact = clock->is_steady() && is_as_planned(time, clock->rate->value, period)};
  }
  return std::nullopt;
}

std::optional<rcc::Rule> StartConditions::rule_for(const ActivityRun& run, const RunsBefore& before,
                                                   const PlanningContext& planning) {
  rcc::Rule rule;
  rule.action.start = {run.net_};
  if (before.running.empty()) return rule;
  rule.otherwise.start = {run.net_};
  bool fits = true;
  const auto add = [&](const rcc::Term& term) { fits = rule.condition.add(term) && fits; };
  for (const ActivityRun* other : before.running) {
    if (run.planned_.taken_over.empty()) {
      add(rcc::Term::state(other->net_, {NetState::kTerminated}));
      continue;
    }
    fits = rule.action.end.add(other->net_) && fits;
    for (const auto& [actuator, end_state] : other->planned_.end_states) {
      if (end_state.released) continue;
      const auto& leaving = planning.predecessors.find(actuator)->second.leaving;
      for (const auto& [command, motion] : end_state.last) {
        const ActivityRun::Clock* clock = other->clock_of(command);
        if (!leaving || motion.motion != leaving->motion.motion || clock == nullptr) continue;
        constexpr double kRounding = 1e-7;  // s
        add(rcc::Term::in_range(other->net_, clock->time, leaving->tau - kRounding,
                                leaving->tau + leaving->lead + kRounding));
        add(rcc::Term::in_range(other->net_, clock->rate_derivative, 0.0, 0.0));
      }
    }
  }
  return fits ? std::optional(rule) : std::nullopt;
}

}  // namespace takt::activity
