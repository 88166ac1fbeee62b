// A mobile base in MuJoCo: where it goes, what its odometry says, how its wheels turn, what rides on it.
#include <cmath>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/device/base_description.h"
#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

constexpr double kRadius = 0.0475, kLever = 0.385;

const device::BaseDescription& youbot() {
  static const auto base = device::read_base("models/youbot_base");
  if (!base) ADD_FAILURE() << base.error().to_string();
  return **base;
}

WorldDescription base_alone(const OdometryError& error = {}) {
  WorldDescription world;
  world.robots.push_back(arm_body("base", youbot(), {}));
  world.arms.push_back(simulated_base("base", "base", youbot()));
  world.arms.back().drive->error = error;
  return world;
}

const device::BaseDescription& rmp() {
  static const auto base = device::read_base("models/rmp50");
  if (!base) ADD_FAILURE() << base.error().to_string();
  return **base;
}

WorldDescription rolling_alone(const OdometryError& error = {}) {
  WorldDescription world;
  world.robots.push_back(arm_body("base", rmp(), {}));
  world.arms.push_back(simulated_base("base", "base", rmp()));
  world.arms.back().drive->error = error;
  return world;
}

WorldDescription with_arm() {
  const auto arm = device::read_arm("models/lwr4plus");
  EXPECT_TRUE(arm);
  WorldDescription world = base_alone();
  world.robots.push_back(arm_body("arm", **arm, {.parent = "base/" + youbot().mount_link}));
  world.arms.push_back(simulated_arm("arm", "arm", **arm));
  return world;
}

JointVector place(double x, double y, double yaw) {
  JointVector q(3);
  q << x, y, yaw;
  return q;
}

JointVector measured(World& world, const char* name = "base") {
  device::ArmSample sample;
  EXPECT_TRUE(world.arm(name)->read(sample));
  EXPECT_EQ(sample.fault, 0u) << world.arm(name)->fault_text(sample.fault);
  return sample.q;
}

/// Where the body really is.
JointVector truth(World& world) {
  const Pose X_WF = world.body_pose(world.body("base/body"));
  return place(X_WF.translation().x(), X_WF.translation().y(), std::atan2(X_WF.linear()(1, 0), X_WF.linear()(0, 0)));
}

/// Tells the base to go to `goal` in that time on a polynomial, then to stand for half a second; all other arms hold.
void drive(World& world, const JointVector& goal, double seconds) {
  device::ArmSample sample;
  ASSERT_TRUE(world.arm("base")->read(sample));
  const JointVector start = sample.q, way = goal - start;
  const int cycles = static_cast<int>(seconds * 1000);
  for (int k = 1; k <= cycles + 500; ++k) {
    const double t = std::min(1.0, static_cast<double>(k) / cycles);
    const double s = t * t * t * (10 - 15 * t + 6 * t * t), ds = 30 * t * t * (1 - t) * (1 - t) / seconds;
    const double dds = 60 * t * (1 - t) * (1 - 2 * t) / (seconds * seconds);
    device::ArmSetPoint set_point;
    set_point.cycle = k;
    set_point.q = start + s * way;
    set_point.dq = ds * way;
    set_point.ddq = dds * way;
    world.arm("base")->write(set_point);
    ASSERT_TRUE(world.step());
  }
}

double wheel_angle(const World& world, const std::string& wheel) {
  const mjModel* m = world.physics_model();
  return world.physics_data()->qpos[m->jnt_qposadr[mj_name2id(m, mjOBJ_JOINT, ("base/" + wheel).c_str())]];
}

TEST(SimBase, GoesWhereItIsToldAndItsOdometryIsRight) {
  World world = make(base_alone());
  for (const JointVector& goal : {place(0.8, 0, 0), place(0.8, -0.5, 1.2), place(-0.2, 0.3, 4.0)}) {
    drive(world, goal, 10.0);
    EXPECT_LT((measured(world) - goal).cwiseAbs().maxCoeff(), 1e-3);
    JointVector error = truth(world) - goal;
    error[2] = std::remainder(error[2], 2.0 * M_PI);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-3);
    const Pose X_WF = world.body_pose(world.body("base/body"));
    EXPECT_EQ(X_WF.translation().z(), 0.0) << "it slides on the floor";
  }
}

TEST(SimBase, WheelsRollAsTheBodyMoves) {
  World world = make(base_alone());
  const char* const wheels[] = {"front_left", "front_right", "rear_left", "rear_right"};
  const double ways[3][5] = {{1, 1, 1, 1, 1.0}, {-1, 1, 1, -1, 1.0}, {-1, 1, -1, 1, kLever}};  // per m, m, rad
  for (int axis = 0; axis < 3; ++axis) {
    double before[4];
    for (int i = 0; i < 4; ++i) before[i] = wheel_angle(world, wheels[i]);
    const JointVector from = truth(world);
    // Along the body's own axes: its heading is 0 until the last of them.
    JointVector goal = from;
    goal[axis] += 0.7;
    drive(world, goal, 4.0);
    const double way = truth(world)[axis] - from[axis];
    EXPECT_NEAR(way, 0.7, 1e-3);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(wheel_angle(world, wheels[i]) - before[i], ways[axis][i] * ways[axis][4] * way / kRadius, 0.02)
          << "axis " << axis << ", " << wheels[i];
    }
  }
}

TEST(SimBase, AWrongScaleOfTheOdometryIsSeenInTheTruthOnly) {
  World world = make(base_alone({.linear_scale = 1.02, .angular_scale = 0.98}));
  drive(world, place(1.0, 0, 0), 5.0);
  EXPECT_NEAR(measured(world)[0], 1.0, 1e-3);
  EXPECT_NEAR(truth(world)[0], 1.0 / 1.02, 1e-3);
  drive(world, place(1.0, 0, 1.0), 4.0);
  EXPECT_NEAR(measured(world)[2], 1.0, 1e-3);
  EXPECT_NEAR(truth(world)[2], 1.0 / 0.98, 1e-3);
  // It now points 1.02 rad to the left and believes 1 rad: the way ahead is turned by the difference.
  drive(world, place(1.0 + 0.5 * std::cos(1.0), 0.5 * std::sin(1.0), 1.0), 4.0);
  const double believed = 1.0 / 0.98;
  EXPECT_NEAR(truth(world)[0], 1.0 / 1.02 * (1.0 + 0.5 * std::cos(believed)), 2e-3);
  EXPECT_NEAR(truth(world)[1], 1.0 / 1.02 * 0.5 * std::sin(believed), 2e-3);
}

TEST(SimBase, ADriftOfTheHeadingBendsTheWay) {
  constexpr double kDrift = 0.05;  // rad/m
  World world = make(base_alone({.heading_drift = kDrift}));
  drive(world, place(2.0, 0, 0), 9.0);
  EXPECT_LT((measured(world) - place(2.0, 0, 0)).cwiseAbs().maxCoeff(), 1e-3);
  // It counts a turn to the left that is not there, and steers against it: an arc of curvature -kDrift.
  EXPECT_NEAR(truth(world)[2], -2.0 * kDrift, 1e-3);
  EXPECT_NEAR(truth(world)[1], -(1.0 - std::cos(2.0 * kDrift)) / kDrift, 2e-3);
}

TEST(SimBase, RandomErrorsGrowWithTheRootOfTheWayAndAreDrawnFromTheSeed) {
  const auto off = [](std::uint64_t seed) {
    WorldDescription description = base_alone({.random_walk = 0.01});
    description.seed = seed;
    World world = make(description);
    drive(world, place(1.0, 0, 0), 5.0);
    return Eigen::Vector2d((truth(world) - place(1.0, 0, 0)).head<2>());
  };
  double square = 0.0;
  constexpr int kRuns = 12;
  for (int seed = 1; seed <= kRuns; ++seed) square += off(static_cast<std::uint64_t>(seed)).squaredNorm();
  const double sigma = std::sqrt(square / (2 * kRuns));
  EXPECT_GT(sigma, 0.006) << "m after a metre; 0.01 is meant";
  EXPECT_LT(sigma, 0.015);
  EXPECT_EQ(off(3), off(3));
}

/// Ahead, a turn on the spot, and back: what its wheels can do. At no time does the body go sideways.
TEST(RollingBase, DrivesAlongItsHeadingAndTurns) {
  World world = make(rolling_alone());
  double worst = 0.0;
  const JointVector goals[] = {place(1.0, 0, 0), place(1.0, 0, 1.0), place(1.0 - std::cos(1.0), -std::sin(1.0), 1.0)};
  for (const JointVector& goal : goals) {
    drive(world, goal, 6.0);
    EXPECT_LT((measured(world) - goal).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_LT((truth(world) - goal).cwiseAbs().maxCoeff(), 1e-3);
    const Pose X_WF = world.body_pose(world.body("base/body"));
    worst = std::max(worst, std::abs(X_WF.translation().z()));
  }
  EXPECT_EQ(worst, 0.0);
}

/// Told to go sideways (no planner would) it does not go: its motors have no force in that direction.
TEST(RollingBase, DoesNotGoSidewaysWhateverItIsTold) {
  World world = make(rolling_alone());
  drive(world, place(0, 0.05, 0), 1.0);
  EXPECT_LT(std::abs(truth(world)[1]), 1e-4);
  EXPECT_LT(std::abs(truth(world)[2]), 0.05);
}

/// At rest a base does not creep: its friction holds what its drives make of a few micrometres, and small pushes.
TEST(SimBase, StaticFrictionHoldsWhatStands) {
  World world = make(base_alone({.linear_scale = 1.01, .random_walk = 0.001}));
  drive(world, place(0.3, 0.1, 0.2), 3.0);
  const JointVector before = truth(world);
  drive(world, measured(world), 2.0);
  EXPECT_LT((truth(world) - before).cwiseAbs().maxCoeff(), 1e-5);
  const int body = world.body("base/body");
  const JointVector parked = measured(world);
  device::ArmSetPoint set_point;
  set_point.q = parked;
  set_point.dq = set_point.ddq = place(0, 0, 0);
  const auto pushed = [&](double force) {
    world.push(body, Eigen::Vector3d(force, 0, 0));
    for (int k = 0; k < 500; ++k) {
      world.arm("base")->write(set_point);
      EXPECT_TRUE(world.step());
    }
    return truth(world)[0] - before[0];
  };
  constexpr double friction = 6.0;  // N, models/youbot_base
  EXPECT_LT(std::abs(pushed(0.5 * friction)), 1e-4);
  // What is stronger meets the drives, which bring it back when the push is over.
  EXPECT_GT(pushed(5.0 * friction), 1e-4);
  (void)pushed(0.0);
  EXPECT_LT((measured(world) - parked).cwiseAbs().maxCoeff(), 1e-3);
}

/// A push of 100 N from the side is held by the tyres, one of 400 N makes them slip, and the odometry sees neither.
TEST(RollingBase, TyresHoldAPushFromTheSideUntilTheySlip) {
  for (const double force : {100.0, 400.0}) {
    World world = make(rolling_alone());
    drive(world, place(0, 0, 0), 0.1);
    const int body = world.body("base/body");
    // Not for long where they slip: at overspeed the drives close their brakes.
    const int cycles = force < 200.0 ? 300 : 60;
    for (int k = 0; k < cycles; ++k) {
      world.push(body, Eigen::Vector3d(0, force, 0));
      ASSERT_TRUE(world.step());
    }
    const double moved = truth(world)[1];
    if (force < 200.0) {
      EXPECT_NEAR(moved, force / 100000.0, 3e-4);
    } else {
      EXPECT_GT(moved, 0.005);
    }
    EXPECT_LT(std::abs(measured(world)[1]), 1e-4);
  }
}

/// From 20 mm beside its line it comes back to it while it drives, although nothing can push it there.
TEST(RollingBase, SteersBackToItsLine) {
  World world = make(rolling_alone());
  device::ArmSample sample;
  constexpr double kSpeed = 0.4, kBeside = 0.02;
  for (int k = 1; k <= 6000; ++k) {
    const double t = 1e-3 * k, v = std::min(kSpeed, 0.4 * t), x = t < 1.0 ? 0.2 * t * t : 0.2 + kSpeed * (t - 1.0);
    device::ArmSetPoint set_point;
    set_point.cycle = k;
    set_point.q = place(x, kBeside, 0);
    set_point.dq = place(v, 0, 0);
    set_point.ddq = place(t < 1.0 ? 0.4 : 0.0, 0, 0);
    world.arm("base")->write(set_point);
    ASSERT_TRUE(world.step());
  }
  EXPECT_NEAR(truth(world)[1], kBeside, 1e-3);
}

TEST(RollingBase, WheelsRollAsTheBodyMoves) {
  World world = make(rolling_alone());
  drive(world, place(0.6, 0, 0), 4.0);
  EXPECT_NEAR(wheel_angle(world, "left_wheel"), 0.6 / 0.2404, 0.01);
  EXPECT_NEAR(wheel_angle(world, "right_wheel"), 0.6 / 0.2404, 0.01);
  drive(world, place(0.6, 0, 1.0), 4.0);
  EXPECT_NEAR(wheel_angle(world, "right_wheel") - wheel_angle(world, "left_wheel"), 0.538 / 0.2404, 0.01);
}

/// What a base weighs with all that it carries, N.
double weight_of(const World& world) {
  const mjModel* m = world.physics_model();
  return 9.81 * m->body_subtreemass[world.body("base/body")];
}

/// On a floor that is smooth, so that the brakes hold more than the wheels.
TEST(SimBase, SlipsWhereAPushIsMoreThanItsWheelsHold) {
  constexpr double kGrip = 0.3;
  WorldDescription description = base_alone();
  description.arms.back().drive->grip = kGrip;
  World world = make(description);
  ASSERT_TRUE(world.step());
  world.arm("base")->brake();
  const int body = world.body("base/body");
  const double grip = kGrip * weight_of(world);
  const auto pushed = [&](double force, int cycles) {
    world.push(body, Eigen::Vector3d(force, 0, 0));
    for (int i = 0; i < cycles; ++i) EXPECT_TRUE(world.step());
    return truth(world)[0];
  };
  ASSERT_GT(grip, 0.0);
  EXPECT_LT(pushed(0.9 * grip, 500), 2e-3) << "it holds";
  (void)pushed(0.0, 500);
  const double begin = truth(world)[0];
  const double mass = weight_of(world) / 9.81, a = 0.2 * grip / mass;
  const double way = pushed(1.2 * grip, 500) - begin;
  // Its wheels, which turn with it in the simulation, add a little to its mass.
  EXPECT_NEAR(way, 0.5 * a * 0.25, 0.15 * way);
  (void)pushed(0.0, 500);
  const double slid = truth(world)[0] - begin;
  EXPECT_NEAR(slid, way * 1.2, 0.1 * slid) << "it brakes with its friction: a sixth of the way";
  EXPECT_LT(measured(world)[0], 5e-3) << "its wheels have not turned";
}

TEST(SimBase, TipsWhereTheLoadIsBeyondItsWheels) {
  const auto fault_with = [](double mass, const Eigen::Vector3d& at) {
    WorldDescription description = base_alone();
    ObjectDescription load = box("load", {0.1, 0.1, 0.1}, at);
    load.mount.parent = "base/body";
    load.mass = mass;
    description.objects.push_back(load);
    World world = make(description);
    device::ArmSample sample;
    for (int i = 0; i < 300; ++i) EXPECT_TRUE(world.step());
    EXPECT_TRUE(world.arm("base")->read(sample));
    return fault_kind(sample.fault);
  };
  // Of 22 kg and its wheels, which stand 150 mm to the left and right of its middle, 235 mm before and behind it.
  EXPECT_EQ(fault_with(10.0, {0.0, 0.3, 0.3}), ArmFault::kNone);
  EXPECT_EQ(fault_with(100.0, {0.0, 0.3, 0.3}), ArmFault::kTips);
  EXPECT_EQ(fault_with(100.0, {0.0, 0.1, 0.3}), ArmFault::kNone);
  EXPECT_EQ(fault_with(100.0, {0.2, 0.0, 0.3}), ArmFault::kNone);
  EXPECT_EQ(fault_with(100.0, {-0.4, 0.0, 0.3}), ArmFault::kTips);
}

/// A short push at the top leaves a wheel without load for a moment, and the base falls back.
TEST(SimBase, AShortBlowDoesNotTipIt) {
  const auto fault_after = [](int cycles) {
    World world = make(base_alone());
    const int body = world.body("base/body");
    world.push(body, Eigen::Vector3d::Zero(), Eigen::Vector3d(0.3 * weight_of(world), 0, 0));
    for (int i = 0; i < cycles; ++i) EXPECT_TRUE(world.step());
    world.push(body, Eigen::Vector3d::Zero());
    for (int i = 0; i < 200; ++i) EXPECT_TRUE(world.step());
    device::ArmSample sample;
    EXPECT_TRUE(world.arm("base")->read(sample));
    return fault_kind(sample.fault);
  };
  EXPECT_EQ(fault_after(50), ArmFault::kNone);
  EXPECT_EQ(fault_after(150), ArmFault::kTips);
}

TEST(SimBase, ASnapshotHoldsTheOdometry) {
  WorldDescription description = base_alone({.linear_scale = 1.02, .random_walk = 0.01});
  World world = make(description);
  drive(world, place(0.3, 0.2, 0.4), 3.0);
  const Snapshot middle = world.save();
  drive(world, place(0.6, 0.0, 0.0), 3.0);
  const JointVector first = truth(world), counted = measured(world);
  ASSERT_TRUE(world.restore(middle));
  drive(world, place(0.6, 0.0, 0.0), 3.0);
  EXPECT_EQ(truth(world), first);
  EXPECT_EQ(measured(world), counted);
}

TEST(SimBase, AnArmOnTopMovesWithItAndFeelsIt) {
  World world = make(with_arm());
  const double arm_mass = model("lwr4plus")->total_mass();
  EXPECT_NEAR(world.arm("base")->payload().mass, arm_mass, 1e-9) << "the base is told what it carries";
  const JointVector home = measured(world, "arm");
  const auto tool = [&] { return world.body_pose(world.body("arm/flange")); };
  const Pose X_BT = world.body_pose(world.body("base/body")).inverse() * tool();
  double most = 0.0;
  // Quick enough to be felt: 0.25 m/s after half a second.
  device::ArmSample sample;
  for (int k = 1; k <= 1000; ++k) {
    const double v = std::min(0.25, 0.5e-3 * k);
    device::ArmSetPoint set_point;
    set_point.cycle = k;
    set_point.q = place(k <= 500 ? 0.25e-6 * k * k : 0.0625 + 0.25e-3 * (k - 500), 0, 0);
    set_point.dq = place(v, 0, 0);
    set_point.ddq = place(k <= 500 ? 0.5 : 0.0, 0, 0);
    world.arm("base")->write(set_point);
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(world.arm("arm")->read(sample));
    if (k > 50) most = std::max(most, (sample.q - home).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(most, 1e-5) << "rad: it is pushed";
  EXPECT_LT(most, 5e-3) << "and holds against it";
  drive(world, place(0.5, 0.3, 1.0), 4.0);
  const Pose now = world.body_pose(world.body("base/body")).inverse() * tool();
  EXPECT_LT((now.translation() - X_BT.translation()).norm(), 1e-3);
}

TEST(SimBase, CycleDoesNotAllocate) {
  World world = make(base_alone({.heading_drift = 0.01, .random_walk = 0.01}));
  drive(world, place(0.1, 0, 0), 1.0);
  device::ArmSample sample;
  device::ArmSetPoint set_point;
  set_point.q = place(0.1, 0, 0);
  set_point.dq = set_point.ddq = place(0, 0, 0);
  takt::test::AllocationGuard guard;
  for (int k = 0; k < 100; ++k) {
    world.arm("base")->write(set_point);
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(world.arm("base")->read(sample));
  }
  EXPECT_EQ(guard.count(), 0u);
}

TEST(SimBase, WrongFiguresAreFindings) {
  WorldDescription description = base_alone({.linear_scale = 0.0, .random_walk = -1.0});
  description.arms.back().drive->wheels[1] = "yaww";
  const auto world = World::create(description);
  ASSERT_FALSE(world);
  const std::string text = world.error().to_string();
  for (const char* found : {"linear scale", "random walk", "'yaww' is not a wheel"})
    EXPECT_NE(text.find(found), std::string::npos) << text;
}

}  // namespace
}  // namespace takt::sim::test
