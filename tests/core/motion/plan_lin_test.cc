#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/inverse.h"
#include "core/motion/path_clock.h"
#include "core/motion/planner.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/shortest_time.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

using kinematics::Chain;
using kinematics::IkStatus;
using kinematics::InverseKinematics;
namespace robots = kinematics::test;

// Inverse kinematics ends with a residual below 1e-12; at the singularity measures met here that is less in q than:
constexpr double kSampleError = 5e-12;

struct Arm {
  explicit Arm(const std::string& urdf) : chain(robots::chain_of(urdf)), inverse(*InverseKinematics::create(chain)) {}
  Chain chain;
  InverseKinematics inverse;
};

/// A configuration away from limits and singularities.
JointVector good_q(Random& random, const Arm& arm) {
  for (;;) {
    const JointVector q = 0.7 * robots::random_q(random, arm.chain);
    if (arm.inverse.singularity_measure(q) > 0.1) return q;
  }
}

Eigen::Isometry3d pose_near(Random& random, const Eigen::Isometry3d& X, double metres, double radians) {
  Eigen::Isometry3d goal = X;
  goal.translation() += metres * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  const Eigen::Vector3d axis = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  goal.linear() = Eigen::AngleAxisd(random.uniform(-radians, radians), axis) * X.linear();
  return goal;
}

/// What a run of a line shows, seen from outside: joint samples, and where the frame was by forward kinematics.
struct Seen {
  takt::test::LimitOracle joints;
  takt::test::LimitOracle frame;  ///< way along the line and turn from the start
  double line_deviation = 0.0;    ///< m
  double turn_deviation = 0.0;    ///< rad, away from the axis of the line
  double largest_step = 0.0;      ///< rad between two samples
  JointVector q_end = {};
};

takt::test::LimitOracle frame_oracle(const CartesianLimits& limits) {
  return {{.lower = {-1e-9, -1e-9},
           .upper = {1e9, 1e9},
           .velocity = {limits.linear_velocity, limits.angular_velocity},
           .acceleration = {limits.linear_acceleration, limits.angular_acceleration},
           .jerk = {limits.linear_jerk, limits.angular_jerk}},
          kPeriod,
          kSampleError};
}

Seen watch(const Arm& arm, const Motion& motion, const JointLimits& limits, const CartesianLimits& cartesian,
           const Eigen::Isometry3d& X_FM, const Targets& targets) {
  const auto& line = std::get<CartesianLine>(motion.path);
  Seen seen{joint_oracle(limits, kSampleError), frame_oracle(cartesian)};
  JointVector q = motion.q_start;
  const Eigen::Isometry3d X_start = arm.chain.forward(q) * X_FM;
  run(motion, targets, 15000, [&](const PathPoint& at) {
    const JointVector last = q;
    ASSERT_EQ(arm.inverse.solve(line.sample(at).X_BM * X_FM.inverse(), line.held(at).q, q), IkStatus::kOk);
    seen.joints.add(as_list(q));
    seen.largest_step = std::max(seen.largest_step, (q - last).cwiseAbs().maxCoeff());

    const Eigen::Isometry3d X = arm.chain.forward(q) * X_FM;
    const Eigen::Vector3d way = X.translation() - X_start.translation();
    const double along = way.dot(line.direction);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(X.linear() * X_start.linear().transpose()));
    const Eigen::Vector3d turned = turn.angle() * turn.axis();
    const double about = turned.dot(line.axis);
    seen.frame.add({along, about});
    seen.line_deviation = std::max(seen.line_deviation, (way - along * line.direction).norm());
    seen.turn_deviation = std::max(seen.turn_deviation, (turned - about * line.axis).norm());
  });
  seen.q_end = q;
  return seen;
}

// Rows P1, P3: as planned, and whatever the clock is told.
TEST(PlanLin, P3_KeepsJointAndCartesianLimitsAndItsLineForAnyTargets) {
  Random random(41);
  const std::vector<Arm> arms = {Arm(robots::lwr_urdf()), Arm(robots::ur5_urdf()), Arm(robots::tx90_urdf())};
  const CartesianLimits cartesian;
  int planned = 0;
  double most = 0.0;
  for (int i = 0; i < 80; ++i) {
    const Arm& arm = arms[static_cast<std::size_t>(i) % arms.size()];
    const JointLimits limits = random_limits(random, arm.chain);
    const JointVector q0 = good_q(random, arm);
    MotionOptions options;
    if (i % 2 == 1) options.X_FM = pose_near(random, Eigen::Isometry3d::Identity(), 0.2, 1.0);
    const double size = i % 5 == 0 ? 0.01 : 0.3;
    const Eigen::Isometry3d goal = pose_near(random, arm.chain.forward(q0) * options.X_FM, size, 3 * size);
    const auto motion = plan_lin(arm.chain, arm.inverse, limits, cartesian, q0, goal, {}, options);
    if (!motion) continue;  // out of reach or range: other tests look at these
    ++planned;
    for (int k = 0; k < 4; ++k) {
      const auto targets = k == 0 ? always(1.0) : at_random(random, k == 1);
      const Seen seen = watch(arm, *motion, limits, cartesian, options.X_FM, targets);
      expect_kept(seen.joints, "joints");
      expect_kept(seen.frame, "frame");
      EXPECT_LT(seen.line_deviation, 1e-9) << "allowed are 0.01 mm";
      EXPECT_LT(seen.turn_deviation, 1e-7);
      EXPECT_LT(seen.largest_step, limits.velocity.maxCoeff() * kPeriod) << "another branch";
      most = std::max({most, seen.joints.acceleration.share, seen.joints.jerk.share, seen.frame.acceleration.share});
      if (k == 0) {
        EXPECT_LT((seen.q_end - motion->q_goal).cwiseAbs().maxCoeff(), 1e-9);
        const Eigen::Isometry3d X_end = arm.chain.forward(motion->q_goal) * options.X_FM;
        EXPECT_LT((X_end.matrix() - goal.matrix()).norm(), 1e-9);
      }
    }
  }
  EXPECT_GT(planned, 30) << "too few lines to say anything";
  EXPECT_GT(most, 0.9);
}

TEST(PlanLin, P3_KeepsLimitsNearSingularities) {
  Random random(42);
  const Arm arm(robots::lwr_urdf());
  const CartesianLimits cartesian;
  int near = 0;
  for (int i = 0; i < 400 && near < 6; ++i) {
    JointVector q0 = 0.7 * robots::random_q(random, arm.chain);
    const double measure = arm.inverse.singularity_measure(q0);
    if (measure < 0.012 || measure > 0.04) continue;
    const JointLimits limits = random_limits(random, arm.chain);
    const auto motion =
        plan_lin(arm.chain, arm.inverse, limits, cartesian, q0, pose_near(random, arm.chain.forward(q0), 0.2, 0.3));
    if (!motion) continue;
    ++near;
    expect_kept(watch(arm, *motion, limits, cartesian, Eigen::Isometry3d::Identity(), always(1.0)).joints, "planned");
    expect_kept(watch(arm, *motion, limits, cartesian, Eigen::Isometry3d::Identity(), at_random(random, true)).joints,
                "random targets");
  }
  EXPECT_EQ(near, 6);
}

class PlanLinOnLwr : public testing::Test {
 protected:
  PlanLinOnLwr() {
    q0_ << 0, -0.5236, 0, 1.5708, 0, -1.0472, 0;
    X0_ = arm_.chain.forward(q0_);
  }
  Result<Motion> plan(const Eigen::Isometry3d& goal, const MotionOptions& options = {},
                      const std::optional<JointVector>& held = {}) const {
    return plan_lin(arm_.chain, arm_.inverse, limits_, cartesian_, q0_, goal, held, options);
  }
  Eigen::Isometry3d shifted(double x, double y, double z) const { return Eigen::Translation3d(x, y, z) * X0_; }
  Diagnostics refusal(const Eigen::Isometry3d& goal, const MotionOptions& options = {}) const {
    const auto motion = plan(goal, options);
    return motion ? Diagnostics() : motion.error();
  }

  Arm arm_{robots::lwr_urdf()};
  Random random_{43};
  JointLimits limits_ = random_limits(random_, arm_.chain);
  CartesianLimits cartesian_;
  JointVector q0_ = JointVector(7);
  Eigen::Isometry3d X0_;
};

TEST_F(PlanLinOnLwr, TakesItsTimeFromTheCartesianLimitsWhereTheJointsDoNotBind) {
  limits_.velocity *= 100;
  limits_.acceleration *= 100;
  limits_.jerk *= 100;
  for (const double way : {0.001, 0.02, 0.2}) {
    const double shortest =
        shortest_time({cartesian_.linear_velocity, cartesian_.linear_acceleration, cartesian_.linear_jerk}, way);
    const auto motion = plan(shifted(0, 0, -way));
    ASSERT_TRUE(motion) << motion.error().to_string();
    EXPECT_GE(motion->duration(), shortest);
    EXPECT_LE(motion->duration(), 1.127 * shortest);
  }
}

TEST_F(PlanLinOnLwr, GoesAtTheSpeedThatIsAskedForAndStopsFromItAtOnce) {
  const auto motion = plan(shifted(0, 0, -0.05), {.linear_velocity = 0.005});
  ASSERT_TRUE(motion);
  const LawPoint middle = motion->law.at(motion->duration() / 2);
  EXPECT_NEAR(middle.ds * 0.05, 0.005, 0.0051 * 0.01);
  EXPECT_LE(middle.ds * 0.05, 0.005);
  const PathClock clock(motion->clock, motion->duration(), false);
  EXPECT_LT(clock.stop_time_bound(), 0.1) << "a slow motion may be stopped fast";
}

TEST_F(PlanLinOnLwr, StartsAndEndsAtRestOnItsPoses) {
  const Eigen::Isometry3d goal = pose_near(random_, X0_, 0.1, 0.5);
  const auto motion = plan(goal);
  ASSERT_TRUE(motion);
  const auto& line = std::get<CartesianLine>(motion->path);
  const FrameSample end = line.sample(follow(motion->law, {.tau = motion->duration(), .rate = 1.0}));
  EXPECT_LT((end.X_BM.matrix() - goal.matrix()).norm(), 1e-12);
  EXPECT_TRUE(end.V_BM_B.isZero(0.0) && end.A_BM_B.isZero(0.0));
  EXPECT_EQ(motion->q_start, q0_);
}

TEST_F(PlanLinOnLwr, HeldJointsMayGoWhileTheFrameStands) {
  const auto motion = plan(X0_, {}, JointVector::Constant(1, 0.6));
  ASSERT_TRUE(motion) << motion.error().to_string();
  EXPECT_GT(motion->duration(), 0.1);
  EXPECT_NEAR(motion->q_goal[2], 0.6, 1e-12);
  EXPECT_LT((arm_.chain.forward(motion->q_goal).matrix() - X0_.matrix()).norm(), 1e-10);
  expect_kept(watch(arm_, *motion, limits_, cartesian_, Eigen::Isometry3d::Identity(), always(1.0)).joints, "held");
}

TEST_F(PlanLinOnLwr, ALineWithoutWayIsLegal) {
  const auto motion = plan(X0_);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->duration(), 0.0);
  EXPECT_EQ(motion->q_goal, q0_);
  EXPECT_EQ(plan(shifted(1e-14, 0, 0))->duration(), 0.0);
  EXPECT_GT(plan(shifted(1e-7, 0, 0))->duration(), 0.0);
}

TEST_F(PlanLinOnLwr, HalfATurnIsPlannedTheSameWayEachTime) {
  q0_[6] = 1.6;  // so that the last joint has room for it
  X0_ = arm_.chain.forward(q0_);
  Eigen::Isometry3d goal = X0_;
  goal.linear() = X0_.linear() * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());
  const auto a = plan(goal);
  ASSERT_TRUE(a) << a.error().to_string();
  goal.linear() = X0_.linear() * Eigen::AngleAxisd(-std::numbers::pi, Eigen::Vector3d::UnitZ());
  const auto b = plan(goal);
  ASSERT_TRUE(b);
  EXPECT_LT((a->q_goal - b->q_goal).norm(), 1e-6);
}

TEST_F(PlanLinOnLwr, RefusesAGoalOutOfReachAndSaysHowFarTheArmComes) {
  const Diagnostics text = refusal(shifted(0.9, 0, 0));
  EXPECT_THAT(text, Reports(Code::kUnreachable, "/goal"));
}

TEST_F(PlanLinOnLwr, RefusesALineThatLeavesTheRangeOfAJoint) {
  limits_.upper[3] = 1.6;
  EXPECT_THAT(refusal(shifted(-0.15, 0, 0)), Reports(Code::kOutOfRange, "/goal", {"joint_4", "91.6732"}));
}

TEST_F(PlanLinOnLwr, RefusesALineThroughASingularity) {
  // Wrist straight at a5 = 0: turning the flange there and beyond passes the wrist singularity.
  q0_[5] = -0.3;
  X0_ = arm_.chain.forward(q0_);
  Eigen::Isometry3d goal = X0_;
  JointVector q1 = q0_;
  q1[5] = 0.3;
  goal = arm_.chain.forward(q1);
  const Diagnostics text = refusal(goal);
  EXPECT_THAT(text, Reports(Code::kPlanningFailed, "/goal"));
  q0_.setZero();  // the candle
  X0_ = arm_.chain.forward(q0_);
  EXPECT_THAT(refusal(shifted(0.05, 0, -0.05)), Reports(Code::kPlanningFailed, "/goal", {"0.0"}));
}

TEST_F(PlanLinOnLwr, RefusesWhatIsNoPoseAndNoOption) {
  Eigen::Isometry3d goal = X0_;
  goal.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(goal), Reports(Code::kOutOfRange, "/goal"));
  goal = X0_;
  goal.linear() *= 2.0;
  EXPECT_THAT(refusal(goal), Reports(Code::kOutOfRange, "/goal"));
  EXPECT_THAT(refusal(X0_, {.linear_velocity = 0.0}), Reports(Code::kOutOfRange, "/options/linear_velocity", {"0"}));
  cartesian_.angular_jerk = -1.0;
  EXPECT_THAT(refusal(X0_), Reports(Code::kOutOfRange, "/cartesian_limits/angular_jerk"));
  const auto held = plan_lin(arm_.chain, arm_.inverse, limits_, {}, q0_, X0_, JointVector::Constant(1, 5.0));
  ASSERT_FALSE(held);
  EXPECT_THAT(held.error(), Reports(Code::kOutOfRange, "/held_goal/0", {"joint_3", "286.479"}));
}

}  // namespace
}  // namespace takt::motion::test
