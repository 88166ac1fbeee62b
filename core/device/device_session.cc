#include "core/device/device_session.h"

#include <algorithm>
#include <limits>

namespace takt::device {

namespace {

constexpr std::int64_t kFarAhead = std::int64_t{1} << 31;  // cycles: no device is silent for that long
constexpr Nanoseconds kFarAway = std::numeric_limits<Nanoseconds>::max() / 4;  // no clock shows that
constexpr Nanoseconds kOldest = 10 * kSecond;  // a measurement is no older than that when it is sent
constexpr std::uint64_t kLastFirst = std::uint64_t{1} << 62;
constexpr std::int64_t kRunGap = 4;         // cycles between two packets of a run: some may be lost
constexpr std::int64_t kDriftShare = 1000;  // 1 / share: more than what two clocks drift apart while one is silent

/// a - b, or the nearest that there is.
Nanoseconds difference(Nanoseconds a, Nanoseconds b) {
  Nanoseconds out = 0;
  if (!__builtin_sub_overflow(a, b, &out)) return out;
  return a < b ? std::numeric_limits<Nanoseconds>::min() : std::numeric_limits<Nanoseconds>::max();
}

}  // namespace

DeviceSession::Verdict DeviceSession::take(const DeviceCycle& packet, Nanoseconds received, bool may_open) {
  const bool impossible = packet.stamp > kFarAway || packet.stamp < -kFarAway;
  if (impossible) {
    count_implausible();
    return Verdict::kDropped;
  }
  if (!open_) {
    const bool first = inlet_.newest() == 0;
    if (first) return begin(packet, received);
    extend_run(packet);
    if (run_ < kRun || !may_open) return Verdict::kDropped;
    ++inlet_.counts().restarts;
    return begin(packet, received);
  }
  const Nanoseconds silent = received - received_;
  if (options_.ends_when_silent && silent > kBridged * options_.cycle + options_.jitter)
    return finish(End::kSilent, packet);
  const std::int64_t ahead = ahead_of(packet.sequence, newest_.sequence);
  return ahead > 0 ? take_new(packet, ahead, received) : take_old(packet, ahead);
}

DeviceSession::Verdict DeviceSession::take_old(const DeviceCycle& packet, std::int64_t ahead) {
  const std::uint64_t back = 0 - static_cast<std::uint64_t>(ahead);
  if (back >= inlet_.newest()) {
    ++inlet_.counts().reordered;
    return refuse(packet);
  }
  const std::uint64_t number = inlet_.newest() - back;
  const bool repeated = inlet_.seen(number);
  (void)inlet_.accept(number);
  return repeated ? Verdict::kDropped : refuse(packet);
}

DeviceSession::Verdict DeviceSession::take_new(const DeviceCycle& packet, std::int64_t ahead, Nanoseconds received) {
  if (too_early(ahead, received)) {
    count_implausible();
    return refuse(packet);
  }
  if (options_.ends_when_silent && ahead > kBridged) return finish(End::kSilent, packet);
  const bool agrees = clock_agrees(packet, newest_, ahead);
  if (!agrees) ++clock_steps_;
  disagreeing_ = agrees ? 0 : disagreeing_ + 1;
  if (disagreeing_ >= kRun) return finish(End::kDisagrees, packet);
  (void)inlet_.accept(inlet_.newest() + static_cast<std::uint64_t>(ahead));
  instant_ += ahead * options_.cycle;
  estimator_.add(instant_, received);
  newest_ = packet;
  received_ = received;
  run_ = 0;
  return Verdict::kAccepted;
}

DeviceSession::Verdict DeviceSession::begin(const DeviceCycle& packet, Nanoseconds received) {
  // Counted on from the device's own number where that leaves room to count.
  const bool first = inlet_.newest() == 0, has_room = packet.sequence > 0 && packet.sequence < kLastFirst;
  (void)inlet_.accept(first ? (has_room ? packet.sequence : 1) : inlet_.newest() + 1);
  open_ = true;
  newest_ = packet;
  instant_ = packet.stamp;
  received_ = received;
  disagreeing_ = run_ = 0;
  age_ = 0;
  estimator_ = ClockEstimator();
  estimator_.add(instant_, received);
  return Verdict::kOpened;
}

DeviceSession::Verdict DeviceSession::finish(End why, const DeviceCycle& packet) {
  open_ = false;
  end_ = why;
  // Of a restart the run so far is evidence of the next session; else it begins now.
  if (why != End::kRestarted) {
    run_ = 0;
    extend_run(packet);
  }
  return Verdict::kEnded;
}

void DeviceSession::close() {
  open_ = false;
  end_ = End::kFailed;
  run_ = 0;
}

DeviceSession::Verdict DeviceSession::refuse(const DeviceCycle& packet) {
  extend_run(packet);
  return run_ >= kRun ? finish(End::kRestarted, packet) : Verdict::kDropped;
}

void DeviceSession::extend_run(const DeviceCycle& packet) {
  const std::int64_t cycles = run_ == 0 ? 0 : ahead_of(packet.sequence, refused_.sequence);
  const bool belongs = cycles > 0 && cycles <= kRunGap && clock_agrees(packet, refused_, cycles);
  run_ = belongs ? std::min(run_ + 1, kRun) : 1;
  refused_ = packet;
}

std::int64_t DeviceSession::ahead_of(std::uint64_t sequence, std::uint64_t other) const {
  const int unused = 64 - options_.sequence_bits;
  // The difference in so many bits, with its sign.
  return static_cast<std::int64_t>((sequence - other) << unused) >> unused;
}

/// Within a quarter of a cycle: enough for stamps that are taken in a task of their own, and for clocks that are
/// slewed.
bool DeviceSession::clock_agrees(const DeviceCycle& packet, const DeviceCycle& before, std::int64_t cycles) const {
  const Nanoseconds by_number = cycles * options_.cycle;
  const Nanoseconds off = difference(difference(packet.stamp, before.stamp), by_number);
  const Nanoseconds open = options_.cycle / 4 + by_number / kDriftShare;
  return off <= open && off >= -open;
}

/// No packet comes before it was sent. What is known of the two clocks leaves some doubt about when that was.
bool DeviceSession::too_early(std::int64_t cycles, Nanoseconds received) const {
  if (cycles > kFarAhead) return true;
  const Nanoseconds by_number = cycles * options_.cycle;
  const Nanoseconds early = estimator_.to_core(instant_ + by_number) - received;
  return early > ClockEstimator::kStep + 4 * options_.cycle + options_.jitter + by_number / kDriftShare;
}

Nanoseconds DeviceSession::measured_at(Nanoseconds stamp, Nanoseconds received) {
  const Nanoseconds age = difference(newest_.stamp, stamp);
  if (age >= -options_.cycle && age <= kOldest) age_ = age;
  return std::min(estimator_.to_core(instant_ - age_), received);
}

}  // namespace takt::device
