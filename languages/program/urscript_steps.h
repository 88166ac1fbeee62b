#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "languages/program/urscript_map.h"

namespace takt::languages {

/// "12: movel".
[[nodiscard]] std::string script_step_name(const TextLocation& at, const std::string& word);

/// A motion as a step. @param turns  the tool turns on it
/// @param problem  what no step can do; the step is null then. Realtime: setup.
[[nodiscard]] nlohmann::ordered_json motion_step(const urscript::MotionCommand& motion, bool turns,
                                                 const UrscriptMap& map, const expression::Cell& cell,
                                                 std::string& problem);

/// What lasts as a step, which ends when it is cancelled.
[[nodiscard]] nlohmann::ordered_json lasting_step(const urscript::LastingCommand& command, const UrscriptMap& map);

}  // namespace takt::languages
