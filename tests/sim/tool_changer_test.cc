// A tool changer on a gantry: what is within its tolerance it couples and draws in, what is not stays where it is.
#include "sim/machines/tool_changer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

std::string heavy(const std::string& name, double mass) {
  return "<link name='" + name + "'><inertial><mass value='" + std::to_string(mass) +
         "'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>";
}

std::string sliding(const std::string& name, const std::string& parent, const std::string& child,
                    const std::string& axis) {
  return "<joint name='" + name + "' type='prismatic'><parent link='" + parent + "'/><child link='" + child +
         "'/><axis xyz='" + axis + "'/><limit lower='-2' upper='2' velocity='3' effort='2000'/></joint>";
}

/// Two sliding axes x, z; the flange looks down.
std::string crane_urdf() {
  return "<robot name='crane'>" + heavy("base", 10) + heavy("trolley", 8) + heavy("ram", 6) + "<link name='flange'/>" +
         sliding("x", "base", "trolley", "1 0 0") + sliding("z", "trolley", "ram", "0 0 1") +
         "<joint name='mount' type='fixed'><parent link='ram'/><child link='flange'/>"
         "<origin xyz='0 0 0' rpy='3.141592653589793 0 0'/></joint></robot>";
}

constexpr double kFace = 0.036;        ///< of the changer's coupling face, from its mount
constexpr double kRest = 0.1 + 0.022;  ///< height of the coupling face of a tool side that lies on its stand
constexpr double kAbove = 0.05;        ///< of the changer at the start, over that

/// Where the tool side lies, beside where the changer comes down.
struct Beside {
  double x = 0.0, yaw = 0.0;
  bool coupled = false;  ///< it hangs on the changer instead
};

class ToolChangerTest : public testing::Test {
 protected:
  void build(const Beside& beside = {}) {
    auto crane = kinematics::RobotModel::parse(crane_urdf(), ".");
    ASSERT_TRUE(crane) << crane.error().to_string();
    WorldDescription description;
    RobotDescription portal = plain_body("portal", std::make_shared<kinematics::RobotModel>(*crane), {});
    portal.mount.X_P.translation().z() = kRest + kAbove + kFace;
    portal.q = {0, 0};
    description.robots.push_back(portal);
    description.robots.push_back(plain_body("changer", model("tool_changer"), {.parent = "portal/flange"}));
    RobotDescription side = plain_body("side", model("tool_side"), {});
    side.free = true;
    const Pose down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    side.mount.X_P = Eigen::Translation3d(beside.x, 0, beside.coupled ? kRest + kAbove : kRest) *
                     Eigen::AngleAxisd(beside.yaw, Eigen::Vector3d::UnitZ()) * down;
    description.robots.push_back(side);
    SimArmDescription arm;
    arm.name = "arm";
    arm.robot = "portal";
    arm.base_link = "base";
    arm.flange_link = "flange";
    description.arms.push_back(arm);
    description.objects.push_back(box("stand", {0.2, 0.2, 0.1}, {0, 0, 0.05}));
    description.tool_sides.push_back(
        {.name = "side", .pointer = {}, .body = "side/plate", .size = "tc10", .number = 7});
    description.tool_changers.push_back({.name = "changer",
                                         .pointer = {},
                                         .body = "changer/coupling",
                                         .size = "tc10",
                                         .tolerance = {.offset = 0.001, .gap = 0.0015, .angle = M_PI / 180.0},
                                         .lock_time = 0.15});
    if (beside.coupled) description.tool_changers.back().coupled = "side";
    world.emplace(make(description));
  }

  SimToolChanger& changer() { return *world->tool_changer("changer"); }
  void step(int cycles = 1) {
    for (int i = 0; i < cycles; ++i) {
      world->arm("arm")->write(set_point(q, dq, JointVector::Zero(2)));
      ASSERT_TRUE(world->step());
      q += 0.001 * dq;
    }
  }
  /// In a straight line, 0.1 m/s; the ends are abrupt, the drives of the crane follow.
  void move(int axis, double way) {
    const int cycles = static_cast<int>(std::lround(std::abs(way) / 0.1 * 1000));
    dq = JointVector::Zero(2);
    dq[axis] = way / (cycles * 0.001);
    step(cycles);
    dq.setZero();
    step(300);
  }
  void set_lock(bool locks, int cycles = 400) {
    changer().lock.write(locks);
    step(cycles);
  }
  Pose offset() {
    const Pose X_WC = world->body_pose(world->body("changer/coupling"));
    return X_WC.inverse() * world->body_pose(world->body("side/plate"));
  }
  bool says(SimGauge& gauge) { return *gauge.wire() >= 0.5; }

  std::optional<World> world;
  JointVector q = JointVector::Zero(2), dq = JointVector::Zero(2);
};

TEST_F(ToolChangerTest, CouplesWhatIsThereAndCarriesIt) {
  build();
  step(50);
  EXPECT_TRUE(says(changer().unlocked));
  EXPECT_FALSE(says(changer().ready_to_lock));
  move(1, -kAbove);
  EXPECT_TRUE(says(changer().ready_to_lock));
  set_lock(true);
  EXPECT_TRUE(says(changer().locked));
  EXPECT_TRUE(says(changer().coupled));
  EXPECT_EQ(*changer().tool_number.wire(), 7.0);
  move(1, 0.2);
  move(0, 0.3);
  EXPECT_GT(world->body_pose(world->body("side/plate")).translation().z(), kRest + 0.19);
  EXPECT_LT(offset().translation().norm(), 2e-5) << "steel on steel";
  // Back again: it stays where it is put.
  move(0, -0.3);
  move(1, -0.2);
  set_lock(false);
  EXPECT_TRUE(says(changer().unlocked));
  EXPECT_FALSE(says(changer().coupled));
  EXPECT_EQ(*changer().tool_number.wire(), 0.0);
  move(1, 0.2);
  EXPECT_NEAR(world->body_pose(world->body("side/plate")).translation().z(), kRest, 5e-4);
}

TEST_F(ToolChangerTest, DrawsInWhatIsALittleAside) {
  build({.x = 0.0007, .yaw = 0.8 * M_PI / 180.0});
  move(1, -kAbove + 0.001);
  ASSERT_GT(offset().translation().norm(), 0.0009);
  set_lock(true);
  ASSERT_TRUE(says(changer().coupled));
  EXPECT_LT(offset().translation().norm(), 2e-5);
  EXPECT_LT(Eigen::AngleAxisd(offset().linear()).angle(), 2e-4);
}

/// Across, along and about the axis, each a little too much.
TEST_F(ToolChangerTest, DoesNotCoupleWhatIsNotThere) {
  struct Case {
    Beside beside;
    double short_of;
  };
  for (const auto& [beside, short_of] : {Case{{.x = 0.0013}, 0.0}, Case{{}, 0.002}, Case{{.yaw = 0.03}, 0.0}}) {
    SCOPED_TRACE(testing::Message() << beside.x << " " << short_of << " " << beside.yaw);
    q = dq = JointVector::Zero(2);
    build(beside);
    move(1, -kAbove + short_of);
    const Pose before = world->body_pose(world->body("side/plate"));
    EXPECT_FALSE(says(changer().ready_to_lock));
    set_lock(true);
    EXPECT_TRUE(says(changer().locked));
    EXPECT_FALSE(says(changer().coupled));
    move(1, 0.1);
    EXPECT_TRUE(world->body_pose(world->body("side/plate")).isApprox(before, 1e-3)) << "it lies where it lay";
    // Locked empty it takes nothing, wherever it goes.
    move(1, -0.1 - short_of);
    EXPECT_FALSE(says(changer().coupled));
  }
}

TEST_F(ToolChangerTest, WithoutAirTheLockStaysAsItIs) {
  build({.coupled = true});
  step(50);
  ASSERT_TRUE(says(changer().coupled));
  changer().set_air(false);
  set_lock(false);
  EXPECT_TRUE(says(changer().coupled)) << "self-locking: the tool does not fall";
  EXPECT_LT(offset().translation().norm(), 2e-5);
  changer().set_air(true);
  step(400);
  EXPECT_TRUE(says(changer().unlocked));
  EXPECT_GT(offset().translation().norm(), 0.02) << "now it has fallen";
}

TEST_F(ToolChangerTest, ALockThatBreaksDropsTheTool) {
  build({.coupled = true});
  step(50);
  changer().set_broken(true);
  step(200);
  EXPECT_FALSE(says(changer().coupled));
  EXPECT_NEAR(world->body_pose(world->body("side/plate")).translation().z(), kRest, 2e-3);
}

TEST_F(ToolChangerTest, ASnapshotKnowsWhatIsLocked) {
  build({.x = 0.0007});
  move(1, -kAbove + 0.001);
  changer().lock.write(true);
  step(80);  // halfway: it is being drawn in
  const Snapshot snapshot = world->save();
  step(500);
  const auto first = world->save();
  set_lock(false, 300);
  ASSERT_TRUE(world->restore(snapshot));
  step(500);
  EXPECT_EQ(world->save(), first);
}

TEST_F(ToolChangerTest, WrongDescriptionsAreReported) {
  WorldDescription description;
  RobotDescription side = plain_body("side", model("tool_side"), {});
  side.free = true;
  description.robots.push_back(side);
  description.tool_sides.push_back({.name = "side", .pointer = "/side", .body = "side/rim", .size = "a", .number = 0});
  description.tool_changers.push_back({.name = "changer",
                                       .pointer = "/changer",
                                       .body = "nowhere",
                                       .size = "b",
                                       .tolerance = {},
                                       .lock_time = 0.0,
                                       .coupled = "side"});
  const auto made = World::create(description);
  ASSERT_FALSE(made);
  EXPECT_GE(made.error().list().size(), 6U) << made.error().to_string();
}

}  // namespace
}  // namespace takt::sim::test
