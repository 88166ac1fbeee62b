#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/activity/command_activity.h"
#include "core/operations/command/command_builder.h"
#include "core/operations/command/operation_command.h"

/// Operations as activities: steps of files, and what programs in C++ ask for. Realtime: setup.
namespace takt::operations {

/// An operation, or a transaction of several, as an activity that begins at rest. It is made into commands anew each
/// time that it is planned, with the cell of whoever plans: that may be another thread.
class OperationActivity final : public activity::ActivityModel {
 public:
  using RootPtr = std::shared_ptr<const OperationCommand>;
  /// Its commands, each with the key of what it observes.
  using Keys = std::vector<std::pair<const OperationCommand*, std::string>>;
  struct Options {
    std::string name = {};                        ///< empty: that of the command
    std::vector<std::string> actuators = {};      ///< empty: the devices that it drives
    std::optional<activity::ArmAfter> arms = {};  ///< of an arm that rests before; nothing: as the plan says
    command::ExternalHandler tell = {};           ///< gets external effects
    /// What was expected and did not happen makes the run fail (RunFailure::kAborted); else whoever asked for it judges
    /// it, with OperationCommand::report().
    bool judged = true;
  };

  /// @param context  of the program; it outlives the activity
  OperationActivity(RootPtr root, activity::Context& context, Options options);

  [[nodiscard]] std::vector<std::string> actuators() const override { return options_.actuators; }
  [[nodiscard]] const Keys& keys() const { return keys_; }
  [[nodiscard]] Result<activity::PlannedActivity> prepare(const activity::PlanningContext& planning) const override;

 private:
  RootPtr root_;
  activity::Context& context_;  ///< of the program's thread; who plans may be another one
  Options options_;
  expression::Biases biases_;
  activity::ConcurrentMotions meanwhile_;
  Keys keys_;
};

/// Checks and plans the commands of a tree. @return diagnostics with locations of the file
/// @param[in,out] places  as command::plan() has them
[[nodiscard]] Diagnostics plan_commands(const CommandBuilder& tree, const expression::Cell& cell,
                                        expression::Places& places, command::TreeEnd& end);

/// Whole locations as those below an operation.
[[nodiscard]] Diagnostics below(const OperationCommand& root, const Diagnostics& diagnostics);

/// An operation of one actuator of a program in C++.
/// @param context  of the program; it must outlive the activity
[[nodiscard]] activity::ActivityPtr operation_activity(std::string name,
                                                       std::unique_ptr<const OperationCommand> command,
                                                       std::string actuator, activity::Context& context,
                                                       activity::ArmAfter arms = activity::ArmAfter::kUnknown);

/// One whose parameters were refused: it is never carried out.
[[nodiscard]] activity::ActivityPtr refused_activity(std::string name, std::string actuator, Diagnostics why);

/// What a program in C++ needs to know of an operation: its header has a function form_of(const Parameters&).
template <class P>
struct OperationForm {
  std::string_view type;
  const ParameterTable<P>& (*table)();
  std::string P::*device;                                  ///< the parameter that names the actuator
  std::unique_ptr<OperationCommand> (*command)(const P&);  ///< from parameters that were accepted
  activity::ArmAfter arms = activity::ArmAfter::kUnknown;
};

/// An operation of an actuator: its parameters are checked as those of a file.
template <class P>
activity::ActivityPtr operation_activity(P parameters, const std::string& actuator, activity::Context& context) {
  const OperationForm<P> form = form_of(parameters);
  parameters.*form.device = actuator;
  const std::string name = parameters.name.empty() ? std::string(form.type) + " " + actuator : parameters.name;
  auto accepted = form.table().accept(std::move(parameters), context.cell);
  if (!accepted) return refused_activity(name, actuator, std::move(accepted.error()));
  std::unique_ptr<OperationCommand> command = form.command(*accepted);
  command->name = form.type;
  return operation_activity(name, std::move(command), actuator, context, form.arms);
}

}  // namespace takt::operations
