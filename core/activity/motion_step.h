#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/step.h"

namespace takt::activity {

/// "ptp" and "lin": a planned motion of one arm, guarded if it has "until". Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_ptp(const nlohmann::ordered_json& json, const std::string& pointer,
                                              const command::Cell& cell, Findings& findings);
[[nodiscard]] std::unique_ptr<Step> parse_lin(const nlohmann::ordered_json& json, const std::string& pointer,
                                              const command::Cell& cell, Findings& findings);

}  // namespace takt::activity
