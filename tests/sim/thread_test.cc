// Screws: caught at their pose, pitch, torques, seat, a crossed thread.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;
using Kind = ThreadEvent::Kind;

struct ThreadSize {
  const char* name;
  double pitch, major, pitch_diameter, minor, run_down, head_diameter, head_height;
};
// ISO 261, ISO 724, ISO 4762; run-down torque as models/threads.json.
constexpr ThreadSize kSizes[] = {{"M3", 0.0005, 0.003, 0.002675, 0.002459, 0.01, 0.0055, 0.003},
                                 {"M4", 0.0007, 0.004, 0.003545, 0.003242, 0.02, 0.007, 0.004},
                                 {"M5", 0.0008, 0.005, 0.00448, 0.004134, 0.04, 0.0085, 0.005},
                                 {"M6", 0.001, 0.006, 0.00535, 0.004917, 0.06, 0.01, 0.006},
                                 {"M8", 0.00125, 0.008, 0.007188, 0.006647, 0.12, 0.013, 0.008},
                                 {"M16", 0.002, 0.016, 0.014701, 0.013835, 0.3, 0.024, 0.016}};
constexpr double kFlankFriction = 0.12, kHeadFriction = 0.12;
constexpr double kShankLength = 0.012;

ContactParameters hard_surface() {
  ContactParameters made;
  made.stiffness = 3e6;
  made.damping = 600.0;
  made.friction = kHeadFriction;
  made.own_stiffness = made.own_friction = true;
  return made;
}

/// A screw above a threaded bore, its tip just inside the chamfer.
WorldDescription screw_over_thread(const ThreadSize& size, double lean) {
  WorldDescription world;
  ObjectDescription block = box("block", {0.05, 0.05, 0.03}, {0.0, 0.0, -0.015});
  const double chamfer = 0.6 * (size.major - size.minor);
  world::Bore bore{.radius = 0.5 * size.minor, .depth = 0.02, .chamfer = chamfer, .thread = size.name};
  bore.X_SB.translation().z() = 0.015;
  block.shapes[0].bores.push_back(bore);
  block.contact = hard_surface();
  world.objects.push_back(block);

  ObjectDescription screw;
  screw.name = "screw";
  screw.free = true;
  screw.mass = 0.006;
  screw.contact = hard_surface();
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.5 * size.major, kShankLength}, .chamfer = chamfer});
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.5 * size.head_diameter, size.head_height}});
  screw.shapes[0].X_OG.translation().z() = 0.5 * kShankLength;
  screw.shapes[1].X_OG.translation().z() = kShankLength + 0.5 * size.head_height;
  screw.screw = ScrewDescription{
      .thread = {size.name, size.pitch, size.major, size.pitch_diameter, size.run_down, kFlankFriction}};
  screw.mount.X_P.translation().z() = -chamfer;
  screw.mount.X_P.rotate(Eigen::AngleAxisd(lean, Vector3d::UnitY()));
  world.objects.push_back(screw);
  return world;
}

/// The same bolt upside down and fixed, and a nut that stands on its tip.
WorldDescription nut_on_bolt(const ThreadSize& size) {
  WorldDescription world = screw_over_thread(size, 0.0);
  ObjectDescription bolt = world.objects.back();
  const double chamfer = 0.6 * (size.major - size.minor), height = 0.8 * size.major;
  bolt.name = "bolt";
  bolt.free = false;
  bolt.mount.X_P = Pose(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  ObjectDescription nut;
  nut.name = "nut";
  nut.free = true;
  nut.mass = 0.006;
  nut.contact = hard_surface();
  nut.shapes.push_back({.shape = kinematics::Cylinder{0.8 * size.major, height}});
  world::Bore bore{.radius = 0.5 * size.minor, .chamfer = chamfer, .thread = size.name};
  bore.X_SB = Eigen::Translation3d(0.0, 0.0, -0.5 * height) * Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
  nut.shapes[0].bores.push_back(bore);
  nut.mount.X_P.translation().z() = 0.5 * height - chamfer;
  world.objects = {bolt, nut};
  return world;
}

/// Turns the screw about its own axis with a torque, as a hand does that gives way sideways.
class Hand {
 public:
  explicit Hand(World& world, const char* what = "screw") : world_(world), body_(world.body(what)) {}

  /// @param torque  Nm, to the right   @param rate  rad/s, no faster   @return false: the simulation has failed
  bool turn(double torque, double rate, int cycles) {
    auto* data = const_cast<mjData*>(world_.physics_data());
    const mjModel* model = world_.physics_model();
    const int dof = model->body_dofadr[body_];
    for (int i = 0; i < cycles; ++i) {
      const double now = -data->qvel[dof + 5];  // about its own z, which points to the head
      applied_ = std::clamp(0.002 * torque * (rate - now) + held_, 0.0, torque);
      held_ = std::clamp(held_ + 0.5 * torque * (rate - now) * 0.001, 0.0, torque);
      data->qfrc_applied[dof + 5] = -applied_;
      if (!world_.step()) return false;
    }
    data->qfrc_applied[dof + 5] = 0.0;
    return true;
  }
  [[nodiscard]] double applied() const { return applied_; }

 private:
  World& world_;
  int body_;
  double applied_ = 0.0, held_ = 0.0;
};

std::vector<Kind> kinds(const World& world) {
  std::vector<Kind> found;
  for (const ThreadEvent& event : world.threads().events()) found.push_back(event.kind);
  return found;
}

TEST(Thread, ANutGoesDownAFixedBoltByThePitchATurnAndSeatsOnItsHead) {
  for (const ThreadSize& size : kSizes) {
    World world = make(nut_on_bolt(size));
    Hand hand(world, "nut");
    ASSERT_TRUE(hand.turn(3.0 * size.run_down, 6.0, 200));
    ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught})) << size.name;
    const int body = world.body("nut");
    const double height = world.body_pose(body).translation().z(), angle = world.threads().turned(0);
    ASSERT_TRUE(hand.turn(3.0 * size.run_down, 6.0, 2000));
    const double turns = (world.threads().turned(0) - angle) / (2.0 * std::numbers::pi);
    ASSERT_GT(turns, 1.2) << size.name;
    EXPECT_NEAR((height - world.body_pose(body).translation().z()) / turns, size.pitch, 0.01 * size.pitch) << size.name;
    EXPECT_NEAR(hand.applied(), size.run_down, 0.1 * size.run_down) << size.name;
    EXPECT_LT(world.body_pose(body).translation().head<2>().norm(), 1e-5);
    ASSERT_TRUE(hand.turn(20.0 * size.run_down, 30.0, 6000));
    EXPECT_EQ(kinds(world), (std::vector{Kind::kCaught, Kind::kSeated})) << size.name;
  }
}

TEST(Thread, ANutThatIsTurnedBackIsFree) {
  World world = make(nut_on_bolt(kSizes[3]));
  Hand hand(world, "nut");
  ASSERT_TRUE(hand.turn(3.0 * kSizes[3].run_down, 6.0, 400));
  ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught}));
  auto* data = const_cast<mjData*>(world.physics_data());
  const int dof = world.physics_model()->body_dofadr[world.body("nut")];
  for (int i = 0; i < 3000 && world.threads().events().size() < 2; ++i) {
    data->qfrc_applied[dof + 5] = data->qvel[dof + 5] < 6.0 ? 3.0 * kSizes[3].run_down : 0.0;
    ASSERT_TRUE(world.step());
  }
  EXPECT_EQ(kinds(world), (std::vector{Kind::kCaught, Kind::kReleased}));
}

TEST(Thread, AScrewGoesInByItsPitchATurn) {
  for (const ThreadSize& size : kSizes) {
    World world = make(screw_over_thread(size, 0.0));
    Hand hand(world);
    ASSERT_TRUE(hand.turn(3.0 * size.run_down, 6.0, 200));
    ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught})) << size.name;
    const int body = world.body("screw");
    const double height = world.body_pose(body).translation().z(), angle = world.threads().turned(0);
    ASSERT_TRUE(hand.turn(3.0 * size.run_down, 6.0, 3000));
    const double turns = (world.threads().turned(0) - angle) / (2.0 * std::numbers::pi);
    ASSERT_GT(turns, 1.5) << size.name;
    const double a_turn = (height - world.body_pose(body).translation().z()) / turns;
    EXPECT_NEAR(a_turn, size.pitch, 0.01 * size.pitch) << size.name;
    // Free of the seat it takes the run-down torque.
    EXPECT_NEAR(hand.applied(), size.run_down, 0.1 * size.run_down) << size.name;
    EXPECT_LT(world.body_pose(body).translation().head<2>().norm(), 1e-5);
  }
}

/// The flanks rub where a force across the axis presses them: mu F d2 / 2 more than the run-down torque.
TEST(Thread, AForceAcrossTheAxisMakesItHeavier) {
  const ThreadSize& size = kSizes[3];
  World world = make(screw_over_thread(size, 0.0));
  Hand hand(world);
  ASSERT_TRUE(hand.turn(0.3, 6.0, 2500));
  ASSERT_GT(world.threads().turned(0), 2.0 * std::numbers::pi);
  const double free = hand.applied(), force = 60.0;
  world.push(world.body("screw"), {force, 0.0, 0.0});
  ASSERT_TRUE(hand.turn(0.3, 6.0, 1000));
  const double more = kFlankFriction * force * 0.5 * size.pitch_diameter;
  EXPECT_NEAR(hand.applied() - free, more, 0.1 * more);
}

/// Pulled up by more than what tells a seat, far from the end of its thread.
TEST(Thread, AScrewThatSomebodyPullsIsNotSeated) {
  World world = make(screw_over_thread(kSizes[3], 0.0));
  Hand hand(world);
  ASSERT_TRUE(hand.turn(0.3, 6.0, 1000));
  world.push(world.body("screw"), {0.0, 0.0, 30.0});
  ASSERT_TRUE(hand.turn(0.3, 6.0, 200));
  EXPECT_EQ(kinds(world), (std::vector{Kind::kCaught}));
}

TEST(Thread, TheHeadSeatsAndTheTorqueStaysInTheScrew) {
  const ThreadSize& size = kSizes[3];
  WorldDescription description = screw_over_thread(size, 0.0);
  World world = make(description);
  const std::size_t watch = *world.watch_contact("screw", "block");
  Hand hand(world);
  const double torque = 1.0;
  ASSERT_TRUE(hand.turn(torque, 12.0, 12000));
  ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught, Kind::kSeated}));
  // At rest, and the head presses as pitch and friction say: T = F (P / 2 pi + mu d2 / 2 cos 30 + mu r) + run-down.
  const double clamped = world.contact(watch).force_W.z();
  const double head_radius = 0.5 * size.head_diameter;
  const double lever = size.pitch / (2.0 * std::numbers::pi) +
                       kFlankFriction * 0.5 * size.pitch_diameter / std::cos(std::numbers::pi / 6.0);
  const double least = (torque - size.run_down) / (lever + kHeadFriction * head_radius);
  const double most = (torque - size.run_down) / (lever + kHeadFriction * 0.5 * size.major);
  EXPECT_GT(std::abs(clamped), 0.9 * least);
  EXPECT_LT(std::abs(clamped), 1.1 * most);
  // Let go, it stays tight.
  const double angle = world.threads().turned(0);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(world.step());
  EXPECT_NEAR(world.threads().turned(0), angle, 0.1);
  EXPECT_NEAR(std::abs(world.contact(watch).force_W.z()), std::abs(clamped), 0.1 * std::abs(clamped));
}

TEST(Thread, TurnedBackItIsFreeAgain) {
  World world = make(screw_over_thread(kSizes[3], 0.0));
  Hand hand(world);
  ASSERT_TRUE(hand.turn(0.3, 6.0, 1500));
  ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught}));
  auto* data = const_cast<mjData*>(world.physics_data());
  const int dof = world.physics_model()->body_dofadr[world.body("screw")];
  for (int i = 0; i < 3000 && kinds(world).size() == 1; ++i) {
    data->qfrc_applied[dof + 5] = 0.09;
    ASSERT_TRUE(world.step());
  }
  EXPECT_EQ(kinds(world), (std::vector{Kind::kCaught, Kind::kReleased}));
  // Nothing pushes it as it is let go.
  data->qfrc_applied[dof + 5] = 0.0;
  const Vector3d before = Eigen::Map<const Vector3d>(data->qvel + dof);
  ASSERT_TRUE(world.step());
  EXPECT_LT((Eigen::Map<const Vector3d>(data->qvel + dof) - before).norm(), 0.015);  // m/s: gravity's share is 0.0098
}

TEST(Thread, ACrossedThreadIsHeavyWithinAQuarterTurn) {
  for (const ThreadSize& size : kSizes) {
    const double crossing = std::atan(0.5 * size.pitch / size.major);
    // It floats just clear of the chamfer, so that it stays as it leans until it is caught.
    WorldDescription description = screw_over_thread(size, 1.5 * crossing);
    description.physics.gravity = Vector3d::Zero();
    description.objects[1].mount.X_P.translation().z() += 0.4 * size.pitch;
    World world = make(description);
    Hand hand(world);
    // Twice the run-down torque is what one would notice; it comes to rest before 90 degrees.
    ASSERT_TRUE(hand.turn(2.0 * size.run_down, 3.0, 2000));
    ASSERT_EQ(kinds(world), (std::vector{Kind::kCrossed})) << size.name;
    EXPECT_LT(world.threads().turned(0), 0.5 * std::numbers::pi) << size.name;
    EXPECT_GT(world.threads().turned(0), 0.0) << size.name;
    EXPECT_NEAR(hand.applied(), 2.0 * size.run_down, 0.05 * size.run_down);
  }
}

TEST(Thread, NothingIsCaughtThatDoesNotFit) {
  const auto caught = [](const WorldDescription& description, double torque) {
    World world = make(description);
    Hand hand(world);
    EXPECT_TRUE(hand.turn(torque, 6.0, 300));
    return !world.threads().events().empty();
  };
  EXPECT_TRUE(caught(screw_over_thread(kSizes[3], 0.0), 0.1));
  EXPECT_FALSE(caught(screw_over_thread(kSizes[3], 0.0), 0.0)) << "not turned";
  WorldDescription other = screw_over_thread(kSizes[3], 0.0);
  other.objects[0].shapes[0].bores[0].thread = "M5";
  EXPECT_FALSE(caught(other, 0.1)) << "another size";
  WorldDescription aside = screw_over_thread(kSizes[3], 0.0);
  aside.objects[1].mount.X_P.translation() += Vector3d(0.003, 0.0, 0.002);
  EXPECT_FALSE(caught(aside, 0.001)) << "beside the mouth";
}

TEST(Thread, ABoreThatHoldsNoTurnIsReported) {
  WorldDescription thin = screw_over_thread(kSizes[3], 0.0);
  thin.objects[0].shapes[0].bores[0].depth = 0.0016;
  const auto world = World::create(thin);
  ASSERT_FALSE(world);
  EXPECT_THAT(world.error(),
              takt::test::Reports(Code::kOutOfRange, "/objects/block/bores/0", {"M6", "0.001", "0.0009502"}));
}

/// A hand that shakes turns it to and fro by 1.5 degrees.
TEST(Thread, WobblingDoesNotStartAThread) {
  World world = make(screw_over_thread(kSizes[3], 0.0));
  auto* data = const_cast<mjData*>(world.physics_data());
  const int dof = world.physics_model()->body_dofadr[world.body("screw")];
  for (int i = 0; i < 500; ++i) {
    data->qvel[dof + 5] = i / 10 % 2 == 0 ? 2.5 : -2.5;
    ASSERT_TRUE(world.step());
  }
  EXPECT_TRUE(world.threads().events().empty());
}

/// The block stands on a sensor, which feels what the thread does to it.
TEST(Thread, ASensorUnderTheBlockFeelsTheTorque) {
  WorldDescription description = screw_over_thread(kSizes[3], 0.0);
  RobotDescription sensor;
  sensor.name = "sensor";
  sensor.model = model("ft_gamma");
  sensor.mount.X_P.translation().z() = -0.2;
  description.robots.push_back(sensor);
  description.objects[0].mount.parent = "sensor/tool";
  description.objects[0].mount.X_P = Pose::Identity();
  SimForceTorqueDescription wrist;
  wrist.name = "wrist";
  wrist.tool_side = "sensor/measuring";
  description.force_torque_sensors.push_back(wrist);
  const World measured = make(description);
  const double mouth = measured.body_pose(measured.body("block")).translation().z() + 0.015;
  description.objects[1].mount.X_P.translation().z() += mouth;

  World world = make(description);
  Hand hand(world);
  ASSERT_TRUE(hand.turn(0.5, 6.0, 800));
  ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught}));
  const Vector3d torque = wrench(world).wrench.torque;
  EXPECT_NEAR(torque.z(), -hand.applied(), 0.02 * kSizes[3].run_down);
  EXPECT_LT(torque.head<2>().norm(), 0.001);
}

/// Also from the cycle in which it is caught.
TEST(Thread, AStateGoesOnBitForBit) {
  World world = make(screw_over_thread(kSizes[3], 0.0));
  auto* data = const_cast<mjData*>(world.physics_data());
  data->qfrc_applied[world.physics_model()->body_dofadr[world.body("screw")] + 5] = -2e-6;
  std::vector<Snapshot> snapshots;
  for (int i = 0; i < 120; ++i) {
    snapshots.push_back(world.save());
    ASSERT_TRUE(world.step());
  }
  ASSERT_EQ(kinds(world), (std::vector{Kind::kCaught}));
  const Snapshot end = world.save();
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    ASSERT_TRUE(world.restore(snapshots[i]));
    for (std::size_t k = i; k < snapshots.size(); ++k) ASSERT_TRUE(world.step());
    ASSERT_EQ(world.save(), end) << "from cycle " << i;
  }
}

TEST(Thread, IsPartOfTheStateAndAllocatesNothing) {
  World world = make(screw_over_thread(kSizes[3], 0.0));
  Hand hand(world);
  ASSERT_TRUE(hand.turn(0.2, 6.0, 500));
  const Snapshot snapshot = world.save();
  ASSERT_TRUE(hand.turn(0.2, 6.0, 200));
  const double there = world.threads().turned(0);
  ASSERT_TRUE(world.restore(snapshot));
  EXPECT_LT(world.threads().turned(0), there);
  Hand again(world);
  takt::test::AllocationGuard guard;
  const bool stepped = again.turn(0.2, 6.0, 100);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(stepped);
}

}  // namespace
}  // namespace takt::sim::test
