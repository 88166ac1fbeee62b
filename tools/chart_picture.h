#pragma once

#include <string>

#include "core/base/diagnostics.h"

namespace takt::languages {
struct Chart;
}

namespace takt::tools {

/// A chart as SVG: states as boxes in the boxes of those around them, transitions as arrows with their events and
/// conditions. Graphviz's `dot` places them. Diagnostics at "--svg".
[[nodiscard]] Result<std::string> chart_svg(const languages::Chart& chart);

}  // namespace takt::tools
