#include "core/world/belief.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/reports.h"

namespace takt::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using takt::test::Reports;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

Isometry3d moved(double x, double y, double z) { return Isometry3d(Eigen::Translation3d(x, y, z)); }

Object box_object(const std::string& name, const Vector3d& size, double mass, bool fixed = false) {
  Object object{.name = name, .parts = {{Box{size}}}, .fixed = fixed};
  object.mass = spread_mass(object.parts, mass);
  return object;
}

/// A table of 0.5 m, a tray on it with a floor of 10 mm, and a bolt in the tray. Two arms, whose flanges have been seen
/// 1 m high.
class BeliefTest : public testing::Test {
 protected:
  BeliefTest() {
    add("table", "world", moved(0, 0, 0.25), box_object("table", {1, 1, 0.5}, 0.0, true));
    Object tray = box_object("tray", {0.3, 0.2, 0.01}, 0.4);
    tray.grasps["rim"] = moved(0.15, 0, 0.02);
    add("tray", "table", moved(0, 0, 0.255), tray);
    add("bolt", "tray", moved(0.05, 0, 0.025), box_object("bolt", {0.02, 0.02, 0.04}, 0.1));
    EXPECT_TRUE(belief.frames.add("tray/rim", "tray", tray.grasps["rim"]).empty());
    for (const char* arm : {"left", "right"}) EXPECT_TRUE(belief.frames.add(arm, "world", moved(0, 0, 0)).empty());
  }

  void add(const std::string& name, const std::string& parent, const Isometry3d& X, const Object& object) {
    EXPECT_TRUE(belief.frames.add(name, parent, X).empty());
    belief.objects[name] = object;
  }
  /// The flange of an arm is at X_WF: what rides on it is seen there.
  void move(const std::string& arm, const Isometry3d& X_WF) {
    for (const std::string& name : belief.frames.moving()) {
      const Relation& relation = *belief.frames.relation(name);
      if (relation.source == arm) belief.frames.see(name, X_WF * relation.X_PF);
    }
  }
  void take(const std::string& gripper, const std::string& arm, const std::string& object, const Isometry3d& X_WF) {
    const Hold hold{.object = object,
                    .arm = arm,
                    .X_FO = X_WF.inverse() * *belief.frames.pose(object),
                    .p_FG = Vector3d(0, 0, 0.1)};
    EXPECT_TRUE(belief.take(gripper, hold).empty());
    move(arm, X_WF);
  }

  Belief belief;
};

TEST_F(BeliefTest, WhatIsGrippedMovesWithTheFlangeAndSoDoesWhatIsInIt) {
  const Isometry3d X_WF = moved(0.15, 0, 0.7);
  take("gripper", "left", "tray", X_WF);
  EXPECT_TRUE(belief.is_held("tray"));
  EXPECT_TRUE(belief.is_held("bolt")) << "it is in the tray";
  EXPECT_FALSE(belief.is_held("table"));
  EXPECT_THAT(belief.riders("tray"), ElementsAre("bolt"));
  move("left", X_WF * moved(0, 0, 0.2));
  EXPECT_NEAR(belief.frames.pose("tray")->translation().z(), 0.705, 1e-12);
  EXPECT_NEAR(belief.frames.pose("bolt")->translation().z(), 0.73, 1e-12);
  EXPECT_NEAR(belief.frames.pose("tray/rim")->translation().z(), 0.725, 1e-12);
  const auto carrier = belief.carrier_of("bolt");
  ASSERT_TRUE(carrier.has_value());
  EXPECT_EQ(carrier->arm, "left");
  EXPECT_TRUE(carrier->X_FO.isApprox(moved(-0.1, 0, -0.17), 1e-12));
  EXPECT_FALSE(belief.carrier_of("table").has_value());
}

TEST_F(BeliefTest, TheLoadIsThatOfThePartAndOfAllThatIsInIt) {
  take("gripper", "left", "tray", moved(0, 0, 0.7));
  const MassProperties load = belief.load_of("left");
  EXPECT_NEAR(load.mass, 0.5, 1e-12);
  EXPECT_TRUE(load.p_OC.isApprox(Vector3d(0.01, 0, (0.4 * -0.195 + 0.1 * -0.17) / 0.5), 1e-12))
      << load.p_OC.transpose();
  // Against the parallel-axis theorem, about x through the centre of both.
  const double tray = 0.4 * (0.2 * 0.2 + 0.01 * 0.01) / 12, bolt = 0.1 * (0.02 * 0.02 + 0.04 * 0.04) / 12;
  const double apart = 0.4 * 0.005 * 0.005 + 0.1 * 0.02 * 0.02;
  EXPECT_NEAR(load.I_C(0, 0), tray + bolt + apart, 1e-12);
  EXPECT_EQ(belief.load_of("right").mass, 0.0);
}

TEST_F(BeliefTest, OfTwoThatHoldOneObjectEachBearsHalfWhereItHolds) {
  take("left gripper", "left", "tray", moved(-0.15, 0, 0.7));
  take("right gripper", "right", "tray", moved(0.15, 0, 0.7));
  for (const char* arm : {"left", "right"}) {
    EXPECT_NEAR(belief.load_of(arm).mass, 0.25, 1e-12);
    EXPECT_TRUE(belief.load_of(arm).p_OC.isApprox(Vector3d(0, 0, 0.1), 1e-12)) << "it exerts no moment on the wrist";
  }
  EXPECT_EQ(belief.carrier_of("tray")->arm, "left") << "the first one";
  ASSERT_TRUE(belief.let_go("left gripper", *belief.frames.pose("tray"), "world").has_value());
  EXPECT_EQ(belief.carrier_of("tray")->arm, "right") << "the other one holds it still";
  EXPECT_NEAR(belief.load_of("right").mass, 0.5, 1e-12);
}

TEST_F(BeliefTest, WhatIsReleasedStaysAndDependsOnWhatItStandsOn) {
  take("gripper", "left", "bolt", moved(0, 0, 0.7));
  const Isometry3d X_WO = moved(0.4, 0.1, 0.52);
  EXPECT_EQ(belief.support_of("bolt", X_WO, 0.005), "table");
  EXPECT_EQ(belief.support_of("bolt", moved(0.05, 0, 0.53), 0.005), "tray");
  EXPECT_EQ(belief.support_of("bolt", moved(0.05, 0, 0.6), 0.005), std::nullopt) << "in the air";
  const auto left = belief.let_go("gripper", X_WO, "table");
  ASSERT_TRUE(left.has_value() && left->has_value());
  EXPECT_EQ((*left)->object, "bolt");
  EXPECT_TRUE(belief.held.empty());
  EXPECT_EQ(belief.frames.relation("bolt")->parent, "table");
  EXPECT_TRUE(belief.frames.pose("bolt")->isApprox(X_WO, 1e-12));
  EXPECT_THAT(belief.riders("tray"), testing::IsEmpty());
}

TEST_F(BeliefTest, AFreeObjectIsFoundBetweenTheFingersAndAHeldOrFixedOneIsNot) {
  EXPECT_EQ(belief.free_object_at({0.05, 0, 0.53}, 0.01), "bolt");
  EXPECT_EQ(belief.free_object_at({0.05, 0, 0.558}, 0.01), "bolt") << "8 mm above it";
  EXPECT_EQ(belief.free_object_at({0.05, 0, 0.565}, 0.01), std::nullopt);
  EXPECT_EQ(belief.free_object_at({0.4, 0.4, 0.5}, 0.01), std::nullopt) << "the table belongs to the cell";
  take("gripper", "left", "tray", moved(0, 0, 0.7));
  EXPECT_EQ(belief.free_object_at({0.05, 0, 0.53}, 0.01), std::nullopt) << "it is in a tray that is held";
}

TEST_F(BeliefTest, ALostObjectIsNowhereUntilItIsFoundAgain) {
  take("gripper", "left", "tray", moved(0, 0, 0.7));
  belief.lose("tray");
  EXPECT_FALSE(belief.knows("tray"));
  EXPECT_FALSE(belief.knows("bolt"));
  EXPECT_TRUE(belief.held.empty());
  EXPECT_THAT(belief.frames.pose("tray/rim").error(), Reports(Code::kUnknownPose, "", {"tray"}));
  ASSERT_TRUE(belief.found("tray", moved(0, 0, 0.1)).empty());
  EXPECT_TRUE(belief.knows("bolt"));
  EXPECT_NEAR(belief.frames.pose("bolt")->translation().z(), 0.125, 1e-12);
}

TEST_F(BeliefTest, AMeasurementMovesAHeldObjectInTheGripper) {
  take("gripper", "left", "bolt", moved(0, 0, 0.7));
  const Isometry3d X_WO = *belief.frames.pose("bolt") * moved(0.002, 0, 0);
  ASSERT_TRUE(belief.found("bolt", X_WO).empty());
  EXPECT_TRUE(belief.frames.pose("bolt")->isApprox(X_WO, 1e-12));
  move("left", moved(0, 0, 0.9));
  EXPECT_TRUE(belief.frames.pose("bolt")->isApprox(moved(0, 0, 0.2) * X_WO, 1e-12)) << "it stays so in the gripper";
  EXPECT_NEAR(belief.held.at("gripper").X_FO.translation().x(), 0.052, 1e-12);
}

TEST_F(BeliefTest, ACopyIsABranchOfItsOwn) {
  Belief other = belief;
  other.lose("tray");
  EXPECT_TRUE(belief.knows("bolt"));
  EXPECT_FALSE(other.knows("bolt"));
}

// -- Masses of shapes -------------------------------------------------------------------------------------------------

TEST(MassOfShapes, ALongCapsuleIsNearlyACylinderAndAShortOneABall) {
  const auto inertia = [](const Shape& shape) { return spread_mass({{shape}}, 1.0).I_C; };
  EXPECT_NEAR(inertia(Capsule{0.01, 10.0})(0, 0) / inertia(Cylinder{0.01, 10.0 + 0.04 / 3})(0, 0), 1.0, 1e-4);
  EXPECT_TRUE(inertia(Capsule{0.2, 1e-9}).isApprox(inertia(Sphere{0.2}), 1e-6));
}

TEST(MassOfShapes, PartsOfOneDensityShareTheMassByVolume) {
  const std::vector<Object::Part> parts{{Box{{0.1, 0.1, 0.1}}, moved(0, 0, 0)},
                                        {Box{{0.1, 0.1, 0.3}}, moved(0, 0, 0.2)}};
  const MassProperties whole = spread_mass(parts, 4.0),
                       one = spread_mass({{Box{{0.1, 0.1, 0.4}}, moved(0, 0, 0.15)}}, 4.0);
  EXPECT_TRUE(whole.p_OC.isApprox(one.p_OC, 1e-12));
  EXPECT_TRUE(whole.I_C.isApprox(one.I_C, 1e-12));
  EXPECT_NEAR(spread_mass(parts, 4.0, {3.0, 1.0}).p_OC.z(), 0.05, 1e-12) << "unless they are given";
}

}  // namespace
}  // namespace takt::world
