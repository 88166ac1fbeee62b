#include "cell/run/scene_message.h"

#include <map>

#include <mujoco/mujoco.h>

#include "foxglove/SceneUpdate.pb.h"
#include "sim/film/body_shapes.h"

namespace takt::cell {
namespace {

constexpr std::size_t kMostBytes = std::size_t{16} << 20;  ///< half of what a chunk of a recording may hold

void put(const sim::BodyShape& shape, foxglove::TriangleListPrimitive& triangles) {
  triangles.mutable_pose()->mutable_orientation()->set_w(1.0);
  foxglove::Color& colour = *triangles.mutable_color();
  colour.set_r(shape.rgba[0]);
  colour.set_g(shape.rgba[1]);
  colour.set_b(shape.rgba[2]);
  colour.set_a(shape.rgba[3]);
  for (const auto& point : shape.points) {
    foxglove::Point3& p = *triangles.add_points();
    p.set_x(point[0]);
    p.set_y(point[1]);
    p.set_z(point[2]);
  }
  triangles.mutable_indices()->Add(shape.indices.begin(), shape.indices.end());
}

}  // namespace

std::string scene_message(const mjModel_& model) {
  foxglove::SceneUpdate scene;
  std::map<int, foxglove::SceneEntity*> entities;
  for (const sim::BodyShape& shape : sim::body_shapes(&model)) {
    foxglove::SceneEntity*& entity = entities[shape.body];
    if (entity == nullptr) {
      const char* name = shape.body > 0 ? mj_id2name(&model, mjOBJ_BODY, shape.body) : nullptr;
      entity = scene.add_entities();
      entity->mutable_timestamp();
      entity->set_id(name != nullptr ? name : "world");
      entity->set_frame_id(entity->id());
      entity->set_frame_locked(true);
    }
    put(shape, *entity->add_triangles());
  }
  std::string message = scene.SerializeAsString();
  return message.size() <= kMostBytes ? message : std::string();
}

}  // namespace takt::cell
