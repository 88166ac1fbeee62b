// Whatever happens to a device's clock, its counter, the wire and the core: no two answers to an arm are further apart
// than its limits allow (rows S2, T2, T3, S4).
#include <cmath>
#include <cstdlib>
#include <deque>
#include <optional>
#include <ostream>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "core/device/arm_agent.h"
#include "core/motion/time_law.h"

namespace takt::device {
namespace {

constexpr Nanoseconds kMs = kMillisecond;

JointVector joint(double q) { return JointVector::Constant(1, q); }

motion::JointLimits limits() {
  return {.lower = joint(-50), .upper = joint(50), .velocity = joint(2), .acceleration = joint(10), .jerk = joint(200)};
}

struct Fault {
  enum class Kind {
    kClockStep,    ///< somebody sets the device's clock by `size` ns
    kLose,         ///< packets do not come
    kDelay,        ///< packets come late, together
    kRepeat,       ///< packets come again
    kSwap,         ///< a packet comes after the next one
    kForge,        ///< a packet with a number that is `size` too large
    kForgeClock,   ///< one with a stamp that is off by `size` ns
    kNoNumber,     ///< one whose position is not finite
    kRestart,      ///< counter and clock begin anew
    kNotReady,     ///< the device takes no set points for some cycles
    kCoreStalls,   ///< no set points
    kCoreSkips,    ///< the core leaves out time
    kCoreJumps,    ///< set points `size` nrad away
    kCoreHurries,  ///< set points that move too fast
    kCount
  };
  Kind kind = Kind::kLose;
  int after = 0;   ///< cycles of the device since the fault before
  int cycles = 1;  ///< how long it lasts
  std::int64_t size = 0;
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << "{kind " << static_cast<int>(fault.kind) << " after " << fault.after << " for " << fault.cycles
             << " size " << fault.size << "}";
}

rc::Gen<Fault> any_fault() {
  const auto size =
      rc::gen::oneOf(rc::gen::inRange<std::int64_t>(-1000, 1000), rc::gen::inRange<std::int64_t>(-10 * kMs, 10 * kMs),
                     rc::gen::inRange<std::int64_t>(-kSecond, kSecond),
                     rc::gen::element<std::int64_t>(-3600 * kSecond, 3600 * kSecond, INT64_MAX, INT64_MIN));
  // Ranges of the generator grow with the size of the case; here only the number of faults does.
  return rc::gen::resize(
      rc::kNominalSize,
      rc::gen::build<Fault>(
          rc::gen::set(&Fault::kind, rc::gen::map(rc::gen::inRange(0, static_cast<int>(Fault::Kind::kCount)),
                                                  [](int kind) { return static_cast<Fault::Kind>(kind); })),
          rc::gen::set(&Fault::after, rc::gen::oneOf(rc::gen::inRange(0, 10), rc::gen::inRange(0, 200))),
          rc::gen::set(&Fault::cycles, rc::gen::oneOf(rc::gen::inRange(1, 6), rc::gen::inRange(1, 60))),
          rc::gen::set(&Fault::size, size)));
}

/// Asserts what an arm may be answered, from nothing but answers, limits and the time between their instants.
class Judge {
 public:
  explicit Judge(Nanoseconds core_period) : guard_(limits(), core_period) {}

  /// The device did not follow until now: the next answer begins a new history.
  void forget() { count_ = 0; }
  void add(const ArmAnswer& answer) {
    const double q = answer.state.q[0];
    RC_ASSERT(std::isfinite(q));
    double speed = 0.0, dt = 0.0;
    if (count_ > 0) {
      RC_ASSERT(answer.instant > instant_);
      dt = to_seconds(answer.instant - instant_);
      speed = (q - q_) / dt;
      RC_ASSERT(std::abs(speed) <= guard_.speed(0) + 4e-9 / dt);
    }
    if (count_ > 1) {
      const double open = 2.0 * (AnswerGuard::kRateOpen * 2.0 + 4e-9 / std::min(dt, dt_));
      RC_ASSERT(std::abs(speed - speed_) <= 0.5 * guard_.acceleration(0) * (dt + dt_) + open);
    }
    ++count_;
    q_ = q;
    instant_ = answer.instant;
    speed_ = speed;
    dt_ = dt;
  }

 private:
  AnswerGuard guard_;
  int count_ = 0;
  double q_ = 0.0, speed_ = 0.0, dt_ = 0.0;
  Nanoseconds instant_ = 0;
};

/// A device, a wire and a core, all of which misbehave as they are told.
class World {
 public:
  World(Nanoseconds cycle, int bits, std::uint64_t first)
      : cycle_(cycle),
        mask_((std::uint64_t{1} << bits) - 1),
        counter_(first),
        agent(limits(), {.device_cycle = cycle, .margin = 2 * kMs, .sequence_bits = bits}, clock_),
        judge_(kMs) {}

  /// A cycle of the device, and those of the core in it.
  void step() {
    ++counter_;
    device_time_ += cycle_;
    clock_.set(machine_ - skipped_);
    send();
    for (Nanoseconds t = 0; t < cycle_; t += kMs) {
      clock_.set(machine_ - skipped_);
      core_cycle(machine_ - skipped_);
      machine_ += kMs;
    }
    for (int* left : {&lose_, &delay_, &repeat_, &not_ready_, &stall_}) *left = std::max(0, *left - 1);
  }

  void happen(const Fault& fault) {
    using Kind = Fault::Kind;
    switch (fault.kind) {
      case Kind::kClockStep:
        if (std::abs(fault.size / 2) < 7200 * kSecond) device_time_ += fault.size;
        break;
      case Kind::kLose:
        lose_ = fault.cycles;
        break;
      case Kind::kDelay:
        delay_ = fault.cycles;
        break;
      case Kind::kRepeat:
        repeat_ = fault.cycles;
        break;
      case Kind::kSwap:
        delay_ = 1;
        swap_ = true;
        break;
      case Kind::kForge: {
        ArmPacket forged = packet();
        forged.sample.sequence = (counter_ + static_cast<std::uint64_t>(fault.size)) & mask_;
        arrive(forged);
        break;
      }
      case Kind::kForgeClock: {
        ArmPacket forged = packet();
        forged.sample.sequence = (counter_ + 1) & mask_;
        forged.instant = fault.size;
        arrive(forged);
        break;
      }
      case Kind::kNoNumber: {
        ArmPacket broken = packet();
        broken.sample.sequence = (counter_ + 1) & mask_;
        broken.sample.commanded[0] = std::nan("");
        RC_ASSERT(!agent.answer(broken));
        break;
      }
      case Kind::kRestart:
        counter_ = static_cast<std::uint64_t>(fault.size) & mask_ & 0xff;
        device_time_ = 0;
        not_ready_ = 0;
        break;
      case Kind::kNotReady:
        not_ready_ = fault.cycles;
        break;
      case Kind::kCoreStalls:
        stall_ = fault.cycles;
        break;
      case Kind::kCoreSkips:
        skipped_ += fault.cycles * kMs;
        machine_ += fault.cycles * kMs;
        clock_.skip(fault.cycles * kMs);
        break;
      case Kind::kCoreJumps:
        jump_ = 1e-9 * static_cast<double>(fault.size);
        break;
      case Kind::kCoreHurries:
        hurry_ = 1.0 + 0.5 * fault.cycles;
        break;
      case Kind::kCount:
        break;
    }
  }
  void heal() { lose_ = delay_ = repeat_ = not_ready_ = stall_ = 0; }
  [[nodiscard]] bool ready() const { return ready_; }

 private:
  ArmPacket packet() const {
    ArmPacket packet;
    packet.sample.sequence = counter_ & mask_;
    packet.sample.q = packet.sample.dq = packet.sample.commanded = joint(q_);
    packet.sample.ready = not_ready_ == 0;
    packet.instant = packet.sample.stamp = device_time_;
    return packet;
  }

  void send() {
    if (lose_ > 0) return;
    wire_.push_back(packet());
    if (delay_ > 0) return;
    if (swap_ && wire_.size() == 2) std::swap(wire_[0], wire_[1]);
    swap_ = false;
    while (!wire_.empty()) {
      const ArmPacket next = wire_.front();
      wire_.pop_front();
      arrive(next);
      if (repeat_ > 0) RC_ASSERT(!agent.answer(next));
    }
  }

  void arrive(const ArmPacket& packet) {
    const auto answer = agent.answer(packet);
    if (!answer) return;
    if (answer->session != session_ || !followed_ || !packet.sample.ready) judge_.forget();
    session_ = answer->session;
    followed_ = packet.sample.ready;
    judge_.add(*answer);
    if (packet.sample.ready) q_ = answer->state.q[0];
  }

  void core_cycle(Nanoseconds now) {
    agent.set_held(held_);
    ArmSample sample;
    if (stall_ > 0 || !agent.read(sample)) return;
    RC_ASSERT(sample.stamp <= now);
    if (!sample.ready) {
      ready_ = held_ = false;
      hurry_ = 1.0;
      jump_ = 0.0;
      return;
    }
    if (!ready_) {
      begin_ = now;
      from_ = sample.commanded[0];
      way_ = -way_;
    }
    ready_ = held_ = true;
    agent.write(set_point(now));
  }

  /// 1.5 rad there, then it stands, at up to nine tenths of the limits.
  ArmSetPoint set_point(Nanoseconds now) const {
    static const auto law = motion::TimeLaw::rest_to_rest({.velocity = 1.2, .acceleration = 6.0, .jerk = 120.0});
    const auto at = law.at(hurry_ * to_seconds(now - begin_));
    return {.cycle = now / kMs,
            .stamp = now,
            .q = joint(from_ + way_ * at.s + jump_),
            .dq = joint(hurry_ * way_ * at.ds),
            .ddq = joint(hurry_ * hurry_ * way_ * at.dds)};
  }

  Nanoseconds cycle_;
  std::uint64_t mask_, counter_;
  VirtualClock clock_;
  Nanoseconds machine_ = 0, skipped_ = 0, device_time_ = 77 * kSecond;
  int lose_ = 0, delay_ = 0, repeat_ = 0, not_ready_ = 0, stall_ = 0;
  bool swap_ = false;
  std::deque<ArmPacket> wire_;
  double q_ = 0.0;
  bool ready_ = false, held_ = false, followed_ = false;
  Nanoseconds begin_ = 0;
  double from_ = 0.0, way_ = -1.5, jump_ = 0.0, hurry_ = 1.0;
  std::uint64_t session_ = 0;

 public:
  ArmAgent agent;

 private:
  Judge judge_;
};

class AgentFaults : public testing::Test {
 protected:
  // The same cases in every run; RC_PARAMS from outside comes first.
  AgentFaults() { (void)setenv("RC_PARAMS", "seed=21 max_success=200 max_size=60", /*overwrite=*/0); }
};

TEST_F(AgentFaults, S2_NoSequenceOfFaultsMakesTheAnswersStep) {
  const bool holds = rc::check("answers keep the limits of the arm over the time between their instants", [] {
    const auto cycle = *rc::gen::elementOf(std::vector<Nanoseconds>{kMs, 4 * kMs, 8 * kMs});
    const auto bits = *rc::gen::element(16, 32);
    const auto first = *rc::gen::elementOf(std::vector<std::uint64_t>{0, 1, 65'000, 0xffff'ff00});
    const auto faults = *rc::gen::container<std::vector<Fault>>(any_fault());
    World world(cycle, bits, first);
    const auto run = [&](int cycles) {
      for (int i = 0; i < cycles; ++i) world.step();
    };
    run(static_cast<int>(400 * kMs / cycle));
    for (const Fault& fault : faults) {
      run(fault.after);
      world.happen(fault);
    }
    run(100);
    world.heal();
    run(static_cast<int>(2 * kSecond / cycle));
    RC_ASSERT(world.ready());  // and what is right again is accepted again
    RC_ASSERT(world.agent.phase() == AgentReport::Phase::kFollowing);
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace takt::device
