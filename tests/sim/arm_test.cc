#include <cmath>
#include <limits>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/machines/arm.h"
#include "tests/sim/cell.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

WorldDescription cell() {
  WorldDescription world;
  world.robots.push_back(lwr());
  add_probe(world);
  world.arms.push_back(lwr_controller());
  return world;
}

Eigen::Vector3d tip(const World& world) { return world.body_pose(world.body("probe/tcp")).translation(); }

/// Smooth move between two positions in `duration` s: position, rate and acceleration at `t`.
device::ArmSetPoint smooth(const JointVector& from, const JointVector& to, double duration, double t) {
  const double s = std::min(t / duration, 1.0);
  const double p = s * s * s * (10 - 15 * s + 6 * s * s);
  const double v = s < 1 ? 30 * s * s * (1 - s) * (1 - s) / duration : 0.0;
  const double a = s < 1 ? 60 * s * (1 - s) * (1 - 2 * s) / (duration * duration) : 0.0;
  return set_point(from + p * (to - from), v * (to - from), a * (to - from));
}

/// Largest distance of the tip from where the set points want it, in a move of about 0.3 m.
double worst_tracking(const WorldDescription& description) {
  World world = make(description);
  const JointVector from = lwr_home();
  JointVector to = from;
  to[0] += 0.5;
  to[1] -= 0.2;
  to[3] += 0.2;
  const kinematics::Chain chain = lwr_chain();
  double worst = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const auto point = smooth(from, to, 1.5, k * 1e-3);
    // The set point of cycle k is where the arm shall be when cycle k begins.
    const Eigen::Vector3d wanted = chain.forward(point.q).translation();
    const Eigen::Vector3d is = world.body_pose(world.body("arm/flange")).translation();
    worst = std::max(worst, (wanted - is).norm());
    world.arm("arm")->write(point);
    EXPECT_TRUE(world.step());
  }
  return worst;
}

TEST(SimArm, HoldsStillAtHome) {
  World world = make(cell());
  const Eigen::Vector3d begin = tip(world);
  hold(world, lwr_home(), 1000);
  EXPECT_LT((sample(world).q - lwr_home()).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((tip(world) - begin).norm(), 1e-4);
  EXPECT_LT(sample(world).dq.cwiseAbs().maxCoeff(), 1e-5);
}

TEST(SimArm, HoldsTheLastPositionWithoutSetPoints) {
  World world = make(cell());
  JointVector dq = JointVector::Zero(7);
  dq[0] = 0.2;
  JointVector q = lwr_home();
  for (int k = 0; k < 500; ++k) {
    q[0] = lwr_home()[0] + 0.2e-3 * k;
    world.arm("arm")->write(set_point(q, dq, JointVector::Zero(7)));
    ASSERT_TRUE(world.step());
  }
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(world.step());
  EXPECT_LT((sample(world).q - q).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT(sample(world).dq.cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SimArm, TracksASmoothMove) { EXPECT_LT(worst_tracking(cell()), 0.5e-3); }

TEST(SimArm, StepOfTenMillimetresSettles) {
  // 10 mm at the tip from axis 1 alone.
  World world = make(cell());
  const JointVector home = lwr_home();
  JointVector goal = home;
  const double radius = tip(world).head<2>().norm();
  goal[0] += 0.010 / radius;
  const double step = goal[0] - home[0];
  double overshoot = 0.0;
  for (int k = 0; k < 200; ++k) {
    hold(world, goal, 1);
    overshoot = std::max(overshoot, sample(world).q[0] - goal[0]);
  }
  EXPECT_LT(overshoot, 0.05 * step);
  double late = 0.0;
  for (int k = 0; k < 300; ++k) {
    hold(world, goal, 1);
    late = std::max(late, std::abs(sample(world).q[0] - goal[0]));
  }
  EXPECT_LT(late * radius, 0.1e-3);
}

TEST(SimArm, D6_HeavierPlantTracksDifferently) {
  // The controller knows the URDF, not the plant: if it read the plant's own mass matrix, both runs would be alike.
  const double nominal = worst_tracking(cell());
  WorldDescription heavy = cell();
  heavy.physics.plant_mass_scale = 1.1;
  EXPECT_GT(worst_tracking(heavy), 1.5 * nominal);
}

TEST(SimArm, PayloadErrorSagsByThePredictedAmount) {
  // 1 kg that the controller believes in and that is not there lifts the arm: its weight against the position loop.
  WorldDescription description = cell();
  description.arms[0].payload_mass_error = 1.0;
  // Exact comparison with statics: without the friction that holds part of the load.
  for (auto& joint : description.robots[0].joints) joint.coulomb = 0.0;
  World world = make(description);
  hold(world, lwr_home(), 3000);
  const JointVector shift = sample(world).q - lwr_home();

  const kinematics::Chain chain = lwr_chain();
  const kinematics::Payload carried = world.arm("arm")->payload();
  kinematics::Payload real = carried;
  real.mass -= 1.0;
  const JointVector zero = JointVector::Zero(7);
  const Eigen::Vector3d gravity(0, 0, -9.81);
  const JointVector q = sample(world).q;
  const JointVector surplus =
      chain.inverse_dynamics(q, zero, zero, gravity, carried) - chain.inverse_dynamics(q, zero, zero, gravity, real);
  kinematics::JointMatrix M = chain.mass_matrix(q, carried);
  for (int i = 0; i < 7; ++i) M(i, i) += description.robots[0].joints[static_cast<std::size_t>(i)].armature;
  const JointVector w = description.arms[0].control.natural_frequency;
  const JointVector predicted = (M.inverse() * surplus).cwiseQuotient(w.cwiseProduct(w));
  EXPECT_LT((shift - predicted).norm(), 0.02 * predicted.norm());
  EXPECT_GT(predicted.norm(), 1e-4);
}

TEST(SimArm, JointTorqueSensorsReadGravityAtRest) {
  const WorldDescription description = cell();
  World world = make(description);
  hold(world, lwr_home(), 1000);
  const JointVector zero = JointVector::Zero(7);
  const JointVector expected =
      lwr_chain().inverse_dynamics(lwr_home(), zero, zero, Eigen::Vector3d(0, 0, -9.81), world.arm("arm")->payload());
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 20.0);
  EXPECT_LT((sample(world).tau - expected).cwiseAbs().maxCoeff(), 0.1);
}

TEST(SimArm, FirstSampleIsThatOfARobotAtRest) {
  World world = make(cell());
  const auto first = sample(world);
  EXPECT_EQ(first.sequence, 1u);
  EXPECT_EQ(first.stamp, 0);
  EXPECT_TRUE(first.ready);
  EXPECT_LT((first.q - lwr_home()).norm(), 1e-12);
  EXPECT_GT(first.tau.cwiseAbs().maxCoeff(), 20.0);
}

TEST(SimArm, MeasurementIsQuantisedAndNoisyAsTold) {
  WorldDescription description = cell();
  auto& measurement = description.arms[0].measurement;
  measurement.position_resolution = 1e-4;
  measurement.torque_noise = JointVector::Constant(7, 0.1);
  World world = make(description);
  double sum = 0.0, squares = 0.0;
  const int n = 2000;
  for (int k = 0; k < n; ++k) {
    hold(world, lwr_home(), 1);
    const auto s = sample(world);
    const double steps = s.q[1] / 1e-4;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
    sum += s.tau[6];
    squares += s.tau[6] * s.tau[6];
  }
  const double sigma = std::sqrt(squares / n - (sum / n) * (sum / n));
  EXPECT_NEAR(sigma, 0.1, 0.02);
}

TEST(SimArm, S3_BrakesStopAndHoldTheArm) {
  World world = make(cell());
  const JointVector from = lwr_home();
  JointVector to = from;
  to[1] += 0.6;
  for (int k = 0; k < 500; ++k) {
    world.arm("arm")->write(smooth(from, to, 1.0, k * 1e-3));
    ASSERT_TRUE(world.step());
  }
  ASSERT_GT(std::abs(sample(world).dq[1]), 0.5);
  world.arm("arm")->brake();
  EXPECT_FALSE(sample(world).ready);
  for (int k = 0; k < 300; ++k) {
    world.arm("arm")->write(smooth(from, to, 1.0, 0.5 + k * 1e-3));  // ignored
    ASSERT_TRUE(world.step());
  }
  const JointVector stopped = sample(world).q;
  EXPECT_LT(std::abs(stopped[1] - (from[1] + 0.3)), 0.2);
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(world.step());
  EXPECT_LT((sample(world).q - stopped).cwiseAbs().maxCoeff(), 1e-3) << "brakes hold against gravity";

  world.arm("arm")->release_brakes();
  EXPECT_TRUE(sample(world).ready);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(world.step());
  EXPECT_LT((sample(world).q - stopped).cwiseAbs().maxCoeff(), 1e-3) << "opened brakes hold where the arm is";
}

TEST(SimArm, BrakingAtRestDoesNotSag) {
  World world = make(cell());
  hold(world, lwr_home(), 500);
  const JointVector before = sample(world).q;
  world.arm("arm")->brake();
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(world.step());
  EXPECT_LT((sample(world).q - before).cwiseAbs().maxCoeff(), 2e-4);
}

TEST(SimArm, FaultsCloseTheBrakesAndSayWhy) {
  const auto fault_after = [](const device::ArmSetPoint& point) {
    World world = make(cell());
    hold(world, lwr_home(), 10);
    world.arm("arm")->write(point);
    EXPECT_TRUE(world.step());
    const auto s = sample(world);
    EXPECT_FALSE(s.ready);
    EXPECT_NE(world.arm("arm")->fault_text(s.fault), world.arm("arm")->fault_text(0)) << "it says something";
    return std::pair(fault_kind(s.fault), world.arm("arm")->fault_text(s.fault));
  };
  JointVector far = lwr_home();
  far[2] += 0.2;
  const auto [fault, text] = fault_after(set_point(far));
  EXPECT_EQ(fault, ArmFault::kFollowingError);
  EXPECT_THAT(text, takt::test::Names("e1")) << "the joint that is away";
  JointVector none = lwr_home();
  none[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fault_after(set_point(none)).first, ArmFault::kSetPointInvalid);
  EXPECT_EQ(fault_after(set_point(JointVector::Zero(3))).first, ArmFault::kSetPointInvalid);
}

TEST(SimArm, OverspeedClosesTheBrakes) {
  WorldDescription description = cell();
  description.arms[0].control.overspeed_factor = 0.1;
  World world = make(description);
  JointVector to = lwr_home();
  to[0] += 0.5;
  for (int k = 0; k < 500; ++k) {
    world.arm("arm")->write(smooth(lwr_home(), to, 1.0, k * 1e-3));
    ASSERT_TRUE(world.step());
  }
  EXPECT_NE(world.arm("arm")->fault_text(sample(world).fault).find("overspeed"), std::string::npos);
}

TEST(SimArm, MotorsNeverExceedTheirLimits) {
  WorldDescription description = cell();
  description.arms[0].control.following_error_limit = 10.0;
  description.arms[0].control.overspeed_factor = 100.0;
  World world = make(description);
  JointVector far = lwr_home();
  far[1] += 1.0;
  const JointVector limit = lwr_chain().effort_limit();
  bool saturated = false;
  for (int k = 0; k < 200; ++k) {
    hold(world, far, 1);
    const JointVector torque = world.arm("arm")->motor_torque();
    ASSERT_TRUE((torque.cwiseAbs().array() <= limit.array()).all());
    saturated = saturated || torque[1] == limit[1] || torque[1] == -limit[1];
  }
  EXPECT_TRUE(saturated) << "the test must reach the limit";
}

}  // namespace
}  // namespace takt::sim::test
