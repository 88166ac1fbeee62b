#pragma once

#include <map>
#include <string>

#include "core/base/diagnostics.h"
#include "core/device/device_file.h"

namespace takt::device {

/// A metric thread and the socket head cap screw that goes with it, SI units (docs/threads.md).
struct ScrewThread {
  double pitch = 0.0;           ///< m a turn
  double major = 0.0;           ///< m, outer diameter of the screw
  double pitch_diameter = 0.0;  ///< m, where the flanks meet: the lever of their friction
  double minor = 0.0;           ///< m, inner diameter of the nut
  double clearance = 0.0;       ///< m, diameter of a hole that the screw goes through
  double head_diameter = 0.0, head_height = 0.0;
  double socket_width = 0.0, socket_depth = 0.0;  ///< m, across flats of the hexagon socket; its depth
  double run_down = 0.0;                          ///< Nm, what turning the free screw takes
  double friction = 0.0;                          ///< of the flanks
};

using ScrewThreadTable = std::map<std::string, ScrewThread>;

/// The file `threads.json` beside the models of the library, of each of its folders. Empty where there is no such
/// file; a size in two of them is a diagnostic. Realtime: setup.
[[nodiscard]] Result<ScrewThreadTable> read_threads(const ModelLibrary& library);

}  // namespace takt::device
