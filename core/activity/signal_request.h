#pragma once

#include <optional>
#include <string>

#include "core/base/object_reader.h"
#include "core/command/condition.h"
#include "core/command/device_net.h"

namespace takt::activity {

/// What a step "set" says. Keys: docs/scenarios.md.
struct SetRequest {
  std::string output;
  command::SignalValue value = false;
};
[[nodiscard]] SetRequest read_set(ObjectReader& reader, const command::Cell& cell);
/// @return false with a finding: a value outside of the range of the output.
bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer, Findings& findings);

/// What a step "wait" says: a time, or a condition and maybe a time after which that has failed.
struct WaitRequest {
  std::optional<command::Condition> until;  ///< nothing: `seconds` pass
  std::optional<double> seconds, timeout;
};
[[nodiscard]] WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell);

}  // namespace takt::activity
