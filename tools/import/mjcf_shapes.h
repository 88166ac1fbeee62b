#pragma once

#include <map>
#include <string>

#include <Eigen/Geometry>

#include "tools/import/draft.h"

struct mjModel_;

namespace takt::tools {

/// Numbers as text that is read as the same number again.
[[nodiscard]] std::string exact(double value);
[[nodiscard]] std::string exact(const Eigen::Vector3d& value);

/// A pose as MuJoCo has it: position, quaternion w x y z.
[[nodiscard]] Eigen::Isometry3d pose_at(const double* position, const double* quaternion);
/// The <origin> of an element.
void set_pose(Node& node, const Eigen::Isometry3d& X);

/// The geoms of a compiled model as shapes of links. What MuJoCo shows (groups 0 to 2) is seen, what touches something
/// collides. Meshes go into Draft::meshes as they were compiled. Capsules become a cylinder and two balls, ellipsoids
/// meshes. Realtime: setup.
class MjcfShapes {
 public:
  MjcfShapes(const mjModel_& model, Draft& draft) : model_(model), draft_(draft) {}
  void add(Node& link, int body);
  /// What belongs to no body.
  void note_world() const;

 private:
  void add_shape(Node& link, int geom, bool seen);
  [[nodiscard]] std::string mesh_of(int geom);
  [[nodiscard]] std::string ellipsoid(const Eigen::Vector3d& radii, int geom);
  [[nodiscard]] std::string colour(int geom) const;

  const mjModel_& model_;
  Draft& draft_;
  std::map<int, std::string> meshes_;  ///< by number: name in Draft::meshes
};

}  // namespace takt::tools
