#pragma once

#include <optional>
#include <string>

#include "core/base/time.h"
#include "sim/render_image.h"

namespace takt::sim {

/// What stands in the film beside the picture; an empty text or an absent value leaves its place free. Text is UTF-8;
/// what does not fit is cut with an ellipsis.
struct Overlay {
  std::string title;                    ///< of the scenario, upper left
  std::string step;                     ///< node of the program at work, lower left
  std::string camera;                   ///< upper right
  std::string note;                     ///< under the step, e.g. "guard tripped: torque of left/J4"
  Nanoseconds time = 0;                 ///< simulated time, lower right
  std::optional<double> force_N;        ///< the force to watch, as number and bar
  std::optional<double> force_limit_N;  ///< marked in the bar; above it the bar turns red
  std::string force_label = "Force";
  bool operator==(const Overlay&) const = default;
};

/// Draws `overlay` on translucent strips at the upper and lower edge; scales with the height of the picture.
/// Pure function of its arguments; needs no font on the machine. Thread: any. Realtime: setup.
void draw_overlay(const Overlay& overlay, Image& image);

}  // namespace takt::sim
