#include "core/kinematics/inverse.h"

#include <cmath>
#include <limits>
#include <tuple>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "core/kinematics/plane.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::kinematics {
namespace {

using takt::test::Reports;
using test::pose_distance;
using test::random_q;
using test::random_vector;

struct Case {
  std::string name;
  Chain chain;
  std::vector<int> held;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"lwr", test::lwr(), {2}});
  all.push_back({"lwr, other held joint", test::lwr(), {0}});
  all.push_back({"ur5", test::chain_of(test::ur5_urdf()), {}});
  all.push_back({"tx90", test::chain_of(test::tx90_urdf()), {}});
  Random random(11);
  for (int i = 0; i < 4; ++i)
    all.push_back({"random of 9", *Chain::create(test::random_model(random, 9), "l0", "flange"), {0, 4, 7}});
  return all;
}

/// Runs a check on each arm in many postures that are not singular.
template <class Check>
void for_good_postures(Check check) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const auto inverse = InverseKinematics::create(c.chain, c.held);
    ASSERT_TRUE(inverse) << inverse.error().to_string();
    Random random(5, c.name);
    for (int done = 0; done < 300;) {
      const JointVector q = random_q(random, c.chain);
      if (inverse->singularity_measure(q) < 0.02) continue;
      check(random, *inverse, q);
      ++done;
    }
  }
}

// --- pose ------------------------------------------------------------------------------------------------------------

TEST(InverseKinematics, ComesBackToTheJointsThatMadeThePose) {
  for_good_postures([](Random& random, const InverseKinematics& inverse, const JointVector& q) {
    const Chain& chain = inverse.chain();
    const Eigen::Isometry3d X_BF = chain.forward(q);
    JointVector found = q + random_vector(random, chain.joint_count(), 0.004);
    ASSERT_EQ(inverse.solve(X_BF, inverse.held(q), found), IkStatus::kOk);
    EXPECT_LT((found - q).cwiseAbs().maxCoeff(), 1e-9) << "the same branch";
    EXPECT_LT(pose_distance(chain.forward(found), X_BF), 3e-12 * std::max(1.0, chain.reach()));
    EXPECT_EQ(inverse.held(found), inverse.held(q)) << "held means held, to the bit";
  });
}

TEST(InverseKinematics, SamePoseGivesSameJointsWhereverItCameFrom) {
  for_good_postures([](Random& random, const InverseKinematics& inverse, const JointVector& q) {
    const Eigen::Isometry3d X_BF = inverse.chain().forward(q);
    JointVector once = q + random_vector(random, inverse.chain().joint_count(), 0.002);
    JointVector twice = q + random_vector(random, inverse.chain().joint_count(), 0.002);
    ASSERT_EQ(inverse.solve(X_BF, inverse.held(q), once), IkStatus::kOk);
    ASSERT_EQ(inverse.solve(X_BF, inverse.held(q), twice), IkStatus::kOk);
    EXPECT_LT((once - twice).cwiseAbs().maxCoeff(), 1e-10);
  });
}

TEST(InverseKinematics, UnreachablePosesAndNonsenseLeaveTheSeedUntouched) {
  const Chain chain = test::lwr();
  const auto inverse = InverseKinematics::create(chain);
  ASSERT_TRUE(inverse);
  JointVector q(7);
  q << 0.1, -0.5, 0.2, 1.5, 0.1, -1.0, 0.3;
  const JointVector seed = q;
  JointVector dq = JointVector::Ones(7), ddq = JointVector::Ones(7);
  InverseKinematics::Goal goal;
  goal.held = goal.held_dq = goal.held_ddq = JointVector::Zero(1);
  for (const double x :
       {2.0, 1e300, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    goal.X_BF = chain.forward(seed);
    goal.X_BF.translation().x() = x;
    EXPECT_EQ(inverse->solve(goal.X_BF, goal.held, q), IkStatus::kNotConverged);
    EXPECT_EQ(inverse->solve_motion(goal, q, dq, ddq), IkStatus::kNotConverged);
    EXPECT_EQ(q, seed);
    EXPECT_EQ(dq, JointVector::Ones(7));
    EXPECT_EQ(ddq, JointVector::Ones(7));
  }
  goal.X_BF = chain.forward(seed);
  goal.X_BF.linear() = goal.X_BF.linear() * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(inverse->solve(goal.X_BF, goal.held, q), IkStatus::kNotConverged) << "half a turn away is another branch";
}

TEST(InverseKinematics, PassesThroughASingularPoseWithoutAJump) {
  // Wrist straight (joint 6 at 0): joints 5 and 7 share one axis. The path leads through it exactly.
  const Chain chain = test::lwr();
  const auto inverse = InverseKinematics::create(chain);
  JointVector made(7);
  made << 0.1, -0.5, 0.2, 1.5, 0.0, 0.0, 0.3;
  JointVector q = made;
  q[5] = -0.05;
  for (int k = -50; k <= 50; ++k) {
    made[5] = 1e-3 * k;
    const JointVector before = q;
    ASSERT_EQ(inverse->solve(chain.forward(made), inverse->held(made), q), IkStatus::kOk) << k;
    EXPECT_LT((q - before).cwiseAbs().maxCoeff(), 0.01) << k;
    EXPECT_LT(pose_distance(chain.forward(q), chain.forward(made)), 3e-12);
  }
  made[5] = 0.0;
  JointVector dq;
  EXPECT_LT(inverse->singularity_measure(made), 1e-12);
  EXPECT_EQ(inverse->rates(made, Vector6::Ones(), JointVector::Zero(1), dq), IkStatus::kSingular);
  EXPECT_EQ(dq.size(), 0) << "untouched";
}

// --- rates -----------------------------------------------------------------------------------------------------------

TEST(InverseKinematics, RatesAndAccelerationsAreExact) {
  for_good_postures([](Random& random, const InverseKinematics& inverse, const JointVector& q) {
    const Chain& chain = inverse.chain();
    const int n = chain.joint_count();
    const JointVector dq = random_vector(random, n, 2.0);
    const JointVector ddq = random_vector(random, n, 5.0);
    InverseKinematics::Goal goal;
    Jacobian J;
    chain.jacobian(q, goal.X_BF, J);
    goal.V_BF_B = J * dq;
    goal.A_BF_B = J * ddq + chain.jacobian_dot_times_dq(q, dq);
    std::tie(goal.held, goal.held_dq, goal.held_ddq) = std::tuple(inverse.held(q), inverse.held(dq), inverse.held(ddq));

    JointVector rates, accelerations;
    ASSERT_EQ(inverse.rates(q, goal.V_BF_B, goal.held_dq, rates), IkStatus::kOk);
    EXPECT_LT((rates - dq).cwiseAbs().maxCoeff(), 1e-11);
    ASSERT_EQ(inverse.accelerations(q, dq, goal.A_BF_B, goal.held_ddq, accelerations), IkStatus::kOk);
    EXPECT_LT((accelerations - ddq).cwiseAbs().maxCoeff(), 1e-10);

    JointVector all_q = q + random_vector(random, n, 0.002);
    JointVector all_dq, all_ddq;
    ASSERT_EQ(inverse.solve_motion(goal, all_q, all_dq, all_ddq), IkStatus::kOk);
    EXPECT_LT((all_q - q).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((all_dq - dq).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT((all_ddq - ddq).cwiseAbs().maxCoeff(), 1e-6);
    // Against the chain at the q that was found there is no excuse left.
    chain.jacobian(all_q, goal.X_BF, J);
    EXPECT_LT((J * all_dq - goal.V_BF_B).cwiseAbs().maxCoeff(), 1e-11);
    const Vector6 acceleration = J * all_ddq + chain.jacobian_dot_times_dq(all_q, all_dq);
    EXPECT_LT((acceleration - goal.A_BF_B).cwiseAbs().maxCoeff(), 1e-10 * std::max(1.0, acceleration.norm()));
  });
}

// --- measures --------------------------------------------------------------------------------------------------------

TEST(InverseKinematics, SingularityMeasureVanishesWhereTheLwrIsSingular) {
  const Chain chain = test::lwr();
  const auto inverse = InverseKinematics::create(chain);
  JointVector q(7);
  q << 0.3, -0.5, 0.4, 1.5, 0.5, -1.0, 0.3;
  EXPECT_GT(inverse->singularity_measure(q), 0.1);
  JointVector straight = q;
  straight[3] = 0.0;
  EXPECT_LT(inverse->singularity_measure(straight), 1e-12);
  for (const double away : {1e-2, 1e-4, 1e-6}) {
    JointVector near = q;
    near[5] = away;
    EXPECT_GT(inverse->singularity_measure(near), 0.05 * away);
    EXPECT_LT(inverse->singularity_measure(near), 2.0 * away);
  }
}

TEST(InverseKinematics, LimitDistance) {
  const Chain chain = test::lwr();
  JointVector q = JointVector::Zero(7);
  EXPECT_DOUBLE_EQ(limit_distance(chain, q), chain.upper()[1]);
  q[3] = chain.lower()[3] + 0.25;
  EXPECT_NEAR(limit_distance(chain, q), 0.25, 1e-15);
  q[6] = chain.upper()[6] + 0.5;
  EXPECT_NEAR(limit_distance(chain, q), -0.5, 1e-15);
}

// --- realtime --------------------------------------------------------------------------------------------------------

TEST(InverseKinematics, CyclicFunctionsNeverAllocate) {
  for_good_postures([](Random& random, const InverseKinematics& inverse, const JointVector& q) {
    const Chain& chain = inverse.chain();
    const JointVector dq = random_vector(random, chain.joint_count(), 1.0);
    InverseKinematics::Goal goal;
    goal.held = inverse.held(q);
    goal.held_dq = inverse.held(dq);
    goal.held_ddq = inverse.held(dq);
    JointVector found = q, rates = dq, accelerations = dq;
    Jacobian J;
    Payload payload;
    payload.mass = 1.0;

    const takt::test::AllocationGuard guard;
    chain.jacobian(q, goal.X_BF, J);
    goal.X_BF = chain.forward(q);
    goal.V_BF_B = J * dq;
    goal.A_BF_B = chain.jacobian_dot_times_dq(q, dq);
    const JointVector tau = chain.inverse_dynamics(q, dq, dq, Eigen::Vector3d(0, 0, -9.81), payload);
    const JointMatrix M = chain.mass_matrix(q, payload);
    const IkStatus solved = inverse.solve(goal.X_BF, goal.held, found);
    const IkStatus moved = inverse.solve_motion(goal, found, rates, accelerations);
    goal.X_BF.translation().x() += 100.0;
    const IkStatus unreachable = inverse.solve(goal.X_BF, goal.held, found);  // the damped steps
    const double measures = inverse.singularity_measure(q) + limit_distance(chain, q);
    const std::size_t allocations = guard.count();

    EXPECT_EQ(allocations, 0u);
    EXPECT_EQ(solved, IkStatus::kOk);
    EXPECT_EQ(moved, IkStatus::kOk);
    EXPECT_EQ(unreachable, IkStatus::kNotConverged);
    EXPECT_TRUE(std::isfinite(tau.sum() + M.sum() + measures));
  });
}

// Walks along paths ask for all of it at each place: one call has to say what three do.
TEST(InverseKinematics, APassSaysWhatRatesAccelerationsAndMeasureSay) {
  int regular = 0, irregular = 0;
  for_good_postures([&](Random& random, const InverseKinematics& inverse, const JointVector& q) {
    const JointVector dq = random_vector(random, inverse.chain().joint_count(), 1.0);
    InverseKinematics::Goal goal;
    goal.held_dq = inverse.held(dq);
    goal.held_ddq = inverse.held(random_vector(random, inverse.chain().joint_count(), 1.0));
    for (int i = 0; i < 6; ++i) {
      goal.V_BF_B[i] = random.uniform(-1.0, 1.0);
      goal.A_BF_B[i] = random.uniform(-1.0, 1.0);
    }
    JointVector rates, accelerations;
    ASSERT_EQ(inverse.rates(q, goal.V_BF_B, goal.held_dq, rates), IkStatus::kOk);
    ASSERT_EQ(inverse.accelerations(q, rates, goal.A_BF_B, goal.held_ddq, accelerations), IkStatus::kOk);
    const double measure = inverse.singularity_measure(q);
    // Far from the border, next to it by rounding, and on it.
    for (const double share : {0.1, 0.999, 1.0 - 1e-9, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.0 + 1e-9, 1.001, 10.0}) {
      InverseKinematics::Passage passage;
      ASSERT_EQ(inverse.pass(q, goal, share * measure, passage), IkStatus::kOk);
      EXPECT_EQ(passage.dq, rates);
      EXPECT_EQ(passage.ddq, accelerations);
      EXPECT_EQ(passage.regular, measure >= share * measure) << share;
      (passage.regular ? regular : irregular) += 1;
    }
  });
  EXPECT_GT(std::min(regular, irregular), 1000);
}

// --- fewer than six joints -------------------------------------------------------------------------------------------

/// What a chain of few joints can reach it comes back to; what it cannot is refused, and named.
TEST(ShortChain, ReachesWhatItsJointsCanDoAndNamesTheRest) {
  Random random(31);
  for (const int n : {3, 4, 5}) {
    const auto chain = Chain::create(test::random_model(random, n), "l0", "flange");
    const auto inverse = InverseKinematics::create(*chain);
    ASSERT_TRUE(inverse) << inverse.error().to_string();
    for (int done = 0; done < 100;) {
      const JointVector q = random_q(random, *chain), dq = random_vector(random, n, 1.0);
      if (inverse->singularity_measure(q) < 0.02) continue;
      ++done;
      const Eigen::Isometry3d X_BF = chain->forward(q);
      JointVector found = q + random_vector(random, n, 0.004);
      ASSERT_EQ(inverse->solve(X_BF, {}, found), IkStatus::kOk) << n;
      EXPECT_LT((found - q).cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_LT(inverse->beyond_joints(q, X_BF).norm(), 1e-12);
      // From a seed that is almost there, as in the last cycles of a motion.
      found = q + random_vector(random, n, 2e-11);
      ASSERT_EQ(inverse->solve(X_BF, {}, found), IkStatus::kOk) << n;

      Eigen::Isometry3d X;
      Jacobian J;
      chain->jacobian(q, X, J);
      JointVector rates;
      ASSERT_EQ(inverse->rates(q, J * dq, {}, rates), IkStatus::kOk);
      EXPECT_LT((rates - dq).cwiseAbs().maxCoeff(), 1e-9);

      // A step across all that the joints can do, by more than kTurnSlack.
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(J.transpose());
      const Vector6 across = lu.kernel().col(0).normalized();
      Eigen::Isometry3d beyond = X_BF;
      beyond.translation() += 2e-2 * across.head<3>();
      const Eigen::Vector3d turn = 2e-2 * across.tail<3>();
      if (turn.norm() > 0)
        beyond.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * beyond.linear();
      found = q;
      EXPECT_EQ(inverse->solve(beyond, {}, found), IkStatus::kNotConverged);
      EXPECT_EQ(found, q) << "untouched";
      EXPECT_GT(inverse->beyond_joints(q, beyond).norm(), 1e-5);
    }
  }
}

TEST(ShortChain, ABaseGoesInItsPlaneOnly) {
  const auto model = RobotModel::load("models/youbot_base/youbot_base.urdf");
  ASSERT_TRUE(model) << model.error().to_string();
  const std::vector<std::string> wheels{"front_left", "front_right", "rear_left", "rear_right"};
  EXPECT_FALSE(Chain::create(*model, "odometry", "body")) << "wheels move beside the chain";
  const auto chain = Chain::create(*model, "odometry", "body", wheels);
  ASSERT_TRUE(chain) << chain.error().to_string();
  EXPECT_NEAR(chain->total_mass(), 30.0, 1e-9);
  EXPECT_TRUE(moves_in_plane(*chain));
  Random random(5);
  EXPECT_FALSE(moves_in_plane(*Chain::create(test::random_model(random, 3), "l0", "flange")));
  const auto inverse = InverseKinematics::create(*chain);
  ASSERT_TRUE(inverse);
  JointVector q(3), start = JointVector::Zero(3);
  q << 3.2, -1.7, 7.0;
  Eigen::Isometry3d X_BF = chain->forward(q);
  SolutionOptions options;
  options.reference = q;
  auto solutions = inverse_solutions(*chain, X_BF, options);
  ASSERT_EQ(solutions.size(), 1u);
  EXPECT_LT((solutions[0] - q).cwiseAbs().maxCoeff(), 1e-9) << "in the turn in which it stands";
  options.reference = start;
  solutions = inverse_solutions(*chain, X_BF, options);
  ASSERT_EQ(solutions.size(), 1u);
  EXPECT_NEAR(solutions[0][2], 7.0 - 2.0 * M_PI, 1e-9);

  X_BF.translation().z() = 0.02;
  const Vector6 beyond = inverse->beyond_joints(start, X_BF);
  EXPECT_NEAR(beyond[2], 0.02, 1e-12);
  EXPECT_LT(beyond.head<2>().norm() + beyond.tail<3>().norm(), 1e-12);
  EXPECT_TRUE(inverse_solutions(*chain, X_BF, options).empty());
}

// --- what is refused -------------------------------------------------------------------------------------------------

TEST(InverseKinematics, FindingsNameWhatIsWrong) {
  const Chain seven = test::lwr();
  const Chain six = test::chain_of(test::ur5_urdf());
  EXPECT_TRUE(InverseKinematics::create(seven));
  EXPECT_EQ(InverseKinematics::create(seven)->held_joints(), std::vector<int>{2});
  EXPECT_TRUE(InverseKinematics::create(six));
  EXPECT_FALSE(InverseKinematics::create(six, {2}));
  const auto twice = InverseKinematics::create(seven, {9, 9});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().list().size(), 4u) << "count, two indices, one of them twice";
  Random random(2);
  const auto eight = Chain::create(test::random_model(random, 8), "l0", "flange");
  const auto nameless = InverseKinematics::create(*eight);
  ASSERT_FALSE(nameless);
  EXPECT_THAT(nameless.error(), Reports(Code::kWrongSize, "", {"2"}));
  const auto five = Chain::create(test::random_model(random, 5), "l0", "flange");
  EXPECT_TRUE(InverseKinematics::create(*five));
  EXPECT_FALSE(InverseKinematics::create(*five, {2})) << "none is left over";
  const auto two = Chain::create(test::random_model(random, 2), "l0", "flange");
  EXPECT_FALSE(InverseKinematics::create(*two));
}

}  // namespace
}  // namespace takt::kinematics
