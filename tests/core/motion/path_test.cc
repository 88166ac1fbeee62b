#include "core/motion/path.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/random.h"
#include "tests/support/reports.h"

namespace takt::motion {
namespace {

using takt::test::Reports;

Eigen::Isometry3d random_pose(Random& random) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1);
  const Eigen::Quaterniond R(random.normal(), random.normal(), random.normal(), random.normal());
  X.linear() = R.normalized().toRotationMatrix();
  return X;
}

JointVector joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q[i++] = value;
  return q;
}

TEST(JointLine, GoesInProportionAndEndsExactly) {
  const JointLine line{.q_start = joints({0.1, -2.0}), .q_goal = joints({0.3, 1.0 / 3.0})};
  EXPECT_EQ(line.sample({.s = 0.0}).q, line.q_start);
  EXPECT_EQ(line.sample({.s = 1.0}).q, line.q_goal);
  const JointSample half = line.sample({.s = 0.5, .ds = 2.0, .dds = -3.0});
  EXPECT_NEAR(half.q[0], 0.2, 1e-15);
  EXPECT_NEAR(half.dq[0], 0.4, 1e-15);
  EXPECT_NEAR(half.ddq[1], -7.0, 1e-14);
}

TEST(CartesianLine, MeetsBothPosesAndStaysOnTheStraightLine) {
  Random random(21);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Isometry3d start = random_pose(random);
    const Eigen::Isometry3d goal = random_pose(random);
    const auto line = CartesianLine::between(start, goal);
    EXPECT_TRUE(line.sample({.s = 0.0}).X_BM.isApprox(start, 1e-13));
    EXPECT_TRUE(line.sample({.s = 1.0}).X_BM.isApprox(goal, 1e-13));
    EXPECT_LE(line.angle, std::numbers::pi + 1e-9) << "the short way round";
    const Eigen::Vector3d p = line.sample({.s = random.unit()}).X_BM.translation() - start.translation();
    EXPECT_LT(p.cross((goal.translation() - start.translation()).normalized()).norm(), 1e-14);
  }
}

TEST(CartesianLine, TwistAndAccelerationAreTheDerivativesOfThePose) {
  Random random(22);
  for (int i = 0; i < 200; ++i) {
    const auto line = CartesianLine::between(random_pose(random), random_pose(random));
    const double s = random.uniform(0.1, 0.9);
    const double ds = random.uniform(-1, 1);
    const double dds = random.uniform(-1, 1);
    const double h = 1e-5;
    const auto at = [&](double t) {
      return line.sample({.s = s + t * (ds + t / 2 * dds), .ds = ds + t * dds, .dds = dds});
    };
    const FrameSample now = at(0.0);
    const Eigen::Vector3d v = (at(h).X_BM.translation() - at(-h).X_BM.translation()) / (2 * h);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(at(h).X_BM.linear() * at(-h).X_BM.linear().transpose()));
    EXPECT_LT((v - now.V_BM_B.head<3>()).norm(), 1e-8);
    EXPECT_LT((turn.axis() * turn.angle() / (2 * h) - now.V_BM_B.tail<3>()).norm(), 1e-7);
    EXPECT_LT(((at(h).V_BM_B - at(-h).V_BM_B) / (2 * h) - now.A_BM_B).norm(), 1e-8);
  }
}

TEST(CartesianLine, HalfATurnHasOneAxisWhateverTheRounding) {
  Random random(23);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Isometry3d start = random_pose(random);
    const Eigen::Vector3d axis = random_pose(random).translation().normalized();
    Eigen::Vector3d found[2];
    for (int k = 0; k < 2; ++k) {
      Eigen::Isometry3d goal = start;
      // A hair less and a hair more than half a turn, about either sense of the axis.
      const double angle = std::numbers::pi + (k == 0 ? 1e-12 : -1e-12);
      goal.linear() = Eigen::AngleAxisd(k == 0 ? angle : -angle, axis) * start.linear();
      const auto line = CartesianLine::between(start, goal);
      found[k] = line.axis;
      EXPECT_TRUE(line.sample({.s = 1.0}).X_BM.isApprox(goal, 1e-9));
      EXPECT_GT(line.axis.x() == 0.0 ? 1.0 : line.axis.x(), -1e-8);
    }
    EXPECT_LT((found[0] - found[1]).norm(), 1e-8);
  }
}

TEST(CartesianLine, HasNoWayWhereThereIsNone) {
  Random random(24);
  const Eigen::Isometry3d X = random_pose(random);
  const auto line = CartesianLine::between(X, X);
  EXPECT_EQ(line.length, 0.0);
  EXPECT_EQ(line.angle, 0.0);
  EXPECT_NEAR(line.axis.norm(), 1.0, 1e-15);
}

TEST(CartesianLine, HeldJointsGoInProportion) {
  const auto line = CartesianLine::between(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(), joints({0.2}),
                                           joints({0.6}));
  EXPECT_NEAR(line.held({.s = 0.25, .ds = 2.0}).q[0], 0.3, 1e-15);
  EXPECT_NEAR(line.held({.s = 0.25, .ds = 2.0}).dq[0], 0.8, 1e-15);
}

Path through_text(const Path& path) {
  const auto json = parse_json(to_json(path).dump());
  EXPECT_TRUE(json);
  const auto read = path_from_json(*json);
  EXPECT_TRUE(read) << read.error().to_string();
  return read ? *read : Path();
}

TEST(Path, SurvivesJsonTextBitForBit) {
  Random random(25);
  for (int i = 0; i < 100; ++i) {
    const Path line = CartesianLine::between(random_pose(random), random_pose(random), joints({random.unit()}),
                                             joints({random.unit()}));
    const Path read = through_text(line);
    const PathPoint at{.s = random.unit(), .ds = 1.0, .dds = 1.0};
    const FrameSample a = std::get<CartesianLine>(line).sample(at);
    const FrameSample b = std::get<CartesianLine>(read).sample(at);
    EXPECT_EQ(a.X_BM.matrix(), b.X_BM.matrix());
    EXPECT_EQ(a.V_BM_B, b.V_BM_B);
    EXPECT_EQ(std::get<CartesianLine>(line).held(at).q, std::get<CartesianLine>(read).held(at).q);
    const JointLine joint_line{joints({random.unit(), random.unit()}), joints({random.unit(), random.unit()})};
    EXPECT_EQ(std::get<JointLine>(through_text(joint_line)).sample(at).q, joint_line.sample(at).q);
  }
}

Diagnostics refusal(const char* text) {
  const auto path = path_from_json(nlohmann::ordered_json::parse(text), "/path");
  return path ? Diagnostics() : path.error();
}

TEST(Path, RefusesWhatIsNoneAndSaysWhy) {
  EXPECT_THAT(refusal("[]"), Reports(Code::kWrongType, "/path"));
  EXPECT_THAT(refusal(R"({"kind": "joint_lime"})"), Reports(Code::kUnknownName, "/path/kind", {"joint_line"}));
  EXPECT_THAT(refusal(R"({"kind": "joint_line", "start": [1, 2], "goal": [1]})"),
              Reports(Code::kWrongSize, "/path/goal"));
  EXPECT_THAT(refusal(R"({"kind": "joint_line", "start": [1], "goal": [1], "gaol": 1})"),
              Reports(Code::kUnknownKey, "/path/gaol", {"gaol"}));
  EXPECT_THAT(refusal(R"({"kind": "cartesian_line", "start": [0, 0, 0, 2, 0, 0, 0]})"),
              Reports(Code::kOutOfRange, "/path/start", {"2"}));
  EXPECT_THAT(refusal(R"({"kind": "cartesian_line", "start": [0, 0, 0, 1, 0, 0, 0], "axis": [1, 1, 0]})"),
              Reports(Code::kOutOfRange, "/path/axis"));
  EXPECT_THAT(refusal(R"({"kind": "joint_line", "start": [1,1,1,1,1,1,1,1,1,1,1,1,1],
                          "goal": [1,1,1,1,1,1,1,1,1,1,1,1,1]})"),
              Reports(Code::kWrongSize, "/path/start", {"12"}));
}

}  // namespace
}  // namespace takt::motion
