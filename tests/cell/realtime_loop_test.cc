// A core in real time beside its program. No time is judged here: machines are shared.
#include "cell/run/realtime_loop.h"

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

namespace takt::cell {
namespace {

using namespace std::chrono_literals;

class RealtimeLoopTest : public testing::Test {
 protected:
  rcc::ControlCore core{{}};
  MonotonicClock time;
  RealtimeLoop loop{
      core, time, {.priority = 0, .lock_memory = false, .overrun_limit = std::numeric_limits<int>::max()}};
  int after = 0, looks = 0;
};

TEST_F(RealtimeLoopTest, TheProgramLooksBetweenCyclesUntilItIsOver) {
  std::int64_t last = -1;
  const auto report = loop.run({.after_cycle = [&] { return ++after > 0; },
                                .program =
                                    [&] {
                                      EXPECT_FALSE(core.running_cycle()) << "the cycle stands while the program looks";
                                      EXPECT_GT(core.cycle(), last);
                                      last = core.cycle();
                                      return ++looks < 20;
                                    },
                                .outside = {}});
  EXPECT_EQ(looks, 20);
  EXPECT_GE(after, 20);
  EXPECT_TRUE(report.granted.failure.empty());
  EXPECT_FALSE(report.granted.realtime_scheduling);
  EXPECT_GE(report.wakeups.count(), 20);
  EXPECT_LE(report.wakeups.worst(), report.begins.worst());
}

TEST_F(RealtimeLoopTest, CyclesGoOnWhileWhatMayWaitWaits) {
  std::atomic<int> cycles = 0;
  loop.run({.after_cycle = [&cycles] { return ++cycles > 0; },
            .program = [&] { return ++looks < 3; },
            .outside =
                [&cycles] {
                  for (const int before = cycles; cycles < before + 20;) std::this_thread::sleep_for(1ms);
                }});
  EXPECT_EQ(looks, 3);
  EXPECT_GE(core.cycle(), 40) << "the program looked again when it was ready";
}

TEST_F(RealtimeLoopTest, WhatFollowsACycleCanEndTheRun) {
  const auto report =
      loop.run({.after_cycle = [&] { return ++after < 5; }, .program = [] { return true; }, .outside = {}});
  EXPECT_EQ(after, 5);
  EXPECT_EQ(core.cycle(), 5);
  EXPECT_TRUE(report.granted.failure.empty());
}

}  // namespace
}  // namespace takt::cell
