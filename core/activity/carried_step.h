#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/step.h"

namespace takt::activity {

/// "lin" with "base_to": the tool goes on a straight line in the room while the base that carries the arm drives to a
/// place of its own; both on one clock. Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_carried_lin(const nlohmann::ordered_json& json, const std::string& pointer,
                                                      const command::Cell& cell, Findings& findings);

}  // namespace takt::activity
