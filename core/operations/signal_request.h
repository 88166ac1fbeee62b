#pragma once

#include <optional>
#include <string>

#include "core/command/actions/device_commands.h"
#include "core/expression/condition.h"
#include "core/operations/parameter_table.h"
#include "core/operations/state_request.h"

namespace takt::activity {

/// What a step "set" says. Keys: docs/scenarios.md.
struct SetRequest : OperationHead {
  std::string output;
  command::SignalValue value = false;
  /// In place of `value`: an analog output follows this, limited to its range, until it is cancelled.
  std::optional<ValueRequest> source;
  // Of an output that follows.
  std::optional<double> factor;             ///< in the output's unit for each of the source's
  std::optional<double> offset;             ///< in the output's unit
  std::optional<double> seconds;            ///< for so long
  std::optional<command::Condition> until;  ///< until this becomes true
};
[[nodiscard]] const ParameterTable<SetRequest>& set_parameters();
[[nodiscard]] SetRequest read_set(ObjectReader& reader, const command::Cell& cell);
/// Whether a step "set" follows a value.
[[nodiscard]] bool sets_by_following(const nlohmann::ordered_json& json);
/// @return false with a diagnostic: a value outside of the range of the output, or in another unit.
bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer,
                 Diagnostics& diagnostics);

/// What a step "wait" says: a time, or a condition and maybe a time after which that has failed.
struct WaitRequest : OperationHead {
  std::optional<command::Condition> until;  ///< nothing: `seconds` pass
  std::optional<double> seconds, timeout;
};
[[nodiscard]] const ParameterTable<WaitRequest>& wait_parameters();
[[nodiscard]] WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell);

}  // namespace takt::activity
