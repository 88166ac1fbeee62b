#include "core/kinematics/chain.h"

#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <kdl/chainjnttojacdotsolver.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <kdl/tree.hpp>

#include "tests/core/kinematics/robots.h"
#include "tests/support/reports.h"

namespace takt::kinematics {
namespace {

using takt::test::Reports;
using test::random_vector;

// --- the oracle: the same model as a KDL chain -----------------------------------------------------------------------

KDL::Vector to_kdl(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame to_kdl(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          to_kdl(Eigen::Vector3d(X.translation()))};
}

KDL::RigidBodyInertia to_kdl(const Inertial& body, const Eigen::Isometry3d& X) {
  const Eigen::Isometry3d X_LC = X * body.X_LC;
  const Eigen::Matrix3d I = X_LC.linear() * body.I_C * X_LC.linear().transpose();
  const KDL::RotationalInertia tensor(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return KDL::RigidBodyInertia(body.mass, to_kdl(Eigen::Vector3d(X_LC.translation())), tensor);
}

/// All bodies fixed to a link, itself included, in its frame.
KDL::RigidBodyInertia fixed_bodies(const RobotModel& model, const std::string& link, const Eigen::Isometry3d& X,
                                   const std::string& stop) {
  KDL::RigidBodyInertia sum;
  if (model.link(link)->inertial) sum = to_kdl(*model.link(link)->inertial, X);
  for (const Joint& joint : model.joints) {
    if (joint.parent == link && joint.type == JointType::kFixed && joint.child != stop)
      sum = sum + fixed_bodies(model, joint.child, X * joint.X_PJ, stop);
  }
  return sum;
}

KDL::Chain kdl_chain(const RobotModel& model, const std::string& base, const std::string& flange,
                     const Payload& payload = {}) {
  std::vector<const Joint*> path;
  for (std::string link = flange; link != base; link = path.front()->parent)
    path.insert(path.begin(), model.joint_above(link));
  KDL::Chain chain;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Joint& joint = *path[i];
    const auto kind = joint.type == JointType::kFixed       ? KDL::Joint::None
                      : joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis
                                                            : KDL::Joint::RotAxis;
    const KDL::Vector origin = to_kdl(Eigen::Vector3d(joint.X_PJ.translation()));
    const KDL::Vector axis = to_kdl(Eigen::Vector3d(joint.X_PJ.linear() * joint.axis));
    const KDL::Joint moving =
        kind == KDL::Joint::None ? KDL::Joint(joint.name, kind) : KDL::Joint(joint.name, origin, axis, kind);
    const std::string stop = i + 1 < path.size() ? path[i + 1]->child : std::string();
    KDL::RigidBodyInertia body = fixed_bodies(model, joint.child, Eigen::Isometry3d::Identity(), stop);
    if (joint.child == flange && payload.mass > 0.0) {
      Inertial tool{payload.mass, Eigen::Isometry3d::Identity(), payload.I_C};
      tool.X_LC.translation() = payload.p_FC;
      body = body + to_kdl(tool, Eigen::Isometry3d::Identity());
    }
    chain.addSegment(KDL::Segment(joint.child, moving, to_kdl(joint.X_PJ), body));
  }
  return chain;
}

KDL::JntArray to_kdl(const JointVector& q) {
  KDL::JntArray array(static_cast<unsigned>(q.size()));
  array.data = q;
  return array;
}

Payload random_payload(Random& random) {
  Payload payload{random.uniform(0.1, 7.0), Eigen::Vector3d(0.02, -0.03, 0.1), Eigen::Matrix3d::Zero()};
  payload.I_C.diagonal() << 0.02, 0.03, 0.025;
  payload.I_C(0, 1) = payload.I_C(1, 0) = 0.001;
  return payload;
}

/// Runs a check on random chains of 1 to kMaxJoints joints and several postures each.
template <class Check>
void for_random_chains(std::string_view stream, Check check) {
  Random random(7, stream);
  for (int round = 0; round < 60; ++round) {
    const RobotModel model = test::random_model(random, 1 + round % kMaxJoints);
    const auto chain = Chain::create(model, "l0", "flange");
    ASSERT_TRUE(chain) << chain.error().to_string();
    for (int posture = 0; posture < 5; ++posture) check(random, model, *chain, test::random_q(random, *chain));
    if (::testing::Test::HasFailure()) return;
  }
}

// --- against KDL -----------------------------------------------------------------------------------------------------

TEST(Chain, ForwardAndJacobianAgreeWithKdl) {
  for_random_chains("fk", [](Random&, const RobotModel& model, const Chain& chain, const JointVector& q) {
    KDL::Chain oracle = kdl_chain(model, "l0", "flange");
    KDL::Frame pose;
    KDL::ChainFkSolverPos_recursive(oracle).JntToCart(to_kdl(q), pose);
    KDL::Jacobian expected(static_cast<unsigned>(chain.joint_count()));
    KDL::ChainJntToJacSolver(oracle).JntToJac(to_kdl(q), expected);

    Eigen::Isometry3d X_BF;
    Jacobian J;
    chain.jacobian(q, X_BF, J);
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(X_BF.translation()[r], pose.p[r], 1e-12);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(X_BF.linear()(r, c), pose.M(r, c), 1e-12);
    }
    EXPECT_EQ(chain.forward(q).matrix(), X_BF.matrix()) << "one pose, computed in two places";
    EXPECT_LT((J - expected.data).cwiseAbs().maxCoeff(), 1e-12);
  });
}

TEST(Chain, JacobianDotTimesVelocityAgreesWithKdl) {
  for_random_chains("jdot", [](Random& random, const RobotModel& model, const Chain& chain, const JointVector& q) {
    const JointVector dq = random_vector(random, chain.joint_count(), 3.0);
    KDL::Chain oracle = kdl_chain(model, "l0", "flange");
    KDL::ChainJntToJacDotSolver solver(oracle);
    KDL::Twist expected;
    solver.JntToJacDot(KDL::JntArrayVel(to_kdl(q), to_kdl(dq)), expected);
    const Vector6 bias = chain.jacobian_dot_times_dq(q, dq);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(bias[i], expected[i], 1e-11 * std::max(1.0, bias.norm()));
  });
}

TEST(Chain, InverseDynamicsAgreesWithKdl) {
  for_random_chains("rne", [](Random& random, const RobotModel& model, const Chain& chain, const JointVector& q) {
    const int n = chain.joint_count();
    const Payload payload = random_payload(random);
    const Eigen::Vector3d gravity(1.0, -2.0, -9.81);
    const JointVector dq = random_vector(random, n, 3.0);
    const JointVector ddq = random_vector(random, n, 5.0);
    KDL::Chain oracle = kdl_chain(model, "l0", "flange", payload);
    KDL::JntArray expected(static_cast<unsigned>(n));
    KDL::ChainIdSolver_RNE solver(oracle, to_kdl(gravity));
    ASSERT_EQ(solver.CartToJnt(to_kdl(q), to_kdl(dq), to_kdl(ddq), KDL::Wrenches(oracle.getNrOfSegments()), expected),
              0);
    const JointVector tau = chain.inverse_dynamics(q, dq, ddq, gravity, payload);
    EXPECT_LT((tau - expected.data).cwiseAbs().maxCoeff(), 1e-11 * std::max(1.0, tau.norm()));
  });
}

TEST(Chain, PathDynamicsAreThePartsOfInverseDynamicsToTheBit) {
  for_random_chains("path", [](Random& random, const RobotModel&, const Chain& chain, const JointVector& q) {
    const int n = chain.joint_count();
    const Payload payload = random.unit() < 0.5 ? Payload{} : random_payload(random);
    const Eigen::Vector3d gravity(1.0, -2.0, -9.81), weightless = Eigen::Vector3d::Zero();
    const JointVector first = random_vector(random, n, 3.0), second = random_vector(random, n, 5.0);
    const JointVector none = JointVector::Zero(n);
    const Chain::PathDynamics parts = chain.path_dynamics(q, first, second, gravity, payload);
    EXPECT_EQ(parts.inertial, chain.inverse_dynamics(q, none, first, weightless, payload));
    EXPECT_EQ(parts.centrifugal, chain.inverse_dynamics(q, first, second, weightless, payload));
    EXPECT_EQ(parts.gravity, chain.inverse_dynamics(q, none, none, gravity, payload));
  });
}

TEST(Chain, MassMatrixAgreesWithKdlAndIsTheColumnsOfInverseDynamics) {
  for_random_chains("mass", [](Random& random, const RobotModel& model, const Chain& chain, const JointVector& q) {
    const int n = chain.joint_count();
    const Payload payload = random_payload(random);
    KDL::Chain oracle = kdl_chain(model, "l0", "flange", payload);
    KDL::JntSpaceInertiaMatrix expected(n);
    KDL::ChainDynParam(oracle, KDL::Vector::Zero()).JntToMass(to_kdl(q), expected);
    const JointMatrix M = chain.mass_matrix(q, payload);
    const double scale = std::max(1.0, M.norm());
    EXPECT_LT((M - expected.data).cwiseAbs().maxCoeff(), 1e-12 * scale);
    EXPECT_EQ(M, JointMatrix(M.transpose()));
    const JointVector zero = JointVector::Zero(n);
    for (int j = 0; j < n; ++j) {
      const JointVector unit = JointVector::Unit(n, j);
      const JointVector column = chain.inverse_dynamics(q, zero, unit, Eigen::Vector3d::Zero(), payload);
      EXPECT_LT((M.col(j) - column).cwiseAbs().maxCoeff(), 1e-12 * scale);
    }
  });
}

// --- against itself: differences and energy --------------------------------------------------------------------------

TEST(Chain, JacobianIsTheDerivativeOfForward) {
  for_random_chains("difference", [](Random& random, const RobotModel&, const Chain& chain, const JointVector& q) {
    const JointVector direction = random_vector(random, chain.joint_count(), 1.0);
    constexpr double kStep = 1e-5;
    const Eigen::Isometry3d ahead = chain.forward(q + kStep * direction);
    const Eigen::Isometry3d behind = chain.forward(q - kStep * direction);
    Eigen::Isometry3d X_BF;
    Jacobian J;
    chain.jacobian(q, X_BF, J);
    const Vector6 twist = J * direction;
    const Eigen::Vector3d v = (ahead.translation() - behind.translation()) / (2.0 * kStep);
    const Eigen::Matrix3d W = (ahead.linear() - behind.linear()) / (2.0 * kStep) * X_BF.linear().transpose();
    EXPECT_LT((v - twist.head<3>()).norm(), 1e-7);
    EXPECT_LT((Eigen::Vector3d(W(2, 1), W(0, 2), W(1, 0)) - twist.tail<3>()).norm(), 1e-7);

    Jacobian J_ahead, J_behind;
    chain.jacobian(q + kStep * direction, X_BF, J_ahead);
    chain.jacobian(q - kStep * direction, X_BF, J_behind);
    const Vector6 bias = (J_ahead - J_behind) / (2.0 * kStep) * direction;
    EXPECT_LT((bias - chain.jacobian_dot_times_dq(q, direction)).norm(), 1e-6 * std::max(1.0, bias.norm()));
  });
}

TEST(Chain, PowerOfTheTorquesIsTheChangeOfEnergy) {
  for_random_chains("energy", [](Random& random, const RobotModel&, const Chain& chain, const JointVector& q) {
    const int n = chain.joint_count();
    const JointVector dq = random_vector(random, n, 2.0);
    const JointVector ddq = random_vector(random, n, 2.0);
    const JointVector zero = JointVector::Zero(n);
    const auto kinetic = [&](double t) {
      const JointVector at = q + t * dq + 0.5 * t * t * ddq;
      const JointVector rate = dq + t * ddq;
      const JointVector momentum = chain.mass_matrix(at) * rate;
      return 0.5 * rate.dot(momentum);
    };
    constexpr double kStep = 1e-5;
    const double change = (kinetic(kStep) - kinetic(-kStep)) / (2.0 * kStep);
    const double power = dq.dot(chain.inverse_dynamics(q, dq, ddq, Eigen::Vector3d::Zero()));
    EXPECT_NEAR(change, power, 1e-6 * std::max(1.0, std::abs(kinetic(0.0))));
    EXPECT_GT(kinetic(0.0), 0.0);
    EXPECT_EQ(chain.inverse_dynamics(q, zero, zero, Eigen::Vector3d::Zero()), zero);
  });
}

// --- the LWR 4+ in figures -------------------------------------------------------------------------------------------

JointVector degrees(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q[i++] = value * EIGEN_PI / 180.0;
  return q;
}

TEST(Chain, LwrStandsAsPublished) {
  const Chain chain = test::lwr();
  ASSERT_EQ(chain.joint_count(), 7);
  EXPECT_EQ(chain.joint_names()[2], "joint_3");
  EXPECT_NEAR(chain.total_mass(), 16.0, 1e-12);
  EXPECT_NEAR(chain.reach(), 0.868, 1e-12);
  EXPECT_DOUBLE_EQ(chain.upper()[1], 120.0 * EIGEN_PI / 180.0);
  EXPECT_DOUBLE_EQ(chain.effort_limit()[6], 38.0);

  const Eigen::Isometry3d upright = chain.forward(JointVector::Zero(7));
  EXPECT_EQ(upright.linear(), Eigen::Matrix3d::Identity()) << "round axes give round numbers";
  EXPECT_LT((upright.translation() - Eigen::Vector3d(0, 0, 1.1785)).norm(), 1e-15);
  const Eigen::Isometry3d home = chain.forward(degrees({0, -30, 0, 90, 0, -60, 0}));
  EXPECT_LT((home.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 1e-14) << "the flange points down";
  EXPECT_NEAR(home.translation().x(), 0.538, 5e-4);
  EXPECT_NEAR(home.translation().z(), 0.384, 5e-4);
}

TEST(Chain, PayloadHangsWithItsWeight) {
  const Chain chain = test::lwr();
  const JointVector q = degrees({0, -90, 0, 0, 0, 0, 0});  // stretched level along +x
  const JointVector zero = JointVector::Zero(7);
  const Eigen::Vector3d gravity(0, 0, -9.81);
  Payload payload;
  payload.mass = 2.0;
  payload.p_FC = Eigen::Vector3d(0, 0, 0.1);
  const JointVector difference =
      chain.inverse_dynamics(q, zero, zero, gravity, payload) - chain.inverse_dynamics(q, zero, zero, gravity);
  // Gravity turns the arm about +y; axis 2 points along -y and axis 4 along +y.
  EXPECT_NEAR(difference[1], 2.0 * 9.81 * (0.868 + 0.1), 1e-12);
  EXPECT_NEAR(difference[3], -2.0 * 9.81 * (0.39 + 0.078 + 0.1), 1e-12);
  EXPECT_NEAR(difference[0], 0.0, 1e-12);
}

// --- what is refused -------------------------------------------------------------------------------------------------

TEST(Chain, FindingsNameWhatIsWrong) {
  const RobotModel model = test::model_of(test::lwr_urdf());
  const auto unknown = Chain::create(model, "bsae", "flansch");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().list().size(), 2u) << "both at once";
  EXPECT_THAT(unknown.error(), Reports(Code::kUnknownName, "", {"base"}));
  EXPECT_FALSE(Chain::create(model, "flange", "base")) << "upside down";
  EXPECT_FALSE(Chain::create(model, "base", "base")) << "no joint";
  EXPECT_FALSE(Chain::create(model, "link_7", "flange")) << "no movable joint";
  EXPECT_FALSE(Chain::create(model, "link_2", "link_5")) << "movable joints beyond the flange";

  Random random(1);
  EXPECT_FALSE(Chain::create(test::random_model(random, kMaxJoints + 1), "l0", "flange"));

  RobotModel branched = model;
  Joint finger = *model.joint("joint_3");
  finger.name = "finger_joint";
  finger.parent = "flange";
  finger.child = "finger";
  branched.joints.push_back(finger);
  branched.links.push_back({"finger", {}, {}, {}});
  const auto refused = Chain::create(branched, "base", "flange");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), Reports(Code::kInvalidValue, "", {"finger_joint"}));
  EXPECT_TRUE(Chain::create(branched, "base", "finger")) << "the same joint on the path";
}

TEST(Chain, SubtreeAboveTheBaseIsLeftOut) {
  const RobotModel model = test::model_of(test::lwr_urdf());
  const auto part = Chain::create(model, "link_3", "flange");
  ASSERT_TRUE(part);
  EXPECT_EQ(part->joint_count(), 4);
  EXPECT_NEAR(part->total_mass(), 2.303 * 2 + 1.601 + 1.493 + 0.114, 1e-12);
}

}  // namespace
}  // namespace takt::kinematics
