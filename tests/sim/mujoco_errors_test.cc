#include "sim/model/mujoco_errors.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/render_fixture.h"

namespace takt::sim {
namespace {

TEST(MujocoErrors, AnErrorDeepInsideMujocoBecomesAFindingAndTheProcessLives) {
  const ModelPtr model = compile_scene(R"(<geom size="1"/>)");
  const DataPtr data = posed_data(model.get());
  mjtNum state[8] = {};
  const Result<void> result = mujoco_call("/cell", [&] { mj_getState(model.get(), data.get(), state, 1u << 30); });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().list().front().pointer, "/cell");
  EXPECT_TRUE(result.error().to_string().find("MuJoCo: ") != std::string::npos);
  EXPECT_TRUE(mujoco_call("", [&] { mj_step(model.get(), data.get()); }));
}

TEST(MujocoErrors, ValuesPassThrough) {
  EXPECT_EQ(mujoco_call("", [] { return 7; }).value(), 7);
}

TEST(MujocoErrors, WarningsAreCountedAndTheLastOneIsKept) {
  install_mujoco_handlers();
  const auto before = mujoco_warnings().count;
  mju_warning("the torque is %d Nm", 42);
  EXPECT_EQ(mujoco_warnings().count, before + 1);
  EXPECT_EQ(mujoco_warnings().last, "the torque is 42 Nm");
}

}  // namespace
}  // namespace takt::sim
