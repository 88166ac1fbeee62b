// The latch of an emergency stop (row S4): no stop is lost, whoever writes it and however short it is.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "core/device/emergency_stop.h"

namespace takt::device {
namespace {

/// A latch, its cycle, and a chain that was closed and reset.
struct Bench {
  explicit Bench(Nanoseconds input_age_max = 0) : stop("e-stop", input_age_max) {
    stop.set_healthy(true);
    look();
    reset();
  }
  bool look() {
    stop.begin_cycle(cycle, cycle * kMillisecond);
    ++cycle;
    return stop.latched();
  }
  /// As a person does it: down for a cycle, and up. @return true if it is still latched.
  bool reset() {
    stop.set_reset(true);
    look();
    stop.set_reset(false);
    return look();
  }

  EmergencyStop stop;
  std::int64_t cycle = 0;
};

TEST(EmergencyStop, S4_AStopBetweenTwoCyclesIsSeen) {
  Bench bench;
  ASSERT_FALSE(bench.stop.latched());
  bench.stop.set_healthy(false);
  bench.stop.set_healthy(true);
  EXPECT_TRUE(bench.look());
  EXPECT_TRUE(bench.look()) << "nothing resumes by itself";
  EXPECT_FALSE(bench.reset());
}

TEST(EmergencyStop, S4_AResetInTheCycleOfTheStopDoesNotClearIt) {
  Bench bench;
  bench.stop.set_healthy(false);
  bench.stop.set_healthy(true);
  bench.stop.set_reset(true);
  EXPECT_TRUE(bench.look());
  EXPECT_TRUE(bench.look()) << "the edge is over: it came with the stop";
  bench.stop.set_reset(false);
  EXPECT_TRUE(bench.look());
  EXPECT_FALSE(bench.reset());
}

TEST(EmergencyStop, S4_AStopInTheCycleOfTheResetWins) {
  Bench bench;
  bench.stop.press(StopCategory::kStopAndHold);
  EXPECT_TRUE(bench.look());
  bench.stop.set_healthy(true);
  EXPECT_TRUE(bench.look());
  bench.stop.set_reset(true);
  bench.stop.press(StopCategory::kStopAndHold);
  bench.stop.set_healthy(true);
  EXPECT_TRUE(bench.look());
}

TEST(EmergencyStop, S4_TheChainMustBeHealthyBeforeTheEdge) {
  Bench bench;
  bench.stop.set_healthy(false);
  EXPECT_TRUE(bench.look());
  bench.stop.set_healthy(true);
  bench.stop.set_reset(true);
  EXPECT_TRUE(bench.look()) << "closed and reset at once: the cycle has not seen it closed before the edge";
  EXPECT_TRUE(bench.reset()) << "still down: no edge";
  EXPECT_FALSE(bench.reset());
}

TEST(EmergencyStop, S4_OfShortStopsTheStrongestCounts) {
  Bench bench;
  bench.stop.press(StopCategory::kStopAndHold);
  bench.stop.set_healthy(true);
  bench.stop.press(StopCategory::kBrakes);
  bench.stop.set_healthy(true);
  bench.stop.press(StopCategory::kStopThenBrakes);
  bench.stop.set_healthy(true);
  bench.stop.set_category(StopCategory::kStopAndHold);  // of the next one
  EXPECT_TRUE(bench.look());
  EXPECT_EQ(bench.stop.category(), StopCategory::kBrakes);
  EXPECT_TRUE(bench.look());
  EXPECT_EQ(bench.stop.category(), StopCategory::kBrakes) << "until it is reset";
  EXPECT_FALSE(bench.reset());
  EXPECT_EQ(bench.stop.category(), StopCategory::kStopAndHold);
}

TEST(EmergencyStop, S4_AnOpenChainTakesAStrongerCategoryAndNoWeakerOne) {
  Bench bench;
  bench.stop.press(StopCategory::kStopThenBrakes);
  bench.look();
  bench.stop.set_category(StopCategory::kStopAndHold);
  bench.look();
  EXPECT_EQ(bench.stop.category(), StopCategory::kStopThenBrakes);
  bench.stop.set_category(StopCategory::kBrakes);
  bench.look();
  EXPECT_EQ(bench.stop.category(), StopCategory::kBrakes);
}

TEST(EmergencyStop, S4_AnInputThatSendsNothingIsAStop) {
  Bench bench(5 * kMillisecond);
  for (int i = 0; i < 20; ++i) {
    bench.stop.beat();
    ASSERT_FALSE(bench.look()) << i;
  }
  for (int i = 0; i < 4; ++i) ASSERT_FALSE(bench.look()) << i;
  EXPECT_TRUE(bench.look()) << "5 ms after the cycle that saw the last sign of life";
  EXPECT_TRUE(bench.stop.silent());
  bench.stop.beat();
  EXPECT_TRUE(bench.look()) << "nothing resumes by itself";
  EXPECT_FALSE(bench.stop.silent());
  EXPECT_FALSE(bench.reset());
}

/// The bits of a stop are written and read as one: whatever the threads do, a cycle sees a category that belongs to a
/// stop, and every stop that was written before a cycle began.
TEST(EmergencyStop, S4_NoStopOfAnyThreadIsLostAndNoneIsTorn) {
  Bench bench;
  constexpr int kStops = 2000;
  std::atomic<int> asked = 0, pressed = 0;
  std::atomic<bool> over = false;
  std::jthread button([&] {
    for (int i = 1; i <= kStops; ++i) {
      while (asked.load(std::memory_order_acquire) < i && !over) std::this_thread::yield();
      bench.stop.press(StopCategory::kBrakes);
      bench.stop.set_healthy(true);
      bench.stop.set_category(StopCategory::kStopAndHold);
      pressed.store(i, std::memory_order_release);
    }
  });
  std::jthread other([&] {
    while (!over) bench.stop.beat();
  });
  int lost = 0, torn = 0, stuck = 0;
  for (int i = 1; i <= kStops; ++i) {
    for (int tries = 0; bench.stop.latched() && tries < 3; ++tries) bench.reset();
    stuck += bench.stop.latched() ? 1 : 0;
    asked.store(i, std::memory_order_release);
    while (pressed.load(std::memory_order_acquire) < i) std::this_thread::yield();
    bench.look();
    lost += bench.stop.latched() ? 0 : 1;
    torn += bench.stop.category() == StopCategory::kBrakes ? 0 : 1;
  }
  over = true;
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(stuck, 0);
}

}  // namespace
}  // namespace takt::device
