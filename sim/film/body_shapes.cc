#include "sim/film/body_shapes.h"

#include <memory>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/film/render_scene.h"
#include "sim/film/renderer.h"

namespace takt::sim {
namespace {

constexpr int kMostGeoms = 20'000;

Eigen::Isometry3f pose_of(const mjData& data, int body) {
  Eigen::Isometry3f X = Eigen::Isometry3f::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * body).cast<float>();
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body).cast<float>();
  return X;
}

BodyShape shape_of(const SceneTriangles& triangles, const SceneGeom& geom, const mjModel& model, const mjData& data) {
  BodyShape shape;
  shape.body = model.geom_bodyid[geom.model_geom];
  const Eigen::Isometry3f X_BW = pose_of(data, shape.body).inverse(Eigen::Isometry);
  const SceneVertex* vertices = triangles.vertices.data() + geom.first_vertex;
  for (std::size_t k = 0; k < 4; ++k) shape.rgba[k] = static_cast<float>(vertices[0].colour[k]) / 255.0F;
  for (std::size_t i = 0; i < geom.shape->vertices.size(); ++i) {
    const Eigen::Vector3f p = X_BW * Eigen::Vector3f(vertices[i].position.data());
    shape.points.push_back({p.x(), p.y(), p.z()});
  }
  shape.indices = geom.shape->indices;
  return shape;
}

}  // namespace

std::vector<BodyShape> body_shapes(const mjModel_* model) {
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model), &mj_deleteData);
  pose_for_drawing(model, data.get());
  mjvScene scene;
  mjv_defaultScene(&scene);
  mjv_makeScene(model, &scene, kMostGeoms);
  const std::unique_ptr<mjvScene, decltype(&mjv_freeScene)> freed(&scene, &mjv_freeScene);
  mjvOption visible;
  mjv_defaultOption(&visible);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  mjv_updateScene(model, data.get(), &visible, nullptr, &camera, mjCAT_STATIC | mjCAT_DYNAMIC, &scene);
  SceneTriangles triangles;
  const ShapeLibrary shapes(model);
  triangles.fill(model, data.get(), scene, shapes);
  std::vector<BodyShape> found;
  for (const SceneGeom& geom : triangles.geoms)
    if (!geom.is_floor && geom.model_geom >= 0) found.push_back(shape_of(triangles, geom, *model, *data));
  return found;
}

}  // namespace takt::sim
