// Cost of the I/O agents (docs/time.md): the core's side in the cycle, the device's side in its own, emulated devices.
#include <memory>

#include <benchmark/benchmark.h>

#include "core/base/random.h"
#include "core/device/arm_agent.h"
#include "core/emulation/slow_arm.h"

namespace takt {
namespace {

using device::JointVector;

constexpr int kJoints = 7;

motion::JointLimits limits() {
  const auto all = [](double x) { return JointVector::Constant(kJoints, x); };
  return {.lower = all(-3), .upper = all(3), .velocity = all(2), .acceleration = all(10), .jerk = all(200)};
}

device::ArmPacket packet(std::uint64_t sequence, Nanoseconds instant) {
  device::ArmPacket packet;
  packet.sample.sequence = sequence;
  packet.sample.stamp = packet.instant = instant;
  packet.sample.q = packet.sample.dq = packet.sample.tau = packet.sample.commanded = JointVector::Zero(kJoints);
  packet.sample.ready = true;
  return packet;
}

device::ArmSetPoint set_point(Nanoseconds time) {
  const JointVector zero = JointVector::Zero(kJoints);
  return {.cycle = time / kMillisecond, .stamp = time, .q = zero, .dq = zero, .ddq = zero};
}

/// What an agent adds to a core cycle: one read and one write. The device answers each eighth cycle.
void core_side(benchmark::State& state) {
  VirtualClock clock;
  device::ArmAgent agent(limits(), {.device_cycle = 8 * kMillisecond}, clock);
  device::ArmSample sample;
  std::uint64_t sequence = 0;
  Nanoseconds now = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(agent.read(sample));
    agent.write(set_point(now));
    now += kMillisecond;
    if (now % (8 * kMillisecond) != 0) continue;
    state.PauseTiming();
    clock.set(now);
    benchmark::DoNotOptimize(agent.answer(packet(++sequence, now)));
    state.ResumeTiming();
  }
}
BENCHMARK(core_side)->Iterations(40'000);

/// Core and device together, a packet and eight cycles: what a device cycle costs both sides.
void device_cycle(benchmark::State& state) {
  VirtualClock clock;
  device::ArmAgent agent(limits(), {.device_cycle = 8 * kMillisecond}, clock);
  device::ArmSample sample;
  std::uint64_t sequence = 0;
  Nanoseconds now = 0;
  for (auto _ : state) {
    clock.set(now);
    benchmark::DoNotOptimize(agent.answer(packet(++sequence, now)));
    for (int i = 0; i < 8; ++i) {
      benchmark::DoNotOptimize(agent.read(sample));
      agent.write(set_point(now));
      now += kMillisecond;
    }
  }
}
BENCHMARK(device_cycle);

void estimator(benchmark::State& state) {
  device::ClockEstimator estimator;
  Random random(1);
  Nanoseconds now = 0;
  for (auto _ : state) {
    estimator.add(now, now + static_cast<Nanoseconds>(random.bits() & 0xffff));
    benchmark::DoNotOptimize(estimator.to_core(now));
    now += kMillisecond;
  }
}
BENCHMARK(estimator);

/// An arm without a body: what is measured is the emulation alone.
class Nobody final : public device::ArmBackend {
 public:
  bool read(device::ArmSample& sample) override {
    sample = sample_;
    return true;
  }
  void write(const device::ArmSetPoint& set_point) override {
    ++sample_.sequence;
    sample_.stamp = set_point.stamp;
    sample_.q = set_point.q;
  }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override {}
  [[nodiscard]] std::string fault_text(std::uint32_t) const override { return {}; }

 private:
  device::ArmSample sample_ = packet(1, 0).sample;
};

/// A core cycle of a slow arm in lock-step: controller, wire, agent, digest.
void emulated_arm(benchmark::State& state) {
  const emulation::SlowOptions options{
      .cycle = state.range(0) * kMillisecond, .drift = 100e-6, .wire = {.transport = 100'000, .jitter = 300'000}};
  emulation::SlowArm arm("arm", std::make_shared<Nobody>(), limits(), options, kMillisecond, 1);
  device::ArmSample sample;
  Nanoseconds now = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(arm.read(sample));
    arm.write(set_point(now));
    now += kMillisecond;
  }
}
BENCHMARK(emulated_arm)->Arg(1)->Arg(4)->Arg(8);

}  // namespace
}  // namespace takt

BENCHMARK_MAIN();
