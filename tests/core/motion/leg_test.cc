// Geometry of CIRC and splines, the curves that they are made of, and how they survive JSON.
#include "core/motion/leg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/path_clock.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

class LegTest : public testing::Test {
 protected:
  LegTest() {
    q0_ << 0, -0.5236, 0, 1.5708, 0, -1.0472, 0;
    X0_ = arm_.chain.forward(q0_) * arm_.X_FM;
  }
  Eigen::Isometry3d shifted(double x, double y, double z) const { return Eigen::Translation3d(x, y, z) * X0_; }
  static PathSample at(const Leg& leg, double s) { return CompositePath{leg.pieces}.sample({.s = s, .ds = 1.0}); }
  static Diagnostics refusal(const Result<Leg>& leg) { return leg ? Diagnostics() : leg.error(); }

  Random random_{17};
  RandomArm arm_{robots::lwr_urdf(), random_};
  ArmModel model_ = arm_.model();
  JointVector q0_ = JointVector(7);
  Eigen::Isometry3d X0_;
};

TEST_F(LegTest, AnArcPassesItsThreePointsOnOneCircle) {
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d via = nearby(random_, X0_, 0.2, 0.0);
    const Eigen::Isometry3d goal = nearby(random_, X0_, 0.2, 1.0);
    const auto leg = circ_leg(model_, q0_, ArcThrough{.p_via = via.translation(), .X_BM_goal = goal});
    if (!leg) continue;
    const auto& arc = std::get<CartesianArc>(leg->pieces.front().geometry);
    EXPECT_LT((at(*leg, 0.0).frame.X_BM.matrix() - X0_.matrix()).norm(), 1e-12);
    EXPECT_LT((at(*leg, 1.0).frame.X_BM.matrix() - goal.matrix()).norm(), 1e-10);
    const double radius = (X0_.translation() - arc.centre).norm();
    double nearest = 1e9;
    for (int k = 0; k <= 2000; ++k) {
      const Eigen::Vector3d p = at(*leg, k / 2000.0).frame.X_BM.translation();
      EXPECT_NEAR((p - arc.centre).norm(), radius, 1e-10);
      nearest = std::min(nearest, (p - via.translation()).norm());
    }
    EXPECT_LT(nearest, arc.arc * radius / 2000.0) << "it passes the point on the way";
  }
}

TEST_F(LegTest, ATangentialArcShowsTheSameSideToItsCentre) {
  const auto leg = circ_leg(model_, q0_,
                            ArcAbout{.centre = X0_.translation() + Eigen::Vector3d(0.1, 0, 0.3),
                                     .axis = {0, 0, 2},
                                     .angle = -2.0,
                                     .orientation = ArcOrientation::kTangential});
  ASSERT_TRUE(leg) << leg.error().to_string();
  const auto& arc = std::get<CartesianArc>(leg->pieces.front().geometry);
  EXPECT_NEAR(arc.centre.z(), X0_.translation().z(), 1e-12) << "in the plane of the start";
  const auto centre_in_M = [&](double s) -> Eigen::Vector3d { return at(*leg, s).frame.X_BM.inverse() * arc.centre; };
  for (const double s : {0.3, 0.7, 1.0}) EXPECT_LT((centre_in_M(s) - centre_in_M(0.0)).norm(), 1e-12);
  EXPECT_NEAR(at(*leg, 0.5).frame.V_BM_B.head<3>().norm(), 0.2, 1e-12);
}

TEST_F(LegTest, FixedOrientationStays) {
  const auto leg = circ_leg(model_, q0_,
                            ArcThrough{.p_via = X0_ * Eigen::Vector3d(0.05, 0.05, 0),
                                       .X_BM_goal = nearby(random_, shifted(0.1, 0, 0), 0, 1.0),
                                       .orientation = ArcOrientation::kFixed});
  ASSERT_TRUE(leg) << leg.error().to_string();
  EXPECT_LT((at(*leg, 1.0).frame.X_BM.linear() - X0_.linear()).norm(), 1e-12);
}

TEST_F(LegTest, RefusesWhatIsNoCircleAndNoSpline) {
  const auto through = [&](const Eigen::Vector3d& via, const Eigen::Isometry3d& goal) {
    return refusal(circ_leg(model_, q0_, ArcThrough{.p_via = via, .X_BM_goal = goal}));
  };
  EXPECT_THAT(through(shifted(0.05, 0, 0).translation(), shifted(0.1, 0, 0)), Reports(Code::kInvalidValue, "/via"));
  EXPECT_THAT(through(X0_.translation(), shifted(0.1, 0, 0)), Reports(Code::kInvalidValue, "/via"));
  EXPECT_THAT(through(shifted(0.05, 0, 0).translation(), X0_), Reports(Code::kInvalidValue, "/via"));
  EXPECT_THAT(refusal(circ_leg(model_, q0_, ArcAbout{.centre = X0_.translation(), .angle = 1.0})),
              Reports(Code::kOutOfRange, "/centre"));
  EXPECT_THAT(refusal(circ_leg(model_, q0_, ArcAbout{.axis = Eigen::Vector3d::Zero(), .angle = 1.0})),
              Reports(Code::kOutOfRange, "/axis"));
  const std::vector<Eigen::Isometry3d> twice = {shifted(0.1, 0, 0), shifted(0.1, 0, 0)};
  EXPECT_THAT(refusal(spline_leg(model_, q0_, twice)), Reports(Code::kInvalidValue, "/points/1"));
  EXPECT_THAT(refusal(spline_leg(model_, q0_, std::vector{shifted(0.1, 0, 0)})),
              Reports(Code::kWrongSize, "/points", {"1"}));
  Eigen::Isometry3d turned = shifted(0.1, 0, 0);
  turned.linear() = Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitX()) * X0_.linear();
  EXPECT_THAT(refusal(spline_leg(model_, q0_, std::vector{shifted(0.05, 0, 0), turned})),
              Reports(Code::kInvalidValue, "/points/1", {"178"}));
}

TEST_F(LegTest, SplinesPassTheirPointsAndHaveFourContinuousDerivatives) {
  std::vector<JointVector> points;
  for (int i = 0; i < 5; ++i) points.push_back(q0_ + 0.3 * JointVector::Random(7));
  const auto leg = spline_leg(model_, q0_, points);
  ASSERT_TRUE(leg) << leg.error().to_string();
  ASSERT_EQ(leg->pieces.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& curve = std::get<JointCurve>(leg->pieces[i].geometry);
    EXPECT_LT((curve.q.at(1.0).value - points[i]).norm(), 1e-12);
    if (i + 1 == points.size()) continue;
    // Third and fourth derivative by s from both sides: coefficients of the polynomials.
    const auto& next = std::get<JointCurve>(leg->pieces[i + 1].geometry);
    const double h0 = leg->pieces[i].s_end - leg->pieces[i].s_begin;
    const double h1 = leg->pieces[i + 1].s_end - leg->pieces[i + 1].s_begin;
    const auto& c = curve.q.c;
    const JointVector third = (6.0 * c[3] + 24.0 * c[4] + 60.0 * c[5]) / std::pow(h0, 3);
    const JointVector fourth = (24.0 * c[4] + 120.0 * c[5]) / std::pow(h0, 4);
    EXPECT_LT((third - 6.0 * next.q.c[3] / std::pow(h1, 3)).norm(), 1e-7 * (1.0 + third.norm()));
    EXPECT_LT((fourth - 24.0 * next.q.c[4] / std::pow(h1, 4)).norm(), 1e-7 * (1.0 + fourth.norm()));
  }
}

TEST_F(LegTest, SplinesThroughPosesMeetThem) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 5; ++i) poses.push_back(nearby(random_, X0_, 0.2, 1.0));
  const auto leg = spline_leg(model_, q0_, poses);
  ASSERT_TRUE(leg) << leg.error().to_string();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PathPiece& piece = leg->pieces[i];
    EXPECT_LT((sample(piece.geometry, {.s = 1.0}).frame.X_BM.matrix() - poses[i].matrix()).norm(), 1e-10);
  }
  // Velocity and acceleration belong to the poses, also where the orientation turns.
  const double h = 1e-5;
  for (const double s : {0.1, 0.33, 0.5, 0.9}) {
    const PathSample a = at(*leg, s - h);
    const PathSample b = at(*leg, s + h);
    const PathSample m = at(*leg, s);
    EXPECT_LT((m.frame.V_BM_B.head<3>() - (b.frame.X_BM.translation() - a.frame.X_BM.translation()) / (2 * h)).norm(),
              1e-6);
    const Eigen::Vector3d turned = log_rotation(b.frame.X_BM.linear() * a.frame.X_BM.linear().transpose()) / (2 * h);
    EXPECT_LT((m.frame.V_BM_B.tail<3>() - turned).norm(), 1e-6);
    EXPECT_LT((m.frame.A_BM_B - (b.frame.V_BM_B - a.frame.V_BM_B) / (2 * h)).norm(),
              1e-5 * (1 + m.frame.A_BM_B.norm()));
  }
}

TEST(RotationVectorTest, MotionGoesThereAndBack) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const auto vector = [&](double size) -> Eigen::Vector3d {
      return size * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    };
    const Eigen::Vector3d phi = vector(i % 3 == 0 ? 1e-4 : i % 3 == 1 ? 0.1 : 1.7);
    const AngularMotion motion{.w = vector(2.0), .alpha = vector(3.0)};
    const AngularMotion again = angular_motion(rotation_vector(phi, motion));
    EXPECT_LT((again.w - motion.w).norm(), 1e-12);
    EXPECT_LT((again.alpha - motion.alpha).norm(), 1e-11);
    EXPECT_LT((log_rotation(exp_rotation(phi)) - phi).norm(), 1e-12);
  }
}

TEST_F(LegTest, PathsSurviveJsonTextBitForBit) {
  Random random(19);
  int compared = 0;
  for (int i = 0; i < 12; ++i) {
    std::vector<LegMaker> makers;
    for (int k = 0; k < 3; ++k) makers.push_back(random_leg(random, arm_, 0.1, {Blend::Kind::kFraction, 0.3}));
    const auto plan = plan_sequence(model_, q0_, makers);
    if (!plan) continue;
    ++compared;
    const auto text = to_json(plan->motion.path).dump();
    const auto read = path_from_json(nlohmann::ordered_json::parse(text));
    ASSERT_TRUE(read) << read.error().to_string();
    EXPECT_EQ(to_json(*read).dump(), text);
    for (int k = 0; k <= 100; ++k) {
      const PathSample a = sample(plan->motion.path, {.s = k / 100.0, .ds = 1.0, .dds = 1.0});
      const PathSample b = sample(*read, {.s = k / 100.0, .ds = 1.0, .dds = 1.0});
      EXPECT_EQ(a.joints.q, b.joints.q);
      EXPECT_EQ(a.frame.X_BM.matrix(), b.frame.X_BM.matrix());
      EXPECT_EQ(a.frame.A_BM_B, b.frame.A_BM_B);
    }
  }
  EXPECT_GT(compared, 3);
}

TEST(CompositePathTest, RefusesPiecesThatDoNotMeet) {
  const auto refused = [](const char* text) {
    const auto path = path_from_json(nlohmann::ordered_json::parse(text));
    return path ? Diagnostics() : path.error();
  };
  const std::string a = R"({"s": [0, 0.5], "geometry": {"kind": "joint_line", "start": [0], "goal": [1]}})";
  const auto with = [&](const std::string& second) {
    return R"({"kind": "composite", "pieces": [)" + a + "," + second + "]}";
  };
  EXPECT_EQ(refused(with(R"({"s": [0.5, 1], "geometry": {"kind": "joint_line", "start": [1], "goal": [2]}})").c_str())
                .to_string(),
            "");
  EXPECT_THAT(
      refused(with(R"({"s": [0.5, 1], "geometry": {"kind": "joint_line", "start": [1.1], "goal": [2]}})").c_str()),
      Reports(Code::kOutOfRange, "/pieces/1"));
  EXPECT_THAT(
      refused(with(R"({"s": [0.6, 1], "geometry": {"kind": "joint_line", "start": [1], "goal": [2]}})").c_str()),
      Reports(Code::kOutOfRange, "/pieces/1/s", {"0.6"}));
  EXPECT_THAT(
      refused(with(R"({"s": [0.5, 0.9], "geometry": {"kind": "joint_line", "start": [1], "goal": [2]}})").c_str()),
      Reports(Code::kOutOfRange, "/pieces", {"0.9"}));
  EXPECT_THAT(refused(R"({"kind": "composite", "pieces": []})"), Reports(Code::kOutOfRange, "/pieces", {"0"}));
  EXPECT_THAT(refused(R"({"kind": "joint_curve", "coefficients": [[0], [1], [0], [0], [0]]})"),
              Reports(Code::kWrongSize, "/coefficients"));
  EXPECT_THAT(refused(R"({"kind": "joint_cruve"})"), Reports(Code::kUnknownName, "/kind", {"joint_curve"}));
  EXPECT_THAT(refused(R"({"kind": "cartesian_arc", "start": [1, 0, 0, 1, 0, 0, 0], "centre": [0, 0, 0],
                          "normal": [1, 0, 0], "arc_rad": 1})"),
              Reports(Code::kOutOfRange, "/normal"));
}

}  // namespace
}  // namespace takt::motion::test
