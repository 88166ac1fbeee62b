// Shapes "tube" and "container".
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "scenario/shape_kind.h"

namespace takt::scenario {
namespace {

using HollowPart = world::Object::Part;

/// A cylinder with a bore from end to end.
struct TubeShape {
  double radius = 1.0, length = 1.0, inner_radius = 0.5, inner_chamfer = 0.0, chamfer = 0.0;

  [[nodiscard]] std::vector<HollowPart> parts() const {
    world::Bore bore;
    bore.radius = inner_radius;
    bore.chamfer = inner_chamfer;
    bore.X_SB.translation().z() = 0.5 * length;
    return {{.shape = world::Cylinder{radius, length}, .chamfer = chamfer, .bores = {std::move(bore)}}};
  }
};

/// A box without a lid: a floor and four walls, of which the two along x stand between the others.
struct ContainerShape {
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  double wall = 0.1;
  std::optional<double> floor = {};  ///< as the walls

  [[nodiscard]] double floor_thickness() const { return floor.value_or(wall); }
  [[nodiscard]] bool has_inside() const {
    return 2.0 * wall < std::min(size.x(), size.y()) && floor_thickness() < size.z();
  }
  [[nodiscard]] std::vector<HollowPart> parts() const {
    std::vector<HollowPart> all;
    if (!has_inside()) return all;
    const auto add = [&](const Eigen::Vector3d& edges, const Eigen::Vector3d& middle) {
      all.push_back({.shape = world::Box{edges}});
      all.back().X_OS.translation() = middle;
    };
    const double bottom = floor_thickness(), height = size.z() - bottom, middle = 0.5 * bottom;
    add({size.x(), size.y(), bottom}, {0.0, 0.0, 0.5 * (bottom - size.z())});
    for (const double side : {-1.0, 1.0}) {
      add({wall, size.y(), height}, {0.5 * side * (size.x() - wall), 0.0, middle});
      add({size.x() - 2.0 * wall, wall, height}, {0.0, 0.5 * side * (size.y() - wall), middle});
    }
    return all;
  }
};

const table::Table<TubeShape>& tube_table() {
  static const auto table = [] {
    table::Table<TubeShape> tube;
    add_radius(tube);
    add_length(tube);
    tube.number("inner_radius_m", "m", &TubeShape::inner_radius, kBodySize, "Inner radius of a tube.")
        .required()
        .number("inner_chamfer_m", "m", &TubeShape::inner_chamfer, kNotNegative, "Chamfer of a tube's inner edges.");
    add_chamfer(tube);
    tube.rule([](TubeShape& shape, const table::Context& from) {
      if (shape.inner_radius >= shape.radius)
        from.reader.diagnostics().error(Code::kOutOfRange, from.reader.at("inner_radius_m"),
                                        fmt::format("{:g} m inside {:g} m", shape.inner_radius, shape.radius),
                                        "Make it less than 'radius_m'");
    });
    return tube;
  }();
  return table;
}

const table::Table<ContainerShape>& container_table() {
  static const auto table = [] {
    table::Table<ContainerShape> container;
    add_size(container);
    container.number("wall_m", "m", &ContainerShape::wall, kBodySize, "Thickness of a container's walls.")
        .required()
        .number("floor_m", "m", &ContainerShape::floor, kBodySize, "Thickness of a container's floor.")
        .fallback("that of the walls")
        .rule([](ContainerShape& shape, const table::Context& from) {
          if (!shape.has_inside())
            from.reader.diagnostics().error(
                Code::kOutOfRange, from.reader.at("wall_m"), "walls and floor fill the box",
                "Make walls thinner than half the width, and the floor lower than the walls");
        });
    return container;
  }();
  return table;
}

}  // namespace

ShapeKind tube_shape() { return shape_kind<TubeShape, tube_table>("tube", "A hollow cylinder along z."); }
ShapeKind container_shape() {
  return shape_kind<ContainerShape, container_table>("container", "A box with walls and floor, open at the top.");
}

}  // namespace takt::scenario
