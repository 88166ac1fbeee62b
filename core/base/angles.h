#pragma once

#include <span>
#include <string>

#include "core/base/diagnostics.h"

namespace takt {

/// Angles that a file gives in degrees and that look like radians: none is beyond a full turn, and at least one is, to
/// the digits in use, a multiple of pi/6 or pi/4 (1.57, 3.1416, -0.7854). A guess, so only ever a warning.
/// Realtime: setup.
[[nodiscard]] bool look_like_radians(std::span<const double> degrees);

/// Warns at `pointer` if they do, with one of the angles and what it would be in degrees. Realtime: setup.
void warn_of_radians(std::span<const double> degrees, std::string pointer, Diagnostics& diagnostics);

}  // namespace takt
