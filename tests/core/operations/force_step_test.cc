// Steps that control a force: press and search, on a stiff block.
#include <algorithm>

#include "core/operations/force/search_pattern.h"
#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::ElementsAre;

class ForceStepTest : public test::ActivityTest {
 protected:
  /// Above the block, tared, then the steps.
  static std::string over_the_block(const std::string& steps, double x = 0.0, double z = 0.034) {
    return R"({"do": "sequence", "steps": [{"do": "ptp", "to": {"in": "block", "position_m": [)" + std::to_string(x) +
           ", 0, " + std::to_string(z) + R"(], "rpy_deg": [180, 0, 0]}}, {"do": "tare", "cycles": 20}, )" + steps +
           "]}";
  }
  static std::string press(const std::string& more) {
    return R"({"do": "press", "direction": [0, 0, -1], "in": "block", "force_N": 20, "approach_m_s": 0.001)" + more +
           "}";
  }
  /// What the block exerts on the ball along its z, N.
  double pressed_with() const {
    const double z = (fake.X_WO_true.inverse() * fake.tool_in_world(fake.backend->state().q).translation()).z();
    const double depth = 0.025 + fake.cell.arms.at("arm").tip.ball_radius - z;
    return std::max(0.0, depth) * test::FakeCell::kStiffness;
  }
};

TEST_F(ForceStepTest, PressesWithTheWantedForce) {
  double most = 0.0;
  const program::Program program = good(over_the_block(press(R"(, "seconds": 1)")));
  EXPECT_EQ(run(program, [&](int, program::ProgramRunner&) { most = std::max(most, pressed_with()); }), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR(pressed_with(), 20.0, 3.0);
  EXPECT_LT(most, 45.0) << "no blow at the touch, as hard as the block is";
  EXPECT_EQ(variables.touches.count("arm"), 1u);
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ForceStepTest, HoldsItsPlaceWhileItPresses) {
  EXPECT_EQ(run(over_the_block(press(R"(, "seconds": 1)"))), Progress::kDone);
  const Eigen::Isometry3d X_OT = fake.X_WO_true.inverse() * fake.tool_in_world(fake.q());
  EXPECT_NEAR(X_OT.translation().x(), 0.0, 1e-4);
  EXPECT_NEAR(X_OT.translation().y(), 0.0, 1e-4);
  EXPECT_NEAR(X_OT.linear()(2, 2), -1.0, 1e-6);
}

TEST_F(ForceStepTest, NothingToTouchIsAFailure) {
  EXPECT_EQ(run(over_the_block(press(R"(, "travel_m": 0.02)"), 0.0, 0.1)), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/steps/2/travel_m"));
  EXPECT_TRUE(fake.core_arm().at_rest());
}

TEST_F(ForceStepTest, N3_ASilentSensorStopsIt) {
  EXPECT_EQ(run(good(over_the_block(press(R"(, "seconds": 5)"))),
                [this](int, program::ProgramRunner& runner) {
                  fake.sensor->silent = runner.current() == "press" && pressed_with() > 5;
                }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/steps/2/sensor", {"wrist"}));
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ForceStepTest, AConditionEndsIt) {
  EXPECT_EQ(run(over_the_block(press(R"(, "until": {"sensor": "wrist", "above_N": 10})"))), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(pressed_with(), 40.0) << "a millimetre a second, a meganewton a metre";
}

TEST_F(ForceStepTest, RowL6ACancelAtAnyTimeEndsInOrder) {
  const program::Program program = good(over_the_block(press(R"(, "seconds": 1)")));
  for (const int after : {0, 1, 2, 3, 50, 400, 900}) {
    SCOPED_TRACE(after);
    int begun = -1;
    EXPECT_EQ(run(program,
                  [&](int cycle, program::ProgramRunner& runner) {
                    if (begun < 0 && runner.current() == "press") begun = cycle;
                    if (begun >= 0 && cycle == begun + after) runner.cancel();
                  }),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_TRUE(fake.core_arm().at_rest());
    EXPECT_FALSE(fake.core_arm().held());
    EXPECT_EQ(run(R"({"do": "ptp", "to": "home"})"), Progress::kDone);
  }
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ForceStepTest, ASearchFindsTheEdge) {
  // The block ends 50 mm from its middle.
  EXPECT_EQ(run(over_the_block(R"({"do": "search", "direction": [0, 0, -1], "in": "block", "force_N": 10,
                "approach_m_s": 0.01, "radius_m": 0.02, "pitch_m": 0.008, "velocity_m_s": 0.03, "drop_m": 0.001})",
                               0.038)),
            Progress::kDone)
      << diagnostics.to_string();
  const Eigen::Vector3d p_O = fake.X_WO_true.inverse() * fake.tool_in_world(fake.q()).translation();
  EXPECT_GT(p_O.x(), 0.049);
  EXPECT_LT(p_O.z(), 0.0305);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ForceStepTest, ASearchThatFindsNothingSaysSo) {
  const auto search = [](const std::string& more) {
    return over_the_block(
        R"({"do": "search", "direction": [0, 0, -1], "in": "block", "force_N": 10, "approach_m_s": 0.01,
        "radius_m": 0.006, "pitch_m": 0.003, "velocity_m_s": 0.03, "drop_m": 0.002, "pattern": "zigzag")" +
        more + "}");
  };
  EXPECT_EQ(run(search("")), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/steps/2"));
  EXPECT_EQ(run(search(R"(, "on_end": "continue")")), Progress::kDone) << diagnostics.to_string();
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ForceStepTest, ASearchThatShowsToBeImpossibleOnceItsValuesAreKnownIsRefused) {
  const auto search = [](const std::string& more) {
    return R"({"do": "sequence", "variables": {"wide": {"unit": "m", "value": 0.02}}, "steps": [
        {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.034], "rpy_deg": [180, 0, 0]}},
        {"do": "tare", "cycles": 20}, {"do": "search", "direction": [0, 0, -1], "in": "block", "force_N": 10,
        "radius_m": "$wide", "velocity_m_s": 0.03, )" +
           more + "}]}";
  };
  EXPECT_EQ(run(search(R"("pitch_m": "$wide / 100", "drop_m": 0.001)")), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kTooLarge, "/program/steps/2/pitch_m"));
  EXPECT_EQ(run(search(R"("pitch_m": "$wide / 4", "drop_m": 0.001, "depth_max_m": "$wide / 20")")), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConflict, "/program/steps/2/depth_max_m"));
}

TEST_F(ForceStepTest, WhatIsWrongWithTheFormIsToldAtOnce) {
  EXPECT_THAT(refused(R"({"do": "press", "sensor": "writs", "direction": [0, 0, 0], "force_N": 0, "approach_m_s": 1,
                          "travel_m": 0, "seconds": -1, "radius_m": 1})"),
              ElementsAre("/program/sensor", "/program/direction", "/program/force_N", "/program/approach_m_s",
                          "/program/travel_m", "/program/seconds", "/program/radius_m"));
  EXPECT_THAT(refused(R"({"do": "search", "pattern": "star", "radius_m": 0.1, "pitch_m": 0.001})"),
              ElementsAre("/program/pattern", "/program/pitch_m", "/program"));
}

TEST(SearchPattern, StaysInsideAndLeavesNoGap) {
  for (const SearchPattern pattern : {SearchPattern::kSpiral, SearchPattern::kZigzag}) {
    const auto points = search_points(pattern, 0.01, 0.002);
    EXPECT_EQ(points.size(), search_size(pattern, 0.01, 0.002));
    for (const Eigen::Vector2d& point : points) EXPECT_LE(point.norm(), 0.01 * std::numbers::sqrt2 + 1e-12);
    // Whatever lies inside is nearer to the pattern than a pitch.
    for (double angle = 0; angle < 6.28; angle += 0.1) {
      for (double radius = 0; radius < 0.009; radius += 0.001) {
        const Eigen::Vector2d at(radius * std::cos(angle), radius * std::sin(angle));
        double nearest = 1.0;
        for (std::size_t i = 1; i < points.size(); ++i) {
          const Eigen::Vector2d way = points[i] - points[i - 1];
          const double t = std::clamp((at - points[i - 1]).dot(way) / std::max(1e-12, way.squaredNorm()), 0.0, 1.0);
          nearest = std::min(nearest, (points[i - 1] + t * way - at).norm());
        }
        EXPECT_LT(nearest, 0.0021);
      }
    }
  }
}

}  // namespace
}  // namespace takt::operations
