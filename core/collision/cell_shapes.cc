#include "core/collision/cell_shapes.h"

#include <algorithm>

namespace takt::collision {
namespace {

/// Of the ground, m: no arm reaches past its border or through it.
constexpr double kFloorWidth = 100.0, kFloorDepth = 10.0;

bool is_meant(const std::string& name, const Body& body) { return name == body.owner || name == body.name; }

}  // namespace

void CellShapes::add_floor() {
  const std::string name = scene.root_of("floor") < 0 ? "floor" : "world/floor";
  const world::Object::Part ground{.shape = world::Box{{kFloorWidth, kFloorWidth, kFloorDepth}}};
  floor = static_cast<int>(scene.bodies().size());
  scene.add_object(name, {ground}, -1, Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.5 * kFloorDepth)));
  objects.insert(name);
}

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
