// Which packets of a device count, and which instant each of them is of (row T2).
#include <vector>

#include <gtest/gtest.h>

#include "core/device/device_session.h"
#include "tests/support/allocation_guard.h"

namespace takt::device {
namespace {

using Verdict = DeviceSession::Verdict;
using End = DeviceSession::End;

constexpr Nanoseconds kCycle = kMillisecond;

/// A device that counts its cycles and shows a clock, and the machine that hears it.
struct Line {
  explicit Line(const DeviceSession::Options& options = {}, std::uint64_t first = 1)
      : session(options), sequence(first) {}

  Verdict next(bool may_open = false) {
    const Verdict verdict = session.take({sequence, stamp}, machine, may_open);
    pass();
    return verdict;
  }
  void pass(int cycles = 1) {
    sequence += static_cast<std::uint64_t>(cycles);
    stamp += cycles * kCycle;
    machine += cycles * kCycle;
  }
  Verdict run(int packets, bool may_open = false) {
    Verdict last = Verdict::kDropped;
    for (int i = 0; i < packets; ++i) last = next(may_open);
    return last;
  }

  DeviceSession session;
  std::uint64_t sequence;
  Nanoseconds stamp = 77 * kSecond, machine = 5 * kSecond;
};

TEST(DeviceSession, T2_TheInstantFollowsFromTheNumber) {
  Line line;
  EXPECT_EQ(line.next(), Verdict::kOpened);
  EXPECT_EQ(line.run(9), Verdict::kAccepted);
  line.stamp -= 3600 * kSecond;  // somebody sets the device's clock
  EXPECT_EQ(line.next(), Verdict::kAccepted);
  EXPECT_EQ(line.session.instant(), 77 * kSecond + 10 * kCycle);
  EXPECT_EQ(line.session.clock_steps(), 1u);
  line.pass(3);  // lost
  EXPECT_EQ(line.next(), Verdict::kAccepted);
  EXPECT_EQ(line.session.instant(), 77 * kSecond + 14 * kCycle);
  EXPECT_EQ(line.session.counts().lost, 3u);
  EXPECT_EQ(line.session.clock_steps(), 1u);
}

TEST(DeviceSession, T2_ACounterMayWrap) {
  for (const int bits : {8, 16, 32, 64}) {
    const std::uint64_t last = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    Line line({.sequence_bits = bits}, last - 4);
    for (int i = 0; i < 1000; ++i) {
      line.sequence &= last;
      ASSERT_EQ(line.next(), i == 0 ? Verdict::kOpened : Verdict::kAccepted) << bits << " bits, packet " << i;
    }
    EXPECT_EQ(line.session.instant(), 77 * kSecond + 999 * kCycle);
    EXPECT_EQ(line.session.counts().lost, 0u);
    EXPECT_GE(line.session.number(), 1000u);
  }
}

TEST(DeviceSession, T2_WhatIsOldOrRepeatedIsDropped) {
  Line line;
  line.run(50);
  EXPECT_EQ(line.session.take({50, line.stamp}, line.machine, false), Verdict::kDropped);
  EXPECT_EQ(line.session.counts().repeated, 1u);
  line.pass(1);
  line.next();
  EXPECT_EQ(line.session.take({51, line.stamp}, line.machine, false), Verdict::kDropped);
  EXPECT_EQ(line.session.counts().reordered, 1u);
  for (std::uint64_t n = 20; n < 40; ++n)
    EXPECT_EQ(line.session.take({n, line.stamp}, line.machine, true), Verdict::kDropped) << "seen before: no restart";
  EXPECT_TRUE(line.session.open());
}

TEST(DeviceSession, T2_ANumberThatTheDeviceCannotHaveReachedIsDropped) {
  for (const std::uint64_t ahead : {std::uint64_t{100}, std::uint64_t{1'000'000}, std::uint64_t{1} << 40,
                                    (std::uint64_t{1} << 63) - 1, std::uint64_t{1} << 63}) {
    Line line;
    line.run(50);
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(line.session.take({line.sequence + ahead, line.stamp}, line.machine, true), Verdict::kDropped);
      EXPECT_EQ(line.next(), Verdict::kAccepted) << "true packets go on";
    }
  }
}

TEST(DeviceSession, S4_ADeviceThatCountsAnewIsANewSessionOnlyWhereItIsAllowed) {
  Line line;
  line.run(1000);
  line.sequence = 1;
  line.stamp = 0;
  EXPECT_EQ(line.run(DeviceSession::kRun - 1), Verdict::kDropped);
  EXPECT_EQ(line.next(), Verdict::kEnded);
  EXPECT_EQ(line.session.end(), End::kRestarted);
  EXPECT_EQ(line.run(100), Verdict::kDropped) << "a net still holds the device";
  const std::uint64_t before = line.session.number();
  EXPECT_EQ(line.next(/*may_open=*/true), Verdict::kOpened);
  EXPECT_EQ(line.session.counts().restarts, 1u);
  EXPECT_EQ(line.session.number(), before + 1) << "samples have growing numbers";
  EXPECT_EQ(line.session.instant(), line.stamp - kCycle) << "on the device's new clock";
  EXPECT_EQ(line.next(), Verdict::kAccepted);
}

/// Few packets were counted before the restart: the new numbers are known already, and then again newer.
TEST(DeviceSession, S4_ARestartRightAfterTheBeginningIsNotMistakenForRepeats) {
  Line line;
  line.run(30);
  line.sequence = 1;
  int ended = 0;
  for (int i = 0; i < 60; ++i) ended += line.next() == Verdict::kEnded ? 1 : 0;
  EXPECT_EQ(ended, 1);
  EXPECT_FALSE(line.session.open());
}

TEST(DeviceSession, S4_SilenceEndsTheSessionOfWhatMoves) {
  Line line;
  line.run(100);
  line.pass(DeviceSession::kBridged - 1);
  EXPECT_EQ(line.next(), Verdict::kAccepted) << "bridged";
  line.pass(DeviceSession::kBridged);
  EXPECT_EQ(line.next(true), Verdict::kEnded);
  EXPECT_EQ(line.session.end(), End::kSilent);
  EXPECT_EQ(line.run(DeviceSession::kRun - 2, true), Verdict::kDropped);
  EXPECT_EQ(line.next(true), Verdict::kOpened);

  Line sensor({.ends_when_silent = false});
  sensor.run(100);
  sensor.pass(5000);
  EXPECT_EQ(sensor.next(), Verdict::kAccepted);
}

TEST(DeviceSession, T2_ACounterThatDisagreesWithTheClockForGoodEndsTheSession) {
  Line line;
  line.run(100);
  Verdict verdict = Verdict::kAccepted;
  int packets = 0;
  while (verdict != Verdict::kEnded && ++packets < 100) {  // its cycle is 2 ms, not 1 ms as declared
    line.stamp += kCycle;
    line.machine += kCycle;
    verdict = line.next(true);
  }
  EXPECT_EQ(packets, DeviceSession::kRun);
  EXPECT_EQ(line.session.end(), End::kDisagrees);
  for (int i = 0; i < 100; ++i) {
    line.stamp += kCycle;
    line.machine += kCycle;
    EXPECT_EQ(line.next(true), Verdict::kDropped);
  }
}

TEST(DeviceSession, T2_SamplesKeepTheirAgeWhenTheClockIsSet) {
  Line line;
  line.run(100);
  for (const Nanoseconds jump : {Nanoseconds{0}, -3600 * kSecond, 3600 * kSecond, -50 * kMillisecond}) {
    line.stamp += jump;
    ASSERT_EQ(line.next(), Verdict::kAccepted);
    const Nanoseconds received = line.machine - kCycle;
    EXPECT_EQ(line.session.measured_at(line.stamp - kCycle - 300'000, received), received - 300'000) << jump;
    EXPECT_EQ(line.session.measured_at(line.stamp + kSecond, received), received - 300'000) << "it cannot be";
  }
}

TEST(DeviceSession, NoStampOverflows) {
  Line line;
  line.run(10);
  for (const Nanoseconds stamp : {INT64_MAX, INT64_MIN, INT64_MAX - 1}) {
    EXPECT_EQ(line.session.take({line.sequence, stamp}, line.machine, true), Verdict::kDropped);
    EXPECT_LE(line.session.measured_at(stamp, line.machine), line.machine);
  }
  EXPECT_EQ(line.session.counts().implausible, 3u);
  EXPECT_EQ(line.next(), Verdict::kAccepted);
}

TEST(DeviceSession, AllocatesNothing) {
  Line line;
  const test::AllocationGuard guard;
  line.run(1000);
  line.sequence = 1;
  line.run(100, true);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::device
