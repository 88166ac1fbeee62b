#include "sim/world/stage.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/render_fixture.h"

namespace takt::sim {
namespace {

constexpr const char* kBall = R"(<body pos="0 0 0.05"><freejoint/><geom size="0.1"/></body>)";

TEST(Stage, OneLightCastsTheShadow) {
  const StageOptions options;
  const ModelPtr model = compile_scene(kBall, &options);
  int casting = 0;
  for (int i = 0; i < model->nlight; ++i) casting += model->light_castshadow[i] ? 1 : 0;
  EXPECT_EQ(model->nlight, 3);
  EXPECT_EQ(casting, 1);
  EXPECT_DOUBLE_EQ(model->stat.extent, options.radius);
}

TEST(Stage, TheFloorCarriesBodiesOnlyIfAsked) {
  StageOptions options;
  for (const bool collides : {true, false}) {
    options.floor_collides = collides;
    const ModelPtr model = compile_scene(kBall, &options);
    const DataPtr data = posed_data(model.get());
    mj_forward(model.get(), data.get());
    EXPECT_EQ(data->ncon > 0, collides);
  }
  options.floor = false;
  EXPECT_EQ(compile_scene(kBall, &options)->ngeom, 1);
}

}  // namespace
}  // namespace takt::sim
