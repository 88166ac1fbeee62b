#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/device/force_torque_sensor.h"
#include "core/emulation/slow_force_torque.h"
#include "tests/support/fake_arm.h"

/// What every back end of a force/torque sensor owes the canonical sensor (docs/devices.md, "What a back end owes").
/// Instantiate with INSTANTIATE_TEST_SUITE_P(Name, ForceTorqueConformance, Values(...), name_of_sensor).
namespace takt::test {

/// A sensor back end on the bench. `tap` stands before the machine and can be silenced or made to lie.
struct ForceTorqueRig {
  /// Between the machine and what is tested.
  class Tap final : public device::ForceTorqueBackend {
   public:
    explicit Tap(std::shared_ptr<device::ForceTorqueBackend> behind) : behind_(std::move(behind)) {}
    bool read(device::WrenchSample& sample) override {
      if (silent || !behind_->read(sample)) return false;
      sample.wrench.force.x() += push;
      return true;
    }
    [[nodiscard]] device::BackendTiming timing() const override { return behind_->timing(); }

    bool silent = false;
    double push = 0.0;  ///< N on top of what is read

   private:
    std::shared_ptr<device::ForceTorqueBackend> behind_;
  };

  virtual ~ForceTorqueRig() = default;
  virtual void advance() {}

  std::shared_ptr<const device::ForceTorqueDescription> description;
  std::shared_ptr<device::ForceTorqueBackend> backend;
  std::shared_ptr<Tap> tap;
  double noise = 1e-12;  ///< N: how far readings of one load lie apart
  bool lossy = false;
};

struct SensorUnderTest {
  std::string name;
  std::function<std::unique_ptr<ForceTorqueRig>()> make;
};
inline void PrintTo(const SensorUnderTest& sensor, std::ostream* out) { *out << sensor.name; }
inline std::string name_of_sensor(const testing::TestParamInfo<SensorUnderTest>& info) { return info.param.name; }

struct FakeForceTorqueRig final : ForceTorqueRig {
  FakeForceTorqueRig() {
    description = std::make_shared<const device::ForceTorqueDescription>();
    backend = tap = std::make_shared<Tap>(std::make_shared<FakeForceTorqueSensor>());
  }
};

inline std::unique_ptr<ForceTorqueRig> slowed(std::unique_ptr<ForceTorqueRig> rig,
                                              const emulation::SlowOptions& options) {
  auto adapted = std::make_shared<device::ForceTorqueDescription>(*rig->description);
  adapted->cycle = options.cycle;
  adapted->sample_age_max = 20 * options.cycle;
  rig->description = adapted;
  rig->backend = std::make_shared<emulation::SlowForceTorque>("wrist", rig->tap, options, kMillisecond, 5);
  rig->lossy = options.wire.loss > 0.0 || options.wire.reorder > 0.0;
  return rig;
}

class ForceTorqueConformance : public testing::TestWithParam<SensorUnderTest> {
 protected:
  void SetUp() override {
    rig = GetParam().make();
    ASSERT_TRUE(rig && rig->backend && rig->tap && rig->description);
    sensor = std::make_unique<device::ForceTorqueSensor>("wrist", rig->description, rig->backend);
    timing = rig->backend->timing();
  }
  /// Cycles as the core runs them.
  void cycles(int count) {
    for (int i = 0; i < count; ++i) {
      sensor->begin_cycle(k, k * kMillisecond);
      rig->advance();
      ++k;
    }
  }
  void wait_for_sample() {
    for (int i = 0; i < 2000 && !sensor->has_sample(); ++i) cycles(1);
    ASSERT_TRUE(sensor->has_sample());
  }

  std::unique_ptr<ForceTorqueRig> rig;
  std::unique_ptr<device::ForceTorqueSensor> sensor;
  device::BackendTiming timing;
  std::int64_t k = 0;
};

TEST_P(ForceTorqueConformance, T2_ReadingsAreNumberedStampedOnTheCoresClockAndHeld) {
  wait_for_sample();
  Nanoseconds oldest = 0;
  for (int i = 0; i < 1000; ++i) {
    const device::WrenchSample before = sensor->sample();
    cycles(1);
    const device::WrenchSample& now = sensor->sample();
    ASSERT_TRUE(sensor->has_sample());
    ASSERT_GE(now.sequence, before.sequence);
    ASSERT_LE(now.stamp, (k - 1) * kMillisecond);
    ASSERT_EQ(sensor->sample_age(), (k - 1) * kMillisecond - now.stamp);
    if (now.sequence == before.sequence) {
      ASSERT_EQ(now.wrench.force, before.wrench.force) << "held between updates";
    }
    oldest = std::max(oldest, sensor->sample_age());
  }
  EXPECT_LE(oldest, std::max(timing.sample_age, kMillisecond) + (rig->lossy ? 6 * timing.cycle : 0));
}

/// Row O7: the declared age is a bound for how long a load stays unseen, at any phase of the two clocks.
TEST_P(ForceTorqueConformance, O7_ALoadIsSeenWithinTheDeclaredAge) {
  wait_for_sample();
  cycles(300);
  Nanoseconds longest = 0;
  for (int i = 0; i < 60; ++i) {
    cycles(37 + i % 11);
    const double before = sensor->sample().wrench.force.x();
    rig->tap->push += 20.0;
    const std::int64_t begin = k;
    while (sensor->sample().wrench.force.x() - before < 10.0 && k < begin + 2000) cycles(1);
    // Pushed after cycle begin - 1, seen in cycle k - 1.
    longest = std::max(longest, (k - begin) * kMillisecond);
    ASSERT_NEAR(sensor->sample().wrench.force.x() - before, 20.0, 6.0 * rig->noise + 1e-9);
    rig->tap->push -= 20.0;
    cycles(2 * static_cast<int>(timing.sample_age / kMillisecond) + 20);
  }
  const Nanoseconds bound = std::max(timing.sample_age, kMillisecond) + (rig->lossy ? 6 * timing.cycle : 0);
  EXPECT_LE(longest, bound);
  if (!rig->lossy) {
    EXPECT_GE(longest, bound - 2 * kMillisecond) << "and it is no wider than it must be";
  }
}

TEST_P(ForceTorqueConformance, T2_ASilentSensorIsAbsentPastItsMaximumAge) {
  wait_for_sample();
  cycles(100);
  rig->tap->silent = true;
  int held = 0;
  while (sensor->has_sample() && held < 10'000) {
    cycles(1);
    ++held;
  }
  EXPECT_FALSE(sensor->has_sample());
  EXPECT_LE(held * kMillisecond, rig->description->sample_age_max + 2 * kMillisecond);
  if (timing.cycle > kMillisecond) {
    EXPECT_GE(held * kMillisecond, rig->description->sample_age_max - timing.sample_age);
  }
}

TEST_P(ForceTorqueConformance, N5_WhatIsNotFiniteIsNoReading) {
  wait_for_sample();
  rig->tap->push = std::numeric_limits<double>::quiet_NaN();
  cycles(1 + 2 * static_cast<int>(timing.sample_age / kMillisecond) + 20);
  EXPECT_FALSE(sensor->has_sample());
  rig->tap->push = 0.0;
  wait_for_sample();
}

}  // namespace takt::test
