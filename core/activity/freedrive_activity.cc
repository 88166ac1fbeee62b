#include "core/activity/freedrive_activity.h"

#include <utility>

#include "core/activity/dual_entry_motion.h"
#include "core/activity/motion_activity.h"
#include "core/expression/device_sensors.h"

namespace takt::activity {
namespace {

using command::State;

/// Never null: nobody knows whether it is paused means that it is.
State not_paused(const command::Cell& cell, const std::string& channel) {
  const auto speed = command::channel<net::Real>(cell, channel);
  return !is_null(speed) && is_greater(speed, 0.0);
}

class FreedriveActivity final : public ActivityModel {
 public:
  FreedriveActivity(std::string arm, command::GuidanceParameters wish, FreedriveEnd end, command::Biases biases,
                    ControlModes modes)
      : ActivityModel(arm + " freedrive"),
        arm_(std::move(arm)),
        wish_(std::move(wish)),
        end_(std::move(end)),
        biases_(std::move(biases)),
        modes_(std::move(modes)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {arm_}; }
  [[nodiscard]] bool begins_alone() const override { return !modes_.empty(); }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity prepared;
    prepared.command = freedrive_command(planning.cell, arm_, wish_, end_, biases_);
    prepared.modes = modes_;
    prepared.returns = !modes_.empty();
    prepared.touching = {arm_};
    prepared.end_states[arm_] = {};  // nobody knows where the hand leads it
    const ActuatorState& before = planning.predecessors.find(arm_)->second.at_end;
    // Where a change of the mode takes the set point to shows only then.
    if (modes_.empty() && before.q) prepared.begins[arm_].push_back(seam_at_rest(*before.q));
    return prepared;
  }

 private:
  std::string arm_;
  command::GuidanceParameters wish_;
  FreedriveEnd end_;
  command::Biases biases_;
  ControlModes modes_;
};

}  // namespace

command::RuntimeCommand freedrive_command(const command::Cell& cell, const std::string& arm,
                                          const command::GuidanceParameters& wish, const FreedriveEnd& end,
                                          const command::Biases& biases) {
  command::GuidanceParameters own = wish;
  for (const std::string& channel : {cell.override_channel, speed_channel(arm)}) {
    if (!cell.channels.contains(channel)) continue;
    const State going = not_paused(cell, channel);
    own.enabled = own.enabled ? *own.enabled && going : going;
  }
  command::RuntimeCommand guided("freedrive", command::arm(cell, arm), command::freedrive(cell, arm, own, biases));
  if (end.until) guided.on_entered(*end.until, cancel(guided));
  if (end.seconds) guided.on_entered(guided.started().held_for(*end.seconds), cancel(guided));
  return guided;
}

ControlModes freedrive_modes(const command::Cell& cell, const std::string& arm) {
  if (command::freedrive_kind(cell, arm) != command::FreedriveKind::kSprings) return {};
  return {{arm, device::ControlMode::kJointImpedance}};
}

ActivityPtr freedrive_activity(const command::Cell& cell, const std::string& arm,
                               const command::GuidanceParameters& wish, const FreedriveEnd& end,
                               const command::Biases& biases) {
  return std::make_shared<const FreedriveActivity>(arm, wish, end, biases, freedrive_modes(cell, arm));
}

}  // namespace takt::activity
