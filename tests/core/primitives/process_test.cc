// ProcessOnPath: what it asks of a process and of a path clock, with a clock of its own in the loop.
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/motion/path_clock.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

constexpr double kCycle_s = 1e-3;
const nlohmann::ordered_json kShort = {{"start_timeout", 0.2}};

/// The primitive with a path clock behind it, and a process that runs some cycles after it is wanted.
class Loop {
 public:
  explicit Loop(const nlohmann::ordered_json& parameters, double duration = 1.0)
      : primitive_("ProcessOnPath", parameters),
        clock_({.acceleration_max = 20.0, .jerk_max = 400.0, .stop = {}}, duration, /*retraceable=*/true) {}

  bool lost = false, cancel = false;
  double speed = 1.0;
  int ignition = 20;  ///< cycles

  void step() {
    waited_ = process() ? waited_ + 1 : 0;
    running_ = process() && !lost && waited_ > ignition;
    primitive_.set("running", running_).set("cancel", cancel).set("speed", speed);
    primitive_.set("time", clock_.state().tau).set("at_end", clock_.at_end()).set("standstill", clock_.at_rest());
    primitive_.step();
    clock_.update(rate(), kCycle_s);
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }
  int until_done(int most = 20'000) {
    for (int i = 0; i < most; ++i, step())
      if (done()) return i;
    return -1;
  }
  [[nodiscard]] bool running() const { return running_; }
  [[nodiscard]] double tau() const { return clock_.state().tau; }
  [[nodiscard]] bool rests() const { return clock_.at_rest(); }
  [[nodiscard]] bool at_end() const { return clock_.at_end(); }
  [[nodiscard]] bool flag(const char* port) { return primitive_.get<net::Boolean>(port).value_or(false); }
  [[nodiscard]] bool process() { return cycle_of("process"); }
  [[nodiscard]] bool done() { return cycle_of("done"); }
  [[nodiscard]] double rate() { return primitive_.get<net::Real>("rate").value_or(0.0); }
  [[nodiscard]] std::int64_t starts() { return primitive_.get<net::Integer>("starts").value_or(0); }

 private:
  bool cycle_of(const char* port) { return flag(port); }

  PrimitiveHarness primitive_;
  motion::PathClock clock_;
  int waited_ = 0;
  bool running_ = false;
};

TEST(ProcessOnPath, ThePathBeginsInTheCycleInWhichTheProcessRuns) {
  Loop loop({{"start_timeout", 1.0}, {"finish_time", 0.1}});
  while (!loop.running()) {
    EXPECT_EQ(loop.tau(), 0.0);
    loop.step();
  }
  EXPECT_EQ(loop.rate(), 1.0);
  EXPECT_NEAR(loop.tau(), kCycle_s, 1e-12) << "with the planned rate at once";
  loop.steps(999);
  EXPECT_TRUE(loop.at_end());
  loop.steps(99);
  EXPECT_TRUE(loop.process()) << "it goes on at rest";
  EXPECT_FALSE(loop.done());
  loop.steps(3);
  EXPECT_TRUE(loop.done());
  EXPECT_FALSE(loop.process());
  EXPECT_EQ(loop.starts(), 1);
}

TEST(ProcessOnPath, AProcessThatDoesNotStartEndsIt) {
  Loop loop(kShort);
  loop.lost = true;
  EXPECT_NEAR(loop.until_done(), 202, 2);
  EXPECT_TRUE(loop.flag("not_started"));
  EXPECT_FALSE(loop.flag("lost"));
  EXPECT_FALSE(loop.process());
  EXPECT_EQ(loop.tau(), 0.0);
}

TEST(ProcessOnPath, ALostProcessStopsThePathInTheSameCycle) {
  Loop loop(kShort);
  loop.steps(300);
  loop.lost = true;
  loop.step();
  EXPECT_EQ(loop.rate(), 0.0);
  EXPECT_FALSE(loop.process());
  EXPECT_TRUE(loop.flag("lost"));
  EXPECT_FALSE(loop.done()) << "not before the clock rests";
  EXPECT_GT(loop.until_done(), 0);
  EXPECT_TRUE(loop.rests());
  EXPECT_FALSE(loop.at_end());
}

TEST(ProcessOnPath, ABreakPutsItOutAndItStartsAgainWithAnOverlap) {
  Loop loop({{"start_timeout", 0.2}, {"overlap", 0.05}});
  loop.steps(400);
  const double mark = loop.tau();
  loop.speed = 0.0;
  loop.step();
  EXPECT_FALSE(loop.process());
  loop.steps(500);
  EXPECT_TRUE(loop.rests());
  EXPECT_GT(loop.tau(), mark);
  loop.speed = 0.3;
  while (!loop.running() && !loop.done()) loop.step();
  EXPECT_LE(loop.tau(), mark - 0.05 + 2 * kCycle_s);
  EXPECT_GT(loop.tau(), mark - 0.05 - 0.05) << "no farther back than it takes to brake";
  EXPECT_EQ(loop.rate(), 1.0) << "an override does not change the speed of a process";
  EXPECT_EQ(loop.starts(), 2);
  EXPECT_GT(loop.until_done(), 0);
  EXPECT_TRUE(loop.at_end());
}

TEST(ProcessOnPath, ItStartsAgainAsOftenAsItMay) {
  Loop loop({{"start_timeout", 0.5}, {"overlap", 0.05}, {"restarts", 1}});
  for (const bool last : {false, true}) {
    for (int i = 0; i < 2000 && !loop.running(); ++i) loop.step();
    loop.steps(200);
    ASSERT_TRUE(loop.running());
    loop.lost = true;
    loop.step();
    loop.lost = false;
    EXPECT_EQ(loop.flag("lost"), last);
  }
  EXPECT_GT(loop.until_done(), 0);
  EXPECT_FALSE(loop.at_end());
}

TEST(ProcessOnPath, ACancelBrakesWithItAndFinishes) {
  Loop loop({{"start_timeout", 0.2}, {"finish_time", 0.1}});
  loop.steps(400);
  loop.cancel = true;
  loop.step();
  EXPECT_EQ(loop.rate(), 0.0);
  while (!loop.rests()) {
    EXPECT_TRUE(loop.process());
    loop.step();
  }
  loop.steps(95);
  EXPECT_TRUE(loop.process());
  loop.steps(10);
  EXPECT_TRUE(loop.done());
  EXPECT_FALSE(loop.process());
}

TEST(ProcessOnPath, NothingStartsInABreakOrAfterACancel) {
  Loop held(kShort);
  held.speed = 0.0;
  held.steps(500);
  EXPECT_FALSE(held.process());
  EXPECT_EQ(held.starts(), 0);
  held.cancel = true;
  held.step();
  EXPECT_TRUE(held.done());
}

// Whatever happens, the process is off in the end, the path is followed only while it runs, and no part of it is left
// out that was to be done.
TEST(ProcessOnPath, RandomEventsLeaveItOffAndThePathWithoutGaps) {
  constexpr double kOverlap = 0.02;
  for (int seed = 0; seed < 300; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "process");
    Loop loop({{"start_timeout", 0.3}, {"overlap", kOverlap}, {"finish_time", 0.05}, {"restarts", 1000}});
    loop.ignition = static_cast<int>(1 + random.unit() * 50);
    double reached = 0.0;  // how far the process has been
    bool was_running = false;
    for (int i = 0; i < 8000 && !loop.done(); ++i) {
      if (random.unit() < 0.002) loop.speed = random.unit() < 0.5 ? 0.0 : 1.0;
      if (random.unit() < 0.002) loop.lost = !loop.lost && random.unit() < 0.5;
      if (i > 5000) loop.cancel = true, loop.speed = 1.0;
      const double before = loop.tau();
      loop.step();
      if (loop.tau() > before && loop.rate() == 1.0) {
        ASSERT_TRUE(loop.running()) << seed;
        if (!was_running) {
          ASSERT_LE(before, reached + 1e-9) << seed << ": a gap";
        }
        was_running = true;
        reached = std::max(reached, loop.tau());
      } else {
        was_running = false;
      }
    }
    while (!loop.done()) loop.step();
    EXPECT_FALSE(loop.process()) << seed;
    EXPECT_TRUE(loop.rests()) << seed;
  }
}

}  // namespace
}  // namespace takt::test
