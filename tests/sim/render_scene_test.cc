#include "sim/film/render_scene.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "tests/sim/render_fixture.h"

namespace takt::sim {
namespace {

/// The abstract scene of a model, as the renderer sees it.
class SceneOf {
 public:
  explicit SceneOf(const mjModel* model) : model_(model), shapes_(model) {
    mjv_defaultScene(&scene_);
    mjv_makeScene(model, &scene_, 100);
  }
  ~SceneOf() { mjv_freeScene(&scene_); }
  SceneOf(const SceneOf&) = delete;
  SceneOf& operator=(const SceneOf&) = delete;

  ShadowView shadow(mjData* data) {
    mjvOption option;
    mjv_defaultOption(&option);
    mjvCamera camera;
    mjv_defaultCamera(&camera);
    pose_for_drawing(model_, data);
    mjv_updateScene(model_, data, &option, nullptr, &camera, mjCAT_ALL, &scene_);
    triangles.fill(model_, data, scene_, shapes_);
    return shadow_view(scene_, triangles, {0, 0, 0.6f}, 2.5f, 1, 2048);
  }

  /// The scene as a camera of the model sees it.
  const mjvScene& seen_from(mjData* data, int camera_id) {
    mjvOption option;
    mjv_defaultOption(&option);
    mjvCamera camera;
    mjv_defaultCamera(&camera);
    camera.type = mjCAMERA_FIXED;
    camera.fixedcamid = camera_id;
    mjv_updateScene(model_, data, &option, nullptr, &camera, mjCAT_ALL, &scene_);
    return scene_;
  }

  SceneTriangles triangles;

 private:
  const mjModel* model_;
  ShapeLibrary shapes_;
  mjvScene scene_{};
};

constexpr const char* kMovingBlock = R"(<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <geom type="box" size=".2 .3 .4" pos="0 0 .5"/></body><geom type="cylinder" size=".1 .4" pos=".3 .2 .4"/>)";

TEST(CanBeSeen, IsFalseOnlyWhereNoCornerIsInTheView) {
  Random random(11);
  const ModelPtr model = compile_scene(std::string(kFrontCamera) + R"(<body><joint type="slide" axis="1 0 0"/>
    <joint type="slide" axis="0 1 0"/><joint type="slide" axis="0 0 1"/><geom type="box" size=".2 .3 .4"/></body>)");
  const DataPtr data = posed_data(model.get());
  SceneOf scene(model.get());
  int hidden = 0;
  for (int i = 0; i < 300; ++i) {
    for (int axis = 0; axis < 3; ++axis) data->qpos[axis] = random.uniform(-6, 6);
    (void)scene.shadow(data.get());
    const Eigen::Matrix4f view = camera_view(scene.seen_from(data.get(), 0), 1.5f);
    const SceneGeom& box = scene.triangles.geoms.front();
    bool inside = false;
    for (std::size_t v = 0; v < box.shape->vertices.size(); ++v) {
      const auto& p = scene.triangles.vertices[box.first_vertex + v].position;
      EXPECT_TRUE(box.bounds.contains(Eigen::Vector3f(p[0], p[1], p[2])));
      const Eigen::Vector4f clip = view * Eigen::Vector4f(p[0], p[1], p[2], 1);
      inside = inside || clip.head<3>().cwiseAbs().maxCoeff() <= clip.w();
    }
    if (!can_be_seen(box, view)) ++hidden;
    EXPECT_TRUE(!inside || can_be_seen(box, view));
  }
  EXPECT_GT(hidden, 100);
}

TEST(ShadowView, HoldsEveryCasterOfTheStage) {
  StageOptions stage;
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    stage.key_light = {random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), -1};
    const ModelPtr model = compile_scene(kMovingBlock, &stage);
    const DataPtr data = posed_data(model.get());
    for (int axis = 0; axis < 2; ++axis) data->qpos[axis] = random.uniform(-1, 1);
    SceneOf scene(model.get());
    const ShadowView view = scene.shadow(data.get());
    EXPECT_LE(view.width, 5.0f);
    for (const SceneGeom& geom : scene.triangles.geoms) {
      if (!geom.casts_shadow) continue;
      for (std::size_t v = 0; v < geom.shape->vertices.size(); ++v) {
        const auto& p = scene.triangles.vertices[geom.first_vertex + v].position;
        const Eigen::Vector4f clip = view.clip_from_world * Eigen::Vector4f(p[0], p[1], p[2], 1);
        ASSERT_LE(clip.head<3>().cwiseAbs().maxCoeff(), 1.0f);
      }
    }
  }
}

TEST(ShadowView, MovesInFewStepsWhileACasterMoves) {
  const StageOptions stage;
  const ModelPtr model = compile_scene(kMovingBlock, &stage);
  const DataPtr data = posed_data(model.get());
  SceneOf scene(model.get());
  int changes = 0;
  Eigen::Matrix4f last = scene.shadow(data.get()).clip_from_world;
  for (int i = 1; i <= 1000; ++i) {
    data->qpos[0] = 0.001 * i;
    const Eigen::Matrix4f now = scene.shadow(data.get()).clip_from_world;
    changes += now != last ? 1 : 0;
    last = now;
  }
  EXPECT_GT(changes, 0);
  EXPECT_LT(changes, 20);
}

}  // namespace
}  // namespace takt::sim
