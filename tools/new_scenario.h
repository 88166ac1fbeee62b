#pragma once

#include <filesystem>
#include <string>

#include "tools/cli.h"

namespace takt::tools {

struct ScenarioOptions {
  std::string name;              ///< of the file, without ".json": letters, digits, '_', '-'
  std::string arm = "lwr4plus";  ///< its model
  std::filesystem::path out;     ///< folder, made if it is not there; empty: the one that takt was called in
  std::filesystem::path schema;  ///< of scenario files, for editors; left out where there is no such file
};

/// A scenario file to begin with: an arm, a block beside it, a camera, a short program and expectations, which
/// validates and runs as it is with any arm. Diagnostics: the name, the model, a file that is there already.
/// @return the file. Realtime: setup.
[[nodiscard]] Result<std::filesystem::path> new_scenario(const ScenarioOptions& options,
                                                         const device::ModelLibrary& models);

}  // namespace takt::tools
