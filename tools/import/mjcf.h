#pragma once

#include <filesystem>

#include "core/base/diagnostics.h"
#include "tools/import/draft.h"

namespace takt::tools {

/// A model in MuJoCo's format (MJCF) as the tree of a URDF: MuJoCo's own compiler reads it with its includes, classes,
/// defaults and meshes, so that all of it counts as it does there. A body becomes a link of its name, with its frame
/// where MuJoCo has it at the same joint positions; a site a link without a body; a joint that is not in the origin of
/// its body, or one of several of a body, gets a link of its own. What has no place in a robot is noted by name and
/// place. @return the draft, or diagnostics: no XML, a file that is missing, what MuJoCo's compiler refuses.
/// Realtime: setup.
[[nodiscard]] Result<Draft> read_mjcf(const std::filesystem::path& file);

}  // namespace takt::tools
