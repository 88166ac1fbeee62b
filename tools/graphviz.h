#pragma once

#include <string>

#include "core/base/diagnostics.h"

namespace takt::tools {

/// What Graphviz's `dot` makes of a graph. @param format  as `dot -T` has it
/// Diagnostics at `pointer`: the program is missing, failed, or took too long.
[[nodiscard]] Result<std::string> run_dot(const std::string& graph, const std::string& format,
                                          const std::string& pointer);

}  // namespace takt::tools
