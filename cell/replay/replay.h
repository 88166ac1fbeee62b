#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/device_file.h"
#include "sim/film/renderer.h"

namespace takt::cell {

struct ReplayOptions {
  std::filesystem::path video;
  std::string camera;                                               ///< empty: the scenario's first, and its cuts
  std::optional<sim::FreeCamera> view;                              ///< a camera that no file has, instead
  std::optional<std::vector<std::string>> show;                     ///< marks of the film, instead of the scenario's
  double from = 0.0, to = std::numeric_limits<double>::infinity();  ///< s of simulated time
  int width = 1280, height = 720, fps = 25;
  int jobs = 2;  ///< pictures that are drawn at a time, 1 ... 16
};

/// Draws a recorded run, or a part of it, again from the states in it, with the scenario that it carries; nothing is
/// simulated. A film that ends with a failure shows its last state for a second more.
/// @return number of frames; or diagnostics: no recording, no scenario or states inside, models that do not fit.
[[nodiscard]] Result<std::int64_t> render_recording(const std::filesystem::path& recording,
                                                    const device::ModelLibrary& models, const ReplayOptions& options);

}  // namespace takt::cell
