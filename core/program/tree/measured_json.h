#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/activity/context.h"

namespace takt::activity {

/// What a program has measured, and the frames that it has made or moved, as data (row D3).
[[nodiscard]] nlohmann::ordered_json measured_to_json(const Variables& variables, const command::Cell& cell);
/// Puts it back. Throws nlohmann's exceptions on a foreign form; diagnostics: frames that cannot be. Realtime: setup.
[[nodiscard]] Diagnostics measured_from_json(const nlohmann::ordered_json& json, Variables& variables,
                                             command::Cell& cell);

}  // namespace takt::activity
