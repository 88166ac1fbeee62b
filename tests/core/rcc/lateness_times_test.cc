#include "core/rcc/lateness_times.h"

#include <gtest/gtest.h>

namespace takt::rcc {
namespace {

TEST(LatenessTimes, QuantilesAreUpperBoundsToAMicrosecond) {
  LatenessTimes times;
  EXPECT_EQ(times.quantile(0.5), 0);
  for (Nanoseconds us = 1; us <= 100; ++us) times.add(us * 1000);
  EXPECT_EQ(times.count(), 100);
  EXPECT_EQ(times.worst(), 100'000);
  for (const double share : {0.01, 0.5, 0.99, 1.0}) {
    const auto exact = static_cast<Nanoseconds>(share * 100'000);
    EXPECT_GE(times.quantile(share), exact);
    EXPECT_LE(times.quantile(share), exact + 1000);
  }
}

TEST(LatenessTimes, LongOnesAreKnownToFivePercentAndNoneIsLost) {
  for (const Nanoseconds late : {Nanoseconds{1'234'567}, 50 * kMillisecond, 3 * kSecond, 10'000 * kSecond}) {
    LatenessTimes times;
    times.add(late);
    times.add(10 * late);
    EXPECT_GE(times.quantile(0.5), std::min(late, 1000 * kSecond));
    const bool has_bin = late < 1000 * kSecond;
    EXPECT_TRUE(!has_bin || static_cast<double>(times.quantile(0.5)) <= 1.05 * static_cast<double>(late));
    EXPECT_EQ(times.quantile(1.0), 10 * late) << "never more than the worst, and the last bin has no end";
    EXPECT_EQ(times.worst(), 10 * late);
  }
}

TEST(LatenessTimes, EarlyCountsAsInTime) {
  LatenessTimes times;
  times.add(-5);
  EXPECT_EQ(times.count(), 1);
  EXPECT_EQ(times.worst(), 0);
  EXPECT_EQ(times.quantile(1.0), 0);
}

}  // namespace
}  // namespace takt::rcc
