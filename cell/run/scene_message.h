#pragma once

#include <string>

struct mjModel_;

namespace takt::cell {

/// What the cell looks like, as a message of foxglove.SceneUpdate: an entity for each body, locked to the frame of that
/// name in "/tf", so that viewers of recordings show machines and not axes. Empty where it would be larger than a
/// recording may hold. Realtime: setup.
[[nodiscard]] std::string scene_message(const mjModel_& model);

}  // namespace takt::cell
