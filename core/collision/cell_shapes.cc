#include "core/collision/cell_shapes.h"

#include <algorithm>

namespace takt::collision {
namespace {

bool is_meant(const std::string& name, const Body& body) { return name == body.owner || name == body.name; }

}  // namespace

bool CellShapes::is_relaxed(const Body& a, const Body& b) const {
  return std::ranges::any_of(relaxed, [&](const Relaxation& one) {
    return (is_meant(one.a, a) && is_meant(one.b, b)) || (is_meant(one.a, b) && is_meant(one.b, a));
  });
}

std::vector<std::string> CellShapes::names() const {
  std::set<std::string> names;
  for (const Body& body : scene.bodies()) names.insert({body.owner, body.name});
  return {names.begin(), names.end()};
}

}  // namespace takt::collision
