#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/step.h"

namespace takt::activity {

/// "press": touches along a direction and holds a force. "search": presses and follows a spiral or a zigzag until
/// something is found. Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_press(const nlohmann::ordered_json& json, const std::string& pointer,
                                                const command::Cell& cell, Diagnostics& diagnostics);
[[nodiscard]] std::unique_ptr<Step> parse_search(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
