#include "core/activity/mode_change.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <fmt/format.h>

#include "core/activity/context.h"
#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

using device::ControlMode;

/// What the commands of an activity need of one arm.
struct Needs {
  std::set<ControlMode> modes;
  bool any = false;  ///< one of them takes it as it is
};

bool takes(const command::ActuatorModel& actuator, ControlMode mode) {
  const auto modes = actuator.modes();
  return std::ranges::find(modes, mode) != modes.end();
}

std::map<std::string, Needs, std::less<>> needs_of(const command::Command& command) {
  std::map<std::string, Needs, std::less<>> needs;
  const command::CommandTree tree(command);
  for (int i = 0; i < tree.size(); ++i) {
    const command::CommandNode& node = *tree.at(i).node;
    if (!node.is_runtime()) continue;
    const command::ActuatorModel& actuator = node.actuator->model();
    const auto mode = node.model().mode();
    if (mode && !takes(actuator, *mode)) continue;  // rule C8 reports it
    for (const std::string& device : actuator.devices()) {
      Needs& own = needs[device];
      const bool compliant = std::ranges::any_of(
          actuator.compliant_arms(), [&](const expression::MountedArm* arm) { return arm->device->name() == device; });
      if (mode && compliant) {
        own.modes.insert(*mode);
      } else {
        own.any = true;
      }
    }
  }
  return needs;
}

/// START changes a mode seamlessly or waits for standstill; what is possible only outside of nets has to be requested.
void check_start(const device::Arm& arm, ControlMode is, ControlMode needed, Diagnostics& diagnostics) {
  const device::ControlModes& modes = arm.description().modes;
  const device::ModeChange* change = modes.find(is, needed);
  if (is == needed || !modes.has(needed) || (change != nullptr && change->change != device::ChangeClass::kOutsideNet))
    return;
  if (change == nullptr) return diagnostics.append(check_mode_change(arm, is, needed));
  diagnostics.error(Code::kNotPossibleNow, "",
                    fmt::format("'{}' will be in mode {}, and this needs {}; it goes there only while nothing holds it",
                                arm.name(), name_of(is), name_of(needed)),
                    fmt::format("Change into that mode before: with the step \"control_mode\", or "
                                "use<ControlModeInterface>().switch_to(\"{}\")",
                                name_of(needed)));
}

/// In which mode the commands leave an arm.
std::optional<ControlMode> mode_after(const Needs& needs, std::optional<ControlMode> begin) {
  if (needs.modes.empty()) return begin;
  const ControlMode last = *needs.modes.begin();
  const bool known = needs.modes.size() == 1 && (!needs.any || begin == last);
  return known ? std::optional(last) : std::nullopt;
}

/// No net: only the control mode changes.
class SwitchMode final : public ActivityModel {
 public:
  SwitchMode(const std::string& arm, device::ControlMode mode)
      : ActivityModel(fmt::format("{} {}", arm, name_of(mode))), arm_(arm), mode_(mode) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {arm_}; }
  [[nodiscard]] bool begins_alone() const override { return true; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const expression::MountedArm& arm = planning.cell.arms.find(arm_)->second;
    Diagnostics diagnostics = check_mode_change(*arm.device, arm.mode(), mode_);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    PlannedActivity prepared;
    prepared.modes[arm_] = mode_;
    EndState& end_state = prepared.end_states[arm_];
    // Position begins where the arm is measured to be; the springs keep the set point.
    const bool stays = mode_ != device::ControlMode::kPosition || arm.mode() == mode_;
    if (stays) end_state.after = planning.predecessors.find(arm_)->second.at_end;
    end_state.after.mode = name_of(mode_);
    return prepared;
  }

 private:
  std::string arm_;
  device::ControlMode mode_;
};

}  // namespace

ModeChange::ModeChange(rcc::ControlCore& core, const ControlModes& modes) {
  for (const auto& [name, mode] : modes) {
    const device::Arm* arm = core.find_arm(name);
    if (arm != nullptr) before_[name] = arm->mode();
    if (arm != nullptr && arm->mode() == mode) continue;
    const rcc::RequestId request = core.change_mode(name, mode);
    if (request != 0) {
      open_.push_back({request, arm});
    } else {
      diagnostics_.error(Code::kNotPossibleNow, "/mode",
                         fmt::format("'{}' cannot be asked for mode {} now", name, name_of(mode)),
                         "Name an arm that the core drives, with fewer than 512 requests in one cycle");
    }
  }
}

bool ModeChange::poll(std::span<const rcc::Event> events) {
  for (const rcc::Event& event : events) {
    const auto answered = std::ranges::find(open_, event.request, &Open::request);
    if (answered == open_.end() || event.kind == rcc::Event::Kind::kState) continue;
    if (event.kind == rcc::Event::Kind::kRefused)
      diagnostics_.error(Code::kNotPossibleNow, "/mode",
                         fmt::format("the mode was not changed: {}; '{}' is in mode {}", event.cause.text.view(),
                                     answered->arm->name(), name_of(answered->arm->mode())),
                         "Let the arm come to rest, release it, and acknowledge its fault");
    open_.erase(answered);
  }
  return open_.empty();
}

ActivityPtr mode_activity(const std::string& arm, device::ControlMode mode) {
  return std::make_shared<const SwitchMode>(arm, mode);
}

Diagnostics check_mode_change(const device::Arm& arm, ControlMode from, ControlMode to) {
  Diagnostics diagnostics;
  const device::ControlModes& modes = arm.description().modes;
  if (!modes.has(to)) {
    diagnostics.error(Code::kUnknownName, "/mode", fmt::format("'{}' has no mode '{}'", arm.name(), name_of(to)),
                      modes.list());
  } else if (from != to && modes.find(from, to) == nullptr) {
    std::string ways;
    for (const device::ModeChange& change : modes.changes)
      if (change.from == from) ways += fmt::format("{}{}", ways.empty() ? "" : ", ", name_of(change.to));
    diagnostics.error(Code::kUnsupported, "/mode",
                      fmt::format("'{}' cannot go from {} to {}", arm.name(), name_of(from), name_of(to)),
                      ways.empty() ? std::string("no other mode") : fmt::format("Change from there to {}", ways));
  }
  return diagnostics;
}

Diagnostics check_needed_mode(const device::Arm& arm, std::optional<ControlMode> is, ControlMode needed) {
  if (!arm.description().modes.has(needed)) return check_mode_change(arm, needed, needed);
  Diagnostics refused;
  if (is) check_start(arm, *is, needed, refused);
  return refused;
}

Diagnostics agree_on_modes(PlannedActivity& prepared, const PlanningContext& planning) {
  Diagnostics diagnostics;
  const auto needs = prepared.command ? needs_of(*prepared.command) : std::map<std::string, Needs, std::less<>>();
  for (auto& [name, end_state] : prepared.end_states) {
    const auto arm = planning.cell.arms.find(name);
    const auto before = planning.predecessors.find(name);
    if (arm == planning.cell.arms.end() || before == planning.predecessors.end()) continue;
    const auto given = before->second.at_end.mode ? device::control_mode_of(*before->second.at_end.mode) : std::nullopt;
    const auto entered = prepared.modes.find(name);
    const auto begin = entered != prepared.modes.end() ? std::optional(entered->second) : given;
    const auto own = needs.find(name);
    if (begin && own != needs.end()) {
      Diagnostics refused;
      for (const ControlMode needed : own->second.modes) check_start(*arm->second.device, *begin, needed, refused);
      diagnostics.append(refused, "/compliance");
    }
    if (end_state.after.mode) continue;
    const auto after = prepared.returns ? given : own != needs.end() ? mode_after(own->second, begin) : begin;
    if (after) end_state.after.mode = name_of(*after);
  }
  return diagnostics;
}

}  // namespace takt::activity
