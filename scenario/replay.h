#pragma once

#include <filesystem>
#include <string>

#include "core/base/diagnostics.h"
#include "core/device/device_file.h"

namespace takt::scenario {

struct ReplayOptions {
  std::filesystem::path video;
  std::string camera;  ///< empty: the scenario's first
  int width = 1280, height = 720, fps = 25;
};

/// Draws a recorded run again from the states in it, with the scenario that it carries; nothing is simulated.
/// @return number of frames; or diagnostics: no recording, no scenario or states inside, models that do not fit.
[[nodiscard]] Result<std::int64_t> render_recording(const std::filesystem::path& recording,
                                                    const device::ModelLibrary& models, const ReplayOptions& options);

}  // namespace takt::scenario
