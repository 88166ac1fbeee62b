// Blended motions of a program: what becomes one motion, what ends it, and that any cancel or abort leaves the arm at
// rest inside its limits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::activity {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

class BlendTest : public test::ActivityTest {};

/// Every kind into every other: PTP, LIN, arc through a point, spline of joints, arc about an axis, spline of poses.
constexpr const char* kTour = R"(
  {"do": "ptp", "name": "to", "to": {"in": "block", "position_m": [0, -0.1, 0.2]}, "blend_fraction": 0.4},
  {"do": "lin", "name": "along", "to": {"in": "block", "position_m": [0, 0.1, 0.2]}, "blend_m": 0.04},
  {"do": "circ", "name": "round", "to": {"in": "block", "position_m": [-0.15, 0.1, 0.2]},
   "via": {"in": "block", "position_m": [-0.08, 0.15, 0.22]}, "blend_m": 0.03},
  {"do": "spline", "name": "waves", "blend_fraction": 0.2,
   "through": [{"by_m": [0.05, -0.05, 0]}, {"by_m": [0, -0.1, 0.03]}, {"by_m": [0.05, -0.15, 0]}]},
  {"do": "circ", "name": "turn", "about": {"in": "block", "position_m": [0, 0, 0], "angle_deg": 40}, "blend_m": 0.02},
  {"do": "ptp", "name": "home", "to": "home"})";

TEST_F(BlendTest, P3_MotionsOfAllKindsBecomeOneWithoutAStop) {
  const program::Program program = good(sequence(kTour));
  EXPECT_THAT(program.names(), ElementsAre("sequence", "to", "along", "round", "waves", "turn", "home"));
  EXPECT_EQ(program.step_count(), 6);
  const program::Rehearsed rehearsal = program.rehearse(fake.cell, &fake.core.environment());
  EXPECT_EQ(rehearsal.diagnostics.to_string(), "");
  EXPECT_EQ(run(program), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_EQ(fake.q(), fake.arm->home);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
  EXPECT_EQ(standing_cycles(), 0) << "it never stops at a blend";
  EXPECT_THAT(begun(), ElementsAre("to", "along", "round", "waves", "turn", "home"));
  EXPECT_EQ(steps_done, 6);
  EXPECT_NEAR(cycles * 1e-3, rehearsal.duration, 0.02) << "one start, not six";
}

TEST_F(BlendTest, WithoutBlendsTheSameTourStopsAndTakesLonger) {
  std::string stopping = kTour;
  for (const char* key : {R"(, "blend_fraction": 0.4)", R"(, "blend_m": 0.04)", R"(, "blend_m": 0.03)",
                          R"( "blend_fraction": 0.2,)", R"(, "blend_m": 0.02)"}) {
    stopping.replace(stopping.find(key), std::string(key).size(), "");
  }
  EXPECT_EQ(run(sequence(stopping)), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_GE(standing_cycles(), 5);
  const int stopped = cycles;
  EXPECT_EQ(run(sequence(kTour)), operations::Progress::kDone);
  // A tenth at least: five stops less. How much more depends on which of several postures the goals are planned with.
  EXPECT_LT(cycles, 0.9 * stopped);
}

TEST_F(BlendTest, OtherStepsEndABlendedSequence) {
  const std::string up = R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.05]}, "blend_m": 0.02})";
  const std::string side = R"({"do": "lin", "name": "side", "to": {"by_m": [0.05, 0, 0]}, "blend_m": 0.02})";
  const std::string guarded = R"({"do": "lin", "to": {"by_m": [0, 0, 0.02]}, "on_end": "continue",
      "until": {"sensor": "wrist", "above_N": 50}})";
  const std::string wait = R"({"do": "wait", "seconds": 0.01})";
  const auto notes = [&](const std::string& steps) {
    const Diagnostics found = rehearsed(sequence(steps));
    EXPECT_FALSE(found.has_errors()) << found.to_string();
    return pointers(found);
  };
  EXPECT_THAT(notes(up + "," + side), ElementsAre("/program/steps/1")) << "the last one has nothing to blend into";
  EXPECT_THAT(notes(up + "," + wait + "," + side), ElementsAre("/program/steps/0", "/program/steps/2"));
  const std::string far = R"({"do": "lin", "to": {"by_m": [0.05, 0, 0]}, "until": {"sensor": "wrist", "above_N": 50}})";
  EXPECT_THAT(notes(up + "," + far), ElementsAre()) << "a guarded motion can be blended into";
  EXPECT_EQ(run(sequence(up + "," + side + "," + guarded + "," + up)), operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(BlendTest, AGuardedMotionIsBlendedIntoAndFeelsOnlyItsOwnWay) {
  const std::string program = sequence(R"(
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.08]}},
      {"do": "lin", "name": "over", "to": {"by_m": [0.03, 0, 0], "in": "block"}, "blend_m": 0.01, "velocity_m_s": 0.1},
      {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.08], "in": "block"}, "velocity_m_s": 0.02,
       "until": {"sensor": "wrist", "above_N": 8}}, {"do": "record_contact", "as": "top"})");
  // Pushed while it is on its way there: that is not the touch that is looked for.
  EXPECT_EQ(run(good(program),
                [this](int, program::ProgramRunner&) {
                  const Eigen::Vector3d p_O = fake.X_WO_true.inverse() * fake.tool_in_world(fake.q()).translation();
                  const bool on_the_way = p_O.x() > 0.002 && p_O.x() < 0.02;
                  fake.extra.force = on_the_way ? Eigen::Vector3d(0, 0, 60) : Eigen::Vector3d::Zero();
                }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(steps_done, 4);
  const Eigen::Vector3d p_O = fake.X_WO_true.inverse() * variables.contacts.at("top").p_R;
  EXPECT_NEAR(p_O.x(), 0.03, 1e-6);
  EXPECT_NEAR(p_O.z(), 0.025 + 0.005, 1e-4) << "half the block and the ball";
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(BlendTest, RehearsalTellsWhatCannotBeBlended) {
  const auto notes = [&](const std::string& second, const char* blend) {
    return rehearsed(sequence(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, )" + std::string(blend) + "}," + second));
  };
  const std::string back = R"({"do": "lin", "to": {"by_m": [0, 0, -0.1]}})";
  const Diagnostics reversal = notes(back, R"("blend_m": 0.02)");
  EXPECT_THAT(pointers(reversal), ElementsAre("/program/steps/0/blend_m"));
  EXPECT_THAT(reversal, Notes("/program/steps/0/blend_m"));
  const std::string small = R"({"do": "lin", "to": {"by_m": [0.01, 0, 0]}})";
  EXPECT_THAT(notes(small, R"("blend_m": 0.03)"), Notes("/program/steps/0/blend_m", {"30", "1"}));
  EXPECT_THAT(notes(R"({"do": "lin", "to": {"by_m": [0, 0, 0]}})", R"("blend_fraction": 0.3)"),
              Notes("/program/steps/0/blend_fraction"));
  EXPECT_EQ(run(sequence(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.02},)" + back)),
            operations::Progress::kDone);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
  EXPECT_LT((fake.q() - fake.arm->home).norm(), 1e-9) << "the whole way there and back";
}

TEST_F(BlendTest, WhatIsWrongWithALaterMotionIsToldWithItsName) {
  const Diagnostics found = rehearsed(sequence(R"(
      {"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "blend_m": 0.02},
      {"do": "lin", "name": "too far", "to": {"by_m": [0, 2, 0]}})"));
  EXPECT_THAT(found, Reports(Code::kUnreachable, "/program/steps/0/to", {"too far"}));
}

TEST_F(BlendTest, AllErrorsOfFormAreFoundAtOnce) {
  EXPECT_THAT(
      refused(sequence(R"(
      {"do": "ptp", "to": "home", "blend_m": 0},
      {"do": "ptp", "to": "home", "blend_fraction": 0.6},
      {"do": "ptp", "to": "home", "blend_m": 0.1, "blend_fraction": 0.2},
      {"do": "ptp", "to": "home", "blend_m": 0.1, "until": {"sensor": "wrist", "above_N": 5}},
      {"do": "circ", "to": "home"},
      {"do": "circ", "to": "home", "via": "home", "orientation": "wild"},
      {"do": "circ", "about": {"position_m": [0, 0, 0], "axis": [0, 0, 0], "angle_deg": 90}, "orientation": "goal"},
      {"do": "circ", "about": {"position_m": [0, 0, 0]}},
      {"do": "spline", "through": ["home"]},
      {"do": "spline", "through": ["home", {"by_m": [0, 0, 0.1]}]},
      {"do": "ptp", "to": "home", "velocity_m_s": 1})")),
      ElementsAre("/program/steps/0/blend_m", "/program/steps/1/blend_fraction", "/program/steps/2/blend_fraction",
                  "/program/steps/3/blend_m", "/program/steps/4", "/program/steps/5/orientation",
                  "/program/steps/6/about/axis", "/program/steps/6/orientation", "/program/steps/7/about",
                  "/program/steps/8/through", "/program/steps/9/through", "/program/steps/10/velocity_m_s"));
}

TEST_F(BlendTest, ArcsAndSplinesMayBeGuarded) {
  fake.extra.force.z() = 0.0;
  const program::Program program = good(sequence(R"({"do": "tare"},
      {"do": "circ", "to": {"by_m": [0.1, 0, 0]}, "via": {"by_m": [0.05, 0, 0.05]},
       "until": {"sensor": "wrist", "above_N": 5}})"));
  EXPECT_EQ(
      run(program, [this](int cycle, program::ProgramRunner&) { fake.extra.force.z() = cycle > 900 ? 9.0 : 0.0; }),
      operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(variables.touches.size(), 1u);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

constexpr const char* kShortTour = R"(
  {"do": "ptp", "to": {"in": "block", "position_m": [0, -0.1, 0.2]}, "blend_fraction": 0.4},
  {"do": "lin", "to": {"in": "block", "position_m": [0, 0.1, 0.2]}, "blend_m": 0.04},
  {"do": "circ", "to": {"in": "block", "position_m": [-0.15, 0.1, 0.2]},
   "via": {"in": "block", "position_m": [-0.08, 0.15, 0.22]}})";

// Row L6, P2: wherever a blended sequence is cancelled or aborted.
TEST_F(BlendTest, L6_P2_CancelAtEveryTenthCycleLeavesTheArmAtRestInsideItsLimits) {
  const program::Program program = good(sequence(kShortTour));
  cancel_at_every_tenth_cycle(program);
}

TEST_F(BlendTest, L6_AbortAtEveryFiftiethCycleBrakesInsideTheLimits) {
  const program::Program program = good(sequence(kShortTour));
  const program::Program home = good(R"({"do": "ptp", "to": "home"})");
  for (int at = 10; at < 1500; at += 50) {
    SCOPED_TRACE(at);
    fake.backend->sent.clear();
    const auto result = run(program, [this, at](int cycle, program::ProgramRunner&) {
      if (cycle == at) abort_all();
    });
    EXPECT_TRUE(result == operations::Progress::kDone ||
                testing::Matches(Reports(Code::kStopped, "/program/steps/0", {"abort"}))(diagnostics))
        << diagnostics.to_string();
    fake.step(500);
    EXPECT_TRUE(fake.core_arm().at_rest());
    ASSERT_EQ(run(home), operations::Progress::kDone) << diagnostics.to_string();
    ASSERT_LE(fake.worst_limit_share(), 1.0);
  }
}

}  // namespace
}  // namespace takt::activity
