// The two halves of a tool changer: what their files say, and within what they couple.
#include "core/device/tool_changer.h"

#include <filesystem>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/kinematics/robot_model.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

namespace fs = std::filesystem;
using takt::test::Reports;
using testing::AllOf;
using Json = nlohmann::ordered_json;

constexpr double kChangerDegree = std::numbers::pi / 180.0;

TEST(ToolChangerFile, ReadsBothHalves) {
  const auto changer = read_tool_changer("models/tool_changer");
  ASSERT_TRUE(changer) << changer.error().to_string();
  EXPECT_EQ((*changer)->size, "tc10");
  EXPECT_EQ((*changer)->tolerance.offset, 0.001);
  EXPECT_EQ((*changer)->tolerance.gap, 0.0015);
  EXPECT_NEAR((*changer)->tolerance.angle, kChangerDegree, 1e-12);
  EXPECT_EQ((*changer)->lock_time, 0.15);
  EXPECT_NEAR((*changer)->X_MC.translation().z(), 0.036, 1e-12);
  const auto side = read_tool_side("models/tool_side");
  ASSERT_TRUE(side) << side.error().to_string();
  EXPECT_EQ((*side)->size, (*changer)->size) << "they fit";
  EXPECT_NEAR((*side)->X_ST.translation().z(), 0.022, 1e-12);
  EXPECT_NEAR((*side)->robot->root().inertial->mass, 0.285, 0.001);
}

/// A copy of a model whose device file is changed.
Diagnostics changed(const std::string& model, const Json& changes, const auto& read) {
  const fs::path folder = fs::path(testing::TempDir()) / "takt_tool_changer" / model;
  fs::remove_all(folder);
  fs::create_directories(folder.parent_path());
  fs::copy("models/" + model, folder, fs::copy_options::recursive);
  Json json = *read_json(folder / "device.json");
  json.merge_patch(changes);
  std::ofstream(folder / "device.json") << json.dump(1);
  const auto description = read(folder);
  return description ? Diagnostics() : description.error();
}

TEST(ToolChangerFile, AllMistakesAreReportedAtOnce) {
  EXPECT_THAT(changed("tool_changer",
                      {{"size", ""}, {"offset_max_m", 0}, {"angle_max_deg", 20}, {"lock_time_s", 60}, {"flange", "no"}},
                      read_tool_changer),
              AllOf(Reports(Code::kMissing, "/size"), Reports(Code::kOutOfRange, "/offset_max_m"),
                    Reports(Code::kOutOfRange, "/angle_max_deg"), Reports(Code::kOutOfRange, "/lock_time_s"),
                    Reports(Code::kUnknownName, "/flange", {"no"})));
  EXPECT_THAT(changed("tool_side", {{"size", nullptr}, {"tcp", "tool"}}, read_tool_side),
              AllOf(Reports(Code::kMissing, "", {"size"}), Reports(Code::kUnknownKey, "/tcp")));
  EXPECT_THAT(changed("tool_side", {{"base", "tool"}}, read_tool_side),
              Reports(Code::kInvalidModel, "/base", {"tool", "plate"}));
}

Eigen::Isometry3d off(const Eigen::Vector3d& p, double angle = 0.0,
                      const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  return Eigen::Translation3d(p) * Eigen::AngleAxisd(angle, axis);
}

TEST(CouplingTolerance, HoldsInACylinderAndWithinAnAngleAboutAnyAxis) {
  const CouplingTolerance tolerance{.offset = 0.001, .gap = 0.002, .angle = kChangerDegree};
  EXPECT_TRUE(tolerance.holds(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(tolerance.holds(off({0.00069, 0.00069, 0.0019})));
  EXPECT_TRUE(tolerance.holds(off({0, 0, -0.0019}))) << "either way";
  EXPECT_FALSE(tolerance.holds(off({0.00072, 0.00072, 0}))) << "across the axis together";
  EXPECT_FALSE(tolerance.holds(off({0, 0, 0.0021})));
  EXPECT_FALSE(tolerance.holds(off({0, 0, -0.0021})));
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 1, 1).normalized()}) {
    EXPECT_TRUE(tolerance.holds(off({0, 0, 0}, 0.98 * kChangerDegree, axis)));
    EXPECT_FALSE(tolerance.holds(off({0, 0, 0}, 1.02 * kChangerDegree, axis)));
    EXPECT_FALSE(tolerance.holds(off({0, 0, 0}, std::numbers::pi, axis))) << "turned about";
  }
}

}  // namespace
}  // namespace takt::device
