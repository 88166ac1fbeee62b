#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/command/actions/motion_action.h"

namespace takt::activity {

/// Makes the command of an activity anew each time it is carried out.
using CommandMaker = std::function<command::Command(const PlanningContext&)>;

/// What a command does to an arm that it drives.
enum class ArmAfter : std::uint8_t {
  kStays,   ///< it is where it was
  kUnknown  ///< it is not known where it will be
};

/// What is known of a command that was planned: where its arms are after it, and, where its last motion may be left,
/// for what goes on with that. @param actuators  that it drives. Realtime: setup.
[[nodiscard]] PlannedActivity planned_activity(const command::Command& command,
                                               const std::vector<std::string>& actuators, const command::TreeEnd& end);

/// Where arms are when everything before has ended, as far as that is known.
[[nodiscard]] expression::Places places_before(const PlanningContext& planning);

/// Shows a value under a name where nothing is shown under it yet: a command may be carried out again. @param when
/// null: always
void observe_once(command::CommandNode& node, const std::string& name, expression::ExpressionPtr value,
                  expression::ExpressionPtr when = nullptr);

/// How a wait for a state with a timeout has failed. @param held  the state when its time was over; nothing: unknown
[[nodiscard]] Diagnostics failure_of_wait(const std::optional<net::Boolean>& held, double timeout);

/// Any command as an activity that begins at rest: a gripper, an output, a hold, a transaction of one's own. Realtime:
/// setup.
[[nodiscard]] ActivityPtr command_activity(std::string name, std::vector<std::string> actuators, CommandMaker make,
                                           ArmAfter arms = ArmAfter::kUnknown);

/// A command that the program has built: planned and mapped anew each time it is carried out, never twice at one time.
/// It drives what the command drives, and it is not known where its arms are after it. It fails where a command in it
/// has (Command::failed). Realtime: setup.
[[nodiscard]] ActivityPtr command_activity(const command::Command& command);

}  // namespace takt::activity
