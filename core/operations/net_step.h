#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/parameter.h"
#include "core/operations/step.h"

namespace takt::activity {

/// "net": runs a net of the cell, written by hand, to its end. Keys: docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_net_step(const nlohmann::ordered_json& json, const std::string& pointer,
                                                   const command::Cell& cell, Diagnostics& diagnostics);

[[nodiscard]] const std::vector<ParameterInfo>& net_parameter_list();

}  // namespace takt::activity
