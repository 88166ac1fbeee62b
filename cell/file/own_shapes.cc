#include <algorithm>

#include <fmt/format.h>

#include "cell/file/shape_kind.h"

namespace takt::cell {
namespace {

using Part = world::Object::Part;

/// A cylinder with a bore from end to end.
std::vector<Part> make_tube(FormReader& from) {
  const double radius = from.number("radius_m"), length = from.number("length_m");
  Part tube{.shape = world::Cylinder{radius, length}};
  world::Bore bore;
  bore.radius = from.number("inner_radius_m");
  bore.chamfer = from.number("inner_chamfer_m");
  bore.X_SB.translation().z() = 0.5 * length;
  tube.chamfer = from.number("chamfer_m");
  if (bore.radius >= radius) {
    from.diagnostics().error(Code::kOutOfRange, from.at("inner_radius_m"),
                             fmt::format("{:g} m inside {:g} m", bore.radius, radius), "Make it less than 'radius_m'");
  }
  tube.bores.push_back(std::move(bore));
  return {std::move(tube)};
}

/// A floor and four walls, of which the two along x stand between the others.
std::vector<Part> make_container(FormReader& from) {
  const Eigen::Vector3d size = from.vector("size_m");
  const double wall = from.number("wall_m");
  const double floor = from.number("floor_m", wall);
  std::vector<Part> parts;
  if (2.0 * wall >= std::min(size.x(), size.y()) || floor >= size.z()) {
    from.diagnostics().error(Code::kOutOfRange, from.at("wall_m"), "walls and floor leave no room",
                             "Make walls thinner than half the width, and the floor lower than the walls");
    return parts;
  }
  const auto add = [&parts](const Eigen::Vector3d& edges, const Eigen::Vector3d& middle) {
    parts.push_back({.shape = world::Box{edges}});
    parts.back().X_OS.translation() = middle;
  };
  add({size.x(), size.y(), floor}, {0.0, 0.0, 0.5 * (floor - size.z())});
  const double height = size.z() - floor, middle = 0.5 * floor;
  for (const double side : {-1.0, 1.0}) {
    add({wall, size.y(), height}, {0.5 * side * (size.x() - wall), 0.0, middle});
    add({size.x() - 2.0 * wall, wall, height}, {0.0, 0.5 * side * (size.y() - wall), middle});
  }
  return parts;
}

std::vector<Part> make_cylinder(FormReader& from) {
  const double radius = from.number("radius_m");
  Part part{.shape = world::Cylinder{radius, from.number("length_m")}};
  part.chamfer = from.number("chamfer_m");
  part.bores = read_bores(from);
  return {std::move(part)};
}

std::vector<Part> make_box(FormReader& from) {
  Part part{.shape = world::Box{from.vector("size_m")}};
  part.bores = read_bores(from);
  return {std::move(part)};
}

std::vector<Part> make_sphere(FormReader& from) { return {{.shape = world::Sphere{from.number("radius_m")}}}; }

std::vector<Part> make_capsule(FormReader& from) {
  const double radius = from.number("radius_m");
  return {{.shape = world::Capsule{radius, from.number("length_m")}}};
}

}  // namespace

ShapeKind box_shape() { return {"box", {"A box.", {edges_key("Edge lengths [x, y, z]."), bores_key()}}, make_box}; }

ShapeKind capsule_shape() {
  return {"capsule",
          {"A cylinder along z with a half sphere at each end.",
           {radius_key("Radius."), body_key("length_m", "Length along z without the caps.")}},
          make_capsule};
}

ShapeKind container_shape() {
  return {"container",
          {"A box without a lid.",
           {edges_key("Edge lengths [x, y, z] outside."), body_key("wall_m", "Thickness of the walls."),
            body_key("floor_m", "Thickness of the floor.").optional("that of the walls")}},
          make_container};
}

ShapeKind cylinder_shape() {
  return {"cylinder",
          {"A cylinder along z.",
           {radius_key("Radius."), body_key("length_m", "Length along z."),
            chamfer_key("chamfer_m", "Width of the 45 degree chamfer at both ends."), bores_key()}},
          make_cylinder};
}

ShapeKind sphere_shape() { return {"sphere", {"A sphere.", {radius_key("Radius.")}}, make_sphere}; }

ShapeKind tube_shape() {
  return {"tube",
          {"A tube along z, open at both ends.",
           {radius_key("Radius."), body_key("inner_radius_m", "Inner radius."), body_key("length_m", "Length along z."),
            chamfer_key("chamfer_m", "Width of the 45 degree chamfer at both ends."),
            chamfer_key("inner_chamfer_m", "Width of the chamfer of the inner edges.")}},
          make_tube};
}

}  // namespace takt::cell
