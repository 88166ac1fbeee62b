// Steps with a weave that are blended into each other: one motion of the film, that never stops, whatever becomes of
// it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"
#include "tests/support/tool_oracle.h"

namespace takt::operations {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;

class WeaveStepTest : public test::ActivityTest {
 protected:
  /// A LIN to a place over the block; `more` are keys with a comma before them.
  static std::string lin(const char* name, const char* place, const std::string& more) {
    return fmt::format(R"({{"do": "lin", "name": "{}", "velocity_m_s": 0.08, "to": {{"in": "block",
        "position_m": [{}]}}{}}})",
                       name, place, more);
  }
  static constexpr const char* kWeave = R"(, "weave": {"amplitude_m": 0.002, "frequency_Hz": 2.5,
      "direction": [0, 0, 1], "ramp_s": 0.3})";
  static constexpr const char* kOther = R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 3,
      "direction": [0, 0, 1], "ramp_s": 0.3})";
  static constexpr const char* kBlend = R"(, "blend_m": 0.01)";
  static constexpr const char* kApproach = R"({"do": "ptp", "name": "to", "to": {"in": "block",
      "position_m": [0, -0.03, 0.2]}},)";
  static constexpr const char* kFirst = "0, 0.03, 0.2";
  static constexpr const char* kSecond = "-0.06, 0.03, 0.2";
  static constexpr const char* kThird = "-0.06, -0.03, 0.2";

  /// Three sides of a square.
  static std::string seam(const std::string& a, const std::string& b, const std::string& c) {
    return kApproach + lin("one", kFirst, a + kBlend) + "," + lin("two", kSecond, b + kBlend) + "," +
           lin("three", kThird, c);
  }
  Eigen::Vector3d tool_in_block(const device::JointVector& q) const {
    return fake.cell.frames.pose("block")->inverse() * fake.tool_in_world(q).translation();
  }
  /// First sample of the seam: the approach is over.
  std::size_t begin_of_seam() const {
    const auto& sent = fake.backend->sent;
    std::size_t i = sent.size() - 1;
    while (i > 0 && sent[i].dq.isZero(0.0)) --i;
    while (i > 0 && !sent[i].dq.isZero(0.0)) --i;
    return i;
  }
  /// The least speed along the square, away from both ends, m/s.
  double slowest() const {
    const auto& sent = fake.backend->sent;
    double slowest = 1e9;
    for (std::size_t i = begin_of_seam() + 300; i + 300 < sent.size(); ++i) {
      const Eigen::Vector3d way = tool_in_block(sent[i].q) - tool_in_block(sent[i - 1].q);
      slowest = std::min(slowest, way.head<2>().norm() / 1e-3);
    }
    return slowest;
  }
  /// How far it was beside the plane of the square at most, on the middle of a side: 0, 1, 2.
  double swing(int side) const { return swing(side, begin_of_seam()); }
  double swing(int side, std::size_t from) const {
    double most = 0.0;
    for (std::size_t i = from; i < fake.backend->sent.size(); ++i) {
      const Eigen::Vector3d p = tool_in_block(fake.backend->sent[i].q);
      const bool here = side == 0   ? std::abs(p.x()) < 1e-6 && std::abs(p.y()) < 0.015
                        : side == 1 ? std::abs(p.y() - 0.03) < 1e-6 && std::abs(p.x() + 0.03) < 0.015
                                    : std::abs(p.x() + 0.06) < 1e-6 && std::abs(p.y()) < 0.015;
      if (here) most = std::max(most, std::abs(p.z() - 0.2));
    }
    return most;
  }
};

TEST_F(WeaveStepTest, ASeamWithOneWeaveNeverStopsInItsCorners) {
  const program::Program program = good(sequence(seam(kWeave, kWeave, kWeave)));
  const program::Rehearsed rehearsal = program.rehearse(fake.cell, &fake.core.environment());
  EXPECT_EQ(rehearsal.diagnostics.to_string(), "");
  ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(begun(), ElementsAre("to", "one", "two", "three"));
  EXPECT_EQ(steps_done, 4);
  EXPECT_GT(slowest(), 0.6 * 0.08);
  for (const int side : {0, 1, 2}) EXPECT_GT(swing(side), 0.0012) << side;
  EXPECT_LE(test::worst_tool_share(fake, begin_of_seam()), 1.0);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
  EXPECT_NEAR(cycles * 1e-3, rehearsal.duration, 0.03) << "one start, not three";
  EXPECT_LT((tool_in_block(fake.q()) - Eigen::Vector3d(-0.06, -0.03, 0.2)).norm(), 1e-6) << "it has faded";
}

TEST_F(WeaveStepTest, WithNoneBetweenAndAnotherAfterwards) {
  ASSERT_EQ(run(sequence(seam(kWeave, "", kOther))), Progress::kDone) << diagnostics.to_string();
  EXPECT_GT(slowest(), 0.6 * 0.08);
  EXPECT_GT(swing(0), 0.0012);
  EXPECT_LT(swing(1), 1e-8);
  EXPECT_GT(swing(2), 0.0005);
  EXPECT_LT(swing(2), 0.0011);
  EXPECT_LE(test::worst_tool_share(fake, begin_of_seam()), 1.0);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(WeaveStepTest, IntoItAndOutOfItByMotionsOfJoints) {
  const std::string program = sequence(
      R"({"do": "ptp", "name": "to", "to": {"in": "block", "position_m": [0, -0.06, 0.2]}, "blend_m": 0.02},)" +
      lin("seam", "0, 0.06, 0.2", std::string(kWeave) + R"(, "blend_m": 0.02)") +
      R"(, {"do": "ptp", "name": "home", "to": "home"})");
  EXPECT_EQ(rehearsed(program).to_string(), "");
  ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(begun(), ElementsAre("to", "seam", "home"));
  EXPECT_EQ(standing_cycles(), 0);
  EXPECT_GT(swing(0), 0.0012);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
  EXPECT_EQ(fake.q(), fake.arm->home);
}

// Rows L6, P2.
TEST_F(WeaveStepTest, L6_P2_CancelAtEveryTenthCycleLeavesTheArmAtRestInsideItsLimits) {
  const program::Program program = good(sequence(seam(kWeave, "", kOther)));
  cancel_at_every_tenth_cycle(program);
}

// Row D3: the steps that became one motion are begun again from where the arm is.
TEST_F(WeaveStepTest, D3_ASnapshotInASeamBeginsItAgain) {
  const program::Program program = good(sequence(seam(kWeave, kWeave, kOther)));
  std::string text;
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner& runner) {
                  if (!text.empty() || runner.current() != "two" || tool_in_block(fake.q()).x() > -0.03) return;
                  text = runner.snapshot().dump();
                  runner.cancel();
                }),
            Progress::kDone);
  ASSERT_FALSE(text.empty());
  activity::Context context{fake.cell, fake.core, variables, latency, [](auto, auto, auto) {}};
  program::ProgramRunner runner(program, context);
  const Diagnostics found = runner.restore(test::Json::parse(text));
  ASSERT_TRUE(found.empty()) << found.to_string();
  fake.backend->sent.clear();
  for (int i = 0; i < 20'000 && runner.advance() == Progress::kRunning; ++i) fake.step();
  ASSERT_EQ(runner.progress(), Progress::kDone) << runner.diagnostics().to_string();
  EXPECT_LT((tool_in_block(fake.q()) - Eigen::Vector3d(-0.06, -0.03, 0.2)).norm(), 1e-6);
  EXPECT_GT(swing(1), 0.0012) << "it weaves as before";
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(WeaveStepTest, P2_PausedAndSlowedAnywhereItGoesOnWhereItWas) {
  const program::Program program = good(sequence(seam(kWeave, kWeave, kOther)));
  ASSERT_EQ(run(program,
                [this](int cycle, program::ProgramRunner&) {
                  (void)fake.speed->write(cycle % 700 < 200 ? 0.0 : cycle % 1100 < 500 ? 0.4 : 1.0);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LE(fake.worst_limit_share(), 1.0);
  EXPECT_GT(swing(0, 0), 0.0012) << "it stood on the way";
  EXPECT_LT((tool_in_block(fake.q()) - Eigen::Vector3d(-0.06, -0.03, 0.2)).norm(), 1e-6);
}

TEST_F(WeaveStepTest, WhereTheRunDecidesWhatComesNextItBeginsAndEndsAtRest) {
  const std::string branch = R"({"do": "branch", "cases": [{"when": "$1 < 2", "steps": []}]})";
  const std::string out = sequence(kApproach + lin("one", kFirst, std::string(kWeave) + kBlend) + "," + branch + "," +
                                   lin("two", kSecond, ""));
  const Diagnostics left = rehearsed(out);
  EXPECT_THAT(pointers(left), ElementsAre("/program/steps/1"));
  EXPECT_THAT(left, Notes("/program/steps/1"));
  ASSERT_EQ(run(out), Progress::kDone) << diagnostics.to_string();
  EXPECT_GT(standing_cycles(), 0);
  const std::string into =
      sequence(kApproach + lin("one", kFirst, kBlend) + "," + branch + "," + lin("two", kSecond, kWeave));
  EXPECT_THAT(pointers(rehearsed(into)), ElementsAre("/program/steps/1"));
  EXPECT_THAT(rehearsed(into), Notes("/program/steps/1", {"two", "3"}));
  ASSERT_EQ(run(into), Progress::kDone) << diagnostics.to_string();
  EXPECT_GT(swing(1), 0.0009);
  // What lies in the middle of a plan does not hinder it.
  const std::string around = sequence(kApproach + lin("one", kFirst, kBlend) + "," + branch + "," +
                                      lin("two", kSecond, kBlend) + "," + lin("three", kThird, kWeave));
  EXPECT_EQ(rehearsed(around).to_string(), "");
  fake.backend->sent.clear();
  ASSERT_EQ(run(around), Progress::kDone) << diagnostics.to_string();
  EXPECT_GT(slowest(), 0.6 * 0.08);
  EXPECT_GT(swing(2), 0.0012);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(WeaveStepTest, ConditionsCountWhereTheirMotionIsDone) {
  const std::string unless = R"(, "abort_if": {"sensor": "wrist", "above_N": 30})";
  const program::Program program = good(sequence(R"({"do": "tare"},)" + seam(kWeave, kWeave + unless, kWeave)));
  const auto push_at = [&](double x) {
    return run(program, [this, x](int, program::ProgramRunner&) {
      const Eigen::Vector3d p = tool_in_block(fake.q());
      const bool there = p.y() > 0.029 && std::abs(p.x() - x) < 0.003;
      fake.extra.force = there || (x > 0 && std::abs(p.x()) < 1e-6 && p.y() > -0.01 && p.y() < 0.01)
                             ? Eigen::Vector3d(0, 0, 60)
                             : Eigen::Vector3d::Zero();
    });
  };
  EXPECT_EQ(push_at(1.0), Progress::kDone) << "on the first side";
  EXPECT_EQ(push_at(-0.03), Progress::kFailed) << "on the second";
  EXPECT_THAT(diagnostics, Reports(Code::kAbortCondition, "/program/steps/2", {"two", "abort_if"}));
  EXPECT_TRUE(fake.core_arm().at_rest());
  const std::string until = R"(, "until": {"sensor": "wrist", "above_N": 30}, "on_end": "continue")";
  const program::Program guarded = good(sequence(R"({"do": "tare"},)" + seam(kWeave, kWeave, kWeave + until)));
  fake.extra.force.setZero();
  EXPECT_EQ(run(guarded,
                [this](int, program::ProgramRunner&) {
                  const Eigen::Vector3d p = tool_in_block(fake.q());
                  fake.extra.force =
                      p.x() < -0.0599 && p.y() < 0.0 ? Eigen::Vector3d(0, 0, 60) : Eigen::Vector3d::Zero();
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(variables.touches.size(), 1u);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(WeaveStepTest, WhatIsWrongIsToldWhereItStands) {
  const std::string steep = R"(, "weave": {"amplitude_m": 0.002, "frequency_Hz": 2, "ramp_s": 0.02})";
  const std::string fast = R"(, "weave": {"amplitude_m": 0.05, "frequency_Hz": 5})";
  EXPECT_THAT(rehearsed(sequence(seam(steep, "", ""))), Reports(Code::kLimitExceeded, "/program/steps/1/weave/ramp_s"));
  EXPECT_THAT(rehearsed(sequence(seam("", fast, ""))), Reports(Code::kOutOfRange, "/program/steps/1", {"two"}));
  EXPECT_THAT(refused(sequence(R"({"do": "ptp", "to": "home"},
      {"do": "spline", "through": ["home", {"joints_deg": [0, 0, 0, 0, 0, 0, 0]}], "weave": {"amplitude_m": 0.001,
       "frequency_Hz": 2}})")),
              ElementsAre("/program/steps/1/weave"));
  const std::string motions = R"({"do": "transaction", "commands": {"m": {"start": true, "do": "motions", "steps": [)";
  EXPECT_THAT(
      rehearsed(sequence(kApproach + motions + lin("one", kFirst, kBlend) + "," + lin("two", kSecond, steep) + "]}}}")),
      Reports(Code::kLimitExceeded, "/program/steps/1/commands/m/steps/1/weave/ramp_s"));
}

TEST_F(WeaveStepTest, AForceOffsetGoesOnThroughItsCornersAndMayBeginInOne) {
  const auto offset = [](double force) {
    return fmt::format(R"(, "force_offset": {{"force_N": {}, "reach_m": 0.001, "approach_m_s": 0.005}})", force);
  };
  const std::string tare = R"({"do": "tare"},)";
  for (const bool from_first : {true, false}) {
    SCOPED_TRACE(from_first);
    fake.backend->sent.clear();
    const std::string steps = tare + seam(from_first ? offset(5) : "", offset(5), offset(5));
    EXPECT_EQ(rehearsed(sequence(steps)).to_string(), "");
    ASSERT_EQ(run(sequence(steps)), Progress::kDone) << diagnostics.to_string();
    EXPECT_THAT(begun(), testing::IsSupersetOf({"one", "two", "three"}));
    EXPECT_GT(slowest(), 0.6 * 0.08);
    EXPECT_EQ(swing(0) > 1e-4, from_first);
    EXPECT_NEAR(swing(2), 0.001, 1e-4) << "nothing is there: as far as it may";
    EXPECT_LE(fake.worst_limit_share(), 1.0);
    ASSERT_EQ(run(R"({"do": "ptp", "to": "home"})"), Progress::kDone);
    log.clear();
  }
  EXPECT_THAT(rehearsed(sequence(seam(offset(5), offset(6), ""))),
              Reports(Code::kConflict, "/program/steps/1/force_offset", {"one", "1", "two", "2", "force_offset"}));
  EXPECT_THAT(rehearsed(sequence(seam(offset(5), kWeave, ""))),
              Reports(Code::kConflict, "/program/steps/1/weave", {"two"}));
  EXPECT_THAT(refused(sequence(kApproach + std::string(R"({"do": "transaction", "commands": {"m": {"start": true,
      "do": "motions", "steps": [)") +
                               lin("one", kFirst, offset(5) + kBlend) + "," + lin("two", kSecond, "") + "]}}}")),
              ElementsAre("/program/steps/1/commands/m/steps/1/force_offset"));
  // A sensor that does not answer stops the arm only where the force is wanted.
  const program::Program late = good(sequence(tare + seam("", "", offset(5))));
  EXPECT_EQ(
      run(late, [this](int, program::ProgramRunner&) { fake.sensor->silent = tool_in_block(fake.q()).x() < -0.05; }),
      Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/steps/2", {"three", "wrist"}));
  EXPECT_TRUE(fake.core_arm().at_rest());
}

// The command "motions" of a transaction is the same motion.
TEST_F(WeaveStepTest, AsMotionsOfATransactionItIsTheSame) {
  const auto motions = [&](const std::string& a, const std::string& b, const std::string& c) {
    return sequence(std::string(kApproach) + R"({"do": "transaction", "commands": {"m": {"start": true,
        "do": "motions", "steps": [)" +
                    lin("one", kFirst, a + kBlend) + "," + lin("two", kSecond, b + kBlend) + "," +
                    lin("three", kThird, c) + "]}}}");
  };
  std::vector<std::vector<device::JointVector>> sent;
  for (const std::string& program : {sequence(seam(kWeave, "", kOther)), motions(kWeave, "", kOther)}) {
    ASSERT_EQ(run(R"({"do": "ptp", "to": "home"})"), Progress::kDone);
    fake.backend->sent.clear();
    ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
    sent.emplace_back();
    for (std::size_t i = begin_of_seam(); i < fake.backend->sent.size(); ++i)
      sent.back().push_back(fake.backend->sent[i].q);
  }
  const std::size_t common = std::min(sent[0].size(), sent[1].size());
  ASSERT_GT(common, 2000u);
  for (std::size_t i = 0; i < common; ++i) ASSERT_LT((sent[0][i] - sent[1][i]).norm(), 1e-9) << i;
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::operations
