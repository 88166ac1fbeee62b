#include "core/operations/table/goal.h"

#include <numbers>

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using device::JointVector;
using takt::test::Reports;
using testing::ElementsAre;

constexpr double kDegree = std::numbers::pi / 180.0;

class GoalTest : public test::ActivityTest {
 protected:
  Goal read(const std::string& to, Diagnostics& into) const {
    const auto json = test::Json::parse(R"({"to": )" + to + "}");
    ObjectReader reader(json, "/step", into);
    return read_goal(reader, &fake.cell.arms.at("arm"));
  }
  std::vector<std::string> wrong(const std::string& to) const {
    Diagnostics found;
    (void)read(to, found);
    return pointers(found);
  }
  ResolvedGoal resolved(const std::string& to) const {
    Diagnostics found;
    const Goal goal = read(to, found);
    EXPECT_EQ(found.to_string(), "");
    auto result = resolve(goal, fake.cell, "arm", q);
    if (!result) ADD_FAILURE() << result.error().to_string();
    return result.value_or(ResolvedGoal{});
  }
  JointVector joints(const std::string& to) const { return std::get<JointVector>(resolved(to)); }
  Eigen::Isometry3d pose(const std::string& to) const { return std::get<Eigen::Isometry3d>(resolved(to)); }
  Eigen::Isometry3d X_BT() const { return tool_pose(fake.cell.arms.at("arm"), q); }

  JointVector q = (JointVector(7) << 0.1, -0.4, 0.2, 1.4, 0.1, -1.0, 0.3).finished();
};

TEST_F(GoalTest, HomeAndJoints) {
  EXPECT_EQ(joints("\"home\""), fake.arm->home);
  const JointVector q_goal = joints(R"({"joints_deg": [10, -20, 30, 40, -50, 60, -70]})");
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(q_goal[i], kDegree * (std::array{10, -20, 30, 40, -50, 60, -70}[i]), 1e-15);
}

TEST_F(GoalTest, HomeAndJointsMayBeAbsolute) {
  EXPECT_EQ(joints(R"({"home": true})"), fake.arm->home);
  EXPECT_EQ(joints(R"({"home": true, "absolute": true})"), fake.arm->home);
  const std::string degrees = R"("joints_deg": [10, -20, 30, 40, -50, 60, -70])";
  EXPECT_EQ(joints("{" + degrees + R"(, "absolute": true})"), joints("{" + degrees + "}"))
      << "joints with limits have one turn each";
  EXPECT_THAT(wrong(R"({"home": false})"), ElementsAre("/step/to/home"));
  EXPECT_THAT(wrong(R"({"by_m": [0, 0, 0.1], "absolute": true})"), ElementsAre("/step/to/absolute"));
}

TEST_F(GoalTest, APoseIsGivenInAFrameAndReachedInTheArmsBase) {
  const auto X = pose(R"({"in": "block", "position_m": [0.01, 0.02, 0.1], "rpy_deg": [180, 0, 90]})");
  const Eigen::Isometry3d X_WT = fake.X_WB * X;
  const Eigen::Vector3d wanted = *fake.cell.frames.pose("block") * Eigen::Vector3d(0.01, 0.02, 0.1);
  EXPECT_LT((X_WT.translation() - wanted).norm(), 1e-12);
  EXPECT_LT((X_WT.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 1e-12) << "the tool points down";
  EXPECT_LT((X_WT.linear().col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-12) << "rpy turns x to y";
  const auto same = pose(R"({"in": "block", "position_m": [0.01, 0.02, 0.1], "quaternion": [0, 0.7071067811865476,
      0.7071067811865476, 0]})");
  EXPECT_TRUE(same.isApprox(X, 1e-9));
}

TEST_F(GoalTest, WithoutOrientationThatOfTheToolIsKept) {
  const auto X = pose(R"({"in": "block", "position_m": [0, 0, 0.1]})");
  EXPECT_TRUE(X.linear().isApprox(X_BT().linear(), 1e-12));
}

TEST_F(GoalTest, StepsGoAlongTheAxesOfAFrame) {
  const auto world = pose(R"({"by_m": [0.1, 0.02, -0.03]})");
  EXPECT_LT(
      (fake.X_WB * world.translation() - fake.X_WB * X_BT().translation() - Eigen::Vector3d(0.1, 0.02, -0.03)).norm(),
      1e-12)
      << "the world by default, not the base, which is turned";
  EXPECT_TRUE(world.linear().isApprox(X_BT().linear(), 1e-12));
  const auto base = pose(R"({"by_m": [0.1, 0.02, -0.03], "in": "arm"})");
  EXPECT_LT((base.translation() - X_BT().translation() - Eigen::Vector3d(0.1, 0.02, -0.03)).norm(), 1e-12);
  const auto tcp = pose(R"({"by_m": [0.1, 0.02, -0.03], "in": "tcp"})");
  EXPECT_LT((X_BT().inverse() * tcp.translation() - Eigen::Vector3d(0.1, 0.02, -0.03)).norm(), 1e-12);
}

TEST_F(GoalTest, StepsTurnAboutTheToolsOwnAxes) {
  const auto X = pose(R"({"by_rpy_deg": [0, 0, 30], "in": "block"})");
  EXPECT_LT((X.translation() - X_BT().translation()).norm(), 1e-12);
  const Eigen::AngleAxisd turn(X_BT().linear().transpose() * X.linear());
  EXPECT_NEAR(turn.angle(), 30 * kDegree, 1e-12);
  EXPECT_LT((turn.axis() - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
}

TEST_F(GoalTest, WhatIsWrongIsSaidWhereItStands) {
  EXPECT_THAT(wrong("\"away\""), ElementsAre("/step/to"));
  EXPECT_THAT(wrong("3"), testing::Contains("/step/to"));
  EXPECT_THAT(wrong(R"({"joints_deg": [1, 2]})"), ElementsAre("/step/to/joints_deg"));
  EXPECT_THAT(wrong(R"({"joints_deg": [1, 2, 3, 4, 5, 6, 7], "in": "world"})"), ElementsAre("/step/to/in"));
  EXPECT_THAT(wrong(R"({"position_m": [0, 0, "1"], "rpy_degs": [0, 0, 0]})"),
              ElementsAre("/step/to", "/step/to/position_m/2", "/step/to/rpy_degs"));
  EXPECT_THAT(wrong(R"({"by_m": [0, 0], "by_rpy_deg": 4})"), ElementsAre("/step/to/by_m", "/step/to/by_rpy_deg"));
}

TEST_F(GoalTest, AnUnknownFrameIsFoundWhenTheGoalIsResolved) {
  Diagnostics found;
  for (const char* to : {R"({"in": "blok", "position_m": [0, 0, 0]})", R"({"in": "blok", "by_m": [0, 0, 0]})"}) {
    const auto result = resolve(read(to, found), fake.cell, "arm", q);
    ASSERT_FALSE(result.has_value());
    EXPECT_THAT(result.error(), Reports(Code::kUnknownName, "", {"block"}));
  }
}

}  // namespace
}  // namespace takt::operations
