// The integral part of the simulated position controllers: it takes away what friction they do not know, and nothing
// else (docs/simulation.md, "Friction that the model lacks").
#include "sim/machines/friction_observer.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

JointVector two(double a, double b) {
  JointVector v(2);
  v << a, b;
  return v;
}

TEST(FrictionObserver, FollowsWhatTheModelLacksWithItsRate) {
  FrictionObserver observer(two(50.0, 0.0), 0.5);
  // 2 Nm more are given than the model says are needed: that is friction.
  for (int k = 0; k < 20; ++k) observer.update(two(1.0, 1.0), two(3.0, 3.0), 1e-3);
  const JointVector torque = observer.compensation(two(100.0, 100.0), two(1e3, 1e3));
  EXPECT_NEAR(torque[0], 2.0 * (1.0 - std::pow(0.95, 20)), 1e-12);
  EXPECT_EQ(torque[1], 0.0) << "a joint without a rate has no observer";
}

TEST(FrictionObserver, GivesAtMostItsShareOfTheFrictionAndNothingAtAStandstill) {
  FrictionObserver observer(two(50.0, 50.0), 0.25);
  for (int k = 0; k < 1000; ++k) observer.update(two(0.0, 0.0), two(30.0, -30.0), 1e-3);
  EXPECT_TRUE(observer.compensation(two(4.0, -4.0), two(1e3, -1e3)).isApprox(two(1.0, -1.0), 1e-6));
  EXPECT_LT(observer.compensation(two(4.0, 4.0), two(0.005, 0.005)).cwiseAbs().maxCoeff(), 0.1) << "who creeps";
  EXPECT_TRUE(observer.compensation(two(4.0, 4.0), two(0.0, 0.0)).isZero(0.0));
  observer.reset();
  EXPECT_TRUE(observer.compensation(two(4.0, 4.0), two(1e3, 1e3)).isZero(0.0));
}

/// An arm of the models folder, alone or before a wall, with its observer or without.
class FrictionTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    auto read = device::read_arm(std::string("models/") + GetParam());
    ASSERT_TRUE(read) << read.error().to_string();
    model = *read;
    ASSERT_GT(model->friction_observer.minCoeff(), 0.0) << "the test is about arms that have one";
    cell.robots.push_back(arm_body("arm", *model, {}));
    cell.arms.push_back(simulated_arm("arm", "arm", *model));
  }

  [[nodiscard]] WorldDescription without() const {
    WorldDescription changed = cell;
    changed.arms[0].control.friction_observer.setZero();
    return changed;
  }

  /// All joints go to and fro by 0.1 rad, 0.16 rad/s at most; the largest lag of each, rad. Nothing is compensated
  /// where they turn back.
  [[nodiscard]] JointVector lag(const WorldDescription& description) const {
    World world = make(description);
    const JointVector ones = JointVector::Ones(model->home.size());
    JointVector worst = 0.0 * ones;
    constexpr double kRate = 3.1415926535897931, kWay = 0.05;
    for (int k = 0; k < 2'000; ++k) {
      const double t = 1e-3 * k;
      const JointVector q = model->home + kWay * (1.0 - std::cos(kRate * t)) * ones;
      worst = worst.cwiseMax((sample(world).q - q).cwiseAbs());
      world.arm("arm")->write(
          set_point(q, kWay * kRate * std::sin(kRate * t) * ones, kWay * kRate * kRate * std::cos(kRate * t) * ones));
      EXPECT_TRUE(world.step());
    }
    return worst;
  }

  std::shared_ptr<const device::ArmDescription> model;
  WorldDescription cell;
};

TEST_P(FrictionTest, AMovingJointLagsLess) {
  const JointVector with = lag(cell), lacking = lag(without());
  for (Eigen::Index i = 0; i < with.size(); ++i) EXPECT_LT(with[i], 0.7 * lacking[i]) << "joint " << i;
}

/// A payload that is not known, and a wall, are not friction: the arm rests where it does without an observer.
TEST_P(FrictionTest, AtAStandstillItDoesNotPush) {
  const auto resting = [&](WorldDescription description) {
    World world = make(description);
    hold(world, model->home, 4'000);
    return sample(world).q;
  };
  const double resolution = 2.0 * model->position_resolution;
  cell.arms[0].payload_mass_error = 2.0;
  const JointVector shift = resting(cell) - model->home;
  ASSERT_GT(shift.cwiseAbs().maxCoeff(), 20.0 * resolution) << "the load is no trial";
  EXPECT_LT((resting(cell) - resting(without())).cwiseAbs().maxCoeff(),
            0.02 * shift.cwiseAbs().maxCoeff() + resolution);
}

/// The flange goes down onto a block with 5 mm/s and its set point stops 0.1 mm below the surface.
TEST_P(FrictionTest, ATouchIsNotHarder) {
  struct Forces {
    double worst = 0.0, at_rest = 0.0;  // N
  };
  const auto touch = [&](WorldDescription description) {
    add_probe(description);
    const World empty = make(description);
    Eigen::Vector3d under = empty.body_pose(empty.body("probe/tcp")).translation();
    under.z() -= 0.005 + 0.05 + 1e-3;
    description.objects.push_back(box("block", {0.2, 0.2, 0.1}, under));
    World world = make(description);
    EXPECT_TRUE(world.watch_contact("probe", "block"));
    JointVector q = model->home, last = JointVector::Zero(q.size());
    Forces forces;
    for (int k = 0; k < 1'500; ++k) {
      // 1.1 mm down, with 5 mm/s, begun and ended in 0.1 s.
      const double t = 1e-3 * k, end = 0.32;
      const double s = std::clamp(std::min(t, end - t) / 0.1, 0.0, 1.0);
      kinematics::Vector6 twist = kinematics::Vector6::Zero();
      twist[2] = -0.005 * s * s * (3.0 - 2.0 * s);
      Pose X;
      kinematics::Jacobian J;
      model->chain->jacobian(q, X, J);
      const JointVector dq = J.completeOrthogonalDecomposition().solve(twist);
      world.arm("arm")->write(set_point(q, dq, (dq - last) / 1e-3));
      EXPECT_TRUE(world.step());
      q += 1e-3 * dq;
      last = dq;
    }
    forces = {world.contact(0).max_force, world.contact(0).force};
    return forces;
  };
  const Forces with = touch(cell), lacking = touch(without());
  RecordProperty("with_N", std::to_string(with.worst));
  RecordProperty("without_N", std::to_string(lacking.worst));
  ASSERT_GT(lacking.at_rest, 1.0) << "it does not touch";
  EXPECT_LT(with.worst, 1.1 * lacking.worst);
  EXPECT_NEAR(with.at_rest, lacking.at_rest, 0.1 * lacking.at_rest);
}

INSTANTIATE_TEST_SUITE_P(Arms, FrictionTest, testing::Values("ur5", "tx90"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace takt::sim::test
