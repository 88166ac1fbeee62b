// Many random poses of the arms in models/. A share by default; the whole million of each arm with
// TAKT_POSES=1000000 (docs/benchmarks.md has the figures).
#include <cstdlib>
#include <functional>

#include <gtest/gtest.h>

#include "core/kinematics/arm_angle.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;

/// Outside of this measure (posture.h) a pose counts as well away from singular postures.
constexpr double kRegular = 1e-3;

int poses() {
  const char* wanted = std::getenv("TAKT_POSES");
  return wanted != nullptr ? std::max(1, std::atoi(wanted)) : 100'000;
}

Chain model(const std::string& name) {
  const auto robot = RobotModel::load("models/" + name + "/" + name + ".urdf");
  EXPECT_TRUE(robot) << "run from the root of the repository";
  return *Chain::create(*robot, robot->root().name, "flange");
}

struct Outcome {
  int regular = 0, missed = 0, off = 0;
  double worst = 0.0;
};

/// Options that leave isolated solutions; false where the redundancy has no value at q.
using Choose = std::function<bool(const JointVector& q, SolutionOptions& options)>;

Outcome run(const Chain& chain, const Choose& choose) {
  const auto inverse = InverseKinematics::create(chain);
  Random random(101, "poses");
  Outcome outcome;
  SolutionOptions options;
  options.turns = false;
  const int count = poses();
  for (int k = 0; k < count; ++k) {
    const JointVector q = random_q(random, chain);
    if (inverse->singularity_measure(q) < kRegular || !choose(q, options)) continue;
    options.reference = q;
    const Eigen::Isometry3d X_BF = chain.forward(q);
    const auto solutions = inverse_solutions(chain, X_BF, options);
    ++outcome.regular;
    if (solutions.empty() || (solutions.front() - q).cwiseAbs().maxCoeff() > 1e-6) ++outcome.missed;
    for (const JointVector& s : solutions) {
      const double distance = pose_distance(chain.forward(s), X_BF);
      // What would stand a little outside is brought to the end of the range, as long as six digits of the pose stay.
      const double most = limit_distance(chain, s) == 0.0 ? 1e-6 : 1e-9;
      outcome.worst = std::max(outcome.worst, distance);
      if (!(distance <= most)) ++outcome.off;
    }
  }
  return outcome;
}

void expect_all(const Outcome& outcome) {
  EXPECT_GT(outcome.regular, poses() / 2);
  EXPECT_EQ(outcome.missed, 0) << "the joints that made the pose are among the solutions";
  EXPECT_EQ(outcome.off, 0) << "every solution makes the pose, worst " << outcome.worst;
}

TEST(ManyPoses, Ur5) {
  expect_all(run(model("ur5"), [](const JointVector&, SolutionOptions&) { return true; }));
}

TEST(ManyPoses, Tx90) {
  expect_all(run(model("tx90"), [](const JointVector&, SolutionOptions&) { return true; }));
}

TEST(ManyPoses, LwrWithItsThirdJointHeld) {
  expect_all(run(model("lwr4plus"), [](const JointVector& q, SolutionOptions& options) {
    options.held_values = {q[2]};
    return true;
  }));
}

TEST(ManyPoses, LwrWithItsArmAngle) {
  const Chain chain = model("lwr4plus");
  const auto arm = ArmAngle::recognise(chain);
  ASSERT_TRUE(arm);
  expect_all(run(chain, [&](const JointVector& q, SolutionOptions& options) {
    const auto angle = arm->of(q);
    // The shoulder may be singular for a given arm angle where it is not for a given third joint, and the other way.
    if (!angle || std::abs(std::sin(q[1])) < kRegular || std::abs(std::sin(q[5])) < kRegular) return false;
    options.arm_angles = {*angle};
    return true;
  }));
}

/// Beside singular postures: solutions still make the pose within 1e-6, or the posture is said to be singular.
TEST(ManyPoses, BesideSingularPostures) {
  Random random(102, "beside");
  for (const char* name : {"ur5", "tx90", "lwr4plus"}) {
    const Chain chain = model(name);
    const std::vector<int> joints = chain.joint_count() == 7 ? std::vector<int>{3, 1, 5} : std::vector<int>{2, 4};
    for (int round = 0; round < 6000; ++round) {
      JointVector q = random_q(random, chain);
      const int joint = joints[static_cast<std::size_t>(round) % joints.size()];
      q[joint] = random.uniform(-1.0, 1.0) * std::pow(10.0, -1.0 - round % 14);
      SolutionOptions options;
      options.turns = false;
      options.reference = q;
      if (chain.joint_count() == 7) options.held_values = {q[2]};
      const Eigen::Isometry3d X_BF = chain.forward(q);
      const auto solutions = inverse_solutions(chain, X_BF, options);
      for (const JointVector& s : solutions) EXPECT_LT(pose_distance(chain.forward(s), X_BF), 1e-6);
      EXPECT_TRUE(!solutions.empty() || singularity(chain, q).singular) << name << " " << q.transpose();
    }
  }
}

}  // namespace
}  // namespace takt::kinematics
