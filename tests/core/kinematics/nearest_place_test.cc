// Arms with fewer than six joints: in the cycle they follow what they can do, and go near to what they cannot.
#include "core/kinematics/nearest_place.h"

#include <gtest/gtest.h>

#include "core/base/json.h"
#include "core/kinematics/inverse.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/allocation_guard.h"

namespace takt::kinematics {
namespace {

struct Few {
  std::string name;
  Chain chain;
};

std::vector<Few> few() {
  std::vector<Few> all;
  for (const auto& [file, base, flange] :
       {std::array{"scara", "foot", "tool0"}, std::array{"five", "base_link", "l5"}}) {
    const auto text = read_file(std::string("tests/tools/foreign/") + file + ".urdf", 1u << 20);
    std::string urdf = text.value_or("");
    // As `takt new robot` leaves them: joints beside the arm are fixed.
    for (std::size_t at = 0; (at = urdf.find("name=\"grip_", at)) != std::string::npos; ++at) {
      const std::size_t type = urdf.find("prismatic", at);
      urdf.replace(type, std::string("prismatic").size(), "fixed");
      const std::size_t axis = urdf.find("<axis", at), end = urdf.find("</joint>", at);
      urdf.erase(axis, end - axis);
    }
    auto chain = Chain::create(test::model_of(urdf), base, flange);
    EXPECT_TRUE(chain) << chain.error().to_string();
    if (chain) all.push_back({file, std::move(*chain)});
  }
  return all;
}

TEST(FewJoints, ComeBackToTheJointsThatMadeThePose) {
  for (const Few& arm : few()) {
    SCOPED_TRACE(arm.name);
    const auto inverse = InverseKinematics::create(arm.chain);
    ASSERT_TRUE(inverse) << inverse.error().to_string();
    Random random(3, arm.name);
    for (int done = 0; done < 200;) {
      const JointVector q = test::random_q(random, arm.chain);
      if (inverse->singularity_measure(q) < 0.05) continue;
      ++done;
      JointVector found = q + test::random_vector(random, arm.chain.joint_count(), 0.01);
      const takt::test::AllocationGuard guard;
      const IkStatus status = inverse->solve(arm.chain.forward(q), {}, found);
      const std::size_t allocations = guard.count();
      ASSERT_EQ(status, IkStatus::kOk);
      EXPECT_EQ(allocations, 0u);
      EXPECT_LT((found - q).cwiseAbs().maxCoeff(), 1e-7);
    }
  }
}

TEST(FewJoints, RatesAndAccelerationsAreThoseOfTheMotionThatTheyCanDo) {
  for (const Few& arm : few()) {
    SCOPED_TRACE(arm.name);
    const auto inverse = InverseKinematics::create(arm.chain);
    Random random(4, arm.name);
    for (int done = 0; done < 100;) {
      const JointVector q = test::random_q(random, arm.chain);
      if (inverse->singularity_measure(q) < 0.05) continue;
      ++done;
      const int n = arm.chain.joint_count();
      const JointVector dq = test::random_vector(random, n, 1.0), ddq = test::random_vector(random, n, 1.0);
      Eigen::Isometry3d X;
      Jacobian J;
      arm.chain.jacobian(q, X, J);
      InverseKinematics::Goal goal;
      goal.X_BF = X;
      goal.V_BF_B = J * dq;
      goal.A_BF_B = J * ddq + arm.chain.jacobian_dot_times_dq(q, dq);
      JointVector found = q, rate = dq, acceleration = ddq;
      ASSERT_EQ(inverse->solve_motion(goal, found, rate, acceleration), IkStatus::kOk);
      EXPECT_LT((rate - dq).cwiseAbs().maxCoeff(), 1e-6);
      EXPECT_LT((acceleration - ddq).cwiseAbs().maxCoeff(), 1e-5);
    }
  }
}

TEST(FewJoints, DoNotPretendToTurnWhatTheyCannot) {
  for (const Few& arm : few()) {
    SCOPED_TRACE(arm.name);
    const auto inverse = InverseKinematics::create(arm.chain);
    Random random(5, arm.name);
    int refused = 0;
    for (int i = 0; i < 50; ++i) {
      JointVector q = 0.6 * test::random_q(random, arm.chain);
      Eigen::Isometry3d X = arm.chain.forward(q);
      X.linear() =
          Eigen::AngleAxisd(0.1, X.translation().cross(Eigen::Vector3d::UnitZ()).normalized()).toRotationMatrix() *
          Eigen::AngleAxisd(0.1, Eigen::Vector3d(X.translation().x(), X.translation().y(), 0).normalized()) *
          X.linear();
      const JointVector before = q;
      if (inverse->solve(X, {}, q) == IkStatus::kOk) continue;
      ++refused;
      EXPECT_EQ(q, before) << "untouched";
    }
    EXPECT_EQ(refused, 50);
  }
}

TEST(NearestPlace, IsThePlaceAndNoBetterTurnIsNear) {
  for (const Few& arm : few()) {
    SCOPED_TRACE(arm.name);
    Random random(6, arm.name);
    Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();
    X_FM.translation() = Eigen::Vector3d(0.02, 0.01, 0.1);
    for (int i = 0; i < 50; ++i) {
      const JointVector start =
          0.5 * (arm.chain.lower() + arm.chain.upper()) +
          0.4 * (test::random_q(random, arm.chain) - 0.5 * (arm.chain.lower() + arm.chain.upper()));
      Eigen::Isometry3d wanted = arm.chain.forward(start) * X_FM;
      wanted.linear() =
          wanted.linear() *
          Eigen::AngleAxisd(0.3, Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
      const auto near = nearest_place(arm.chain, wanted, X_FM, start);
      ASSERT_TRUE(near);
      const Eigen::Isometry3d there = arm.chain.forward(near->q) * X_FM;
      EXPECT_LT((there.translation() - wanted.translation()).norm(), 2e-9);
      EXPECT_NEAR(Eigen::AngleAxisd(Eigen::Matrix3d(there.linear().transpose() * wanted.linear())).angle(), near->turn,
                  1e-9);
      EXPECT_LE(near->turn, 0.3 + 1e-6) << "the start is at the place and turned by that much";
      EXPECT_TRUE(((near->q - arm.chain.lower()).array() >= 0.0).all() &&
                  ((arm.chain.upper() - near->q).array() >= 0.0).all());
    }
  }
}

TEST(NearestPlace, AGoalThatCanBeMetIsMet) {
  for (const Few& arm : few()) {
    SCOPED_TRACE(arm.name);
    Random random(7, arm.name);
    int met = 0;
    for (int i = 0; i < 50; ++i) {
      const JointVector q = test::random_q(random, arm.chain);
      const JointVector near_q = (q + test::random_vector(random, arm.chain.joint_count(), 0.2))
                                     .cwiseMax(arm.chain.lower())
                                     .cwiseMin(arm.chain.upper());
      const auto near = nearest_place(arm.chain, arm.chain.forward(q), Eigen::Isometry3d::Identity(), near_q);
      ASSERT_TRUE(near);
      met += near->turn < 1e-6;
    }
    EXPECT_GE(met, 45) << "but where a joint's limit is in the way";
  }
}

TEST(NearestPlace, OutOfReachIsNothing) {
  for (const Few& arm : few()) {
    Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
    far.translation() = Eigen::Vector3d(5.0, 0.0, 0.0);
    EXPECT_FALSE(
        nearest_place(arm.chain, far, Eigen::Isometry3d::Identity(), JointVector::Zero(arm.chain.joint_count())));
  }
}

}  // namespace
}  // namespace takt::kinematics
