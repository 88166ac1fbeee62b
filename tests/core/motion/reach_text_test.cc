#include "core/motion/reach_text.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/solutions.h"
#include "tests/core/motion/motion_runs.h"

namespace takt::motion::test {
namespace {

using kinematics::Chain;
using kinematics::JointVector;
using ::testing::HasSubstr;
namespace robots = kinematics::test;

/// Flange down, ahead of the base.
Eigen::Isometry3d ahead(double x, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, 0.0, z;
  X.linear() = Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return X;
}

bool reaches(const Chain& chain, const Eigen::Isometry3d& X_BF) {
  kinematics::SolutionOptions search;
  search.reference = JointVector::Zero(chain.joint_count());
  return !kinematics::inverse_solutions(chain, X_BF, search).empty();
}

/// What the text names: by how much to move, and where the flange gets to.
struct Named {
  double moved = 0.0;
  Eigen::Vector3d p;
};
Named named_in(std::string text) {
  for (char& c : text)
    if (std::string_view("0123456789.-").find(c) == std::string_view::npos) c = ' ';
  std::istringstream numbers(text);
  Named named;
  numbers >> named.moved >> named.p.x() >> named.p.y() >> named.p.z();
  EXPECT_TRUE(numbers) << text;
  return named;
}

/// The named point is within reach, and a centimetre nearer to the goal nothing is.
void expect_edge(const Chain& chain, const Eigen::Isometry3d& X_BF, const std::string& text) {
  const Named named = named_in(text);
  const Eigen::Vector3d back = (X_BF.translation() - named.p).normalized();
  EXPECT_NEAR((X_BF.translation() - named.p).norm(), named.moved, 2e-3) << text;
  const auto at = [&](double towards_goal) {
    Eigen::Isometry3d X = X_BF;
    X.translation() = named.p + towards_goal * back;
    return X;
  };
  EXPECT_TRUE(reaches(chain, at(-2e-3))) << text;
  EXPECT_FALSE(reaches(chain, at(1e-2))) << text;
}

TEST(ReachText, NamesHowFarTheFlangeGets) {
  for (const Chain& chain : {robots::chain_of(robots::ur5_urdf()), robots::lwr()}) {
    const JointVector q = JointVector::Constant(chain.joint_count(), 0.3);
    const auto far = ahead(3.0, 0.4), near = ahead(0.02, 0.36);
    ASSERT_FALSE(reaches(chain, far));
    const std::string too_far = reach_text(chain, far, q);
    EXPECT_THAT(reach_text(chain, ahead(1e300, 0.4), q), HasSubstr("1e+300")) << "no search goes there";
    expect_edge(chain, far, too_far);
    if (reaches(chain, near)) continue;
    const std::string too_near = reach_text(chain, near, q);
    expect_edge(chain, near, too_near);
    EXPECT_NE(too_far.substr(0, 8), too_near.substr(0, 8)) << too_far << "; " << too_near;
  }
}

}  // namespace
}  // namespace takt::motion::test
