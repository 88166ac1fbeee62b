#pragma once

#include <vector>

#include "core/base/diagnostics.h"
#include "tools/import/triangles.h"

namespace takt::tools {

/// How far a solid that is not convex is split.
struct SplitOptions {
  double concavity = 0.05;  ///< of a part at most, as CoACD measures it: 0.01 (many parts) to 1 (the hull)
  int most_parts = 64;      ///< more are merged
};

/// Of the convex hull of all corners, m^3; the surface may be open. An error where the corners are in one plane.
[[nodiscard]] Result<double> hull_volume(const Triangles& mesh);

/// Convex parts that together are the solid, nearly: hulls, each closed. The same mesh gives the same parts.
/// A convex solid gives itself. Takes seconds; a surface that is not closed is made so from voxels first, which takes
/// half a minute. Source: Wei, Liu, Ling, Su 2022 (CoACD), the library of that name (third_party/coacd.txt).
/// @return the parts, or a diagnostic: the library is not there, or found none. Realtime: setup.
[[nodiscard]] Result<std::vector<Triangles>> convex_parts(const Triangles& mesh, const SplitOptions& options);

}  // namespace takt::tools
