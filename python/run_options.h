#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/run_arguments.h"

namespace takt::python {

/// Options of a run as the command line has them, and where its models are.
struct RunSettings {
  app::ParsedRun parsed;
  std::vector<std::filesystem::path> models;  ///< the install's last
  std::string core, token;                    ///< URL of a server that has the cell, and a file; empty: it is here
};

/// @param options  JSON: seed (text), sets (as --set), video, record, camera, size, fps, realtime, site, models,
/// repeat, measure_times, core, token. Raises takt.OpenError with all that is wrong with them. Realtime: setup.
[[nodiscard]] RunSettings run_settings(const std::string& file, const std::string& options);

}  // namespace takt::python
