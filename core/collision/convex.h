#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/collision/native_shape.h"
#include "core/kinematics/robot_model.h"
#include "core/world/shape.h"

namespace takt::collision {

/// A convex solid fixed to its own frame S, centred on it: the set of points within `radius` of a box, a disc swept
/// along z, or the hull of points. Immutable; copies share the points. Lengths in m. Thread: any.
class Convex {
 public:
  enum class Kind { kBox, kCylinder, kSphere, kCapsule, kHull };

  /// Realtime: setup.
  [[nodiscard]] static Convex from(const world::Shape& shape);
  /// The convex hull of points, of which at least four must not lie in one plane.
  /// @return the hull, or a diagnostic: too few or flat points, not finite. Realtime: setup.
  [[nodiscard]] static Result<Convex> hull(std::span<const Eigen::Vector3d> points);

  [[nodiscard]] Kind kind() const { return kind_; }
  /// Half of the edges of a box; (radius, radius, half length) of a cylinder or capsule; (radius, ...) of a sphere.
  [[nodiscard]] const Eigen::Vector3d& half() const { return half_; }
  /// Corners of a hull; empty for the other kinds.
  [[nodiscard]] std::span<const Eigen::Vector3d> corners() const;
  /// Triangles of a hull: three indices into corners() each, counter-clockwise seen from outside.
  [[nodiscard]] std::span<const int> triangles() const;

  /// The point of the solid that is furthest along a direction, both in S; the direction need not have unit length.
  /// Realtime: cyclic, O(1), of a hull O(corners).
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const;

  /// A ball and an axis-parallel box in S that hold the solid.
  [[nodiscard]] const Eigen::Vector3d& centre() const { return centre_; }
  [[nodiscard]] double radius() const { return radius_; }
  [[nodiscard]] const Eigen::AlignedBox3d& box() const { return box_; }

  /// The same shape for the narrow phase.
  [[nodiscard]] const NativeShape& native() const { return *native_; }

 private:
  struct Hull {
    std::vector<Eigen::Vector3d> corners;
    std::vector<int> triangles;
  };
  Convex() = default;
  void enclose();

  Kind kind_ = Kind::kSphere;
  Eigen::Vector3d half_ = Eigen::Vector3d::Zero();
  std::shared_ptr<const Hull> hull_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0.0;
  Eigen::AlignedBox3d box_;
  NativeShapePtr native_;
};

/// A solid of a URDF: a primitive, or the convex hull of a mesh, as the simulation has it.
/// @return the solid, or diagnostics: a mesh that cannot be read (mesh.h) or is flat. Realtime: setup.
[[nodiscard]] Result<Convex> convex_of(const kinematics::Shape& shape);

}  // namespace takt::collision
