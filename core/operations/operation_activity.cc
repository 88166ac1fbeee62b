#include "core/operations/operation_activity.h"

#include "core/operations/command_builder.h"

namespace takt::activity {
namespace {

/// It refers to nothing but the cell and what the program has measured, so it may be carried out as often as the
/// program likes.
class OperationActivity final : public ActivityModel {
 public:
  OperationActivity(std::string name, std::shared_ptr<const OperationCommand> command, std::string actuator,
                    Context& context, ArmAfter arms)
      : ActivityModel(std::move(name)),
        command_(std::move(command)),
        actuator_(std::move(actuator)),
        context_(context),
        biases_(context.variables.biases),
        arms_(arms) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {actuator_}; }
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    Diagnostics wrong;
    command_->check(planning.cell, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    Diagnostics notes;  // planners of motions have some; these operations have none
    const CommandBuilder tree(*command_, {.cell = planning.cell, .biases = biases_, .notes = notes});
    const auto made = [&tree](const PlanningContext&) { return tree.command(); };
    auto prepared = command_activity(name(), actuators(), made, arms_)->prepare(planning);
    if (!prepared) return std::unexpected(tree.in_file(prepared.error()));
    prepared->touching = command_->meant_touch().devices;
    prepared->verdict = [command = command_, key = tree.parts().front().key, &context = context_](const auto& run) {
      Diagnostics found;
      command->report(run, key, /*cancelled=*/false, context, found);
      return found;
    };
    return prepared;
  }

 private:
  std::shared_ptr<const OperationCommand> command_;
  std::string actuator_;
  Context& context_;  ///< of the program's thread; who plans may be another one
  command::Biases biases_;
  ArmAfter arms_;
};

class RefusedActivity final : public ActivityModel {
 public:
  RefusedActivity(std::string name, std::string actuator, Diagnostics why)
      : ActivityModel(std::move(name)), actuator_(std::move(actuator)), why_(std::move(why)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {actuator_}; }
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext&) const override { return std::unexpected(why_); }

 private:
  std::string actuator_;
  Diagnostics why_;
};

}  // namespace

ActivityPtr operation_activity(std::string name, std::unique_ptr<const OperationCommand> command, std::string actuator,
                               Context& context, ArmAfter arms) {
  return std::make_shared<const OperationActivity>(std::move(name), std::move(command), std::move(actuator), context,
                                                   arms);
}

ActivityPtr refused_activity(std::string name, std::string actuator, Diagnostics why) {
  return std::make_shared<const RefusedActivity>(std::move(name), std::move(actuator), std::move(why));
}

}  // namespace takt::activity
