// A bit in the socket of a screw: torque by shape, and nothing else.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

// An M6 socket head cap screw (ISO 4762) and a key of 32 mm; the figures of docs/threads.md.
constexpr double kShank = 0.012, kHeadHeight = 0.006, kSocketWidth = 0.005, kSocketDepth = 0.003;
constexpr double kKeyLength = 0.032, kKeyPlay = 0.035;
const double kKeyStiffness = 79e9 * 0.1154 * std::pow(kSocketWidth, 4) / kKeyLength;

ObjectDescription cap_screw(const std::string& name) {
  ObjectDescription screw;
  screw.name = name;
  screw.free = true;
  screw.mass = 0.006;
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.003, kShank}, .chamfer = 0.0006});
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.005, kHeadHeight}});
  screw.shapes[0].X_OG.translation().z() = 0.5 * kShank;
  screw.shapes[1].X_OG.translation().z() = kShank + 0.5 * kHeadHeight;
  world::Bore socket{.radius = 0.5 * kSocketWidth, .depth = kSocketDepth};
  socket.X_SB.translation().z() = 0.5 * kHeadHeight;
  screw.shapes[1].bores.push_back(socket);
  screw.screw = ScrewDescription{.thread = {"M6", 0.001, 0.006, 0.00535, 0.06, 0.12}};
  return screw;
}

RobotDescription bit_and_spindle() {
  RobotDescription driver;
  driver.name = "driver";
  driver.model = model("screwdriver");
  driver.mount.parent = "sensor/tool";
  driver.joints.push_back({.joint = "spindle", .armature = 5e-6});
  driver.joints.push_back({.joint = "slide", .spring = JointSpring{.stiffness = 800, .damping = 8, .preload = 2}});
  driver.bits.insert("bit");
  driver.chamfers["bit"] = 0.0005;
  return driver;
}

/// Without gravity: a screwdriver on a sensor points up, and a screw floats over its bit, head down.
/// @param gap  m, from the end of the bit to the bottom of the socket
WorldDescription bit_under_screw(double gap) {
  WorldDescription world;
  world.physics.gravity = Vector3d::Zero();
  RobotDescription sensor;
  sensor.name = "sensor";
  sensor.model = model("ft_gamma");
  world.robots.push_back(sensor);
  world.robots.push_back(bit_and_spindle());
  SimForceTorqueDescription wrist;
  wrist.name = "wrist";
  wrist.tool_side = "sensor/measuring";
  world.force_torque_sensors.push_back(wrist);
  ObjectDescription screw = cap_screw("screw");
  const World measured = make(world);
  const double end = measured.body_pose(measured.body("driver/bit")).translation().z() + kKeyLength;
  screw.mount.X_P.translation().z() = end + gap + kShank + kHeadHeight - kSocketDepth;
  screw.mount.X_P.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  world.objects.push_back(screw);
  return world;
}

/// A screw with a flywheel, so that torques of Newton metres move it slowly.
WorldDescription bit_under_heavy_screw(double gap) {
  WorldDescription world = bit_under_screw(gap);
  kinematics::Inertial inertial;
  inertial.mass = 0.006;
  inertial.I_C = Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  world.objects.back().inertial = inertial;
  return world;
}

class DriveBench {
 public:
  explicit DriveBench(const WorldDescription& description)
      : world(make(description)),
        data_(const_cast<mjData*>(world.physics_data())),
        spindle_(dof("driver/spindle")),
        screw_(dof("screw")) {
    run(20);  // the slide of the bit settles on its stop
  }

  World world;

  /// The same torque forwards on the spindle and backwards on the screw, about the axis of the bit, for that long.
  void wind(double torque, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      torque_ += std::clamp(torque - torque_, -0.01, 0.01);  // Nm a cycle
      data_->qfrc_applied[spindle_] = torque_;
      world.push(world.body("screw"), Eigen::Vector3d::Zero(), {0.0, 0.0, -torque_});
      ASSERT_TRUE(world.step());
    }
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) ASSERT_TRUE(world.step());
  }
  /// Of the bit against the screw, rad.
  [[nodiscard]] double lead() const {
    const Pose X_W = world.body_pose(world.body("screw"));
    return data_->qpos[world.physics_model()->jnt_qposadr[joint("driver/spindle")]] -
           std::atan2(X_W.linear()(1, 0), X_W.linear()(0, 0));
  }
  [[nodiscard]] double& spindle_rate() { return data_->qvel[spindle_]; }
  /// About the axis of the bit.
  [[nodiscard]] double screw_rate() const { return -data_->qvel[screw_ + 5]; }
  void set_screw_rate(double rate) { data_->qvel[screw_ + 5] = -rate; }
  [[nodiscard]] Eigen::Map<Vector3d> screw_velocity() { return Eigen::Map<Vector3d>(data_->qvel + screw_); }
  [[nodiscard]] Eigen::Map<Vector3d> push() { return Eigen::Map<Vector3d>(data_->qfrc_applied + screw_); }
  [[nodiscard]] int contacts() const { return static_cast<int>(data_->ncon); }

 private:
  [[nodiscard]] int joint(const char* name) const { return mj_name2id(world.physics_model(), mjOBJ_JOINT, name); }
  [[nodiscard]] int dof(const char* name) const { return world.physics_model()->jnt_dofadr[joint(name)]; }

  mjData* data_;
  int spindle_, screw_;
  double torque_ = 0.0;
};

TEST(Drive, ABitTurnsAScrewWithoutAForceAlongTheAxis) {
  DriveBench bench(bit_under_heavy_screw(0.001));
  const double torque = 1.0;
  bench.wind(torque, 600);
  EXPECT_EQ(bench.contacts(), 0);
  EXPECT_NEAR(bench.lead(), kKeyPlay + torque / kKeyStiffness, 1e-4);
  // The sensor under the screwdriver feels what the screw exerts on the bit, and no force.
  const device::WrenchSample felt = wrench(bench.world);
  EXPECT_NEAR(felt.wrench.torque.z(), -torque, 0.01);
  EXPECT_LT(felt.wrench.torque.head<2>().norm(), 0.001);
  EXPECT_LT(felt.wrench.force.norm(), 0.01);
}

TEST(Drive, ItHasTheSamePlayBothWays) {
  DriveBench bench(bit_under_heavy_screw(0.001));
  const double torque = 0.5;
  bench.wind(torque, 600);
  const double forwards = bench.lead();
  bench.wind(-torque, 800);
  EXPECT_NEAR(forwards - bench.lead(), 2.0 * (kKeyPlay + torque / kKeyStiffness), 2e-4);
}

TEST(Drive, NothingButTheTurnIsTransmitted) {
  DriveBench bench(bit_under_heavy_screw(0.001));
  bench.wind(0.5, 400);
  const Vector3d before = bench.screw_velocity(), force(0.006, -0.003, 0.012);
  bench.push() = force;
  bench.run(8);
  EXPECT_EQ(bench.contacts(), 0);
  // As fast as the force alone makes it.
  EXPECT_LT((bench.screw_velocity() - before - 0.008 / 0.006 * force).norm(), 1e-9);
}

TEST(Drive, ABitThatIsNotInTheSocketTurnsNothing) {
  for (const double gap : {0.9 * kSocketDepth, kSocketDepth + 0.002}) {
    DriveBench bench(bit_under_screw(gap));
    bench.spindle_rate() = 12.0;
    bench.run(200);
    EXPECT_EQ(bench.screw_rate(), 0.0) << gap;
  }
  DriveBench aside(([] {
    WorldDescription world = bit_under_screw(0.001);
    world.objects.back().mount.X_P.translation().x() += 0.02;
    return world;
  })());
  aside.spindle_rate() = 12.0;
  aside.run(200);
  EXPECT_EQ(aside.screw_rate(), 0.0);
}

TEST(Drive, NoEnergyIsGained) {
  for (const double rate : {0.0, -100.0, 30.0}) {
    DriveBench bench(bit_under_screw(0.001));
    bench.spindle_rate() = 12.0;
    bench.set_screw_rate(rate);
    bench.run(1);  // now the physics knows these velocities
    double least = bench.world.energy();
    for (int i = 0; i < 100; ++i) {
      bench.run(1);
      const double now = bench.world.energy();
      EXPECT_LE(now, least * (1.0 + 1e-9)) << "screw at " << rate << " rad/s, cycle " << i;
      least = std::min(least, now);
    }
    // Flanks that have met part again with a third of their speed.
    EXPECT_NEAR(bench.screw_rate(), bench.spindle_rate(), 0.5) << rate;
  }
}

/// Also in the cycles in which the bit gets into the socket.
TEST(Drive, IsPartOfTheStateAndAllocatesNothing) {
  DriveBench bench(bit_under_screw(kSocketDepth));
  bench.spindle_rate() = 12.0;
  bench.screw_velocity().z() = -0.02;
  bench.run(1);  // now the physics knows these velocities
  std::vector<Snapshot> snapshots;
  for (int i = 0; i < 60; ++i) {
    snapshots.push_back(bench.world.save());
    bench.run(1);
  }
  EXPECT_GT(bench.screw_rate(), 1.0) << "it has been taken along";
  const Snapshot end = bench.world.save();
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    ASSERT_TRUE(bench.world.restore(snapshots[i]));
    bench.run(static_cast<int>(snapshots.size() - i));
    ASSERT_EQ(bench.world.save(), end) << "from cycle " << i;
  }
  ASSERT_TRUE(bench.world.restore(snapshots.front()));
  takt::test::AllocationGuard guard;
  bench.run(60);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::sim::test
