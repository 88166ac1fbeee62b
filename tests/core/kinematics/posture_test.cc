#include "core/kinematics/posture.h"

#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

JointVector joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), q.begin());
  return q;
}

/// Where a link's frame is, straight from the file: the product of all joints up to it.
Eigen::Vector3d place(const RobotModel& model, const JointVector& q, int link) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < link; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    X = X * joint.X_PJ * Eigen::AngleAxisd(q[i], joint.axis);
  }
  return X.translation();
}

TEST(Posture, NamesOfAnArmWithASphericalWrist) {
  const Chain tx90 = test::chain_of(test::tx90_urdf());
  // Leaning forwards with the forearm bent down: the elbow is above the line to the wrist.
  EXPECT_EQ(posture(tx90, joints({0.2, 0.3, 1.4, 0.1, 0.8, 0})).name(), "front, up, no flip");
  EXPECT_EQ(posture(tx90, joints({0.2, 0.3, 1.4, 0.1, -0.8, 0})).name(), "front, up, flip");
  EXPECT_EQ(posture(tx90, joints({0.2, 1.6, -1.2, 0.1, 0.8, 0})).name(), "front, down, no flip");
  // Leaning backwards, mirrored: up stays up.
  EXPECT_EQ(posture(tx90, joints({0.2, -0.6, -1.4, 0.1, 0.8, 0})).name(), "back, up, no flip");
  EXPECT_EQ(posture(tx90, joints({0.2, -1.6, 1.2, 0.1, 0.8, 0})).name(), "back, down, no flip");
}

TEST(Posture, UpMeansTheElbowIsAboveTheLineToTheWrist) {
  // Measured on the links themselves, for arms with other signs, offsets and zero positions.
  for (const std::string& urdf : {test::tx90_urdf(), test::foreign_arms()[0].urdf, test::foreign_arms()[1].urdf}) {
    const RobotModel model = test::model_of(urdf);
    const Chain chain = *Chain::create(model, "base", "flange");
    Random random(2, "elbow");
    int judged = 0;
    for (int round = 0; round < 500; ++round) {
      const JointVector q = test::random_q(random, chain);
      const Eigen::Vector3d shoulder = place(model, q, 2);
      const Eigen::Vector3d elbow = place(model, q, 3);
      const Eigen::Vector3d wrist = place(model, q, 5);
      // Where the wrist is well beside axis 1 and axis 2 there is no doubt what is above.
      const Eigen::Vector2d way = (wrist - shoulder).head<2>();
      if (way.norm() < 0.3 || wrist.head<2>().norm() < 0.3) continue;
      const double share = (elbow - shoulder).head<2>().dot(way) / way.squaredNorm();
      const double height = elbow.z() - shoulder.z() - share * (wrist.z() - shoulder.z());
      if (std::abs(height) < 0.06) continue;
      EXPECT_EQ(posture(chain, q).elbow, height > 0.0 ? "up" : "down") << q.transpose();
      ++judged;
    }
    EXPECT_GT(judged, 50);
  }
}

TEST(Posture, NamesOfAnArmWithThreeParallelAxes) {
  const Chain ur5 = test::chain_of(test::ur5_urdf());
  const JointVector q = joints({0.3, -1.2, 1.6, -1.9, -1.57, 0.2});
  SolutionOptions options;
  options.turns = false;
  const auto all = inverse_solutions(ur5, ur5.forward(q), options);
  std::set<std::string> names;
  for (const JointVector& s : all) names.insert(posture(ur5, s).name());
  EXPECT_EQ(all.size(), 8u);
  EXPECT_EQ(names.size(), 8u) << "every branch has a name of its own";
  EXPECT_EQ(posture(ur5, q).elbow, "up");
  EXPECT_EQ(posture(ur5, q).shoulder, "left");
}

TEST(Posture, NamesOfAnArmWithSevenAxes) {
  // Axes 2 and 6 point to -y, axis 4 to +y: the home posture of the LWR leans and bends towards x.
  const Chain lwr = test::lwr();
  EXPECT_EQ(posture(lwr, joints({0.1, -0.5, 0, 1.5, 0, -1.0, 0})).name(), "front, up, no flip");
  EXPECT_EQ(posture(lwr, joints({0.1, 0.5, 0, -1.5, 0, 1.0, 0})).name(), "back, down, flip");
  // Joints 1 and 3 half a turn on: the same arm in the room, another branch.
  EXPECT_EQ(posture(lwr, joints({0.1 - EIGEN_PI, 0.5, EIGEN_PI, 1.5, 0, -1.0, 0})).name(), "back, up, no flip");
}

/// Every solution of a pose has another name.
TEST(Posture, NamesTellTheSolutionsApart) {
  Random random(6, "names");
  const std::vector<test::ForeignArm> foreign = test::foreign_arms();
  for (const std::string& urdf :
       {test::tx90_urdf(), test::ur5_urdf(), foreign[0].urdf, foreign[1].urdf, foreign[2].urdf}) {
    const Chain chain = test::chain_of(urdf);
    for (int round = 0; round < 200; ++round) {
      const JointVector q = test::random_q(random, chain);
      if (singularity(chain, q).measure < 1e-2) continue;
      SolutionOptions options;
      options.turns = false;
      const auto all = inverse_solutions(chain, chain.forward(q), options);
      std::set<std::string> names;
      for (const JointVector& s : all) names.insert(posture(chain, s).name());
      EXPECT_EQ(names.size(), all.size());
    }
  }
}

TEST(Posture, NamesChangeOnlyAtSingularPostures) {
  Random random(7, "walk");
  for (const std::string& urdf : {test::tx90_urdf(), test::ur5_urdf(), test::lwr_urdf()}) {
    const Chain chain = test::chain_of(urdf);
    int changes = 0;
    for (int walk = 0; walk < 40; ++walk) {
      const JointVector from = test::random_q(random, chain), to = test::random_q(random, chain);
      std::string before = posture(chain, from).name();
      for (int k = 1; k <= 500; ++k) {
        const JointVector q = from + (to - from) * (k / 500.0);
        const std::string name = posture(chain, q).name();
        if (name == before) continue;
        ++changes;
        // S-R-S arms have a joint to spare: not every change is singular there, but a joint is at zero.
        const double near =
            chain.joint_count() == 6
                ? singularity(chain, q).distance
                : std::min({std::abs(std::sin(q[1])), std::abs(std::sin(q[3])), std::abs(std::sin(q[5]))});
        EXPECT_LT(near, 0.05) << before << " to " << name << " at " << q.transpose();
        before = name;
      }
    }
    EXPECT_GT(changes, 20);
  }
}

TEST(Posture, OtherGeometriesFallBack) {
  const test::ForeignArm curved = test::foreign_arms().back();
  const Chain chain = test::chain_of(curved.urdf);
  const Posture at = posture(chain, JointVector::Constant(6, 0.7));
  EXPECT_TRUE(at.shoulder.empty());
  EXPECT_TRUE(at.name() == "aspect +" || at.name() == "aspect -") << at.name();
  Random random(1);
  const auto nine = Chain::create(test::random_model(random, 9), "l0", "flange");
  EXPECT_EQ(posture(*nine, JointVector::Zero(9)).name(), "");
}

TEST(Singularity, NamesTheNearestKind) {
  const Chain tx90 = test::chain_of(test::tx90_urdf());
  const auto nearest = [](const Chain& chain, const JointVector& q) {
    const Singularity s = singularity(chain, q);
    EXPECT_TRUE(s.singular) << q.transpose();
    EXPECT_LT(s.distance, 1e-6);
    return s.nearest;
  };
  EXPECT_EQ(nearest(tx90, joints({0.1, 0.4, 1.2, 0.3, 0.0, 0.2})), "wrist");
  EXPECT_EQ(nearest(tx90, joints({0.1, 0.4, 0.0, 0.3, 0.8, 0.2})), "elbow");
  // The wrist straight above axis 1: 0.05 + 0.425 sin q2 + 0.425 sin(q2 + q3) = 0.
  const double q2 = -0.5;
  const double q3 = std::asin(-(0.05 + 0.425 * std::sin(q2)) / 0.425) - q2;
  EXPECT_EQ(nearest(tx90, joints({0.1, q2, q3, 0.3, 0.8, 0.2})), "shoulder");

  const Chain lwr = test::lwr();
  EXPECT_EQ(nearest(lwr, joints({0.1, 0.4, 0.2, 0.0, 0.3, 0.8, 0.2})), "elbow");
  EXPECT_EQ(nearest(lwr, joints({0.1, 0.0, EIGEN_PI / 2, 1.0, 0.3, 0.8, 0.2})), "shoulder");
  EXPECT_EQ(nearest(lwr, joints({0.1, 0.4, 0.2, 1.0, EIGEN_PI / 2, 0.0, 0.2})), "wrist");
  EXPECT_EQ(nearest(lwr, joints({0.1, 0.0, 0.2, 1.0, 0.3, 0.0, 0.2})), "shoulder and wrist");
  EXPECT_FALSE(singularity(lwr, joints({0.1, 0.0, 0.2, 1.0, 0.3, 0.8, 0.2})).singular)
      << "joint 2 at zero alone is not";

  const Chain ur5 = test::chain_of(test::ur5_urdf());
  EXPECT_EQ(nearest(ur5, joints({0.1, -1.0, 1.0, 0.3, 0.0, 0.2})), "wrist");
  EXPECT_EQ(nearest(ur5, joints({0.1, -1.0, 0.0, 0.3, 0.7, 0.2})), "elbow");
}

TEST(Singularity, MeasureIsThatOfTheCycle) {
  const Chain tx90 = test::chain_of(test::tx90_urdf());
  const auto inverse = InverseKinematics::create(tx90);
  Random random(4, "measure");
  for (int round = 0; round < 100; ++round) {
    const JointVector q = test::random_q(random, tx90);
    const Singularity s = singularity(tx90, q);
    EXPECT_NEAR(s.measure, inverse->singularity_measure(q), 1e-9);
    EXPECT_GE(s.manipulability, 0.0);
    EXPECT_LE(s.condition, 1.0);
  }
}

TEST(Singularity, OtherGeometriesNameTheJointsThatOpposeEachOther) {
  const Chain crooked = test::chain_of(test::foreign_arms()[3].urdf);
  const Singularity s = singularity(crooked, JointVector::Constant(6, 0.3));
  EXPECT_NE(s.nearest.find(" against "), std::string::npos) << s.nearest;
  EXPECT_EQ(s.distance, s.measure);
}

TEST(LimitMargin, OfTheNearestJoint) {
  const Chain lwr = test::lwr();
  JointVector q = JointVector::Zero(7);
  q[3] = lwr.upper()[3] - 0.1;
  EXPECT_NEAR(limit_margin(lwr, q).distance, 0.1, 1e-12);
  EXPECT_EQ(limit_margin(lwr, q).joint, 3);
  q[5] = lwr.lower()[5] - 0.2;
  EXPECT_NEAR(limit_margin(lwr, q).distance, -0.2, 1e-12);
  EXPECT_EQ(limit_margin(lwr, q).distance, limit_distance(lwr, q));
}

}  // namespace
}  // namespace takt::kinematics
