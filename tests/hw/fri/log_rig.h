#pragma once

#include <memory>

#include "hw/emulators/fri/emulator.h"
#include "hw/fri/driver.h"
#include "hw/wire/virtual_network.h"
#include "tests/support/arm_rig.h"
#include "tests/support/wire_log.h"

namespace takt::test {

/// What an arm whose wire is written down is made of, in the order in which it has to be made.
struct LoggedParts {
  explicit LoggedParts(const hw::VirtualFaults& faults) : network(clock, 11, faults) {}
  VirtualClock clock;
  hw::VirtualNetwork network;
  WireLog log;
};

/// The driver and the emulated controller on a virtual wire, whose traffic is written down.
class LoggedTwin final : private LoggedParts, public hw::fri::Backend {
 public:
  LoggedTwin(const device::DriverRequest& request, const hw::fri::ClientOptions& client,
             const hw::fri::ControllerOptions& controller, const hw::VirtualFaults& faults,
             std::shared_ptr<device::ArmBackend> machine)
      : LoggedParts(faults),
        Backend(request, client,
                std::make_unique<RecordingLink>(std::move(*network.open_datagrams({0, hw::fri::kPort})), clock, log),
                clock),
        emulator_(request, controller, std::move(*network.open_datagrams({0, 0})), {hw::kLoopback, hw::fri::kPort},
                  std::move(machine)) {}

  [[nodiscard]] WireLog& wire_log() { return log; }
  [[nodiscard]] const Clock& time() const { return clock; }
  /// Up to the next core cycle; read() itself makes no time go on.
  void pass_cycle() {
    const Nanoseconds now = ++core_cycle_ * core_period_;
    bool looked = false;
    for (;;) {
      const Nanoseconds next = std::max(std::min(emulator_.next_cycle(), network.next_arrival()), clock.now());
      if (next > now) break;
      clock.set(next);
      if (next == now && !std::exchange(looked, true)) emulator_.look();
      emulator_.receive(next);
      log.note(clock, WireLog::Turn::kServe);
      client_.serve();
      if (emulator_.next_cycle() <= next) emulator_.begin_cycle();
    }
    clock.set(now);
    if (!looked) emulator_.look();
    emulator_.drive(now);
  }

 private:
  hw::fri::Emulator emulator_;
  std::int64_t core_cycle_ = -1;
};

/// A second driver, without a controller: it gets the log.
class ReplayedDriver final : public hw::fri::Backend {
 public:
  ReplayedDriver(const device::DriverRequest& request, const hw::fri::ClientOptions& options,
                 std::unique_ptr<hw::DatagramLink> link, const Clock& clock)
      : Backend(request, options, std::move(link), clock) {}
  void serve() { client_.serve(); }
};

/// An arm of the conformance suite whose log is played to a second driver at the end of each test.
struct FriLogRig final : ArmRig {
  explicit FriLogRig(const hw::VirtualFaults& faults) : faults_(faults) {
    client_.margin = faults.wire.jitter;
    auto adapted = std::make_shared<device::ArmDescription>(compliant_arm_description(hw::fri::kJoints));
    for (auto& change : adapted->modes.changes) change.duration = 500 * kMillisecond;
    description = adapted;
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(hw::fri::kJoints));
    tap = std::make_shared<ArmTap>(arm);
    twin = std::make_shared<LoggedTwin>(request(), client_, hw::fri::ControllerOptions{}, faults_, tap);
    twin->wire_log().events.reserve(1U << 20);  // a cycle must not allocate
    pass_cycle = [this] { twin->pass_cycle(); };
    backend = std::make_shared<RecordedCalls>(twin, pass_cycle, twin->time(), twin->wire_log());
    told_resolution = tracking = 3e-7;
    smoothness = faults.wire.loss > 0.0 ? 2.0 : 1.08;
    speed_noise = 1e-3;
  }
  ~FriLogRig() override { play_again(); }
  FriLogRig(const FriLogRig&) = delete;
  FriLogRig& operator=(const FriLogRig&) = delete;
  void release() override {
    arm->state().ready = true;
    twin->wire_log().note(twin->time(), WireLog::Reset{});
    twin->reset();
  }

  std::shared_ptr<FakeArm> arm;
  std::shared_ptr<LoggedTwin> twin;

 private:
  [[nodiscard]] device::DriverRequest request() const {
    return {.device = "arm", .description = description, .seed = 11};
  }
  void play_again() const {
    LogReader log(twin->wire_log());
    VirtualClock clock;
    ReplayedDriver again(request(), client_,
                         std::make_unique<ReplayedLink>(log, hw::Endpoint{hw::kLoopback, hw::fri::kPort}), clock);
    LogPlayer player{.log = log,
                     .clock = clock,
                     .driver = again,
                     .turn = [&](WireLog::Turn) { again.serve(); },
                     .reset = [&] { again.reset(); }};
    player.play();
    EXPECT_TRUE(log.at_end());
    EXPECT_GT(player.reads, 50);
    EXPECT_GT(player.turns, 50);
  }

  hw::VirtualFaults faults_;
  hw::fri::ClientOptions client_;
};

}  // namespace takt::test
