#pragma once

#include "core/program/tree/node.h"
#include "languages/program/urscript_map.h"

namespace takt::languages {

/// Runs a program on nominal values and rehearses what it comes to. Diagnostics have file, line and column.
void rehearse_urscript(std::shared_ptr<const urscript::Program> program, const std::string& file,
                       const UrscriptMap& map, const program::Node& node, operations::Rehearsal& rehearsal,
                       Diagnostics& diagnostics);

}  // namespace takt::languages
