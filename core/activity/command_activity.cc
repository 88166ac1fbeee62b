#include "core/activity/command_activity.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/activity/activity_run.h"
#include "core/command/actions/motion_action.h"
#include "core/command/check.h"
#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

/// A command of a tree that may fail.
struct Fallible {
  std::string path;  ///< below the root
  std::string name;
  std::optional<double> timeout;  ///< of a wait for a state
};

std::string failed_name(const std::string& path) { return path + " has failed"; }
std::string held_name(const std::string& path) { return path + " held"; }

/// Those that fail by themselves; each shows whether it has.
std::vector<Fallible> show_failures(const command::Command& root) {
  const command::CommandTree tree(root);
  const std::string& own = tree.at(0).path;
  std::vector<Fallible> all;
  for (const command::CommandTree::Entry& entry : tree.entries()) {
    command::CommandNode& node = *entry.node;
    const std::string path = entry.path.substr(own.size());
    // A wait of no time is a question: that the state did not hold is its answer.
    const bool times_out = node.until && node.seconds.value_or(0.0) > 0.0;
    if (!times_out && !node.fails_if) continue;
    const auto state = [&node](const char* which) {
      return expression::leaf(net::ValueType::kBoolean, node.subject, which);
    };
    all.push_back({.path = path, .name = node.name, .timeout = {}});
    observe_once(node, failed_name(path), state("failed"));
    if (!times_out) continue;
    all.back().timeout = node.seconds;
    observe_once(node, held_name(path), node.until->node(), state("timed_out"));
  }
  return all;
}

Diagnostics failures_of(const RunView& run, const std::vector<Fallible>& commands) {
  Diagnostics diagnostics;
  for (const Fallible& one : commands) {
    if (!run.was_true(failed_name(one.path))) continue;
    if (one.timeout) {
      diagnostics.append(failure_of_wait(run.value<net::Boolean>(held_name(one.path)), *one.timeout), one.path);
    } else {
      diagnostics.error(Code::kConditionNotMet, one.path, fmt::format("'{}' has failed", one.name),
                        "See its fails_if(), and remove the cause");
    }
  }
  return diagnostics;
}

class CommandActivity final : public ActivityModel {
 public:
  CommandActivity(std::string name, std::vector<std::string> actuators, CommandMaker make, ArmAfter arms)
      : ActivityModel(std::move(name)), actuators_(std::move(actuators)), make_(std::move(make)), arms_(arms) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return actuators_; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const command::Command command = make_(planning);
    expression::Places places = places_before(planning);
    command::TreeEnd end;
    const Diagnostics unplanned = command::plan(command, places, &end);
    Diagnostics wrong = command::check(command, false);
    command::append_new(unplanned, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    const std::vector<Fallible> fallible = show_failures(command);
    PlannedActivity prepared = planned_activity(command, actuators_, end);
    prepared.can_fail = !fallible.empty();
    if (prepared.can_fail) prepared.verdict = [fallible](const RunView& run) { return failures_of(run, fallible); };
    prepared.touching = {actuators_.begin(), actuators_.end()};  // what it means to do only its author knows
    for (const std::string& actuator : actuators_) {
      const auto before = planning.predecessors.find(actuator);
      if (before == planning.predecessors.end() || !before->second.at_end.q) continue;
      const ActuatorState& state = before->second.at_end;
      if (arms_ == ArmAfter::kStays) prepared.end_states[actuator].after = state;
      device::Seam seam;
      seam.q = *state.q;
      seam.dq = seam.ddq = kinematics::JointVector::Zero(state.q->size());
      prepared.begins[actuator].push_back(seam);
    }
    return prepared;
  }

 private:
  std::vector<std::string> actuators_;
  CommandMaker make_;
  ArmAfter arms_;
};

}  // namespace

void observe_once(command::CommandNode& node, const std::string& name, expression::ExpressionPtr value,
                  expression::ExpressionPtr when) {
  const bool known = std::ranges::any_of(node.observations, [&](const auto& one) { return one.name == name; });
  if (!known) node.observations.push_back({name, std::move(value), std::move(when)});
}

Diagnostics failure_of_wait(const std::optional<net::Boolean>& held, double timeout) {
  Diagnostics diagnostics;
  if (!held) {
    diagnostics.error(Code::kSensorSilent, "/until", "a sensor of the condition did not answer",
                      "Check its power and its wiring");
  } else if (!*held) {
    diagnostics.error(Code::kTimeout, "/until", fmt::format("the condition did not hold within {:g} s", timeout),
                      "Increase \"timeout_s\", or put \"try\" around it");
  }
  return diagnostics;
}

PlannedActivity planned_activity(const command::Command& command, const std::vector<std::string>& actuators,
                                 const command::TreeEnd& end) {
  PlannedActivity prepared;
  prepared.command = command;
  for (const std::string& actuator : actuators) {
    EndState& end_state = prepared.end_states[actuator];
    if (const auto rest = end.rest.find(actuator); rest != end.rest.end())
      end_state.after = ActuatorState::at_rest(rest->second);
    end_state.released = end.left != nullptr;
  }
  if (end.left == nullptr) return prepared;
  const command::PlannedMotion& motion = *end.left->model().left_in_motion().motion;
  const std::string arm = end.left->actuator->model().devices().front();
  EndState& left = prepared.end_states[arm];
  left.released = false;
  // It counts only while this motion runs.
  left.after = ActuatorState::at_rest(motion.motion->q_goal);
  left.last.push_back({end.left->subject,
                       {.motion = motion.motion,
                        .X_FM = motion.X_FM,
                        .blend = motion.leaving->blend,
                        .arm = arm,
                        .abort_if = motion.leaving->abort_if}});
  prepared.motions.push_back({end.left->subject, motion.handed_over, 0.0});
  return prepared;
}

expression::Places places_before(const PlanningContext& planning) {
  expression::Places places;
  for (const auto& [device, before] : planning.predecessors)
    if (before.at_end.q) places[device] = *before.at_end.q;
  return places;
}

ActivityPtr command_activity(std::string name, std::vector<std::string> actuators, CommandMaker make, ArmAfter arms) {
  return std::make_shared<const CommandActivity>(std::move(name), std::move(actuators), std::move(make), arms);
}

ActivityPtr command_activity(const command::Command& command) {
  const command::CommandTree tree(command);
  std::vector<std::string> devices;
  for (int i = 0; i < tree.size(); ++i) {
    if (!tree.at(i).node->is_runtime()) continue;
    for (std::string& device : tree.at(i).node->actuator->model().devices())
      if (std::ranges::find(devices, device) == devices.end()) devices.push_back(std::move(device));
  }
  return command_activity(command.name(), std::move(devices), [command](const PlanningContext&) { return command; });
}

}  // namespace takt::activity
