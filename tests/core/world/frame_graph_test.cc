#include "core/world/frame_graph.h"
#include "tests/support/reports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::world {
namespace {

using takt::test::Reports;

Eigen::Isometry3d at(double x, double y, double z, double yaw = 0) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  X.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return X;
}

TEST(FrameGraph, PosesBetweenAnyTwoFrames) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("table", "world", at(1, 0, 0.5, M_PI / 2)).empty());
  ASSERT_TRUE(graph.add("block", "table", at(0.2, 0, 0)).empty());
  ASSERT_TRUE(graph.add("robot", "world", at(0, 1, 0)).empty());
  const auto X = graph.pose("block", "robot");
  ASSERT_TRUE(X.has_value());
  EXPECT_TRUE(X->translation().isApprox(Eigen::Vector3d(1, -0.8, 0.5), 1e-12));
}

TEST(FrameGraph, AMeasuredRelationReplacesTheOldOne) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("a", "world", at(0, 0, 0)).empty());
  ASSERT_TRUE(graph.add("b", "a", at(1, 0, 0)).empty());
  ASSERT_TRUE(graph.set("a", "world", at(0, 0, 2)).empty());
  EXPECT_NEAR(graph.pose("b")->translation().z(), 2.0, 1e-15);
}

TEST(FrameGraph, RefusesUnknownDoubleAndCircularFrames) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("table", "world", at(0, 0, 0)).empty());
  ASSERT_TRUE(graph.add("block", "table", at(0, 0, 0)).empty());
  EXPECT_THAT(graph.add("table", "world", at(0, 0, 0)), Reports(Code::kDuplicate, ""));
  EXPECT_THAT(graph.add("x", "tabel", at(0, 0, 0)), Reports(Code::kUnknownName, "", {"table"}));
  EXPECT_THAT(graph.set("table", "block", at(0, 0, 0)), Reports(Code::kInvalidValue, ""));
  EXPECT_TRUE(graph.set("table", "table", at(0, 0, 0)).has_errors());
  EXPECT_TRUE(graph.set("n", "world", at(NAN, 0, 0)).has_errors());
  EXPECT_FALSE(graph.pose("nothing").has_value());
}

TEST(FrameGraph, MovingFramesHaveNoConstantPoseButWhatHangsOnThemHas) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("arm", "world", at(1, 0, 0)).empty());
  ASSERT_TRUE(graph.set("flange", {.kind = Relation::Kind::kFlange, .parent = "arm", .source = "arm"}).empty());
  ASSERT_TRUE(graph.add("tool", "flange", at(0, 0, 0.1)).empty());
  ASSERT_TRUE(graph.add("camera", "flange", at(0.05, 0, 0)).empty());
  EXPECT_THAT(graph.pose("tool").error(), Reports(Code::kInvalidValue, "", {"flange", "arm"}));
  EXPECT_TRUE(graph.pose("tool", "camera")->translation().isApprox(Eigen::Vector3d(-0.05, 0, 0.1), 1e-15));
  EXPECT_THAT(graph.set("x", {.kind = Relation::Kind::kChannel, .parent = "arm"}), Reports(Code::kMissing, ""));
}

/// Where an arm's links are is asked when a pose is, also of copies.
TEST(FrameGraph, FramesOnAnArmGoWithItsLinks) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("arm", "world", at(1, 0, 0)).empty());
  const auto riding = [](Relation::Kind kind, const Eigen::Isometry3d& X, const char* link) {
    return Relation{.kind = kind, .parent = "arm", .X_PF = X, .source = "arm", .link = link};
  };
  ASSERT_TRUE(graph.set("tool", riding(Relation::Kind::kFlange, at(0, 0, 0.1), "")).empty());
  ASSERT_TRUE(graph.set("camera", riding(Relation::Kind::kLink, at(0, 0.2, 0), "elbow")).empty());
  EXPECT_FALSE(graph.pose("tool").has_value()) << "nobody has looked";
  int asked = 0;
  graph.update_arm_frames("arm", [&](const std::string& link) -> std::optional<Eigen::Isometry3d> {
    ++asked;
    return link.empty() ? std::optional(at(0, 0, 1)) : std::nullopt;
  });
  EXPECT_EQ(asked, 0);
  EXPECT_TRUE(graph.pose("tool")->translation().isApprox(Eigen::Vector3d(1, 0, 1.1), 1e-12));
  EXPECT_EQ(asked, 1);
  EXPECT_FALSE(graph.pose("camera").has_value()) << "this link is not known";
  FrameGraph copy = graph;
  copy.update_arm_frames("arm", [](const std::string&) { return std::optional(at(0, 0, 2)); });
  EXPECT_TRUE(copy.pose("camera")->translation().isApprox(Eigen::Vector3d(1, 0.2, 2), 1e-12));
  EXPECT_NEAR(graph.pose("tool")->translation().z(), 1.1, 1e-12);
}

TEST(FrameGraph, WhatDependsOnAFrameThatIsTakenAwayStaysWhereItIs) {
  FrameGraph graph;
  const auto estimate = [](const std::string& parent, const Eigen::Isometry3d& X) {
    return Relation{.kind = Relation::Kind::kEstimate, .parent = parent, .X_PF = X};
  };
  ASSERT_TRUE(graph.add("table", "world", at(1, 0, 0.5, 0.3)).empty());
  ASSERT_TRUE(graph.set("here", estimate("table", at(0.2, 0, 0, 0.4))).empty());
  ASSERT_TRUE(graph.set("part", estimate("here", at(0, 0.1, 0, 0.1))).empty());
  const Eigen::Isometry3d before = *graph.pose("part");
  const std::uint64_t changes = graph.changes();
  EXPECT_TRUE(graph.remove("here"));
  EXPECT_FALSE(graph.contains("here"));
  EXPECT_GT(graph.changes(), changes);
  EXPECT_EQ(graph.relation("part")->parent, "table");
  EXPECT_TRUE(graph.pose("part")->isApprox(before, 1e-12));
  ASSERT_TRUE(graph.set("table", "world", at(0, 0, 2)).empty());
  EXPECT_NEAR(graph.pose("part")->translation().z(), 2.0, 1e-12) << "it goes with what is left";
  EXPECT_FALSE(graph.remove("here"));
  EXPECT_FALSE(graph.remove("table")) << "no step has made it";
  EXPECT_TRUE(graph.contains("table"));
}

TEST(FrameGraph, ALostFrameHasNoPoseAndNothingThatDependsOnItHas) {
  FrameGraph graph;
  ASSERT_TRUE(graph.add("box", "world", at(1, 0, 0)).empty());
  ASSERT_TRUE(graph.add("part", "box", at(0, 0, 0.1)).empty());
  const auto before = graph.changes();
  ASSERT_TRUE(graph.set("box", {.kind = Relation::Kind::kUnknown, .parent = "world"}).empty());
  EXPECT_GT(graph.changes(), before);
  EXPECT_THAT(graph.pose("part").error(), Reports(Code::kUnknownPose, "", {"box"}));
  EXPECT_TRUE(graph.pose("part", "box").has_value()) << "in the box it is where it was";
  ASSERT_TRUE(graph.set("box", "world", at(0, 0, 1)).empty());
  EXPECT_NEAR(graph.pose("part")->translation().z(), 1.1, 1e-15) << "found again";
}

}  // namespace
}  // namespace takt::world
