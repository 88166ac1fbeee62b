#pragma once

#include <nlohmann/json_fwd.hpp>

namespace takt::scenario {

/// The schema of scenario files, from the tables of all that they hold: plug-ins that are loaded count. Realtime:
/// setup.
[[nodiscard]] nlohmann::ordered_json scenario_schema();

}  // namespace takt::scenario
