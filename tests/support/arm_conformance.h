#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/device/arm.h"
#include "core/device/brake_ramp.h"
#include "core/motion/time_law.h"
#include "tests/support/arm_rig.h"
#include "tests/support/limit_oracle.h"

/// What every back end of an arm owes the canonical arm, whatever machine is behind it (docs/devices.md, "What a back
/// end owes"). Instantiate with INSTANTIATE_TEST_SUITE_P(Name, ArmConformance, Values(...), name_of_case).
namespace takt::test {

class ArmConformance : public testing::TestWithParam<ArmUnderTest> {
 protected:
  using Vector = device::JointVector;
  static constexpr Nanoseconds kPeriod = kMillisecond;
  static constexpr int kSoon = 2000;  ///< cycles in which any arm of the suite becomes ready

  void SetUp() override {
    rig = GetParam().make();
    ASSERT_TRUE(rig && rig->backend && rig->tap && rig->description);
    arm = std::make_unique<device::Arm>("arm", rig->description, rig->backend, kPeriod);
    timing = rig->backend->timing();
  }

  [[nodiscard]] int n() const { return arm->joint_count(); }
  [[nodiscard]] bool has_agent() const { return timing.cycle > 0; }
  [[nodiscard]] Nanoseconds delay() const { return timing.driver_delay + timing.dead_time; }

  /// Cycles until the device stands where the core stands.
  [[nodiscard]] int settling() const { return static_cast<int>((delay() + 2 * timing.cycle) / kPeriod) + 300; }

  /// One cycle as the core runs it. `propose` may call arm->propose().
  template <class Propose>
  void cycle(const Propose& propose) {
    arm->begin_cycle(k, k * kPeriod);
    propose();
    if (const auto trip = arm->check()) trips.push_back(std::string(trip->view()));
    arm->hand_over();
    rig->advance();
    ++k;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle([] {});
  }
  /// The core does nothing, time goes on: what a stalled core looks like to the device.
  void stall(int count) {
    for (int i = 0; i < count; ++i) {
      rig->pass_cycle();
      rig->advance();
      ++k;
    }
  }
  void wait_until_ready() {
    for (int i = 0; i < kSoon && arm->phase() != device::Arm::Phase::kFrozen; ++i) cycles(1);
    ASSERT_EQ(arm->phase(), device::Arm::Phase::kFrozen) << arm->fault_text();
  }

  /// A swing of all joints there and back around where the arm stands, rest to rest, at 60 % of the limits.
  struct Swing {
    Vector start, way;
    motion::TimeLaw law;
    std::int64_t begin = 0;

    [[nodiscard]] motion::JointSample at(Nanoseconds time) const {
      const double t = to_seconds(time - begin * kPeriod), T = law.duration();
      const motion::LawPoint out = law.at(std::max(0.0, std::min(t, T))), back = law.at(std::max(0.0, t - T));
      return {start + (out.s - back.s) * way, (out.ds - back.ds) * way, (out.dds - back.dds) * way};
    }
    [[nodiscard]] int cycles() const { return static_cast<int>(2.0 * law.duration() / to_seconds(kPeriod)) + 2; }
  };
  Swing make_swing(double radians) {
    const auto& limits = arm->description().limits;
    Swing swing;
    swing.start = arm->set_point().q;
    swing.way = Vector::Zero(n());
    motion::RateLimits rate{1e9, 1e9, 1e9};
    for (int i = 0; i < n(); ++i) {
      const bool up = limits.upper[i] - swing.start[i] > swing.start[i] - limits.lower[i];
      swing.way[i] = up ? radians : -radians;
      rate.velocity = std::min(rate.velocity, 0.6 * limits.velocity[i] / radians);
      rate.acceleration = std::min(rate.acceleration, 0.6 * limits.acceleration[i] / radians);
      rate.jerk = std::min(rate.jerk, 0.6 * limits.jerk[i] / radians);
    }
    swing.law = motion::TimeLaw::rest_to_rest(rate);
    swing.begin = k;
    return swing;
  }
  void propose(const Swing& swing) {
    const motion::JointSample at = swing.at(k * kPeriod);
    arm->propose(at.q, at.dq, at.ddq);
  }
  /// Starts a swing and runs it for so many cycles.
  Swing swing_for(int count, double radians = 0.3) {
    EXPECT_FALSE(arm->refusal()) << arm->refusal()->view();
    arm->hold();
    const Swing swing = make_swing(radians);
    for (int i = 0; i < count; ++i) cycle([&] { propose(swing); });
    return swing;
  }
  void finish(const Swing& swing) {
    while (k < swing.begin + swing.cycles()) cycle([&] { propose(swing); });
    arm->release();
    cycles(1);
  }

  void expect_noticed(const std::function<void(device::ArmSample&)>& falsify) {
    wait_until_ready();
    cycles(600);
    const Swing swing = swing_for(0, 0.8);
    const Nanoseconds there = swing.begin * kPeriod + static_cast<Nanoseconds>(1e9 * swing.law.duration());
    rig->tap->falsify = falsify;
    for (int i = 0; i < 6000 && trips.empty() && !arm->lost(); ++i) {
      cycle([&] {
        const motion::JointSample at = swing.at(std::min(k * kPeriod, there));
        arm->propose(at.q, at.dq, at.ddq);
      });
    }
    const bool gives_way = arm->mode() != device::ControlMode::kPosition;  // such an arm may be anywhere
    EXPECT_EQ(arm->lost() || !trips.empty(), !gives_way) << arm->fault_text();
    if (trips.empty()) return;
    EXPECT_THAT(trips.front(), testing::HasSubstr("follow"));
    EXPECT_NE(arm->phase(), device::Arm::Phase::kFollowing);
  }

  /// What the drives were told since `from`, against the limits. Jerk is the business of their interpolator.
  void expect_told_within_limits(std::size_t from) const {
    const auto list = [](const Vector& v) { return std::vector<double>(v.begin(), v.end()); };
    const auto& l = arm->description().limits;
    LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                       1e-12);
    for (std::size_t i = from; i < rig->tap->told.size(); ++i) oracle.add(list(rig->tap->told[i].q));
    EXPECT_LE(oracle.range_excess, 0.0);
    EXPECT_LE(oracle.velocity.share, 1.0 + 0.1 * (rig->smoothness - 1.0) + 1e-3);
    EXPECT_LE(oracle.acceleration.share, rig->smoothness) << "axis " << oracle.acceleration.axis;
  }

  std::unique_ptr<ArmRig> rig;
  std::unique_ptr<device::Arm> arm;
  device::BackendTiming timing;
  std::int64_t k = 0;
  std::vector<std::string> trips;
};

TEST_P(ArmConformance, BecomesReadyAndIsTakenOverWhereItStands) {
  wait_until_ready();
  const auto& sample = arm->sample();
  EXPECT_EQ(sample.q.size(), n());
  EXPECT_EQ(sample.dq.size(), n());
  EXPECT_TRUE(sample.tau.size() == 0 || sample.tau.size() == n());
  EXPECT_TRUE(sample.ready);
  EXPECT_EQ(sample.fault, 0u);
  const Vector& taken = sample.commanded.size() > 0 ? sample.commanded : sample.q;
  EXPECT_EQ(arm->set_point().q, taken);
  EXPECT_LE((taken - sample.q).cwiseAbs().maxCoeff(), 0.01) << "rad";
  EXPECT_FALSE(arm->refusal());
}

TEST_P(ArmConformance, T2_SamplesAreNumberedStampedOnTheCoresClockAndHeld) {
  wait_until_ready();
  Nanoseconds oldest = 0;
  for (int i = 0; i < 1000; ++i) {
    const device::ArmSample before = arm->sample();
    cycles(1);
    const auto& now = arm->sample();
    const Nanoseconds begun = (k - 1) * kPeriod;
    ASSERT_TRUE(arm->has_sample());
    ASSERT_GE(now.sequence, before.sequence);
    ASSERT_LE(now.stamp, begun) << "measured before it is seen";
    ASSERT_EQ(arm->sample_age(), begun - now.stamp);
    if (now.sequence == before.sequence) {
      ASSERT_EQ(now.q, before.q) << "held between updates";
    }
    oldest = std::max(oldest, arm->sample_age());
  }
  // Each lost sample makes the newest a device cycle older.
  const bool lossy = rig->smoothness > 1.5;
  EXPECT_LE(oldest, timing.sample_age + (lossy ? 6 * timing.cycle : 0));
}

TEST_P(ArmConformance, L5_HoldsItsLastSetPointBitForBit) {
  wait_until_ready();
  const Vector q = arm->set_point().q;
  cycles(100);
  const std::size_t from = rig->tap->told.size();
  cycles(500);
  ASSERT_GT(rig->tap->told.size(), from);
  for (std::size_t i = from; i < rig->tap->told.size(); ++i) ASSERT_EQ(rig->tap->told[i].q, q) << i;
  EXPECT_LE((arm->sample().q - q).cwiseAbs().maxCoeff(), rig->tracking);
}

TEST_P(ArmConformance, T3_FollowsAMotionWithTheDeclaredDelay) {
  wait_until_ready();
  cycles(600);  // the estimate of a clock settles
  const std::size_t from = rig->tap->told.size();
  const Swing swing = swing_for(0);
  double told_error = 0.0, measured_error = 0.0, speed_error = 0.0;
  while (k < swing.begin + swing.cycles() + settling()) {
    cycle([&] { propose(swing); });
    ASSERT_TRUE(trips.empty()) << trips.front();
    const auto& told = rig->tap->told.back();
    const motion::JointSample want = swing.at(told.stamp - delay());
    told_error = std::max(told_error, (told.q - want.q).cwiseAbs().maxCoeff());
    const auto& sample = arm->sample();
    // A set point acts from its cycle on, so what is measured at its end is a period younger.
    const motion::JointSample seen = swing.at(sample.stamp - delay() - (rig->has_mass ? 0 : kPeriod));
    measured_error = std::max(measured_error, (sample.q - seen.q).cwiseAbs().maxCoeff());
    speed_error = std::max(speed_error, (sample.dq - seen.dq).cwiseAbs().maxCoeff());
  }
  const double speed = arm->description().limits.velocity.maxCoeff();
  // Half a millisecond of way: what wires with jitter and bridged losses leave open.
  const double open = has_agent() ? 0.5e-3 * speed : 1e-9;
  EXPECT_LE(told_error, open);
  EXPECT_LE(measured_error, open + rig->tracking);
  EXPECT_LE(speed_error, 0.02 * speed + rig->speed_noise) << "velocities come from the driver";
  expect_told_within_limits(from);
  EXPECT_NEAR((rig->tap->told.back().q - swing.start).cwiseAbs().maxCoeff(), 0.0, rig->told_resolution);
}

TEST_P(ArmConformance, T3_StopsByItselfWhenSetPointsRunOut) {
  wait_until_ready();
  cycles(600);
  const Swing swing = swing_for(0);
  while (std::abs(arm->set_point().dq[0]) < 0.3 * swing.law.at(0.5 * swing.law.duration()).ds * std::abs(swing.way[0]))
    cycle([&] { propose(swing); });
  const std::size_t from = rig->tap->told.size();
  stall(1500);
  cycle([&] { propose(swing); });  // the core is back
  if (!has_agent()) {
    EXPECT_LE(arm->sample().dq.cwiseAbs().maxCoeff(), rig->speed_noise) << "without one it holds its last set point";
    return;
  }
  EXPECT_TRUE(arm->lost()) << "the net that held it ends";
  EXPECT_FALSE(arm->fault_text().empty());
  EXPECT_EQ(rig->tap->told.back().dq, Vector::Zero(n()));
  expect_told_within_limits(from);
  // S4: it may be ready again, but it stays where it is until a net is started, from there.
  arm->stop();
  const Vector stands = rig->tap->told.back().q;
  for (int i = 0; i < 300; ++i) cycle([] {});
  EXPECT_EQ(rig->tap->told.back().q, stands);
  EXPECT_EQ(arm->phase(), device::Arm::Phase::kFrozen);
  const Swing again = swing_for(100, 0.05);
  finish(again);
  cycles(settling());
  EXPECT_NEAR((rig->tap->told.back().q - stands).cwiseAbs().maxCoeff(), 0.0, rig->told_resolution);
  EXPECT_TRUE(trips.empty());
}

/// Row S5 asks where the arm is, not how late it is: a net may follow at once.
TEST_P(ArmConformance, S5_ANetMayFollowAtOnceHoweverLateTheArmIs) {
  wait_until_ready();
  cycles(600);
  finish(swing_for(50));
  ASSERT_EQ(arm->phase(), device::Arm::Phase::kFrozen);
  for (int i = 0; i < settling(); ++i) {
    ASSERT_FALSE(arm->refusal()) << arm->refusal()->view() << " " << i << " cycles after the end";
    cycles(1);
  }
  finish(swing_for(50, 0.1));
  EXPECT_TRUE(trips.empty()) << trips.front();
}

TEST_P(ArmConformance, S2_TheGuardsRampArrivesWithinTheLimits) {
  wait_until_ready();
  cycles(600);
  const std::size_t from = rig->tap->told.size();
  (void)swing_for(300);
  arm->stop();
  for (int i = 0; i < 3000 && arm->phase() != device::Arm::Phase::kFrozen; ++i) cycles(1);
  cycles(settling());
  EXPECT_TRUE(arm->at_rest());
  EXPECT_NEAR((rig->tap->told.back().q - arm->set_point().q).cwiseAbs().maxCoeff(), 0.0, rig->told_resolution);
  EXPECT_LE((arm->sample().q - arm->set_point().q).cwiseAbs().maxCoeff(), rig->tracking);
  expect_told_within_limits(from);
}

TEST_P(ArmConformance, S3_BrakesCloseAndItMovesAgainOnlyByANewStart) {
  wait_until_ready();
  cycles(100);
  const Swing swing = swing_for(250);
  arm->brake();
  int until_lost = 0;
  while (!arm->lost() && until_lost < 2000) {
    cycle([&] { propose(swing); });
    ++until_lost;
  }
  ASSERT_TRUE(arm->lost()) << "reported, not planned";
  EXPECT_LE((until_lost - 1) * kPeriod, 2 * delay() + timing.sample_age + 6 * timing.cycle + kPeriod);
  arm->stop();
  cycles(1000);
  EXPECT_LE(arm->sample().dq.cwiseAbs().maxCoeff(), 1e-3 + rig->speed_noise);
  const Vector stands = arm->sample().q;
  rig->release();
  wait_until_ready();
  cycles(500);
  EXPECT_LE((arm->sample().q - stands).cwiseAbs().maxCoeff(), 1e-3 + rig->tracking) << "rad";
  const Swing again = swing_for(50, 0.05);
  finish(again);
  EXPECT_TRUE(trips.empty()) << trips.front();
}

TEST_P(ArmConformance, T2_ASilentDeviceIsAbsentPastItsMaximumAge) {
  wait_until_ready();
  cycles(100);
  rig->tap->silent = true;
  int held = 0;
  while (arm->has_sample() && held < 10'000) {
    cycles(1);
    ++held;
  }
  EXPECT_FALSE(arm->has_sample());
  EXPECT_TRUE(arm->lost());
  if (has_agent()) {
    EXPECT_GE(held * kPeriod, arm->description().sample_age_max - timing.sample_age);
  }
  EXPECT_LE(held * kPeriod, arm->description().sample_age_max + 2 * kPeriod);
  rig->tap->silent = false;
  rig->release();  // a controller may have stopped for want of answers
  wait_until_ready();
}

// -- A machine that does not follow: whoever notices, the driver's controller or the core, its nets end

TEST_P(ArmConformance, AMachineThatStandsStillEndsItsNets) {
  expect_noticed([q = Vector()](device::ArmSample& sample) mutable {
    if (q.size() == 0) q = sample.q;
    sample.q = q;
    sample.dq.setZero();
  });
}

TEST_P(ArmConformance, AMachineThatJumpsEndsItsNets) {
  expect_noticed([](device::ArmSample& sample) { sample.q[0] += 0.3; });
}

TEST_P(ArmConformance, AMachineThatDriftsEndsItsNets) {
  expect_noticed([off = 0.0](device::ArmSample& sample) mutable { sample.q[0] -= (off += 1e-3); });
}

TEST_P(ArmConformance, PayloadIsBelieved) {
  wait_until_ready();
  cycles(500);
  const Vector q = arm->sample().q;
  rig->backend->set_payload({.mass = 1.0, .p_FC = Eigen::Vector3d(0.0, 0.0, 0.05)});
  cycles(500);
  const double moved = (arm->sample().q - q).cwiseAbs().maxCoeff();
  if (rig->has_mass && rig->weight_pulls) {
    EXPECT_GT(moved, 1e-4) << "a load that is not there lifts the arm";
  } else {
    EXPECT_LE(moved, rig->has_mass ? 1e-5 : 0.0) << "only what its own measurements are uncertain by";
  }
}

}  // namespace takt::test
