// Manual control and following as steps: the dead-man switch is in the net.
#include <algorithm>
#include <cmath>

#include "core/net/compiled_net.h"
#include "core/net/stop_bound.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

class JogStepTest : public test::CommandStepTest {
 protected:
  static std::string jog(const std::string& more) {
    return R"({"do": "jog", "name": "jog", "channel": "stick", "in": "arm", "while": {"channel": "enable"},
               "linear_max_m_s": 0.05)" +
           more + "}";
  }
  void push(double vx, bool held) {
    (void)cell.cell.channels.at("stick")->write(net::Twist{.linear = {vx, 0, 0}});
    (void)cell.cell.channels.at("enable")->write(held);
  }
  /// What LOAD certifies of the only net of a program.
  struct Certificate {
    std::int64_t least = -1, most = -1;  ///< cycles from the switch to the set point
    std::int64_t rest = 0;               ///< cycles from a request to stop to rest
  };
  Certificate certificate(const program::Program& program) {
    std::vector<RehearsedNet> nets;
    (void)program.rehearse(cell.cell, &cell.core.environment(), &nets);
    Certificate found;
    if (nets.size() != 1) return found;
    const auto net = net::CompiledNet::compile(nets.front().net, cell.core.environment());
    if (!net) return found;
    for (const auto& line : (*net)->report().reactions) {
      if (line.source.find("enable") == std::string::npos || !line.sink.ends_with("arm.q")) continue;
      found.least = line.minimum_cycles;
      found.most = line.maximum_cycles;
    }
    found.rest = static_cast<std::int64_t>(std::ceil((*net)->path_stop().seconds / to_seconds(cell.core.period())));
    return found;
  }
};

TEST_F(JogStepTest, WithTheSwitchReleasedTheArmIsAtRestInTheCyclesThatLoadCertifies) {
  const program::Program program = good(jog(R"(, "until": {"input": "button"})"));
  const Certificate certified = certificate(program);
  ASSERT_GE(certified.least, 0) << "there is a way from the switch to the arm";
  ASSERT_GT(certified.rest, 0);
  int released = -1, braking = -1, rest = -1;
  double before = 0.0;
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  const bool held = cycle < 500;
                  push(1.0, held);
                  cell.button->sample.value = cycle > 1500;
                  if (!held && released < 0) released = cycle;
                  if (released >= 0 && braking < 0 && speed() < before) braking = cycle - 1;
                  if (released >= 0 && rest < 0 && cell.core_arm().at_rest()) rest = cycle - 1;
                  before = speed();
                  if (cycle == 499) {
                    EXPECT_GT(speed(), 0.01) << "it moves while it is held";
                  }
                }),
            Progress::kDone)
      << diagnostics.to_string();
  ASSERT_GT(braking, 0);
  ASSERT_GT(rest, 0);
  EXPECT_GE(braking - released, certified.least);
  EXPECT_LE(braking - released, certified.most);
  EXPECT_LE(rest - released, certified.most + certified.rest);
  RecordProperty("cycles_to_rest", rest - released);
  RecordProperty("certified_cycles_to_rest", static_cast<int>(certified.most + certified.rest));
  expect_good_end();
}

TEST_F(JogStepTest, ChannelsThatNobodyWritesAnyMoreStandStill) {
  const program::Program program = good(jog(R"(, "seconds": 2)"));
  bool at_rest = false;
  const Eigen::Vector3d from = tool();
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  if (cycle < 400) push(0.05, true);
                  if (cycle == 900) at_rest = cell.core_arm().at_rest();
                }),
            Progress::kDone);
  EXPECT_TRUE(at_rest);
  EXPECT_NEAR(cycles, 2000, 10) << "its time is up";
  EXPECT_GT((tool() - from).norm(), 0.01);
  expect_good_end();
}

TEST_F(JogStepTest, P2_APauseStandsAndAnOverrideScales) {
  const program::Program program = good(jog(R"(, "seconds": 3)"));
  double full = 0.0, half = 0.0, paused = 1.0;
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  push(0.05, true);
                  if (cycle == 400) (void)cell.speed->write(0.5);
                  if (cycle == 800) (void)cell.speed->write(0.0);
                  if (cycle == 400) full = speed();
                  if (cycle == 800) half = speed();
                  if (cycle == 1400) paused = speed();
                }),
            Progress::kDone);
  EXPECT_NEAR(half / full, 0.5, 0.05);
  EXPECT_EQ(paused, 0.0);
  expect_good_end();
}

TEST_F(JogStepTest, L6_ACancelAtAnyTimeEndsInOrder) {
  const program::Program program = good(jog(""));
  for (const int at : {0, 1, 3, 20, 200, 600}) {
    SCOPED_TRACE(at);
    EXPECT_EQ(run(program,
                  [&](int cycle, program::ProgramRunner& runner) {
                    push(0.05, true);
                    if (cycle == at) runner.cancel();
                  }),
              Progress::kDone);
    EXPECT_LT(cycles, at + 400);
    expect_good_end();
  }
}

TEST_F(JogStepTest, ConstantVelocitiesAlongTheToolAndAnInputAsSwitch) {
  const Eigen::Isometry3d X_WT = cell.tool_in_world(cell.q());
  EXPECT_EQ(
      run(good(R"({"do": "jog", "linear_m_s": [0, 0, 0.02], "in": "tcp", "while": {"input": "button"}, "seconds": 1})"),
          [&](int cycle, program::ProgramRunner&) { cell.button->sample.value = cycle < 700; }),
      Progress::kDone);
  const Eigen::Vector3d way = X_WT.linear().transpose() * (tool() - X_WT.translation());
  EXPECT_NEAR(way.z(), 0.014, 0.002);
  EXPECT_LT(way.head<2>().norm(), 1e-4);
  expect_good_end();
}

TEST_F(JogStepTest, AFrameIsFollowedUntilAConditionHolds) {
  const program::Program program = good(R"({"do": "transaction", "name": "t", "commands": {
      "follow": {"do": "follow", "start": true, "channel": "target", "in": "arm", "linear_max_m_s": 0.2}},
      "on": [{"entered": {"action": "follow", "is": "arrived", "held_for_s": 0.1}, "cancel": "follow"}]})");
  const Eigen::Isometry3d goal = cell.moved(0.03, 0.04, -0.02);
  EXPECT_EQ(run(program,
                [&](int, program::ProgramRunner&) { (void)cell.cell.channels.at("target")->write(net::Frame(goal)); }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT((tool() - cell.X_WB * goal.translation()).norm(), 2e-4);
  expect_good_end();
}

TEST_F(JogStepTest, AFrameThatMovesIsFollowedWithoutALag) {
  const program::Program program =
      good(R"({"do": "follow", "channel": "target", "in": "arm", "linear_max_m_s": 0.2, "seconds": 3})");
  constexpr double kVelocity = 0.05;  // m/s, from 0.5 s on
  Eigen::Isometry3d goal = cell.moved(0.0, 0.0, 0.0);
  double lag = 0.0;
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  if (cycle > 500) goal.translation().y() += kVelocity * to_seconds(cell.core.period());
                  (void)cell.cell.channels.at("target")->write(net::Frame(goal));
                  if (cycle > 2000 && cycle < 2900)
                    lag = std::max(lag, (tool() - cell.X_WB * goal.translation()).norm());
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(lag, 0.5e-3) << "a gain of 4/s alone would be 12.5 mm behind";
  expect_good_end();
}

TEST_F(JogStepTest, WhatIsWrongIsToldWithItsPlace) {
  EXPECT_THAT(wrong(R"({"do": "jog", "while": {"channel": "enable"}})"), Reports(Code::kMissing, "/program"));
  EXPECT_THAT(wrong(R"({"do": "jog", "channel": "stick"})"), Reports(Code::kMissing, "/program", {"while"}));
  EXPECT_THAT(wrong(R"({"do": "jog", "channel": "speed", "while": {"channel": "enable"}})"),
              Reports(Code::kTypeMismatch, "/program/channel", {"speed"}));
  EXPECT_THAT(wrong(R"({"do": "jog", "channel": "stcik", "while": {"channel": "enabel"}})"),
              testing::AllOf(Reports(Code::kUnknownName, "/program/channel", {"stick"}),
                             Reports(Code::kUnknownName, "/program/while/channel", {"enable"})));
  EXPECT_THAT(wrong(R"({"do": "jog", "channel": "stick", "in": "nowhere", "while": {"channel": "enable"}})"),
              Reports(Code::kUnknownName, "/program", {"nowhere"}));
  EXPECT_THAT(wrong(R"({"do": "follow", "in": "nowhere"})"), Reports(Code::kUnknownName, "/program", {"nowhere"}));
}

}  // namespace
}  // namespace takt::operations
