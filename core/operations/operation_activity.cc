#include "core/operations/operation_activity.h"

#include "core/operations/command_builder.h"

namespace takt::activity {
namespace {

/// It refers to nothing but the cell, so it may be carried out as often as the program likes.
class OperationActivity final : public ActivityModel {
 public:
  OperationActivity(std::string name, std::shared_ptr<const OperationCommand> command, std::string actuator,
                    command::Biases biases, ArmAfter arms)
      : ActivityModel(std::move(name)), command_(std::move(command)), biases_(std::move(biases)) {
    const auto make = [this](const PlanningContext& planning) {
      Diagnostics notes;  // planners of motions have some; these operations have none
      const CommandBuilder tree(*command_, {.cell = planning.cell, .biases = biases_, .notes = notes});
      return tree.command();
    };
    inner_ = command_activity(this->name(), {std::move(actuator)}, make, arms);
  }

  [[nodiscard]] std::vector<std::string> actuators() const override { return inner_->actuators(); }
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    Diagnostics wrong;
    command_->check(planning.cell, wrong);
    if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    return inner_->prepare(planning);
  }

 private:
  std::shared_ptr<const OperationCommand> command_;
  command::Biases biases_;
  ActivityPtr inner_;
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
                               command::Biases biases, ArmAfter arms) {
  return std::make_shared<const OperationActivity>(std::move(name), std::move(command), std::move(actuator),
                                                   std::move(biases), arms);
}

ActivityPtr refused_activity(std::string name, std::string actuator, Diagnostics why) {
  return std::make_shared<const RefusedActivity>(std::move(name), std::move(actuator), std::move(why));
}

}  // namespace takt::activity
