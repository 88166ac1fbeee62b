// Where links between base and flange are, and how they move.
#include "core/kinematics/link_path.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_vector;

/// The last link of a chain that begins at l0.
std::string last_link(int joints) { return "l" + std::to_string(joints); }

TEST(LinkPath, OfTheFlangeIsTheChain) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const RobotModel model = test::random_model(random, 1 + i % 7);
    const Chain chain = Chain::create(model, "l0", last_link(1 + i % 7)).value();
    const LinkPaths links(model, "l0", chain.joint_names());
    const LinkPath* path = links.find(last_link(1 + i % 7));
    ASSERT_NE(path, nullptr);
    const JointVector q = random_vector(random, chain.joint_count(), 2.0),
                      dq = random_vector(random, chain.joint_count(), 1.0);
    Eigen::Isometry3d X_BF;
    Jacobian J;
    chain.jacobian(q, X_BF, J);
    EXPECT_LT(pose_distance(path->pose(q), X_BF), 1e-12);
    const auto [X, V] = path->motion(q, dq);
    EXPECT_LT(pose_distance(X, X_BF), 1e-12);
    EXPECT_LT((V - J * dq).norm(), 1e-12);
  }
}

// A chain that ends at the link knows nothing of the joints behind it.
TEST(LinkPath, OfEachLinkIsAChainThatEndsThere) {
  const RobotModel model = test::model_of(test::lwr_urdf());
  const Chain whole = test::lwr();
  const LinkPaths links(model, "base", whole.joint_names());
  Random random(4);
  const JointVector q = test::random_q(random, whole);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (const Joint& joint : model.joints) {
    X = X * joint.X_PJ;
    const auto at = std::ranges::find(whole.joint_names(), joint.name);
    if (at != whole.joint_names().end()) X.rotate(Eigen::AngleAxisd(q[at - whole.joint_names().begin()], joint.axis));
    const LinkPath* path = links.find(joint.child);
    ASSERT_NE(path, nullptr) << joint.child;
    EXPECT_LT(pose_distance(path->pose(q), X), 1e-12) << joint.child;
  }
}

TEST(LinkPath, VelocitiesAreDifferencesOfPoses) {
  const RobotModel model = test::model_of(test::ur5_urdf());
  const Chain chain = test::chain_of(test::ur5_urdf());
  const LinkPaths links(model, "base", chain.joint_names());
  Random random(5);
  constexpr double h = 1e-6;
  for (const std::string& name : links.names()) {
    const JointVector q = test::random_q(random, chain), dq = random_vector(random, chain.joint_count(), 1.0);
    const LinkPath& path = *links.find(name);
    const Eigen::Isometry3d before = path.pose(q - h * dq), after = path.pose(q + h * dq);
    const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
    const Vector6 V = path.motion(q, dq).V_BL_B;
    EXPECT_LT((V.head<3>() - (after.translation() - before.translation()) / (2 * h)).norm(), 1e-8) << name;
    EXPECT_LT((V.tail<3>() - turn.axis() * turn.angle() / (2 * h)).norm(), 1e-8) << name;
  }
}

TEST(LinkPath, WhatTheJointsDoNotMoveIsNotThere) {
  const RobotModel model = test::model_of(test::lwr_urdf());
  const Chain whole = test::lwr();
  const LinkPaths links(model, "base", whole.joint_names());
  const auto has = [](const LinkPaths& paths, const char* link) { return paths.find(link) != nullptr; };
  EXPECT_FALSE(has(links, "base"));
  EXPECT_FALSE(has(links, "no such link"));
  EXPECT_TRUE(has(links, "flange"));
  // Those behind a joint that is none of the arm's.
  const LinkPaths first(model, "base", std::span(whole.joint_names()).first(2));
  EXPECT_FALSE(has(first, "flange"));
  EXPECT_EQ(first.names().size(), 2u);
}

}  // namespace
}  // namespace takt::kinematics
