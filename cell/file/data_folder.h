#pragma once

#include <filesystem>
#include <string>

namespace takt::cell {

/// Where models/ and scenarios/ lie: what the environment says (TAKT_ROOT), else above MuJoCo's library or the program
/// that runs (a build tree, or share/takt of an install: a program that is linked with an install finds that one), else
/// where the process was started. Realtime: setup.
[[nodiscard]] std::filesystem::path data_folder();

/// A scenario as somebody names it: that file, else the one of the install, there also without ".json"; `name` itself
/// where there is neither. Realtime: setup.
[[nodiscard]] std::string find_scenario(const std::string& name);

}  // namespace takt::cell
