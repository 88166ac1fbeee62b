#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/step.h"

namespace takt::activity {

/// A command of a file as a step: "transaction", and "jog", "follow", "hold" and motions with something laid over them.
/// One net, through the mapping of the command layer. Keys: docs/programs.md, docs/scenarios.md.
[[nodiscard]] std::unique_ptr<Step> parse_command_step(const nlohmann::ordered_json& json, const std::string& pointer,
                                                       const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
