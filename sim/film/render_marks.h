#pragma once

#include "sim/model/marks.h"

struct mjModel_;
struct mjData_;
struct mjvOption_;
struct mjvScene_;

namespace takt::sim {

/// mjvGeom::segid of what is drawn over whatever would hide it; MuJoCo's own are not negative beyond -1.
inline constexpr int kOnTopSegment = -2;

/// Appends the shapes to a scene that mjv_updateScene has filled; those that do not fit are left out.
void append_shapes(const Marks& marks, mjvScene_& scene);

/// Appends the geoms of the ghost's bodies, translucent. @param posed  of the model, at the ghost's positions
void append_ghost(const mjModel_& model, mjData_& posed, const Ghost& ghost, const mjvOption_& visible,
                  mjvScene_& scene);

}  // namespace takt::sim
