// A run that is tried by forks: what a child says is heard, and the run itself is the one that nobody tried.
#include "cell/run/interruptions.h"

#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::interruptions_test {
namespace {

using Way = Interruptions::Way;

class InterruptionsTest : public testing::Test {
 protected:
  /// Runs `wave` and tries it; a child ends as `in_child` says.
  RunReport run(Interruptions& tries, const std::function<void(const RunReport&)>& in_child) {
    static const device::ModelLibrary models({"models"});
    auto session = Session::open("scenarios/wave.json", models);
    EXPECT_TRUE(session) << session.error().to_string();
    RunOptions options;
    options.repeat = options.measure_times = false;
    tries.attach(options);
    const RunReport report = (*session)->run(options);
    if (tries.in_child()) {
      in_child(report);
      tries.answer();
    }
    return report;
  }
  static Interruptions every(std::int64_t cycles) {
    return Interruptions({.first = 500, .every = cycles, .ways = Interruptions::by_program, .progress = {}});
  }
};

TEST_F(InterruptionsTest, D3_TheRunGoesOnAsIfNothingHadBeen) {
  Interruptions tries = every(1'000), none = every(1'000'000'000);
  const RunReport tried = run(tries, [](const RunReport&) {}), alone = run(none, [](const RunReport&) {});
  EXPECT_GE(tries.tried(), 15);
  EXPECT_TRUE(tries.failures().empty()) << tries.failures().front();
  EXPECT_EQ(tried.digest, alone.digest);
  EXPECT_EQ(tried.verdict, Verdict::kPassed);
}

TEST_F(InterruptionsTest, WhatAChildComplainsOfIsHeardWithWayAndCycle) {
  Interruptions tries = every(1'000);
  run(tries, [&](const RunReport& report) {
    if (tries.way() == Way::kAbort && report.verdict == Verdict::kError) tries.complain("aborted");
  });
  ASSERT_FALSE(tries.failures().empty());
  EXPECT_EQ(tries.failures().front(), "abort in cycle 500: aborted");
  EXPECT_EQ(tries.failures().size(), static_cast<std::size_t>(tries.tried() / 3));
}

TEST_F(InterruptionsTest, AChildThatDiesIsAFailureAndTwentyAreEnough) {
  Interruptions tries = every(100);
  run(tries, [](const RunReport&) { _exit(7); });
  ASSERT_FALSE(tries.failures().empty());
  EXPECT_EQ(tries.failures().front(), "cancel in cycle 500: the process ended");
  EXPECT_GE(tries.failures().size(), 20u);
  EXPECT_LT(tries.failures().size(), 23u);
}

TEST_F(InterruptionsTest, OneMayBeRepeatedInARunOfItsOwn) {
  Interruptions none = every(1'000'000'000);
  const double whole = run(none, [](const RunReport&) {}).sim_time;
  static const device::ModelLibrary models({"models"});
  auto session = Session::open("scenarios/wave.json", models);
  ASSERT_TRUE(session) << session.error().to_string();
  RunOptions options;
  options.repeat = options.measure_times = false;
  auto again = Interruptions::again({Way::kCancel, 1'500, 7, "as it was"});
  again.attach(options);
  std::vector<std::pair<std::string, Nanoseconds>> told;
  options.tell = [&](const LogEntry& entry) {
    if (entry.source == "operator") told.emplace_back(entry.name, entry.time);
  };
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(told, (std::vector<std::pair<std::string, Nanoseconds>>{{"cancel", 1500 * kMillisecond}}));
  EXPECT_GT(report.sim_time, 1.5);
  EXPECT_LT(report.sim_time, whole - 1.0);
}

TEST_F(InterruptionsTest, ABrokenLimitIsTold) {
  Interruptions tries = every(3'000);
  static const device::ModelLibrary models({"models"});
  auto session = Session::open("scenarios/wave.json", models);
  ASSERT_TRUE(session) << session.error().to_string();
  RunOptions options;
  options.repeat = options.measure_times = false;
  tries.attach(options);
  // In a child only each second cycle is looked at, so that what it sees moves twice as fast.
  const auto watch = options.after_cycle;
  options.after_cycle = [&, count = 0](BuiltCell& built) mutable {
    return (tries.in_child() && ++count % 2 == 0) || watch(built);
  };
  (void)(*session)->run(options);
  if (tries.in_child()) tries.answer();
  ASSERT_FALSE(tries.failures().empty());
  EXPECT_THAT(tries.failures().front(), takt::test::Names("arm", "jerk"));
}

}  // namespace
}  // namespace takt::cell::interruptions_test
