#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/collision/scene.h"

namespace takt::collision {

/// Two bodies that the cell's file takes out of the check, and why. A name is that of a device or object (all its
/// bodies) or of one body ("arm/link_3").
struct Relaxation {
  std::string a, b, reason;
};

/// The solids of a cell with what its file says about their check. Built once, then read only.
struct CellShapes {
  Scene scene;
  double margin = 1e-3;  ///< m: nearer than this counts as a collision
  std::string off = {};  ///< why nothing is checked; empty: it is
  std::vector<Relaxation> relaxed = {};
  std::set<std::string, std::less<>> free_objects = {};  ///< that arms may carry

  [[nodiscard]] bool is_relaxed(const Body& a, const Body& b) const;
};

}  // namespace takt::collision
