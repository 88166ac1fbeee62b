#include "core/world/bore.h"

namespace takt::world {
namespace {

constexpr double kFar = 1e3;  // m: where the face around a bore ends

}  // namespace

Revolved material_around(const Bore& bore, double thickness) {
  const double r = bore.radius, c = bore.chamfer;
  if (bore.through()) {
    const double end = -thickness;
    return {{kFar, 0.0}, {r + c, 0.0}, {r, -c}, {r, end + c}, {r + c, end}, {kFar, end}};
  }
  return {{kFar, 0.0}, {r + c, 0.0}, {r, -c}, {r, -bore.depth}, {0.0, -bore.depth}};
}

Revolved chamfered_cylinder(double radius, double length, double chamfer) {
  const double h = 0.5 * length, in = radius - chamfer;
  return {{0.0, -h}, {in, -h}, {radius, chamfer - h}, {radius, h - chamfer}, {in, h}, {0.0, h}};
}

}  // namespace takt::world
