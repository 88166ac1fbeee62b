#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/parameter.h"
#include "core/operations/step.h"

namespace takt::activity {

/// "tare": averages a force/torque sensor at rest and keeps the offset for all later conditions.
[[nodiscard]] std::unique_ptr<Step> parse_tare(const nlohmann::ordered_json& json, const std::string& pointer,
                                               const command::Cell& cell, Diagnostics& diagnostics);
/// "record_contact": keeps the last touch of an arm under a name.
[[nodiscard]] std::unique_ptr<Step> parse_record_contact(const nlohmann::ordered_json& json, const std::string& pointer,
                                                         const command::Cell& cell, Diagnostics& diagnostics);
/// "fit_pose": finds the pose of an object whose surface explains recorded contacts; makes it a frame.
[[nodiscard]] std::unique_ptr<Step> parse_fit_pose(const nlohmann::ordered_json& json, const std::string& pointer,
                                                   const command::Cell& cell, Diagnostics& diagnostics);

[[nodiscard]] const std::vector<ParameterInfo>& tare_parameter_list();
[[nodiscard]] const std::vector<ParameterInfo>& record_contact_parameter_list();
[[nodiscard]] const std::vector<ParameterInfo>& fit_pose_parameter_list();

}  // namespace takt::activity
