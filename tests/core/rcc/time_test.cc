// Time in the core: whole cycles, integer nanoseconds, one clock for all devices (row T1).
#include <cstddef>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

class TimeTest : public CoreTest {
 protected:
  rcc::NetId load_ptp(const std::string& arm, const JointVector& goal) {
    return load(ptp_net(arm, arm, PlannedLine(JointVector::Zero(kFakeJoints), goal)));
  }
};

TEST_F(TimeTest, T1_TimeIsTheNumberOfCyclesTimesThePeriod) {
  // A period without an exact binary fraction of a second: a sum of doubles would drift.
  for (const Nanoseconds period : {kMillisecond, 4 * kMillisecond, Nanoseconds{2'000'001}}) {
    build({.period = period});
    const std::int64_t begin = core->cycle();
    steps(10'000);
    EXPECT_EQ(core->cycle(), begin + 10'000);
    EXPECT_EQ(core->time(), (begin + 10'000) * period);
  }
}

TEST_F(TimeTest, T1_TheSameCycleIsTheSameInstantAtEveryDevice) {
  const auto left = load_ptp("left", joints(0.5, 0, 0)), right = load_ptp("right", joints(0, 0.2, 0));
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
  ASSERT_TRUE(run_to_end(left));
  ASSERT_TRUE(run_to_end(right));
  ASSERT_EQ(left_backend->sent.size(), right_backend->sent.size());
  for (std::size_t i = 0; i < left_backend->sent.size(); ++i) {
    const auto &a = left_backend->sent[i], &b = right_backend->sent[i];
    ASSERT_EQ(a.cycle, b.cycle);
    ASSERT_EQ(a.stamp, b.stamp);
    ASSERT_EQ(a.stamp, a.cycle * core->period());
    ASSERT_EQ(a.cycle, left_backend->sent[0].cycle + static_cast<std::int64_t>(i)) << "no cycle is left out";
  }
}

}  // namespace
}  // namespace takt::test
