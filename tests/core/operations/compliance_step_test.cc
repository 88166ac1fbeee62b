// Compliance as a key of steps: what is sent to the springs, what happens to it where motions go on with one another.
#include "tests/core/activity/command_fixture.h"
#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using device::ControlMode;
using takt::test::Reports;

const std::string kIntoJoint = R"({"do": "control_mode", "mode": "joint_impedance"}, )";
const std::string kIntoCartesian = R"({"do": "control_mode", "mode": "cartesian_impedance"}, )";

std::string steps(const std::string& list) { return R"({"do": "sequence", "steps": [)" + list + "]}"; }
std::string lin(const std::string& by, const std::string& more) {
  return R"({"do": "lin", "to": {"by_m": )" + by + R"(}, "velocity_m_s": 0.05)" + more + "}";
}
std::string springs(double stiffness) {
  return R"(, "compliance": {"mode": "joint_impedance", "stiffness_Nm_rad": )" + std::to_string(stiffness) + "}";
}
const std::string kBackToPosition = R"({"do": "control_mode", "mode": "position"})";

/// The largest change of a stiffness from one cycle to the next, as a share of what the device's ramp allows.
double worst_step(const test::FakeCell& cell) {
  const auto& impedance = cell.arm->impedance;
  const double most = static_cast<double>(cell.core.period()) / static_cast<double>(impedance.ramp);
  double worst = 0.0;
  for (std::size_t i = 1; i < cell.backend->given.size(); ++i) {
    const auto &before = cell.backend->given[i - 1], &now = cell.backend->given[i];
    const auto& range = impedance.range(now.mode).upper.stiffness;
    const device::JointVector share = (now.stiffness - before.stiffness).cwiseAbs().cwiseQuotient(range);
    worst = std::max(worst, share.maxCoeff() / most);
  }
  return worst;
}

class ComplianceStepTest : public test::CommandStepTest {
 protected:
  const device::Compliance& given() const { return cell.backend->given.back(); }
};

TEST_F(ComplianceStepTest, EveryStepThatMovesOrHoldsAnArmTakesSpringsOfTheTool) {
  const std::string soft = R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [500, 600, 700],
      "rotational_stiffness_Nm_rad": 50, "damping_ratio": 0.9, "nullspace_stiffness_Nm_rad": 5})";
  for (const std::string& step : {
           R"({"do": "ptp", "to": {"by_m": [0, 0, 0.05]}, "speed": 0.1)" + soft + "}",
           lin("[0, 0, 0.05]", soft),
           R"({"do": "circ", "via": {"by_m": [0, 0.02, 0.02]}, "to": {"by_m": [0, 0, 0.04]}, "velocity_m_s": 0.05)" +
               soft + "}",
           R"({"do": "spline", "through": [{"by_m": [0, 0.02, 0.02]}, {"by_m": [0, 0, 0.05]}], "velocity_m_s": 0.05)" +
               soft + "}",
           lin("[0, 0, 0.05]", R"(, "weave": {"amplitude_m": 0.002, "frequency_Hz": 2})" + soft),
           R"({"do": "hold", "seconds": 0.7)" + soft + "}",
           R"({"do": "follow", "in": "world", "channel": "target", "seconds": 0.7)" + soft + "}",
           R"({"do": "jog", "linear_m_s": [0, 0, 0.01], "while": {"channel": "enable"}, "seconds": 0.7)" + soft + "}",
           R"({"do": "transaction", "commands": {"m": {"start": true, "do": "motions", "steps": [)" +
               lin("[0, 0, 0.05]", R"(, "blend_m": 0.01)") + ", " + lin("[0, 0.05, 0]", "") + "]" + soft + "}}}",
       }) {
    SCOPED_TRACE(step);
    EXPECT_EQ(run(good(steps(kIntoCartesian + step + R"(, {"do": "ptp", "to": "home", "speed": 0.2})"))),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_EQ(given().stiffness.head(3), Eigen::Vector3d(500, 600, 700));
    EXPECT_EQ(given().stiffness[3], 50.0);
    EXPECT_EQ(given().damping_ratio[0], 0.9);
    EXPECT_EQ(given().nullspace_stiffness, 5.0) << "and a motion without the key leaves the springs as they are";
    EXPECT_LE(worst_step(cell), 1.0 + 1e-9);
    EXPECT_EQ(run(kBackToPosition), Progress::kDone);
    cell.backend->given.clear();
  }
  expect_good_end();
}

TEST_F(ComplianceStepTest, PressAndSearchTakeSprings) {
  const std::string soft = R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [500, 600, 700],
      "rotational_stiffness_Nm_rad": 50, "axes": "tool"})";
  const std::string up = R"("sensor": "wrist", "direction": [0, 0, 1], "in": "world", "approach_m_s": 0.01)" + soft;
  const std::string search = R"("do": "search", "radius_m": 0.01, "pitch_m": 0.002, "drop_m": 0.001, )" + up;
  const std::string pressed = R"({"do": "press", "until": {"input": "button"}, )" + up + "}";
  const auto inside = [](const std::string& command) {
    return R"({"do": "transaction", "commands": {"p": {"start": true, )" + command +
           R"(, "on": [{"entered": {"started": "p"}, "after_s": 0.8, "cancel": "p"}]}}})";
  };
  for (const std::string& step : {pressed, inside(R"("do": "press", )" + up), inside(search)}) {
    SCOPED_TRACE(step);
    cell.backend->given.clear();
    cell.button->sample.value = false;
    const program::Program program =
        good(steps(kIntoCartesian + R"({"do": "tare", "sensor": "wrist", "cycles": 20}, )" + step));
    EXPECT_EQ(run(program, [&](int cycle, program::ProgramRunner&) { cell.button->sample.value = cycle > 800; }),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_EQ(given().stiffness.head(3), Eigen::Vector3d(500, 600, 700));
    EXPECT_EQ(given().stiffness[3], 50.0);
    EXPECT_TRUE(given().in_tool_axes);
    EXPECT_LE(worst_step(cell), 1.0 + 1e-9);
    EXPECT_EQ(run(steps(kBackToPosition + R"(, {"do": "ptp", "to": "home"})")), Progress::kDone);
  }
  expect_good_end();
}

TEST_F(ComplianceStepTest, ForcesAreOfTheTool) {
  EXPECT_EQ(run(good(steps(kIntoCartesian + R"({"do": "hold", "seconds": 1, "compliance": {
      "mode": "cartesian_impedance", "axes": "tool", "force_N": [0, 0, 8], "torque_Nm": [0, 1, 0]}})"))),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(std::ranges::any_of(cell.backend->given, [](const device::Compliance& one) {
    return one.in_tool_axes && one.feed_forward.size() == 6 && one.feed_forward[2] == 8.0 && one.feed_forward[4] == 1.0;
  }));
}

class ComplianceBlendTest : public test::ActivityTest {
 protected:
  const device::Compliance& given() const { return fake.backend->given.back(); }
  bool was_given(double stiffness) const {
    return std::ranges::any_of(fake.backend->given, [&](const auto& one) { return one.stiffness[3] == stiffness; });
  }
};

// Who takes a motion over carries out the rest of it too: with other springs it would have them too soon.
TEST_F(ComplianceBlendTest, MotionsWithOtherSpringsBeginAtRestAndNothingJumps) {
  for (const bool computed : {false, true}) {
    SCOPED_TRACE(computed ? "computed" : "as it stands there");
    fake.backend->sent.clear();
    fake.backend->given.clear();
    const std::string blend = R"(, "blend_m": 0.02)";
    const std::string softer =
        computed ? R"(, "compliance": {"mode": "joint_impedance", "stiffness_Nm_rad": "$soft / 2"})" : springs(200);
    EXPECT_EQ(run(R"({"do": "sequence", "variables": {"soft": 400}, "steps": [)" + kIntoJoint +
                  lin("[0, 0, 0.1]", blend + springs(1500)) + ", " + lin("[0, 0.1, 0]", blend + softer) + ", " +
                  lin("[0, 0, -0.1]", springs(800)) + "]}"),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_EQ(given().stiffness[0], 800.0);
    EXPECT_TRUE(was_given(1500.0));
    EXPECT_TRUE(was_given(200.0));
    EXPECT_LE(worst_step(fake), 1.0 + 1e-9);
    EXPECT_GT(standing_cycles(), 0) << "at each of them";
    EXPECT_EQ(run(steps(kBackToPosition + R"(, {"do": "ptp", "to": "home"})")), Progress::kDone);
  }
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ComplianceBlendTest, AMotionWithoutTheKeyKeepsTheSpringsOfTheOneBefore) {
  EXPECT_EQ(run(steps(kIntoJoint + lin("[0, 0, 0.1]", R"(, "blend_m": 0.02)" + springs(300)) + ", " +
                      lin("[0, 0.1, 0]", ""))),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(given().stiffness[0], 300.0);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ComplianceStepTest, TheModeIsLookedAtWhereTheProgramIsThen) {
  const auto why = [&](const std::string& list) { return wrong(steps(list)); };
  const std::string soft = lin("[0, 0, 0.02]", springs(300));
  EXPECT_EQ(why(kIntoJoint + soft).to_string(), "");
  EXPECT_THAT(why(soft), Reports(Code::kNotPossibleNow, "/program/steps/0/compliance", {"control_mode"}));
  EXPECT_THAT(why(kIntoCartesian + soft),
              Reports(Code::kNotPossibleNow, "/program/steps/1/compliance", {"cartesian_impedance"}));
  EXPECT_THAT(why(kIntoJoint + soft + R"(, {"do": "control_mode", "mode": "position"}, )" + soft),
              Reports(Code::kNotPossibleNow, "/program/steps/3/compliance"));
  EXPECT_EQ(why(kIntoJoint + R"({"do": "freedrive", "seconds": 1}, )" + soft).to_string(), "")
      << "it comes back from there";
  const std::string stiff = lin("[0, 0, 0.02]", R"(, "compliance": {"mode": "position"})");
  EXPECT_EQ(why(stiff).to_string(), "");
  EXPECT_THAT(why(kIntoJoint + stiff), Reports(Code::kNotPossibleNow, "/program/steps/1/compliance"));
  // Only one way leads into the mode: the run tells.
  const std::string perhaps = R"({"do": "branch", "cases": [{"when": "$time() > 0[s]", "steps": [)" +
                              kIntoJoint.substr(0, kIntoJoint.size() - 2) + "]}]}, ";
  EXPECT_EQ(why(perhaps + soft).to_string(), "");
}

TEST_F(ComplianceStepTest, WhatOnlyTheRunCanTellFailsBeforeAnythingMoves) {
  const auto from = cell.q();
  const program::Program program = good(R"({"do": "sequence", "variables": {"soft": "$false"}, "steps": [
      {"do": "branch", "cases": [{"when": "$soft", "steps": [{"do": "control_mode", "mode": "joint_impedance"}]}]}, )" +
                                        lin("[0, 0, 0.02]", springs(300)) + "]}");
  EXPECT_EQ(run(program), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kNotPossibleNow, "/program/steps/1/compliance", {"control_mode"}));
  EXPECT_EQ(cell.q(), from);
}

}  // namespace
}  // namespace takt::operations
