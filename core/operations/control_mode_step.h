#pragma once

#include <memory>
#include <string>

#include "core/operations/parameter.h"
#include "core/operations/step.h"

namespace takt::activity {

/// {"do": "control_mode", "arm": ..., "mode": ...}: brings an arm into a control mode while no net holds it.
[[nodiscard]] std::unique_ptr<Step> parse_control_mode(const nlohmann::ordered_json& json, const std::string& pointer,
                                                       const command::Cell& cell, Diagnostics& diagnostics);

[[nodiscard]] const std::vector<ParameterInfo>& control_mode_parameter_list();

}  // namespace takt::activity
