#pragma once

#include <string>

#include "tools/robustness/robustness.h"

namespace takt::tools {

/// A picture (SVG) of what one expectation measured: a dot for each seed on one axis, the median, and the bounds.
[[nodiscard]] std::string strip_plot(const ExpectationSpread& expectation);

}  // namespace takt::tools
