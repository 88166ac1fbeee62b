// What viewers of recordings show of a cell.
#include "cell/run/scene_message.h"

#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "foxglove/SceneUpdate.pb.h"
#include "tests/cell/described.h"

namespace takt::cell::scene_test {
namespace {

TEST(SceneMessage, HasEveryBodyInItsOwnFrame) {
  Diagnostics warnings;
  const auto built = build_cell(test::parsed(R"({"devices": {"arm": {"model": "ur5", "at": {"position_m": [3, 0, 0]}}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.2, 0.1], "fixed": false, "rgba": [1, 0.2, 0, 1],
                          "at": {"position_m": [0, 0, 0.5], "rpy_deg": [0, 0, 45]}}},
    "program": {"do": "sequence", "steps": [{"do": "wait", "seconds": 1}]}})"),
                                test::models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  foxglove::SceneUpdate scene;
  ASSERT_TRUE(scene.ParseFromString(scene_message(*built->world->model())));
  std::map<std::string, const foxglove::SceneEntity*> entities;
  for (const auto& entity : scene.entities()) entities[entity.id()] = &entity;
  EXPECT_TRUE(entities.contains("arm/wrist_3_link") || entities.size() > 6) << entities.size();
  ASSERT_TRUE(entities.contains("block"));
  const foxglove::SceneEntity& block = *entities.at("block");
  EXPECT_EQ(block.frame_id(), "block");
  EXPECT_TRUE(block.frame_locked());
  ASSERT_EQ(block.triangles_size(), 1);
  EXPECT_EQ(block.triangles(0).indices_size(), 36);
  EXPECT_NEAR(block.triangles(0).color().r(), 1.0, 0.01);
  EXPECT_NEAR(block.triangles(0).color().g(), 0.2, 0.01);
  double most = 0, least = std::numeric_limits<double>::max();
  for (const auto& point : block.triangles(0).points()) {
    most = std::max({most, std::abs(point.x() - 0.2 * (point.x() > 0 ? 1 : -1)), std::abs(std::abs(point.y()) - 0.1)});
    least = std::min(least, std::abs(point.z()));
  }
  EXPECT_LT(most, 1e-6) << "in the frame of the block, not of the world";
  EXPECT_NEAR(least, 0.05, 1e-6);
}

}  // namespace
}  // namespace takt::cell::scene_test
