#pragma once

#include <memory>
#include <string>

#include "core/operations/parameter.h"
#include "core/operations/step.h"

namespace takt::activity {

/// {"do": "freedrive", "arm": ..., "enabled": CONDITION, "until": CONDITION, "seconds": ...}: a person guides an arm by
/// hand.
[[nodiscard]] std::unique_ptr<Step> parse_freedrive(const nlohmann::ordered_json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics);

[[nodiscard]] const std::vector<ParameterInfo>& freedrive_parameter_list();

}  // namespace takt::activity
