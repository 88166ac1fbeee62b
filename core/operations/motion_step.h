#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/step.h"

namespace takt::activity {

/// "ptp", "lin", "circ", "spline": a planned motion of one arm, guarded if it has "until", blended into the motion
/// after it if it has "blend_m" or "blend_fraction". Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_ptp(const nlohmann::ordered_json& json, const std::string& pointer,
                                              const command::Cell& cell, Diagnostics& diagnostics);
[[nodiscard]] std::unique_ptr<Step> parse_lin(const nlohmann::ordered_json& json, const std::string& pointer,
                                              const command::Cell& cell, Diagnostics& diagnostics);
[[nodiscard]] std::unique_ptr<Step> parse_circ(const nlohmann::ordered_json& json, const std::string& pointer,
                                               const command::Cell& cell, Diagnostics& diagnostics);
[[nodiscard]] std::unique_ptr<Step> parse_spline(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
