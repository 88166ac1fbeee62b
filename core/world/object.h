#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/world/bore.h"
#include "core/world/shape.h"

namespace takt::world {

/// Mass, centre of mass and inertia of a rigid body, as seen from some frame O. Mass 0: not known.
struct MassProperties {
  double mass = 0.0;                               ///< kg
  Eigen::Vector3d p_OC = Eigen::Vector3d::Zero();  ///< centre of mass in O, m
  Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();   ///< about the centre of mass, axes of O, kg m^2
};

/// The same body seen from frame A. Realtime: setup.
[[nodiscard]] MassProperties transform(const Eigen::Isometry3d& X_AO, const MassProperties& body);
/// Two bodies of one frame as one. Realtime: setup.
[[nodiscard]] MassProperties combine(const MassProperties& a, const MassProperties& b);

/// A physical object as the application knows it: one or several shapes fixed to its frame O.
struct Object {
  struct Part {
    Shape shape;
    Eigen::Isometry3d X_OS = Eigen::Isometry3d::Identity();
    double chamfer = 0.0;          ///< m, at 45 degrees, of both ends of a cylinder
    std::vector<Bore> bores = {};  ///< in a box or a cylinder
  };
  std::string name;
  std::vector<Part> parts;
  MassProperties mass = {};                                           ///< in its frame O
  std::map<std::string, Eigen::Isometry3d, std::less<>> grasps = {};  ///< X_OG by name, m; frame "OBJECT/GRASP"
  bool fixed = false;                                                 ///< it belongs to the cell: no gripper takes it
};

/// Signed distance to the union of the parts (exact outside, but beside the rim of a bore), m. The point is in object
/// frame O; infinite without parts.
[[nodiscard]] double signed_distance(const Object& object, const Eigen::Vector3d& p_O);

/// Volume of a part with its chamfers and bores, m^3. Realtime: setup.
[[nodiscard]] double volume(const Object::Part& part);

/// Mass properties of shapes of one density, a mass spread over them by their volumes. Realtime: setup.
/// @param mass  kg, of all parts   @param masses  of each part, kg; empty: by volume
[[nodiscard]] MassProperties spread_mass(const std::vector<Object::Part>& parts, double mass,
                                         const std::vector<double>& masses = {});

/// Points on the surface of an object in its frame O, m: corners of boxes, points on the rims of cylinders and on the
/// axes of spheres. What lies on a plane, or in a container, touches it with some of them.
[[nodiscard]] std::vector<Eigen::Vector3d> outline(const Object& object);

}  // namespace takt::world
