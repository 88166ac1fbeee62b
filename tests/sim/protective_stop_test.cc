// An arm that stops by itself when something pushes it too hard.
#include <cmath>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

WorldDescription guarded_arm(double share) {
  WorldDescription world;
  world.robots.push_back(lwr());
  world.arms.push_back(lwr_controller());
  if (share > 0.0) {
    JointVector effort(7);
    effort << 176, 176, 100, 100, 100, 38, 38;  // of the URDF
    world.arms[0].control.protective_torque = share * effort;
  }
  return world;
}

/// Torques of a force at the flange's centre of mass, from the true posture.
JointVector torques_of(const World& world, const Eigen::Vector3d& force) {
  const mjModel* model = world.physics_model();
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, model->nv);
  mj_jacBodyCom(model, world.physics_data(), J.data(), nullptr, world.body("arm/flange"));
  return (J.transpose() * force).head(7);
}

TEST(ProtectiveStop, ComesWhenAJointIsPushedBeyondItsLimit) {
  const WorldDescription description = guarded_arm(0.5);
  World world = make(description);
  hold(world, lwr_home(), 200);
  const int flange = world.body("arm/flange");
  double push = 0.0;
  while (push < 400.0 && sample(world).fault == 0) {
    push += 2.0;
    world.push(flange, {0.0, 0.0, -push});
    hold(world, lwr_home(), 40);
  }
  EXPECT_EQ(fault_kind(sample(world).fault), ArmFault::kExternalTorque);
  EXPECT_FALSE(sample(world).ready);
  const JointVector share =
      torques_of(world, {0.0, 0.0, -push}).cwiseAbs().cwiseQuotient(description.arms[0].control.protective_torque);
  EXPECT_GT(share.maxCoeff(), 0.9);
  EXPECT_LT(share.maxCoeff(), 1.2);
  // It holds where it stopped, and goes on when the operator says so.
  hold(world, lwr_home(), 500);
  const JointVector stopped = sample(world).q;
  world.push(flange, Eigen::Vector3d::Zero());
  hold(world, lwr_home(), 500);
  EXPECT_LT((sample(world).q - stopped).cwiseAbs().maxCoeff(), 0.01);
  world.arm("arm")->release_brakes();
  hold(world, sample(world).q, 50);
  EXPECT_EQ(sample(world).fault, 0u);
  EXPECT_TRUE(sample(world).ready);
}

TEST(ProtectiveStop, NeedsTheTorqueForTenCycles) {
  World world = make(guarded_arm(0.5));
  hold(world, lwr_home(), 200);
  const int flange = world.body("arm/flange");
  world.push(flange, {0.0, 0.0, -150.0});
  hold(world, lwr_home(), 8);
  world.push(flange, Eigen::Vector3d::Zero());
  hold(world, lwr_home(), 200);
  EXPECT_EQ(sample(world).fault, 0u) << "a blow of 8 ms";
}

TEST(ProtectiveStop, WithoutALimitItNeverComes) {
  World world = make(guarded_arm(0.0));
  hold(world, lwr_home(), 200);
  world.push(world.body("arm/flange"), {0.0, 0.0, -150.0});
  hold(world, lwr_home(), 1000);
  EXPECT_EQ(sample(world).fault, 0u);
}

}  // namespace
}  // namespace takt::sim::test
