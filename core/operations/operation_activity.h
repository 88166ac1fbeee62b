#pragma once

#include <memory>
#include <string>
#include <utility>

#include "core/activity/command_activity.h"
#include "core/operations/operation_command.h"

/// Operations as activities of programs in C++. Realtime: setup.
namespace takt::activity {

/// An operation that is a command, made anew each time it is carried out. What its step of a file would do at the end
/// it does too: what was expected and did not happen makes the run fail (RunFailure::kAborted).
/// @param context  of the program; it must outlive the activity
[[nodiscard]] ActivityPtr operation_activity(std::string name, std::unique_ptr<const OperationCommand> command,
                                             std::string actuator, Context& context,
                                             ArmAfter arms = ArmAfter::kUnknown);

/// One whose parameters were refused: it is never carried out.
[[nodiscard]] ActivityPtr refused_activity(std::string name, std::string actuator, Diagnostics why);

/// What a program in C++ needs to know of an operation: its header has a function form_of(const Parameters&).
template <class P>
struct OperationForm {
  std::string_view type;
  const ParameterTable<P>& (*table)();
  std::string P::*device;                                  ///< the parameter that names the actuator
  std::unique_ptr<OperationCommand> (*command)(const P&);  ///< from parameters that were accepted
  ArmAfter arms = ArmAfter::kUnknown;
};

/// An operation of an actuator: its parameters are checked as those of a file.
template <class P>
ActivityPtr operation_activity(P parameters, const std::string& actuator, Context& context) {
  const OperationForm<P> form = form_of(parameters);
  parameters.*form.device = actuator;
  const std::string name = parameters.name.empty() ? std::string(form.type) + " " + actuator : parameters.name;
  auto accepted = form.table().accept(std::move(parameters), context.cell);
  if (!accepted) return refused_activity(name, actuator, std::move(accepted.error()));
  std::unique_ptr<OperationCommand> command = form.command(*accepted);
  command->name = form.type;
  return operation_activity(name, std::move(command), actuator, context, form.arms);
}

}  // namespace takt::activity
