// All threads of a cell at once: the cycle in real time with its watchdog, the agent of an arm on the device's clock,
// the button of an emergency stop, loaders and readers of nets. What is asserted is that nothing breaks; under TSan
// (preset tsan) this is the proof that the threads share nothing unguarded.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "core/device/agent_thread.h"
#include "core/device/emergency_stop.h"
#include "core/rcc/realtime_clock.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/queue_link.h"

namespace takt::test {
namespace {

using namespace std::chrono_literals;
using rcc::NetState;

constexpr Nanoseconds kPeriod = 2 * kMillisecond;

/// An arm whose set points go to an agent on a thread of its own.
class ArmBehindAgent final : public device::ArmBackend {
 public:
  ArmBehindAgent(const motion::JointLimits& limits, const Clock& clock)
      : agent_(limits, {.core_period = kPeriod, .device_cycle = kPeriod, .margin = 20 * kMillisecond}, clock),
        thread_(agent_, link, /*priority=*/0, "left") {}
  void set_held(bool held) override { agent_.set_held(held); }
  bool read(device::ArmSample& sample) override {
    reports += agent_.report().samples.accepted > 0 ? 1 : 0;
    return agent_.read(sample);
  }
  void write(const device::ArmSetPoint& set_point) override { agent_.write(set_point); }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override { agent_.brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override {
    return device::ArmAgent::fault_text(fault);
  }

  QueueLink link;
  std::int64_t reports = 0;  ///< cycle thread

 private:
  device::ArmAgent agent_;
  device::AgentThread thread_;
};

class Threads : public testing::Test {
 protected:
  Threads() {
    core.add(std::make_unique<device::Arm>("left", description, arm, core.period()));
    speed = core.declare({.name = "speed"}).value();
  }

  /// The machine: goes where it is answered, at once. Counts anew now and then, as after a restart.
  void be_device(const std::stop_token& stop) {
    device::ArmPacket packet;
    packet.sample.q = packet.sample.dq = packet.sample.commanded = JointVector::Zero(kFakeJoints);
    packet.sample.ready = true;
    for (int i = 0; !stop.stop_requested(); ++i) {
      if (i % 200 == 199) packet.sample.sequence = 0;
      ++packet.sample.sequence;
      packet.instant = packet.sample.stamp = static_cast<Nanoseconds>(packet.sample.sequence) * kPeriod;
      const auto answers = arm->link.answers();
      if (!answers.empty()) packet.sample.q = packet.sample.commanded = answers.back().state.q;
      packet.sample.fault = i % 300 == 299 ? 5 : 0;
      packet.sample.ready = packet.sample.fault == 0;
      arm->link.put(packet);
      std::this_thread::sleep_for(std::chrono::nanoseconds(kPeriod));
    }
  }

  /// Presses, in all categories, and resets.
  void press_buttons(const std::stop_token& stop) {
    for (int i = 0; !stop.stop_requested(); ++i) {
      button.set_healthy(true);
      button.set_reset(false);
      std::this_thread::sleep_for(5ms);
      button.set_reset(true);
      std::this_thread::sleep_for(i % 4 == 3 ? 60ms : 5ms);
      button.press(static_cast<device::StopCategory>(i % 3));
      button.beat();
    }
  }

  void load_and_start(const std::stop_token& stop) {
    const net::NetDescription net = ptp_net("move", "left", {JointVector::Zero(3), JointVector::Constant(3, 0.05)});
    while (!stop.stop_requested()) {
      const rcc::NetId id = core.load_async(net);
      while (core.state(id) == NetState::kLoading) std::this_thread::yield();
      (void)core.start(id);
      newest = id;
      std::this_thread::sleep_for(10ms);
      (void)core.cancel(id);
      core.abort(id);
      while (core.knows(id) && !core.unload(id)) std::this_thread::sleep_for(1ms);
      ++loads;
    }
  }

  void look(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const rcc::NetId id = newest;
      if (core.status(id).state == NetState::kTerminated) ++ended;
      (void)core.where_it_is();
      (void)speed->write(net::Real(0.5));
      if (const auto watch = core.watch(id, "clock.time", {.capacity = 4})) core.unwatch(*watch);
      if (loads % 7 == 6) core.stop_all(net::Cause::Code::kAborted, "the operator");
      std::this_thread::sleep_for(1ms);
    }
  }

  std::shared_ptr<const device::ArmDescription> description =
      std::make_shared<const device::ArmDescription>(fake_arm_description(kFakeJoints));
  rcc::RealtimeClock clock{{.priority = 0, .lock_memory = false, .overrun_limit = 1'000'000, .watchdog = 20 * kSecond}};
  rcc::ControlCore core{{.period = kPeriod}};
  device::EmergencyStop& button = core.add(std::make_unique<device::EmergencyStop>("button", 500 * kMillisecond));
  std::shared_ptr<ArmBehindAgent> arm = std::make_shared<ArmBehindAgent>(description->limits, clock.time());
  device::Channel* speed = nullptr;
  std::atomic<rcc::NetId> newest = 0;
  std::atomic<int> loads = 0, ended = 0;
};

TEST_F(Threads, OfACellShareNothingUnguarded) {
  {
    std::jthread machine([this](const std::stop_token& stop) { be_device(stop); });
    std::jthread cycle([this](const std::stop_token& stop) { EXPECT_EQ(clock.run(core, stop).failure, ""); });
    std::jthread operator_([this](const std::stop_token& stop) { press_buttons(stop); });
    std::jthread loader([this](const std::stop_token& stop) { load_and_start(stop); });
    std::jthread reader([this](const std::stop_token& stop) { look(stop); });
    std::this_thread::sleep_for(1500ms);
  }
  EXPECT_GT(core.cycle(), 20);
  EXPECT_GT(loads, 3);
  EXPECT_GT(ended, 0);
  EXPECT_GT(arm->reports, 0);
  const auto answers = arm->link.answers();
  ASSERT_GT(answers.size(), 20u);
  for (std::size_t i = 1; i < answers.size(); ++i) {
    if (answers[i].session != answers[i - 1].session) continue;
    const double step = (answers[i].state.q - answers[i - 1].state.q).cwiseAbs().maxCoeff();
    const double dt = to_seconds(answers[i].instant - answers[i - 1].instant);
    ASSERT_LE(step, 1.01 * description->limits.velocity.maxCoeff() * dt) << "answer " << i;
  }
}

}  // namespace
}  // namespace takt::test
