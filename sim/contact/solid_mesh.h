#pragma once

#include <cstdint>
#include <vector>

#include "sim/model/solids.h"

namespace takt::sim {

/// Triangles of a picture, with a normal at each corner.
struct PictureMesh {
  std::vector<float> vertices, normals;  ///< three numbers each, m; as many normals as vertices
  std::vector<int> corners;              ///< three a triangle
};

/// What a box or cylinder with chamfers and bores looks like. Realtime: setup.
[[nodiscard]] PictureMesh picture_of(const ObjectShape& shape, const Solid& solid);

/// Triangles of a plane polygon with holes, as indices into `outer` and then the holes one after the other. `outer`
/// counter-clockwise, holes clockwise; nothing may cross. Realtime: setup.
[[nodiscard]] std::vector<int> triangulate(const std::vector<Eigen::Vector2d>& outer,
                                           const std::vector<std::vector<Eigen::Vector2d>>& holes);

}  // namespace takt::sim
