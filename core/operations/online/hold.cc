#include "core/operations/online/hold.h"

#include <utility>

#include "core/command/actions/device_action.h"
#include "core/operations/command/command_step.h"

namespace takt::operations {
namespace {

class HoldCommand final : public OnlineCommand {
 public:
  explicit HoldCommand(const HoldParameters& parameters) : OnlineCommand(parameters) {}

 private:
  [[nodiscard]] command::Action action_of(const BuildContext&) const override { return command::hold(); }
};

}  // namespace

const ParameterTable<HoldParameters>& hold_parameters() {
  static const auto table = online_parameters<HoldParameters>();
  return table;
}

std::unique_ptr<OperationCommand> hold_command(const HoldParameters& parameters) {
  return std::make_unique<HoldCommand>(parameters);
}

Operation hold_operation() {
  return {.name = "hold",
          .doc = "Holds an arm where it is.",
          .parameters = rows_of<hold_parameters>,
          .read_step = step_of_command,
          .read_command = read_command<HoldCommand, hold_parameters>};
}

}  // namespace takt::operations
