#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/activity/context.h"

namespace takt::program {

/// What a program has measured, and the frames that it has made or moved, as data (row D3).
[[nodiscard]] nlohmann::ordered_json measured_to_json(const activity::Variables& variables,
                                                      const expression::Cell& cell);
/// Puts it back. Throws nlohmann's exceptions on a foreign form; diagnostics: frames that cannot be. Realtime: setup.
[[nodiscard]] Diagnostics measured_from_json(const nlohmann::ordered_json& json, activity::Variables& variables,
                                             expression::Cell& cell);

}  // namespace takt::program
