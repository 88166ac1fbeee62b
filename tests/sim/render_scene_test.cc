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

  SceneTriangles triangles;

 private:
  const mjModel* model_;
  ShapeLibrary shapes_;
  mjvScene scene_{};
};

constexpr const char* kMovingBlock = R"(<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <geom type="box" size=".2 .3 .4" pos="0 0 .5"/></body><geom type="cylinder" size=".1 .4" pos=".3 .2 .4"/>)";

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
