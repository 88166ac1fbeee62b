#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/step.h"

namespace takt::activity {

/// "set": brings a digital or an analog output to a value, which then stays.
[[nodiscard]] std::unique_ptr<Step> parse_set(const nlohmann::ordered_json& json, const std::string& pointer,
                                              const command::Cell& cell, Diagnostics& diagnostics);
/// "wait": lets time pass, or waits until a condition holds.
[[nodiscard]] std::unique_ptr<Step> parse_wait(const nlohmann::ordered_json& json, const std::string& pointer,
                                               const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
