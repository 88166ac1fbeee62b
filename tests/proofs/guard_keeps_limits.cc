// Row S2: whatever a net proposes, what is sent keeps the limits. Proposals of every kind of wrongness are made to an
// arm as the control core would, and what leaves it is differentiated by an oracle that knows neither guard nor ramp.
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/device/arm.h"
#include "tests/support/fake_arm.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/random_runs.h"

namespace takt::test {
namespace {

using device::JointVector;

constexpr int kJoints = 3;
constexpr double kPeriod = 1e-3;

/// Judges every set point as it is written; keeps none.
class JudgedArm final : public device::ArmBackend {
 public:
  explicit JudgedArm(const motion::JointLimits& limits)
      : q_(JointVector::Zero(kJoints)),
        oracle({list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration),
                list(limits.jerk)},
               kPeriod, device::Guard::kPositionNoise) {}

  bool read(device::ArmSample& sample) override {
    ++sequence_;
    sample.sequence = sequence_;
    sample.stamp = stamp_;
    sample.q = q_;
    sample.dq = JointVector::Zero(kJoints);
    sample.ready = true;
    return true;
  }
  void write(const device::ArmSetPoint& set_point) override {
    stamp_ = set_point.stamp + kMillisecond;
    q_ = set_point.q;
    ++written;
    oracle.add(list(q_));
  }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override {}
  [[nodiscard]] std::string fault_text(std::uint32_t) const override { return {}; }

 private:
  static std::vector<double> list(const JointVector& v) { return {v.begin(), v.end()}; }
  JointVector q_;
  std::uint64_t sequence_ = 0;
  Nanoseconds stamp_ = 0;

 public:
  long written = 0;
  LimitOracle oracle;
};

/// A motion with bounded derivatives that is good most of the time: a jerk drawn anew now and then, integrated; the
/// same axis is steered back when it comes near a limit, sometimes too late.
class Wanderer {
 public:
  explicit Wanderer(Random& random) : random_(random) {}

  void start(const JointVector& q) {
    q_ = q;
    dq_ = ddq_ = jerk_ = JointVector::Zero(kJoints);
    boldness_ = random_.uniform(0.2, 1.02);
    velocity_share_ = random_.uniform(0.7, 1.05);
    range_share_ = random_.uniform(0.4, 1.3);
  }
  void advance(const motion::JointLimits& limits) {
    for (int i = 0; i < kJoints; ++i) {
      if (random_.unit() < 0.02) jerk_[i] = random_.uniform(-1.0, 1.0) * limits.jerk[i] * boldness_;
      const double a_max = limits.acceleration[i] * boldness_, v_max = limits.velocity[i] * boldness_;
      double a = std::clamp(ddq_[i] + kPeriod * jerk_[i], -a_max, a_max);
      // Steer back from the limits of velocity and range, sometimes too late.
      const double rest = dq_[i] + 0.6 * a * std::abs(a) / limits.jerk[i];
      const bool fast = std::abs(rest) > velocity_share_ * v_max;
      if (fast || std::abs(q_[i] + 0.3 * dq_[i]) > range_share_ * limits.upper[i]) {
        const double away = fast ? rest : q_[i];
        a = ddq_[i] - std::copysign(0.9 * limits.jerk[i] * kPeriod, away);
        a = std::clamp(a, -a_max, a_max);
      }
      const double dq = dq_[i] + 0.5 * kPeriod * (ddq_[i] + a);
      q_[i] += kPeriod * dq_[i] + kPeriod * kPeriod * (2.0 * ddq_[i] + a) / 6.0;
      dq_[i] = dq;
      ddq_[i] = a;
    }
  }
  JointVector q_, dq_, ddq_;

 private:
  Random& random_;
  JointVector jerk_ = JointVector::Zero(kJoints);
  double boldness_ = 1.0, velocity_share_ = 1.0, range_share_ = 1.0;
};

/// Makes a set point wrong in one of many ways.
class Spoiler {
 public:
  explicit Spoiler(Random& random) : random_(random) {}

  static constexpr int kKinds = 9;

  void spoil(int kind, JointVector& q, JointVector& dq, JointVector& ddq) {
    const int joint = static_cast<int>(random_.bits() % kJoints);
    const std::array<JointVector*, 3> parts = {&q, &dq, &ddq};
    JointVector& part = *parts[random_.bits() % parts.size()];
    switch (kind) {
      case 0:  // jumps of every size
        q[joint] += jump();
        break;
      case 1:
        dq[joint] += jump();
        break;
      case 2:
        ddq[joint] += jump();
        break;
      case 3:
        part[joint] = any(special_);
        break;
      case 4: {  // one entry more or less, or none
        static constexpr std::array<int, 4> kSizes = {0, 1, kJoints - 1, kJoints + 1};
        part = JointVector::Constant(any(kSizes), random_.uniform(-1.0, 1.0));
        break;
      }
      case 5:  // all at once somewhere else
        q = JointVector::Constant(kJoints, random_.uniform(-4.0, 4.0));
        break;
      case 6:  // derivatives that belong to another motion
        std::swap(dq, ddq);
        break;
      case 7:  // the smallest differences
        part[joint] = std::nextafter(part[joint], random_.unit() < 0.5 ? -9.0 : 9.0);
        break;
      default:  // derivatives far beyond
        dq *= 100.0;
        ddq *= 100.0;
    }
  }

 private:
  using Limits = std::numeric_limits<double>;
  double jump() { return std::copysign(std::pow(10.0, random_.uniform(-12.0, 3.0)), random_.unit() - 0.5); }
  template <class T, std::size_t kSize>
  T any(const std::array<T, kSize>& list) {
    return list[random_.bits() % kSize];
  }
  std::array<double, 9> special_ = {Limits::quiet_NaN(),   Limits::infinity(),      -Limits::infinity(),
                                    Limits::max(),         Limits::lowest(),        Limits::denorm_min(),
                                    -Limits::denorm_min(), Limits::signaling_NaN(), -0.0};
  Random& random_;
};

struct Tally {
  long samples = 0, trips = 0, spoilt = 0, followed = 0;
};

/// The arm is held, moved, disturbed, held again. All that it is sent is one sequence for the oracle.
void wander(long samples, std::uint64_t seed, bool may_spoil, JudgedArm& backend, Tally& tally,
            const std::shared_ptr<const device::ArmDescription>& description,
            const std::shared_ptr<device::ArmBackend>& shared) {
  Random random(seed, "guard");
  device::Arm arm("arm", description, shared, kMillisecond);
  Wanderer motion(random);
  Spoiler spoiler(random);
  const double chance = std::pow(10.0, random.uniform(-3.5, -0.5));
  for (long i = 0; i < samples; ++i) {
    arm.begin_cycle(i, i * kMillisecond);
    const bool free = arm.phase() == device::Arm::Phase::kFrozen && !arm.held();
    if (free && random.unit() < 0.2) {
      arm.hold();
      motion.start(arm.set_point().q);
    }
    if (arm.held()) {
      motion.advance(description->limits);
      JointVector q = motion.q_, dq = motion.dq_, ddq = motion.ddq_;
      const bool spoil = may_spoil && random.unit() < chance;
      const bool silent = may_spoil && random.unit() < 0.1 * chance;
      if (spoil) spoiler.spoil(static_cast<int>(random.bits() % Spoiler::kKinds), q, dq, ddq);
      tally.spoilt += spoil || silent ? 1 : 0;
      if (!silent) arm.propose(q, dq, ddq);
      if (random.unit() < 0.0005) arm.release();
      if (random.unit() < 0.0005) arm.stop();
    }
    if (arm.check()) ++tally.trips;
    tally.followed += arm.phase() == device::Arm::Phase::kFollowing ? 1 : 0;
    arm.hand_over();
  }
  // To rest, so that the next arm takes over where this one stands.
  arm.stop();
  for (int at_rest = 0; at_rest < 4; at_rest += arm.phase() == device::Arm::Phase::kFrozen ? 1 : 0) {
    ++samples;
    arm.begin_cycle(samples, samples * kMillisecond);
    arm.hand_over();
  }
  tally.samples = backend.written;
}

class GuardProof : public testing::Test {
 protected:
  std::shared_ptr<const device::ArmDescription> description =
      std::make_shared<const device::ArmDescription>(fake_arm_description(kJoints));
};

TEST_F(GuardProof, RowS2NothingBeyondTheLimitsIsSentWhateverIsProposed) {
  constexpr long kRun = 20'000;
  const RandomRuns runs(10'000'000);
  auto backend = std::make_shared<JudgedArm>(description->limits);
  Tally tally;
  std::uint64_t seed = runs.first_seed;
  for (; tally.samples < runs.count; ++seed) {
    wander(std::min(kRun, runs.count - tally.samples + 1), seed, true, *backend, tally, description, backend);
    const auto& oracle = backend->oracle;
    ASSERT_LE(oracle.range_excess, 1e-4) << "seed " << seed;  // what a limit's tolerance does to a stopping distance
    ASSERT_LE(oracle.velocity.share, 1.0 + device::Guard::kShare) << "seed " << seed;
    ASSERT_LE(oracle.acceleration.share, 1.0 + device::Guard::kShare) << "seed " << seed;
    ASSERT_LE(oracle.jerk.share, 1.0 + device::Guard::kShare) << "seed " << seed;
  }
  const auto& oracle = backend->oracle;
  std::printf(
      "%ld set points sent, %ld as proposed, %ld proposals spoilt, %ld trips; largest share of a limit: velocity "
      "%.6f, acceleration %.6f, jerk %.6f; range %.3g beyond\n",
      tally.samples, tally.followed, tally.spoilt, tally.trips, oracle.velocity.share, oracle.acceleration.share,
      oracle.jerk.share, oracle.range_excess);
  // The samples must be worth it: much was followed, much was wrong, and the limits were used.
  EXPECT_GT(tally.followed, tally.samples / 4);
  EXPECT_GT(tally.trips, tally.samples / 20'000);
  EXPECT_GT(oracle.velocity.share, 0.99);
  EXPECT_GT(oracle.range_excess, -0.01);
  EXPECT_GT(oracle.acceleration.share, 0.9);
  EXPECT_GT(oracle.jerk.share, 0.9);
}

/// The oracle sees what the guard would have let pass: the same proposals, sent without it.
TEST_F(GuardProof, RowS2TheOracleSeesWhatAnArmWithoutGuardWouldSend) {
  JudgedArm backend(description->limits);
  Random random(1, "guard");
  Wanderer motion(random);
  Spoiler spoiler(random);
  motion.start(JointVector::Zero(kJoints));
  for (int i = 0; i < 100'000; ++i) {
    motion.advance(description->limits);
    JointVector q = motion.q_, dq = motion.dq_, ddq = motion.ddq_;
    if (random.unit() < 0.01) spoiler.spoil(0, q, dq, ddq);
    backend.write({.cycle = i, .stamp = 0, .q = q, .dq = dq, .ddq = ddq});
  }
  EXPECT_GT(backend.oracle.velocity.share, 10.0);
  EXPECT_GT(backend.oracle.jerk.share, 1000.0);
}

}  // namespace
}  // namespace takt::test
