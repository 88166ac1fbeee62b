#pragma once

#include <filesystem>
#include <functional>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

namespace takt::tools {

/// What the picture of the work space found.
struct Reach {
  double farthest_m =
      0.0;  ///< of the flange's centre from the middle of the base's z axis at shoulder height, any hand
  double best_measure = 0.0;
  double share = 1.0;  ///< of the right section that was solved for in the time there was
};

struct ReachOptions {
  /// Called some hundred times with the share of the work that is done, 0 to 1; may be empty.
  std::function<void(double)> progress = {};
  /// Processor time after which no more fields are solved for: what is there then is drawn, and the picture says so.
  /// Arms without a closed form took 5 s at most where this was measured.
  double most_seconds = 20.0;
};

/// Draws two sections through the work space of an arm, in the plane through the z axis of its base, as SVG: where its
/// flange gets with any orientation, and with z of the flange straight down and x ahead. The colour of a place is the
/// best singularity measure (posture.h) of the postures found there; the arm is drawn in its home posture. The left
/// section comes from evenly spread joint positions, the right one from all solutions at the middle of each field.
/// @return diagnostics: a file that cannot be written or is no .svg
[[nodiscard]] Result<Reach> draw_reach(const device::ArmDescription& arm, const std::filesystem::path& file,
                                       const ReachOptions& options = {});

}  // namespace takt::tools
