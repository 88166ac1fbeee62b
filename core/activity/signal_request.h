#pragma once

#include <optional>
#include <string>

#include "core/activity/state_request.h"
#include "core/base/object_reader.h"
#include "core/command/condition.h"
#include "core/command/device_commands.h"

namespace takt::activity {

/// What a step "set" says. Keys: docs/scenarios.md.
struct SetRequest {
  /// An analog output goes after a value, brought into its range, until it is cancelled.
  struct Following {
    ValueRequest value;
    std::optional<double> factor;             ///< in the output's unit for each of the value's
    std::optional<double> offset;             ///< in the output's unit
    std::optional<double> seconds;            ///< so long
    std::optional<command::Condition> until;  ///< until this holds
  };
  std::string output;
  command::SignalValue value = false;
  std::optional<Following> following;  ///< in place of `value`
};
[[nodiscard]] SetRequest read_set(ObjectReader& reader, const command::Cell& cell);
/// Whether a step "set" follows a value.
[[nodiscard]] bool sets_by_following(const nlohmann::ordered_json& json);
/// @return false with a finding: a value outside of the range of the output, or in another unit.
bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer, Findings& findings);

/// What a step "wait" says: a time, or a condition and maybe a time after which that has failed.
struct WaitRequest {
  std::optional<command::Condition> until;  ///< nothing: `seconds` pass
  std::optional<double> seconds, timeout;
};
[[nodiscard]] WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell);

}  // namespace takt::activity
