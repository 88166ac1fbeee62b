#include "sim/film/render_marks.h"

#include <algorithm>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {
namespace {

using Eigen::Vector3d;
using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr float kGhostOpacity = 0.32F;
constexpr std::array<float, 3> kGhostTint = {0.25F, 0.55F, 0.95F};
constexpr float kOwnLight = 0.55F;  // marks are read in the shadow too

Vector3d vector_of(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

void append(const Mark& mark, mjvScene& scene) {
  const Vector3d from = vector_of(mark.from), along = vector_of(mark.to) - from;
  const double length = along.norm();
  if (scene.ngeom >= scene.maxgeom || !(length > 1e-6)) return;
  const bool arrow = mark.shape == Mark::Shape::kArrow;
  const RowMatrix axes = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along).toRotationMatrix();
  // An arrow begins at its position; a rod is a box about its centre, the shape of the fewest triangles.
  const Vector3d at = arrow ? from : Vector3d(from + along / 2);
  const std::array<double, 3> size = {mark.radius, mark.radius, arrow ? length : length / 2};
  mjvGeom& geom = scene.geoms[scene.ngeom++];
  mjv_initGeom(&geom, arrow ? mjGEOM_ARROW : mjGEOM_BOX, size.data(), at.data(), axes.data(), mark.rgba.data());
  geom.category = mjCAT_DECOR;
  geom.objtype = mjOBJ_UNKNOWN;
  geom.objid = -1;
  geom.segid = mark.on_top ? kOnTopSegment : -1;
  geom.emission = kOwnLight;
  geom.specular = geom.shininess = 0;
}

void make_ghost(mjvGeom& geom) {
  for (std::size_t i = 0; i < 3; ++i) geom.rgba[i] = 0.35F * geom.rgba[i] + 0.65F * kGhostTint[i];
  geom.rgba[3] = kGhostOpacity;
  geom.category = mjCAT_DECOR;
}

}  // namespace

void append_shapes(const Marks& marks, mjvScene_& scene) {
  for (const Mark& mark : marks.shapes) append(mark, scene);
}

void append_ghost(const mjModel_& model, mjData_& posed, const Ghost& ghost, const mjvOption_& visible,
                  mjvScene_& scene) {
  const int first = scene.ngeom;
  mjv_addGeoms(&model, &posed, &visible, nullptr, mjCAT_DYNAMIC, &scene);
  const auto shown = [&](const mjvGeom& geom) {
    if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) return false;
    const auto body = static_cast<std::size_t>(model.geom_bodyid[geom.objid]);
    return body < ghost.bodies.size() && ghost.bodies[body];
  };
  mjvGeom* begin = scene.geoms + first;
  mjvGeom* end = std::stable_partition(begin, scene.geoms + scene.ngeom, shown);
  std::for_each(begin, end, make_ghost);
  scene.ngeom = static_cast<int>(end - scene.geoms);
}

}  // namespace takt::sim
