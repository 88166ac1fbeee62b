#pragma once

#include <optional>
#include <string>

#include "core/command/actions/device_commands.h"
#include "core/expression/condition_state.h"
#include "core/operations/command/operation_activity.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/state_parameters.h"

/// "set": brings a digital or an analog output to a value, which then stays; or lets an analog one follow a value.
/// Realtime: setup.
namespace takt::operations {

struct SetParameters {
  std::string output = {};  ///< empty: the only one
  command::SignalValue value = false;
  /// In place of `value`: an analog output follows this, limited to its range, until it is cancelled.
  std::optional<ValueParameters> source = {};
  // Of an output that follows.
  std::optional<double> factor = {};                  ///< in the output's unit for each of the source's
  std::optional<double> offset = {};                  ///< in the output's unit
  std::optional<double> seconds = {};                 ///< for so long
  std::optional<expression::StateSource> until = {};  ///< until this becomes true
  std::string name = {}, pointer = {};                ///< for people; in its file
};
[[nodiscard]] const ParameterTable<SetParameters>& set_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> set_command(const SetParameters& parameters);
[[nodiscard]] inline OperationForm<SetParameters> form_of(const SetParameters&) {
  return {"set", set_parameters, &SetParameters::output, set_command};
}
[[nodiscard]] Operation set_operation();

}  // namespace takt::operations
