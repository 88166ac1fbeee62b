// Shapes "box", "cylinder", "sphere" and "capsule".
#include "scenario/bore_file.h"
#include "scenario/shape_kind.h"

namespace takt::scenario {
namespace {

using world::Bore;
using SolidPart = world::Object::Part;

struct BoxShape {
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  std::vector<Bore> bores = {};
  [[nodiscard]] std::vector<SolidPart> parts() const { return {{.shape = world::Box{size}, .bores = bores}}; }
};

struct CylinderShape {
  double radius = 1.0, length = 1.0, chamfer = 0.0;
  std::vector<Bore> bores = {};
  [[nodiscard]] std::vector<SolidPart> parts() const {
    return {{.shape = world::Cylinder{radius, length}, .chamfer = chamfer, .bores = bores}};
  }
};

struct SphereShape {
  double radius = 1.0;
  [[nodiscard]] std::vector<SolidPart> parts() const { return {{.shape = world::Sphere{radius}}}; }
};

struct CapsuleShape {
  double radius = 1.0, length = 1.0;
  [[nodiscard]] std::vector<SolidPart> parts() const { return {{.shape = world::Capsule{radius, length}}}; }
};

const table::Table<BoxShape>& box_table() {
  static const auto table = [] {
    table::Table<BoxShape> box;
    add_size(box);
    add_bores(box);
    return box;
  }();
  return table;
}

const table::Table<CylinderShape>& cylinder_table() {
  static const auto table = [] {
    table::Table<CylinderShape> cylinder;
    add_radius(cylinder);
    add_length(cylinder);
    add_chamfer(cylinder);
    add_bores(cylinder);
    return cylinder;
  }();
  return table;
}

const table::Table<SphereShape>& sphere_table() {
  static const auto table = [] {
    table::Table<SphereShape> sphere;
    add_radius(sphere);
    return sphere;
  }();
  return table;
}

const table::Table<CapsuleShape>& capsule_table() {
  static const auto table = [] {
    table::Table<CapsuleShape> capsule;
    add_radius(capsule);
    add_length(capsule);
    return capsule;
  }();
  return table;
}

}  // namespace

ShapeKind box_shape() { return shape_kind<BoxShape, box_table>("box", "A box."); }
ShapeKind cylinder_shape() { return shape_kind<CylinderShape, cylinder_table>("cylinder", "A cylinder along z."); }
ShapeKind sphere_shape() { return shape_kind<SphereShape, sphere_table>("sphere", "A sphere."); }
ShapeKind capsule_shape() { return shape_kind<CapsuleShape, capsule_table>("capsule", "A cylinder with round caps."); }

}  // namespace takt::scenario
