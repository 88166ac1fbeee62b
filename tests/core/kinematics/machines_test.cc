// The arms of models/ against the tables that people publish of the same machines: Denavit and Hartenberg's four
// numbers per joint, which share no figure and no formula with the URDFs.
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

constexpr double kHalf = EIGEN_PI / 2;

/// Standard (distal) form: T = Rz(theta0 + q) Tz(d) Tx(a) Rx(alpha), m and rad.
struct Row {
  double theta0, d, a, alpha;
};

struct Machine {
  const char* name;
  std::vector<Row> rows;
  std::vector<std::array<double, 2>> range_deg;
  std::vector<double> deg_per_s;
};

const std::vector<Machine>& machines() {
  static const std::vector<Machine> all = {
      {"lwr4plus",
       {{0, 0.3105, 0, kHalf},
        {0, 0, 0, -kHalf},
        {0, 0.4, 0, -kHalf},
        {0, 0, 0, kHalf},
        {0, 0.39, 0, kHalf},
        {0, 0, 0, -kHalf},
        {0, 0.078, 0, 0}},
       {{-170, 170}, {-120, 120}, {-170, 170}, {-120, 120}, {-170, 170}, {-120, 120}, {-170, 170}},
       {110, 110, 128, 128, 204, 184, 184}},
      {"ur5",
       {{0, 0.089159, 0, kHalf},
        {0, 0, -0.425, 0},
        {0, 0, -0.39225, 0},
        {0, 0.10915, 0, kHalf},
        {0, 0.09465, 0, -kHalf},
        {0, 0.0823, 0, 0}},
       {{-360, 360}, {-360, 360}, {-360, 360}, {-360, 360}, {-360, 360}, {-360, 360}},
       {180, 180, 180, 180, 180, 180}},
      {"tx90",
       {{0, 0.478, 0.05, -kHalf},
        {-kHalf, 0.05, 0.425, 0},
        {kHalf, 0, 0, kHalf},
        {0, 0.425, 0, -kHalf},
        {0, 0, 0, kHalf},
        {0, 0.1, 0, 0}},
       {{-180, 180}, {-130, 147.5}, {-145, 145}, {-270, 270}, {-115, 140}, {-270, 270}},
       {400, 400, 430, 540, 475, 760}}};
  return all;
}

Eigen::Isometry3d table_pose(const std::vector<Row>& rows, const JointVector& q) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const double theta = row.theta0 + q[static_cast<Eigen::Index>(i)];
    Eigen::Matrix4d step;
    step << std::cos(theta), -std::sin(theta) * std::cos(row.alpha), std::sin(theta) * std::sin(row.alpha),
        row.a * std::cos(theta),  //
        std::sin(theta), std::cos(theta) * std::cos(row.alpha), -std::cos(theta) * std::sin(row.alpha),
        row.a * std::sin(theta),                               //
        0.0, std::sin(row.alpha), std::cos(row.alpha), row.d,  //
        0.0, 0.0, 0.0, 1.0;
    X.matrix() = X.matrix() * step;
  }
  return X;
}

Chain chain_of_model(const std::string& name) {
  const auto robot = RobotModel::load("models/" + name + "/" + name + ".urdf");
  EXPECT_TRUE(robot) << "run from the root of the repository";
  return *Chain::create(*robot, "base", "flange");
}

TEST(Machines, FlangeIsWhereThePublishedTableSays) {
  for (const Machine& machine : machines()) {
    SCOPED_TRACE(machine.name);
    const Chain chain = chain_of_model(machine.name);
    Random random(12, machine.name);
    double worst = 0.0;
    for (int round = 0; round < 10'000; ++round) {
      const JointVector q = test::random_q(random, chain);
      worst = std::max(worst, test::pose_distance(chain.forward(q), table_pose(machine.rows, q)));
    }
    EXPECT_LT(worst, 1e-12);
  }
}

TEST(Machines, LimitsAreThePublishedOnes) {
  for (const Machine& machine : machines()) {
    SCOPED_TRACE(machine.name);
    const Chain chain = chain_of_model(machine.name);
    ASSERT_EQ(chain.joint_count(), static_cast<int>(machine.range_deg.size()));
    for (int i = 0; i < chain.joint_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_NEAR(chain.lower()[i] * 180 / EIGEN_PI, machine.range_deg[k][0], 1e-12) << i;
      EXPECT_NEAR(chain.upper()[i] * 180 / EIGEN_PI, machine.range_deg[k][1], 1e-12) << i;
      EXPECT_NEAR(chain.velocity_limit()[i] * 180 / EIGEN_PI, machine.deg_per_s[k], 1e-12) << i;
    }
  }
}

}  // namespace
}  // namespace takt::kinematics
