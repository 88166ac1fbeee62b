#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "hw/emulators/rtde/emulated_robot.h"
#include "hw/rtde/driver.h"
#include "hw/wire/virtual_network.h"
#include "hw/wire/virtual_stream.h"
#include "tests/hw/rtde/controller_bench.h"
#include "tests/support/arm_rig.h"
#include "tests/support/stream_log.h"

namespace takt::test {

/// What a robot whose connections are written down is made of, in the order in which it has to be made.
struct LoggedController {
  LoggedController(const hw::rtde::DriverOptions& options, const hw::rtde::ControllerOptions& controller,
                   const device::DriverRequest& request, std::shared_ptr<device::ArmBackend> machine,
                   const hw::VirtualFaults& faults, std::shared_ptr<WireLog> wire_log)
      : network(clock, request.seed, faults),
        log(std::move(wire_log)),
        recording(network, clock, *log),
        robot(controller, request.description, std::move(machine), network) {
    EXPECT_TRUE(robot.listen(options.host));
  }
  VirtualClock clock;
  hw::VirtualNetwork network;
  std::shared_ptr<WireLog> log;
  RecordingNetwork recording;
  hw::rtde::EmulatedRobot robot;
};

/// The driver and the emulated controller on a virtual wire, whose traffic is written down.
class LoggedRobot final : private LoggedController, public hw::rtde::Driver {
 public:
  LoggedRobot(const hw::rtde::DriverOptions& options, const hw::rtde::ControllerOptions& controller,
              const device::DriverRequest& request, std::shared_ptr<device::ArmBackend> machine,
              const hw::VirtualFaults& faults, std::shared_ptr<WireLog> wire_log)
      : LoggedController(options, controller, request, std::move(machine), faults, std::move(wire_log)),
        Driver(options, request, recording, clock),
        period_(request.core_period) {}
  ~LoggedRobot() override { log->note(clock, WireLog::Turn::kEnd); }
  LoggedRobot(const LoggedRobot&) = delete;
  LoggedRobot& operator=(const LoggedRobot&) = delete;

  [[nodiscard]] const Clock& time() const { return clock; }
  [[nodiscard]] hw::rtde::Controller& controller() { return robot.controller(); }
  /// Up to the next core cycle; read() itself makes no time go on.
  void pass_cycle() {
    const Nanoseconds now = ++cycle_ * period_;
    for (;;) {
      const Nanoseconds arrival = network.next_arrival();
      const Nanoseconds next = std::min(arrival > clock.now() ? arrival : hw::VirtualPipe::kNever, robot.next_frame());
      if (next >= now) break;
      clock.set(std::max(next, clock.now()));
      serve(next);
    }
    clock.set(now);
    robot.look();
    serve(now);
    robot.tell(cycle_, now);
  }

 private:
  void serve(Nanoseconds now) {
    robot.serve(now);
    log->note(clock, WireLog::Turn::kServe);
    poll();
  }

  Nanoseconds period_;
  std::int64_t cycle_ = -1;
};

/// An arm of the conformance suite whose log is played to a second driver at the end of each test.
struct RtdeLogRig final : ArmRig {
  RtdeLogRig(const hw::rtde::DriverOptions& options, const hw::rtde::ControllerOptions& controller,
             const hw::VirtualFaults& faults)
      : options_(options) {
    auto adapted = std::make_shared<device::ArmDescription>(*ur5());
    adapted->cycle = options.cycle();
    adapted->sample_age_max = 20 * options.cycle();
    description = adapted;
    tap = std::make_shared<ArmTap>(std::make_shared<FakeArm>(ur5()->home));
    log_->events.reserve(1U << 20);  // a cycle must not allocate
    robot_ = std::make_shared<LoggedRobot>(options, controller, request(), tap, faults, log_);
    pass_cycle = [this] { robot_->pass_cycle(); };
    backend = std::make_shared<RecordedCalls>(robot_, pass_cycle, robot_->time(), *log_);
    smoothness = 1.02 + 7.0 * to_seconds(options.cycle());  // as of RtdeRig
    tracking = 1e-6;
    speed_noise = 1e-3;
  }
  /// The driver ends first: what it sends then is in the log, too.
  ~RtdeLogRig() override {
    backend.reset();
    robot_ = nullptr;
    play_again();
  }
  RtdeLogRig(const RtdeLogRig&) = delete;
  RtdeLogRig& operator=(const RtdeLogRig&) = delete;
  void release() override {
    robot_->controller().power().release_brakes();
    log_->note(robot_->time(), WireLog::Reset{});
    robot_->reset();
  }

 private:
  [[nodiscard]] device::DriverRequest request() const {
    return {.device = "arm", .description = description, .seed = 11};
  }
  void play_again() const {
    LogReader log(*log_);
    VirtualClock clock;
    ReplayedNetwork network(log);
    auto again = std::make_unique<hw::rtde::Driver>(options_, request(), network, clock);
    LogPlayer player{.log = log,
                     .clock = clock,
                     .driver = *again,
                     .turn =
                         [&](WireLog::Turn turn) {
                           if (turn == WireLog::Turn::kEnd)
                             again = nullptr;
                           else
                             again->poll();
                         },
                     .reset = [&] { again->reset(); }};
    player.play();
    EXPECT_TRUE(log.at_end());
    EXPECT_EQ(again, nullptr) << "its end is in the log";
    EXPECT_GT(player.reads, 5);
    EXPECT_GT(player.turns, 5);
  }

  hw::rtde::DriverOptions options_;
  std::shared_ptr<WireLog> log_ = std::make_shared<WireLog>();
  std::shared_ptr<LoggedRobot> robot_;
};

}  // namespace takt::test
