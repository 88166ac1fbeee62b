#pragma once

#include <algorithm>
#include <memory>

#include "hw/can/datagram_can.h"
#include "hw/cia402/canopen_bus.h"
#include "hw/cia402/driver.h"
#include "hw/emulators/cia402/emulator.h"
#include "hw/wire/virtual_network.h"
#include "tests/support/arm_rig.h"
#include "tests/support/fake_arm.h"
#include "tests/support/wire_log.h"

namespace takt::test {

inline constexpr hw::Endpoint kLoggedDrives{hw::kLoopback, hw::kCanPort};

/// How an arm of drives whose log is written down differs from one that lives in the core's cycle.
struct DrivesOptions {
  hw::cia402::ClientOptions client;
  hw::cia402::BusOptions bus;
  hw::VirtualFaults faults;
};

/// The master's side of a bus in datagrams over this link.
inline std::unique_ptr<hw::cia402::FieldBus> bus_over(std::unique_ptr<hw::DatagramLink> link,
                                                      const device::DriverRequest& request,
                                                      const DrivesOptions& options, const Clock& clock) {
  return std::make_unique<hw::cia402::CanopenBus>(
      *request.description, options.bus, std::make_unique<hw::DatagramCan>(std::move(link), kLoggedDrives, clock));
}

/// What drives whose bus is written down are made of, in the order in which it has to be made.
struct LoggedBus {
  explicit LoggedBus(const hw::VirtualFaults& faults) : network(clock, 11, faults) {}
  VirtualClock clock;
  hw::VirtualNetwork network;
  WireLog log;
};

/// The driver and emulated drives on a virtual bus, whose traffic is written down.
class LoggedDrives final : private LoggedBus, public hw::cia402::Backend {
 public:
  LoggedDrives(const device::DriverRequest& request, const DrivesOptions& options,
               std::shared_ptr<device::ArmBackend> machine)
      : LoggedBus(options.faults),
        Backend(request, options.client,
                bus_over(std::make_unique<RecordingLink>(std::move(*network.open_datagrams({})), clock, log), request,
                         options, clock),
                clock),
        emulator_(
            request, {},
            std::make_unique<hw::DatagramCan>(std::move(*network.open_datagrams(kLoggedDrives)), hw::Endpoint{}, clock),
            std::move(machine)) {
    bus_time_ = 2 * options.faults.wire.slowest();
  }

  [[nodiscard]] WireLog& wire_log() { return log; }
  [[nodiscard]] const Clock& time() const { return clock; }
  /// Up to the next core cycle; read() itself makes no time go on.
  void pass_cycle() {
    const Nanoseconds now = ++core_cycle_ * core_period_;
    bool looked = false;
    for (;;) {
      const Nanoseconds next = std::max(std::min(next_cycle_, network.next_arrival()), clock.now());
      if (next > now) break;
      clock.set(next);
      if (next == now && !std::exchange(looked, true)) emulator_.look();
      emulator_.receive(next);
      if (next_cycle_ <= next) begin_cycle();
      log.note(clock, WireLog::Turn::kServe);
      client_.poll();
    }
    clock.set(now);
    if (!looked) emulator_.look();
    emulator_.receive(now);
    emulator_.drive(now);
  }

 private:
  void begin_cycle() {
    log.note(clock, WireLog::Turn::kBeginCycle);
    client_.begin_cycle();
    next_cycle_ += cycle_;
  }

  hw::cia402::Emulator emulator_;
  std::int64_t core_cycle_ = -1;
  Nanoseconds next_cycle_ = 0;  // of the bus
};

/// An arm of the conformance suite whose log is played to a second driver at the end of each test.
struct DrivesLogRig final : ArmRig {
  DrivesLogRig(const hw::VirtualFaults& faults, Nanoseconds cycle) {
    options_.faults = faults;
    options_.client.cycle = options_.bus.cycle = cycle;
    options_.client.margin = faults.wire.jitter;
    auto adapted = std::make_shared<device::ArmDescription>(fake_arm_description(3));
    adapted->cycle = cycle;
    adapted->sample_age_max = 20 * cycle;
    description = adapted;
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(3));
    tap = std::make_shared<ArmTap>(arm);
    drives = std::make_shared<LoggedDrives>(request(), options_, tap);
    drives->wire_log().events.reserve(1U << 20);  // a cycle must not allocate
    pass_cycle = [this] { drives->pass_cycle(); };
    backend = std::make_shared<RecordedCalls>(drives, pass_cycle, drives->time(), drives->wire_log());
    told_resolution = tracking = 1e-7;  // an increment is 6e-8 rad
    speed_noise = 1e-6;
    smoothness = faults.wire.loss > 0.0 ? 2.0 : 1.05 + 0.8 * to_seconds(cycle);
  }
  ~DrivesLogRig() override { play_again(); }
  DrivesLogRig(const DrivesLogRig&) = delete;
  DrivesLogRig& operator=(const DrivesLogRig&) = delete;
  void release() override {
    arm->state().ready = true;
    drives->wire_log().note(drives->time(), WireLog::Reset{});
    drives->reset();
  }

  std::shared_ptr<FakeArm> arm;
  std::shared_ptr<LoggedDrives> drives;

 private:
  [[nodiscard]] device::DriverRequest request() const {
    return {.device = "arm", .description = description, .seed = 11};
  }
  void play_again() const {
    LogReader log(drives->wire_log());
    VirtualClock clock;
    hw::cia402::Backend again(request(), options_.client,
                              bus_over(std::make_unique<ReplayedLink>(log, hw::Endpoint{}), request(), options_, clock),
                              clock);
    LogPlayer player{.log = log,
                     .clock = clock,
                     .driver = again,
                     .turn =
                         [&](WireLog::Turn turn) {
                           turn == WireLog::Turn::kBeginCycle ? again.client().begin_cycle() : again.client().poll();
                         },
                     .reset = [&] { again.reset(); }};
    player.play();
    EXPECT_TRUE(log.at_end());
    EXPECT_GT(player.reads, 50);
    EXPECT_GT(player.turns, 50);
  }

  DrivesOptions options_;
};

}  // namespace takt::test
