// A gripper on a gantry: what it holds it holds by friction, and its states tell the truth about it.
#include "sim/machines/gripper.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

using device::GripperState;

std::string link(const std::string& name, double mass) {
  return "<link name='" + name + "'><inertial><mass value='" + std::to_string(mass) +
         "'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>";
}

std::string slide(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& axis) {
  return "<joint name='" + name + "' type='prismatic'><parent link='" + parent + "'/><child link='" + child +
         "'/><axis xyz='" + axis + "'/><limit lower='-2' upper='2' velocity='3' effort='2000'/></joint>";
}

/// Three sliding axes x, y, z above the table; the flange looks down.
std::string gantry_urdf() {
  return "<robot name='gantry'>" + link("base", 10) + link("bridge", 10) + link("cross", 8) + link("ram", 6) +
         "<link name='flange'/>" + slide("x", "base", "bridge", "1 0 0") + slide("y", "bridge", "cross", "0 1 0") +
         slide("z", "cross", "ram", "0 0 1") +
         "<joint name='mount' type='fixed'><parent link='ram'/><child link='flange'/>"
         "<origin xyz='0 0 0' rpy='3.141592653589793 0 0'/></joint></robot>";
}

constexpr double kPartEdge = 0.04;
constexpr double kTcp = 0.1175;  ///< of the gripper, from its mount

/// A gantry that carries the gripper, and a part of 1 kg on a table, between the open fingers.
class GripperTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto read = device::read_gripper("models/wsg50");
    ASSERT_TRUE(read) << read.error().to_string();
    model = *read;
    auto gantry = kinematics::RobotModel::parse(gantry_urdf(), ".");
    ASSERT_TRUE(gantry) << gantry.error().to_string();
    WorldDescription description;
    RobotDescription portal = plain_body("portal", std::make_shared<kinematics::RobotModel>(*gantry), {});
    portal.mount.X_P.translation().z() = tcp_height() + kTcp;
    portal.q = {0, 0, 0};
    description.robots.push_back(portal);
    description.robots.push_back(gripper_body("gripper", *model, {.parent = "portal/flange"}, model->stroke));
    SimArmDescription arm;
    arm.name = "arm";
    arm.robot = "portal";
    arm.base_link = "base";
    arm.flange_link = "flange";
    description.arms.push_back(arm);
    description.grippers.push_back(simulated_gripper("gripper", "gripper", *model));
    description.objects.push_back(box("table", {1, 1, 0.02}, {0, 0, -0.01}));
    add_parts(description);
    world.emplace(make(description));
    q = dq = JointVector::Zero(3);
  }
  /// Of the tool at the start, m above the table.
  [[nodiscard]] virtual double tcp_height() const { return kPartEdge / 2; }
  virtual void add_parts(WorldDescription& description) const {
    ObjectDescription part = box("part", {kPartEdge, kPartEdge, kPartEdge}, {0, 0, kPartEdge / 2});
    part.free = true;
    part.mass = 1.0;
    description.objects.push_back(part);
  }

  void command(double width, double speed, double force) {
    sent = {.sequence = sent.sequence + 1, .width = width, .speed = speed, .force = force};
  }
  void step(const JointVector& ddq = JointVector::Zero(3)) {
    if (sent.sequence > 0) world->gripper("gripper")->write(sent);
    world->arm("arm")->write(set_point(q, dq, ddq));
    ASSERT_TRUE(world->step());
    constexpr double h = 0.001;
    q += h * dq + 0.5 * h * h * ddq;
    dq += h * ddq;
  }
  void wait(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 1000)); ++i) step();
  }
  /// `way` along an axis with `acceleration`, then the same down to rest.
  void move(int axis, double way, double acceleration) {
    const int half = static_cast<int>(std::ceil(std::sqrt(std::abs(way) / acceleration) * 1000));
    JointVector ddq = JointVector::Zero(3);
    ddq[axis] = way / std::pow(half * 0.001, 2);
    for (int i = 0; i < half; ++i) step(ddq);
    ddq = -ddq;
    for (int i = 0; i < half; ++i) step(ddq);
    dq.setZero();
  }
  device::GripperSample sample() {
    device::GripperSample s;
    EXPECT_TRUE(world->gripper("gripper")->read(s));
    return s;
  }
  /// Of the part in the gripper.
  Pose held_pose() const {
    return world->body_pose(world->body("gripper/base")).inverse() * world->body_pose(world->body("part"));
  }
  double slip(const Pose& since) const { return (held_pose().translation() - since.translation()).norm(); }

  std::shared_ptr<const device::GripperDescription> model;
  std::optional<World> world;
  device::GripperSetPoint sent;
  JointVector q, dq;
};

TEST_F(GripperTest, GoesWhereItIsSentWithTheSpeedItIsTold) {
  command(0.08, 0.1, 40);
  double fastest = 0.0;
  int moving = 0;
  do {
    step();
    fastest = std::max(fastest, std::abs(sample().speed));
    ++moving;
  } while ((sample().command != sent.sequence || sample().state == GripperState::kMoving) && moving < 2000);
  EXPECT_EQ(sample().state, GripperState::kIdle);
  EXPECT_NEAR(sample().width, 0.08, 3e-4);
  EXPECT_NEAR(fastest, 0.1, 0.005);
  EXPECT_NEAR(moving * 0.001, 0.03 / 0.1 + 0.1 / model->acceleration, 0.06);
}

TEST_F(GripperTest, HoldsOneKilogramForAMinuteWithoutSlip) {
  command(0, 0.1, 60);
  wait(0.8);
  ASSERT_EQ(sample().state, GripperState::kHolding);
  EXPECT_NEAR(sample().width, kPartEdge, 1e-3);
  EXPECT_NEAR(sample().force, 60, 1);
  move(2, 0.2, 1.0);
  wait(0.2);
  const Pose held = held_pose();
  wait(60);
  RecordProperty("slip_um", std::to_string(1e6 * slip(held)));
  EXPECT_LT(slip(held), 1e-4);
  EXPECT_EQ(sample().state, GripperState::kHolding);
}

TEST_F(GripperTest, HoldsWhileItMovesWithOneMetrePerSecondSquared) {
  command(0, 0.1, 60);
  wait(0.8);
  move(2, 0.2, 1.0);
  wait(0.2);
  const Pose held = held_pose();
  for (const int axis : {0, 1, 2}) {
    move(axis, 0.25, 1.0);
    EXPECT_LT(slip(held), 1e-4) << "axis " << axis;
    move(axis, -0.25, 1.0);
    EXPECT_LT(slip(held), 1e-4) << "axis " << axis << ", back";
    RecordProperty("slip_um_after_axis_" + std::to_string(axis), std::to_string(1e6 * slip(held)));
  }
}

TEST_F(GripperTest, OneKilogramSlipsLessThanATenthOfAMillimetreInTenFastMotions) {
  command(0, 0.1, 80);
  wait(0.8);
  move(2, 0.3, 1.0);
  wait(0.3);
  const Pose held = held_pose();
  double most = 0.0;
  for (int i = 0; i < 10; ++i) {
    const double way = i % 2 == 0 ? 0.3 : -0.3;
    move(i / 2 % 3, way, 10.0);  // 0.35 s each, 1.7 m/s
    wait(0.1);
    most = std::max(most, slip(held));
  }
  wait(0.5);
  RecordProperty("slip_um", std::to_string(1e6 * slip(held)));
  RecordProperty("most_um", std::to_string(1e6 * most));
  EXPECT_LT(most, 1e-4);
  EXPECT_LT(slip(held), 1e-4);
  EXPECT_LT(Eigen::AngleAxisd(held.linear().transpose() * held_pose().linear()).angle(), 1e-3);
  EXPECT_EQ(sample().state, GripperState::kHolding);
}

/// A screw M3 x 12 that stands on its head on a post, between the fingers.
class GripperAndScrew : public GripperTest {
 protected:
  static constexpr double kPost = 0.03, kHead = 0.003, kShank = 0.012;  ///< m, heights

  [[nodiscard]] double tcp_height() const override { return kPost + kHead + 0.0137; }
  void add_parts(WorldDescription& description) const override {
    description.objects.push_back(box("post", {0.008, 0.008, kPost}, {0, 0, kPost / 2}));
    ObjectDescription screw;
    screw.name = "part";
    screw.free = true;
    screw.mass = 0.0011;
    screw.contact.material = "fastener";
    screw.shapes.push_back({.shape = kinematics::Cylinder{0.0015, kShank}, .chamfer = 0.0003});
    screw.shapes.push_back({.shape = kinematics::Cylinder{0.00275, kHead}});
    screw.shapes[0].X_OG.translation().z() = kShank / 2;
    screw.shapes[1].X_OG.translation().z() = kShank + kHead / 2;
    screw.screw = ScrewDescription{.thread = {"M3", 0.0005, 0.003, 0.002675, 0.01, 0.12}};
    screw.mount.X_P.translation().z() = kPost + kHead + kShank;
    screw.mount.X_P.rotate(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    description.objects.push_back(screw);
  }
};

TEST_F(GripperAndScrew, PadsHoldAnM3Screw) {
  command(0, 0.05, 10);
  wait(3.0);
  ASSERT_EQ(sample().state, GripperState::kHolding);
  EXPECT_NEAR(sample().width, 0.003, 2e-4);
  move(2, 0.2, 2.0);
  wait(0.3);
  const Pose held = held_pose();
  EXPECT_LT(Eigen::AngleAxisd(world->body_pose(world->body("part")).linear() *
                              Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).matrix())
                .angle(),
            0.02)
      << "it was lifted upright";
  for (int i = 0; i < 10; ++i) {
    move(i / 2 % 3, i % 2 == 0 ? 0.3 : -0.3, 10.0);
    EXPECT_LT(slip(held), 1e-4) << "motion " << i;
  }
  wait(60);
  RecordProperty("slip_um", std::to_string(1e6 * slip(held)));
  EXPECT_LT(slip(held), 1e-4);
  EXPECT_LT(Eigen::AngleAxisd(held.linear().transpose() * held_pose().linear()).angle(), 0.005);
  EXPECT_EQ(sample().state, GripperState::kHolding);
}

/// Ten boxes on each other beside the gripper, and the part that it holds.
class GripperAndStack : public GripperTest {
 protected:
  static constexpr int kCount = 10;
  static constexpr double kEdge = 0.04;

  static std::string name_of_box(int i) { return "box" + std::to_string(i); }
  void add_parts(WorldDescription& description) const override {
    GripperTest::add_parts(description);
    for (int i = 0; i < kCount; ++i) {
      ObjectDescription part = box(name_of_box(i), {kEdge, kEdge, kEdge}, {0.0, 0.3, kEdge * (i + 0.5)});
      part.free = true;
      part.mass = 0.1;
      description.objects.push_back(part);
    }
  }
  [[nodiscard]] Eigen::Vector3d at(int i) const { return world->body_pose(world->body(name_of_box(i))).translation(); }
};

TEST_F(GripperAndStack, AStackOfTenStandsForAMinuteBesideAGripper) {
  command(0, 0.1, 60);
  wait(1.0);
  move(2, 0.2, 1.0);
  wait(1.0);
  std::vector<Eigen::Vector3d> before;
  for (int i = 0; i < kCount; ++i) before.push_back(at(i));
  for (int i = 0; i < 6; ++i) {
    move(0, i % 2 == 0 ? 0.25 : -0.25, 2.0);
    wait(9.3);
  }
  double most = 0.0;
  for (int i = 0; i < kCount; ++i) most = std::max(most, (at(i) - before[static_cast<std::size_t>(i)]).norm());
  RecordProperty("moved_um", std::to_string(1e6 * most));
  EXPECT_LT(most, 5e-6);
  EXPECT_EQ(sample().state, GripperState::kHolding);
}

TEST_F(GripperTest, TooWeakAGripDropsThePart) {
  command(0, 0.1, 8);  // friction 0.7 carries 5.6 N of the 9.8 N
  wait(0.8);
  EXPECT_EQ(sample().state, GripperState::kHolding) << "on the table it is held";
  move(2, 0.2, 0.5);
  wait(0.5);
  EXPECT_LT(world->body_pose(world->body("part")).translation().z(), 0.05);
  EXPECT_EQ(sample().state, GripperState::kLost);
  EXPECT_NEAR(sample().width, 0, 1e-3) << "the fingers have closed behind it";
}

TEST_F(GripperTest, OpensAndLeavesThePart) {
  command(0, 0.1, 40);
  wait(0.8);
  command(0.1, 0.1, 40);
  wait(0.8);
  EXPECT_EQ(sample().state, GripperState::kIdle);
  EXPECT_NEAR(sample().width, 0.1, 3e-4);
  EXPECT_NEAR(world->body_pose(world->body("part")).translation().z(), kPartEdge / 2, 5e-4);
}

TEST_F(GripperTest, EasedGripLosesThePart) {
  command(0, 0.1, 60);
  wait(0.8);
  move(2, 0.2, 1.0);
  ASSERT_EQ(sample().state, GripperState::kHolding);
  command(0, 0.1, 5);
  wait(0.6);
  EXPECT_EQ(sample().state, GripperState::kLost);
  EXPECT_LT(world->body_pose(world->body("part")).translation().z(), 0.05);
}

TEST_F(GripperTest, ContinuesBitForBitFromASnapshot) {
  command(0, 0.1, 60);
  wait(0.3);
  const Snapshot snapshot = world->save();
  wait(0.5);
  const std::vector<std::byte> first(world->state_bytes().begin(), world->state_bytes().end());
  ASSERT_TRUE(world->restore(snapshot));
  wait(0.5);
  const std::vector<std::byte> second(world->state_bytes().begin(), world->state_bytes().end());
  EXPECT_TRUE(first == second);
}

TEST_F(GripperTest, CycleDoesNotAllocate) {
  command(0, 0.1, 60);
  wait(0.1);
  takt::test::AllocationGuard guard;
  for (int i = 0; i < 500; ++i) {
    world->gripper("gripper")->write(sent);
    (void)world->step();
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::sim::test
