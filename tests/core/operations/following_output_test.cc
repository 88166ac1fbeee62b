// Analog outputs that follow a value: "set" with a value of a sensor, a motion or a channel.
#include <algorithm>
#include <numbers>

#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

class FollowingOutputTest : public test::CommandStepTest {
 protected:
  static std::string tree(const std::string& commands, const std::string& more = "") {
    return R"({"do": "transaction", "name": "t", "commands": {)" + commands + "}" + more + "}";
  }
  static std::string valve(const std::string& keys) {
    return R"("valve": {"do": "set", "output": "valve", )" + keys + "}";
  }
  static constexpr const char* kMove =
      R"("move": {"do": "lin", "start": true, "to": {"by_m": [0, 0.1, 0]}, "velocity_m_s": 0.1})";
  /// It starts and ends with the motion.
  static constexpr const char* kMeanwhile = R"(, "on": [{"entered": {"completed": "move"}, "cancel": "valve"}])";

  double sent() const { return cell.cell.analog_outputs.at("valve")->value(); }
  /// V in one cycle, over all that was written.
  double fastest() const {
    const auto& written = cell.valve_terminal->written;
    double step = 0.0;
    for (std::size_t i = 1; i < written.size(); ++i) step = std::max(step, std::abs(written[i] - written[i - 1]));
    return step;
  }
  void expect_within_range_and_rate() {
    EXPECT_LE(fastest(), 0.1 + 1e-9) << "100 V/s";
    for (const double value : cell.valve_terminal->written) {
      EXPECT_GE(value, 0.0);
      EXPECT_LE(value, 10.0);
    }
    cell.step(10);
    EXPECT_FALSE(cell.cell.analog_outputs.at("valve")->held());
  }
};

TEST_F(FollowingOutputTest, AForceIsFollowedWithinRangeAndRate) {
  double off = 0.0;
  const program::Program program =
      good(R"({"do": "sequence", "steps": [{"do": "tare", "cycles": 20}, )" +
           tree(valve(R"("start": true, "value": {"sensor": "wrist", "quantity": "force_z"},
                                             "factor": 0.2, "offset": 4, "seconds": 1.5)")) +
           "]}");
  int begun = -1;
  double before = 0.0;
  ASSERT_EQ(run(program,
                [&](int cycle, program::ProgramRunner& runner) {
                  if (begun < 0 && runner.current() == "t") begun = cycle;
                  const int since = begun < 0 ? 0 : cycle - begun;
                  // First it swings, then it jumps beyond the range, then back.
                  const double newton = since > 1'200 ? 0.0
                                        : since > 800 ? 500.0
                                                      : 10.0 * std::sin(2.0 * std::numbers::pi * 2e-3 * since);
                  if (since > 200 && since < 800) off = std::max(off, std::abs(sent() - 4.0 - 0.2 * before));
                  if (since == 1'200) {
                    EXPECT_EQ(sent(), 10.0) << "the end of its range";
                  }
                  if (since == 810) {
                    EXPECT_LT(sent(), 6.0) << "not at once";
                  }
                  before = cell.extra.force.z() = newton;
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(off, 0.06) << "two cycles of the wave behind";
  EXPECT_NEAR(sent(), 4.0, 1e-6) << "it stays where it was when it ended";
  expect_within_range_and_rate();
}

/// Glue for a seam: as much as the tool is fast.
TEST_F(FollowingOutputTest, TheSpeedOfTheToolIsFollowed) {
  double most = 0.0, off = 0.0;
  const program::Program program = good(
      tree(std::string(kMove) + "," + valve(R"("start": true, "value": {"speed": "arm"}, "factor": 50)"), kMeanwhile));
  Eigen::Vector3d before = tool();
  std::vector<double> speeds;
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  most = std::max(most, sent());
                  speeds.push_back((tool() - before).norm() / 1e-3);
                  before = tool();
                  if (speeds.size() > 3) off = std::max(off, std::abs(sent() - 50.0 * speeds[speeds.size() - 2]));
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR(most, 50.0 * *std::ranges::max_element(speeds), 1e-3);
  EXPECT_GT(most, 4.5) << "nearly 0.1 m/s";
  EXPECT_LT(off, 0.12) << "a cycle or two behind";
  EXPECT_LT(sent(), 0.2) << "the tool stands at the end";
  expect_within_range_and_rate();
  expect_good_end();
}

TEST_F(FollowingOutputTest, TheProgressOfAMotionIsFollowed) {
  const Eigen::Vector3d from = tool();
  double off = 0.0;
  // It comes before what it follows: the order of the file does not matter.
  const program::Program program =
      good(tree(valve(R"("start": true, "value": {"progress": "move"}, "factor": 10)") + "," + kMove, kMeanwhile));
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  off = std::max(off, std::abs(sent() - 100.0 * (tool() - from).norm()));
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(off, 0.03) << "a cycle or two of 10 V in 1 s";
  EXPECT_NEAR(sent(), 10.0, 0.01);
  expect_within_range_and_rate();
}

TEST_F(FollowingOutputTest, AChannelIsFollowedAsAStepOfItsOwn) {
  double low = 10.0;
  ASSERT_EQ(run(good(R"({"do": "set", "output": "valve", "value": {"channel": "speed"}, "factor": 8,
                         "until": {"input": "button"}})"),
                [&](int cycle, program::ProgramRunner&) {
                  if (cycle == 300) (void)cell.cell.channels.at("speed")->write(0.25);
                  if (cycle == 299) {
                    EXPECT_NEAR(sent(), 8.0, 1e-9);
                  }
                  if (cycle == 500) low = sent();
                  cell.button->sample.value = cycle > 500;
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR(low, 2.0, 1e-9);
  EXPECT_LT(cycles, 520);
  expect_within_range_and_rate();
}

TEST_F(FollowingOutputTest, N3_WhatIsSilentIsNotFollowedAndIsTold) {
  const program::Program program =
      good(tree(valve(R"("start": true, "value": {"sensor": "wrist"}, "factor": 0.2)") +
                    R"(, "lamp": {"do": "set", "output": "lamp", "value": true})",
                R"(, "on": [{"entered": {"action": "valve", "is": "error"}, "start": "lamp"}])"));
  double then = -1.0;
  ASSERT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  cell.extra.force.x() = 10.0;
                  if (cycle == 300) then = sent();
                  cell.sensor->silent = cycle >= 300;
                }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/commands/valve/value"));
  EXPECT_GT(then, 1.0);
  EXPECT_NEAR(sent(), then, 1e-6);
  EXPECT_TRUE(lamp()) << "handlers decide";
  expect_within_range_and_rate();
}

TEST_F(FollowingOutputTest, L6_ACancelEndsIt) {
  const program::Program program =
      good(R"({"do": "set", "output": "valve", "value": {"channel": "speed"}, "factor": 8})");
  ASSERT_EQ(run(program,
                [&](int cycle, program::ProgramRunner& runner) {
                  if (cycle == 40) runner.cancel();
                }),
            Progress::kDone);
  EXPECT_LT(cycles, 50);
  EXPECT_GT(sent(), 2.0);
  EXPECT_LT(sent(), 5.0) << "on its way";
  expect_within_range_and_rate();
}

}  // namespace
}  // namespace takt::operations
