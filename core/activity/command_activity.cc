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
    PlannedActivity prepared;
    prepared.command = make_(planning);
    command::Places places;
    for (const auto& [device, before] : planning.predecessors)
      if (before.at_end.q) places[device] = *before.at_end.q;
    command::Places ends;
    const Diagnostics unplanned = command::plan(*prepared.command, places, &ends);
    Diagnostics wrong = command::check(*prepared.command, false);
    command::add_news(unplanned, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    for (const std::string& actuator : actuators_) {
      EndState& end_state = prepared.end_states[actuator];
      if (const auto end = ends.find(actuator); end != ends.end())
        end_state.after = ActuatorState::at_rest(end->second);
      const auto before = planning.predecessors.find(actuator);
      if (before == planning.predecessors.end() || !before->second.at_end.q) continue;
      const ActuatorState& state = before->second.at_end;
      if (arms_ == ArmAfter::kStays) end_state.after = state;
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
