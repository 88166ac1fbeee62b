#include "core/activity/command_activity.h"

#include <algorithm>
#include <utility>

#include "core/command/actions/motion_action.h"
#include "core/command/check.h"
#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

class CommandActivity final : public ActivityModel {
 public:
  CommandActivity(std::string name, std::vector<std::string> actuators, CommandMaker make, ArmAfter arms)
      : ActivityModel(std::move(name)), actuators_(std::move(actuators)), make_(std::move(make)), arms_(arms) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return actuators_; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const command::Command command = make_(planning);
    command::Places places = places_before(planning);
    command::TreeEnd end;
    const Diagnostics unplanned = command::plan(command, places, &end);
    Diagnostics wrong = command::check(command, false);
    command::add_news(unplanned, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    PlannedActivity prepared = planned_activity(command, actuators_, end);
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

command::Places places_before(const PlanningContext& planning) {
  command::Places places;
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
