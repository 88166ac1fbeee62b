// Poses that are drawn: frames, which the program knows, mounts and normal deviations, which it does not know.
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "cell/judge/true_poses.h"
#include "core/expression/moving_frames.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::drawn_places_test {
namespace {

using takt::test::Reports;
using test::models;
using test::parsed;
using test::run;

const char* const kCell = R"({"seed": 7,
  "devices": {
    "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}},
    "wrist": {"model": "ft_gamma", "on": "arm"},
    "peg": {"model": "peg8_in_hand", "on": "wrist", "mount": {"rpy_deg": [0, 0, 90]},
            "vary": {"position_m": [0.003, 0, 0.002]}}},
  "frames": {
    "board": {"position_m": [0.6, 0, 1], "vary": {"position_m": [0.05, 0, 0], "rpy_deg": [0, 0, 180]}},
    "beside": {"in": "board", "position_m": [0.1, 0, 0]}},
  "objects": {"block": {"shape": "box", "size_m": [0.05, 0.05, 0.05], "at": {"in": "board"},
                        "vary": {"normal_m": [0.001, 0, 0]}}},
  "program": {"do": "wait", "seconds": 0.01}})";

Description of_seed(std::uint64_t seed) {
  auto description = parse_description(kCell, {}, seed);
  EXPECT_TRUE(description) << description.error().to_string();
  return std::move(*description);
}

TEST(DrawnPlaces, AFrameIsKnownWhereItWasDrawn) {
  double farthest = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Description description = of_seed(seed);
    const FrameEntry& board = description.frames.at(0);
    const Eigen::Vector3d step = board.at.X.translation() - Eigen::Vector3d(0.6, 0, 1);
    EXPECT_LE(std::abs(step.x()), 0.05);
    EXPECT_EQ(step.y(), 0.0);
    farthest = std::max(farthest, std::abs(step.x()));
    EXPECT_TRUE(board.at.X.isApprox(of_seed(seed).frames.at(0).at.X, 0.0)) << "the same seed";
    EXPECT_EQ(description.frames.at(1).at.X.translation().x(), 0.1) << "what does not vary";
  }
  EXPECT_GT(farthest, 0.04);
  Diagnostics warnings;
  const auto built = build_cell(of_seed(3), models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  const auto board = built->cell.frames.pose("board"), beside = built->cell.frames.pose("beside", "board");
  ASSERT_TRUE(board && beside);
  EXPECT_TRUE(board->isApprox(of_seed(3).frames.at(0).at.X, 1e-12));
  EXPECT_NEAR(beside->translation().x(), 0.1, 1e-12) << "it goes with the frame that it stands in";
}

TEST(DrawnPlaces, AMountIsNotWhereTheProgramBelievesItToBe) {
  Diagnostics warnings;
  const Description description = of_seed(7);
  const DeviceEntry& peg = description.devices.at(2);
  const Eigen::Vector3d off = peg.true_mount.translation() - peg.mount.translation();
  EXPECT_GT(off.norm(), 1e-5);
  EXPECT_LE(std::abs(off.x()), 0.003);
  EXPECT_EQ(off.y(), 0.0);
  const auto built = build_cell(of_seed(7), models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  const auto X_FM = built->cell.frames.pose("peg", expression::flange_frame("arm"));
  const auto flange = true_frame(*built, expression::flange_frame("arm")), body = true_frame(*built, "peg");
  ASSERT_TRUE(X_FM && flange && body);
  const Eigen::Isometry3d simulated = built->world->body_pose(built->world->body("peg/mount"));
  EXPECT_TRUE(body->isApprox(simulated, 1e-9)) << "the truth is that of the simulation";
  const Eigen::Isometry3d believed = *flange * *X_FM;
  EXPECT_NEAR((believed.inverse() * simulated).translation().norm(), off.norm(), 1e-9);
  // The centre point of the tool that counts for the arm, and the one that its springs carry.
  const auto tip = true_frame(*built, "peg/tcp");
  ASSERT_TRUE(tip);
  EXPECT_TRUE(tip->isApprox(built->world->body_pose(built->world->body("peg/tcp")), 1e-12));
  EXPECT_TRUE(true_tool(*built, "arm").isApprox(*tip, 1e-6)) << "while its springs rest";
}

TEST(DrawnPlaces, ANormalDeviationHasItsWidthAndLeavesTheRestAsItWas) {
  Variation uniform;
  uniform.position_m << 0.01, 0.02, 0.03;
  uniform.rpy_deg << 1, 2, 3;
  Variation both = uniform;
  both.normal_m << 0.001, 0.0, 0.002;
  constexpr int kSeeds = 4000;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = sum;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Eigen::Isometry3d plain = drawn_pose(Eigen::Isometry3d::Identity(), uniform, seed, "x");
    const Eigen::Isometry3d noisy = drawn_pose(Eigen::Isometry3d::Identity(), both, seed, "x");
    ASSERT_EQ(plain.linear(), noisy.linear());
    const Eigen::Vector3d step = noisy.translation() - plain.translation();
    ASSERT_EQ(step.y(), 0.0);
    sum += step;
    squares += step.cwiseProduct(step);
  }
  for (const int axis : {0, 2}) {
    EXPECT_NEAR(sum[axis] / kSeeds, 0.0, 5 * both.normal_m[axis] / std::sqrt(kSeeds));
    EXPECT_NEAR(std::sqrt(squares[axis] / kSeeds), both.normal_m[axis], 0.06 * both.normal_m[axis]);
  }
}

TEST(DrawnPlaces, WhatStandsByItselfDoesNotVary) {
  const auto refused = parse_description(R"({"devices": {"arm": {"model": "ur5", "at": {}, "vary": {"radius_m": 0.1}}},
    "program": {"do": "wait", "seconds": 1}})");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused, Reports(Code::kMissing, "/devices/arm/vary"));
  const auto negative = parse_description(R"({"frames": {"a": {"vary": {"normal_m": [0, -0.1, 0]}}},
    "program": {"do": "wait", "seconds": 1}})");
  ASSERT_FALSE(negative);
  EXPECT_THAT(negative, Reports(Code::kWrongType, "/frames/a/vary/normal_m/1"));
}

TEST(Duration, OfWhatRunsInTheProgram) {
  const RunReport report = run(parsed(R"({"devices": {"arm": {"model": "ur5", "at": {}}},
    "program": {"do": "sequence", "steps": [
      {"do": "wait", "seconds": 0.3},
      {"do": "sequence", "name": "work", "times": 2, "steps": [{"do": "wait", "seconds": 0.2}]},
      {"do": "branch", "cases": [{"when": "$false", "steps": [{"do": "wait", "name": "never", "seconds": 1}]}]}]},
    "expectations": [
      {"kind": "duration", "below_s": 0.5, "during": "work"}, {"kind": "duration", "below_s": 0.39, "during": "work"},
      {"kind": "duration", "below_s": 0.5}, {"kind": "duration", "below_s": 5, "during": "never"}]})"));
  ASSERT_EQ(report.expectations.size(), 4u);
  EXPECT_TRUE(report.expectations[0].passed) << report.expectations[0].measured;
  EXPECT_NEAR(report.expectations[0].value, 0.4, 0.02);
  EXPECT_FALSE(report.expectations[1].passed);
  EXPECT_FALSE(report.expectations[2].passed) << report.expectations[2].measured;
  EXPECT_FALSE(report.expectations[3].passed) << "it did not run";
}

}  // namespace
}  // namespace takt::cell::drawn_places_test
