#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"

/// Layouts of the page: files that say which parts it shows, and where (docs/panel.md). Realtime: setup.
namespace takt::serve {

/// A layout as the page gets it.
struct Layout {
  std::string json = "null";     ///< null: there is none, or it is broken
  Diagnostics diagnostics = {};  ///< with pointers into the file
};
/// The file beside a scenario: NAME.layout of NAME.json. It is read anew each time, so that an edit shows.
/// @param cameras  of the cell
[[nodiscard]] Layout read_layout(const std::filesystem::path& scenario, const cell::BuiltCell& built,
                                 const std::vector<std::string>& cameras);

}  // namespace takt::serve
