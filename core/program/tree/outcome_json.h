#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/program/tree/node.h"

/// What a node has come to, as part of the state of a program (row D3). Realtime: setup.
namespace takt::program {

/// Not of kRunning.
[[nodiscard]] nlohmann::ordered_json outcome_to_json(Outcome outcome);
/// Throws std::out_of_range on what is none.
[[nodiscard]] Outcome outcome_from_json(const nlohmann::ordered_json& json);

/// Without the names of files.
[[nodiscard]] nlohmann::ordered_json diagnostics_to_json(const Diagnostics& diagnostics);
/// Throws nlohmann's exceptions on what is none.
[[nodiscard]] Diagnostics diagnostics_from_json(const nlohmann::ordered_json& json);

}  // namespace takt::program
