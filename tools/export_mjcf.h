#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cell/file/description.h"
#include "core/base/diagnostics.h"
#include "core/device/device_file.h"

namespace takt::tools {

struct MjcfExport {
  std::filesystem::path scenario;
  std::filesystem::path out;  ///< folder; it is made, and files of the same names in it are replaced
  std::vector<cell::Override> overrides = {};
  std::optional<std::uint64_t> seed = {};  ///< in place of the file's
};

struct MjcfReport {
  std::vector<std::filesystem::path> files;  ///< the model first, then its meshes
  std::vector<std::string> lacks;            ///< what of the cell the model has not
};

/// Writes the cell of a scenario at its start as a model of MuJoCo: OUT/SCENARIO.xml and OUT/assets (sim/plain). The
/// program is not looked at. @return what was written, or all that is wrong with the cell or the folder. Realtime:
/// setup.
[[nodiscard]] Result<MjcfReport> export_mjcf(const MjcfExport& options, const device::ModelLibrary& library);

}  // namespace takt::tools
