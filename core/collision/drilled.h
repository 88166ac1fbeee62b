#pragma once

#include <vector>

#include "core/collision/scene.h"

namespace takt::collision {

/// The convex solids that a part of an object is made of. A part without bores is one. Of one with bores the material
/// around each bore is cut into pieces, so that what stands in a bore does not overlap. The pieces hold all of the
/// material and at most 0.2 mm more: a bore counts as a prism inside its wall, without its chamfer; a drilled cylinder
/// as a prism around it. Chamfers of cylinders are left out, too.
/// @return poses of the pieces in the frame of the object. Realtime: setup.
[[nodiscard]] std::vector<Part> solids_of(const world::Object::Part& part);

}  // namespace takt::collision
