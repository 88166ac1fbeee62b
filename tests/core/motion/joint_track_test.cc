// Joints along a planned motion: at any time, fast, on every kind of path.
#include "core/motion/joint_track.h"

#include <gtest/gtest.h>

#include "core/motion/motion_state.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"

namespace takt::motion::test {
namespace {

namespace robots = kinematics::test;

class JointTrackTest : public testing::Test {
 protected:
  JointTrackTest() {
    q0_ << 0, -0.5236, 0, 1.5708, 0, -1.0472, 0;
    X0_ = arm_.chain.forward(q0_) * arm_.X_FM;
  }
  [[nodiscard]] Eigen::Isometry3d shifted(double x, double y, double z) const {
    return Eigen::Translation3d(x, y, z) * X0_;
  }
  [[nodiscard]] Motion planned(const std::vector<LegMaker>& legs) const {
    auto plan = plan_sequence(model_, q0_, legs);
    EXPECT_TRUE(plan) << plan.error().to_string();
    return plan ? std::move(plan->motion) : Motion{};
  }
  /// Against inverse kinematics from the start of the motion, for each time anew.
  void expect_same(const Motion& motion) const {
    const auto track = JointTrack::follow(model_, motion);
    ASSERT_TRUE(track);
    EXPECT_EQ(track->duration(), motion.duration());
    EXPECT_EQ(track->at(0.0), motion.q_start);
    EXPECT_LT((track->at(motion.duration()) - motion.q_goal).cwiseAbs().maxCoeff(), 1e-9);
    constexpr int kTimes = 97;
    for (int i = 1; i < kTimes; ++i) {
      const double tau = i * motion.duration() / kTimes;
      const auto expected = joints_at(model_, motion, tau);
      ASSERT_TRUE(expected);
      EXPECT_LT((track->at(tau) - expected->q).cwiseAbs().maxCoeff(), 1e-7) << tau;
    }
  }

  Random random_{23};
  RandomArm arm_{robots::lwr_urdf(), random_};
  ArmModel model_ = arm_.model();
  JointVector q0_ = JointVector(7);
  Eigen::Isometry3d X0_;
};

TEST_F(JointTrackTest, FollowsLines) {
  expect_same(planned({[&](const JointVector& q) { return lin_leg(model_, q, shifted(0.05, 0.15, -0.1)); }}));
}

TEST_F(JointTrackTest, FollowsBlendsOfJointsAndLines) {
  JointVector goal = q0_;
  goal[0] += 0.4;
  goal[3] -= 0.2;
  const auto blended = [](Result<Leg> leg) {
    if (leg) leg->blend = {Blend::Kind::kFraction, 0.3};
    return leg;
  };
  expect_same(planned({[&](const JointVector& q) { return blended(ptp_leg(model_, q, goal)); },
                       [&](const JointVector& q) { return blended(lin_leg(model_, q, shifted(0.0, 0.1, 0.1))); },
                       [&](const JointVector& q) { return ptp_leg(model_, q, q0_); }}));
}

TEST_F(JointTrackTest, StandsBeforeAndBehindTheMotion) {
  const Motion motion = planned({[&](const JointVector& q) { return lin_leg(model_, q, shifted(0.0, 0.1, 0.0)); }});
  const auto track = JointTrack::follow(model_, motion);
  ASSERT_TRUE(track);
  EXPECT_EQ(track->at(-1.0), track->at(0.0));
  EXPECT_EQ(track->at(motion.duration() + 1.0), track->at(motion.duration()));
}

// What a check for collisions between samples stands on.
TEST_F(JointTrackTest, NoJointAcceleratesMoreThanTheBoundOfAnyInterval) {
  const auto blended = [](Result<Leg> leg, double acceleration) {
    if (leg) leg->blend = {Blend::Kind::kFraction, 0.3};
    if (leg) leg->acceleration = acceleration;
    return leg;
  };
  JointVector goal = q0_;
  goal[0] += 0.4;
  goal[3] -= 0.2;
  for (const double slow : {1.0, 1e-3, 1e-7}) {
    const Motion motion =
        planned({[&](const JointVector& q) { return blended(ptp_leg(model_, q, goal), 0.5); },
                 [&](const JointVector& q) { return blended(lin_leg(model_, q, shifted(0.0, 0.1, 0.1)), slow); },
                 [&](const JointVector& q) { return ptp_leg(model_, q, q0_); }});
    const auto track = JointTrack::follow(model_, motion);
    ASSERT_TRUE(track);
    double tightest = 0.0;
    for (int i = 0; i < 400; ++i) {
      const double from = random_.uniform(0.0, 0.99) * motion.duration();
      const double to = from + 0.01 * motion.duration();
      const JointVector most = track->largest_acceleration(from, to);
      const double h = (to - from) / 40.0;
      for (double tau = from + h; tau < to - h; tau += h) {
        const JointVector ddq = (track->at(tau + h) - 2.0 * track->at(tau) + track->at(tau - h)) / (h * h);
        const double rounding = 1e-13 / (h * h);
        ASSERT_TRUE(((ddq.cwiseAbs() - most).array() <= rounding).all()) << slow << " at " << tau;
        tightest = std::max(tightest, ddq.cwiseAbs().maxCoeff() / most.maxCoeff());
      }
    }
    EXPECT_GT(tightest, 0.3) << "a bound that says little";
  }
}

}  // namespace
}  // namespace takt::motion::test
