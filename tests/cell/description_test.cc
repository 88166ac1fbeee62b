#include "cell/file/description.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/reports.h"

namespace takt::cell::description_test {
namespace {

using takt::test::Reports;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> pointers(const Diagnostics& diagnostics) {
  std::vector<std::string> pointers;
  for (const Diagnostic& diagnostic : diagnostics.list()) pointers.push_back(diagnostic.pointer);
  return pointers;
}

constexpr const char* kSmall =
    R"({"seed": 3, "devices": {"arm": {"model": "lwr4plus", "start_deg": [90, 0, 0, 0, 0, 0, 0]}},
  "program": {"do": "wait", "seconds": 1}})";

TEST(Description, AllErrorsAreFoundAtOnceWhereTheyStand) {
  const auto description = parse_description(R"({
    "seed": -1, "timelimit_s": 3,
    "frames": {"a": {"position_m": [0, 0]}, "x/y": {}, "world": {}},
    "devices": {"arm": {"modell": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm", "at": {}}},
    "objects": {"a": {"shape": "box", "size_m": [1, 1, 0], "at": {}}},
    "cameras": {"c": {"at": {}, "look_at": {}}},
    "film": {"camera": "cc", "cuts": [{"step": "s", "camera": "d"}]},
    "expectations": [3]
  })");
  ASSERT_FALSE(description.has_value());
  EXPECT_THAT(pointers(description.error()),
              testing::UnorderedElementsAre("/seed", "/timelimit_s", "/frames/a/position_m", "/frames/x~1y",
                                            "/frames/world", "/devices/arm", "/devices/arm/modell", "/devices/wrist/on",
                                            "/objects/a/size_m/2", "/cameras/c/look_at", "", "/expectations/0",
                                            "/objects/a", "/film/camera", "/film/cuts/0/camera"));
  EXPECT_THAT(description.error(), AllOf(Reports(Code::kUnknownKey, "/timelimit_s", {"time_limit_s"}),
                                         Reports(Code::kUnknownKey, "/devices/arm/modell", {"model"}),
                                         Reports(Code::kMissing, "", {"program"}),
                                         Reports(Code::kUnknownName, "/film/camera", {"cc", "c"})));
}

TEST(Description, WhatIsNoJsonIsAFindingToo) {
  EXPECT_FALSE(parse_description("").has_value());
  EXPECT_FALSE(parse_description("{").has_value());
  EXPECT_FALSE(parse_description("[]").has_value());
  EXPECT_FALSE(read_description("no/such/file.json").has_value());
}

TEST(Description, OverridesReplaceBeforeTheFileIsChecked) {
  const auto changed = parse_description(kSmall, {{"/devices/arm/model", "other"},     // a text, without quotes
                                                  {"/devices/arm/start_deg/0", "45"},  // JSON
                                                  {"/program_latency_cycles", "7"}});  // a key that was not there
  ASSERT_TRUE(changed.has_value()) << changed.error().to_string();
  EXPECT_EQ(changed->devices[0].model, "other");
  EXPECT_NEAR(changed->devices[0].start_rad[0], std::numbers::pi / 4, 1e-15);
  EXPECT_EQ(changed->program_latency_cycles, 7);
  EXPECT_THAT(changed->text, HasSubstr("other")) << "what a recording carries is what was run";
  EXPECT_TRUE(parse_description(changed->text).has_value());
}

TEST(Description, OverridesOfNothingAreRefused) {
  const auto wrong = parse_description(
      kSmall, {{"/robots/arm/model", "x"}, {"devices", "1"}, {"", "{}"}, {"/devices/arm/modle", "x"}});
  ASSERT_FALSE(wrong.has_value());
  EXPECT_THAT(pointers(wrong.error()), ElementsAre("/robots/arm/model", "devices", "", "/devices/arm/modle"));
}

TEST(Description, TheSeedFromOutsideWins) {
  EXPECT_EQ(parse_description(kSmall)->seed, 3u);
  EXPECT_EQ(parse_description(kSmall, {}, 9)->seed, 9u);
}

// -- Drawn places --------------------------------------------------------------------------------------------------

ObjectEntry varied() {
  ObjectEntry object;
  object.name = "block";
  object.at.X.translation() << 0.5, 0.1, 0.2;
  object.at.X.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return object;
}

TEST(DrawnPose, D5_DependsOnSeedAndNameAlone) {
  const auto read = [](const std::string& more) {
    const auto description = parse_description(R"({"objects": {)" + more +
                                               R"("block": {"shape": "sphere", "radius_m": 1, "at": {},
        "vary": {"radius_m": 0.1, "position_m": [0.1, 0, 0.2], "rpy_deg": [1, 2, 3]}}},
        "program": {"do": "wait", "seconds": 1}})");
    EXPECT_TRUE(description.has_value());
    return description->objects.back();
  };
  const auto alone = read("");
  const auto beside = read(R"("other": {"shape": "sphere", "radius_m": 1, "at": {}, "vary": {"radius_m": 0.1}},)");
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    EXPECT_EQ(drawn_pose(alone, seed).matrix(), drawn_pose(beside, seed).matrix());
    EXPECT_NE(drawn_pose(alone, seed).matrix(), drawn_pose(alone, seed + 1).matrix());
  }
  auto renamed = alone;
  renamed.name = "brick";
  EXPECT_NE(drawn_pose(alone, 1).matrix(), drawn_pose(renamed, 1).matrix());
}

TEST(DrawnPose, WithoutVariationItIsTheNominalPose) {
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    EXPECT_TRUE(drawn_pose(varied(), seed).isApprox(varied().at.X, 1e-15));
}

/// Uniform in a disc: a quarter of all within half of the radius, as many in each quadrant.
TEST(DrawnPose, TheRadiusIsADisc) {
  ObjectEntry object = varied();
  object.vary.radius_m = 0.015;
  int inner = 0;
  std::array<int, 4> quadrants{};
  constexpr int kSeeds = 10'000;
  double farthest = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Eigen::Isometry3d X = drawn_pose(object, seed);
    const Eigen::Vector3d step = X.translation() - object.at.X.translation();
    ASSERT_NEAR(step.z(), 0.0, 1e-15);
    ASSERT_LE(step.norm(), 0.015 + 1e-12);
    ASSERT_TRUE(X.linear().isApprox(object.at.X.linear(), 1e-12));
    farthest = std::max(farthest, step.norm());
    inner += step.norm() < 0.0075;
    ++quadrants[(step.x() > 0 ? 1u : 0u) + (step.y() > 0 ? 2u : 0u)];
  }
  EXPECT_GT(farthest, 0.0149);
  EXPECT_NEAR(inner, kSeeds / 4, 5 * std::sqrt(kSeeds * 3.0 / 16)) << "five standard deviations";
  for (const int count : quadrants) EXPECT_NEAR(count, kSeeds / 4, 5 * std::sqrt(kSeeds * 3.0 / 16));
}

TEST(DrawnPose, EveryCoordinateStaysInItsBoundsAndComesNearThem) {
  ObjectEntry object = varied();
  object.vary.position_m << 0.01, 0.02, 0.03;
  object.vary.rpy_deg << 0, 0, 5;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1), high = -low;
  double least = 1, most = -1;
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) {
    const Eigen::Isometry3d X = drawn_pose(object, seed);
    const Eigen::Vector3d step = X.translation() - object.at.X.translation();
    low = low.cwiseMin(step);
    high = high.cwiseMax(step);
    const Eigen::Matrix3d R = object.at.X.linear().transpose() * X.linear();
    ASSERT_NEAR(R(2, 2), 1.0, 1e-12) << "only about z";
    least = std::min(least, std::atan2(R(1, 0), R(0, 0)));
    most = std::max(most, std::atan2(R(1, 0), R(0, 0)));
  }
  const double bound = 5 * std::numbers::pi / 180;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(high[axis], object.vary.position_m[axis] + 1e-12);
    EXPECT_GE(low[axis], -object.vary.position_m[axis] - 1e-12);
    EXPECT_GT(high[axis], 0.99 * object.vary.position_m[axis]);
    EXPECT_LT(low[axis], -0.99 * object.vary.position_m[axis]);
  }
  EXPECT_LE(most, bound + 1e-12);
  EXPECT_GE(least, -bound - 1e-12);
  EXPECT_GT(most, 0.99 * bound);
  EXPECT_LT(least, -0.99 * bound);
}

}  // namespace
}  // namespace takt::cell::description_test
