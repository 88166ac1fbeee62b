#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/step.h"

namespace takt::activity {

/// "grip": closes a gripper until a part stops its fingers. Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_grip(const nlohmann::ordered_json& json, const std::string& pointer,
                                               const command::Cell& cell, Diagnostics& diagnostics);
/// "release": opens a gripper.
[[nodiscard]] std::unique_ptr<Step> parse_release(const nlohmann::ordered_json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
