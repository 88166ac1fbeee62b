#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "cell/file/description.h"
#include "core/base/diagnostics.h"

namespace takt::cell {

/// Puts the text of each program that a node "krl" or "urscript" names in the place of its name, of KRL with its data
/// list, the modules of the same folder that it calls and $config.dat, so that the document says all. Files lie below
/// `folder`. Realtime: setup.
void read_robot_programs(nlohmann::ordered_json& document, const std::filesystem::path& folder,
                         Diagnostics& diagnostics);

/// A robot program instead of the scenario's program, as the command line asks for it.
struct RobotProgram {
  std::string file;  ///< NAME.src or NAME.script
  std::string arm;   ///< empty: the only one
  std::string map;   ///< file; empty: NAME.map.json beside the program, if there is one
};

/// The change of a scenario that runs it. Diagnostics: files that cannot be read, an ending that no language has.
/// Realtime: setup.
[[nodiscard]] Result<Override> to_override(const RobotProgram& program);

}  // namespace takt::cell
