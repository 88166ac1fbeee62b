// What drivers, plug-ins and users of the core throw ends where it was thrown: a net, a device or a request fails with
// its reason; the cycle, the other devices and the process go on.
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/emergency_stop.h"
#include "core/device/force_torque_sensor.h"
#include "core/device/gripper.h"
#include "core/device/signal.h"
#include "core/net/registry.h"
#include "core/rcc/realtime_clock.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using net::Cause;
using rcc::NetState;
using takt::test::Reports;
using testing::HasSubstr;

/// A plug-in that throws what is no std::exception while its net is loaded.
class ThrowsWhenLoaded final : public net::Primitive {
 public:
  explicit ThrowsWhenLoaded(net::Setup&) { throw 42; }
  void update(const net::Cycle&) override {}
};
TAKT_PRIMITIVE(ThrowsWhenLoaded, "test", "Throws while it is made.");

/// A driver that throws where the test says.
class ThrowingArm final : public device::ArmBackend {
 public:
  enum class Where { kNowhere, kRead, kWrite, kBrake };
  bool read(device::ArmSample& sample) override {
    if (where == Where::kRead) throw std::runtime_error("socket 7 is gone");
    return arm.read(sample);
  }
  void write(const device::ArmSetPoint& set_point) override {
    if (where == Where::kWrite) throw 7;
    arm.write(set_point);
  }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override {
    if (where == Where::kBrake) throw std::runtime_error("no answer to the brake");
    arm.brake();
  }
  [[nodiscard]] std::string fault_text(std::uint32_t) const override { return {}; }

  Where where = Where::kNowhere;
  FakeArm arm{JointVector::Zero(kFakeJoints)};
};

class LastCatches : public CoreTest {
 protected:
  rcc::NetId start_ptp(const std::string& arm) {
    const auto id = load(ptp_net(arm, arm, {JointVector::Zero(3), joints(0.6, -0.4, 0.2)}));
    core->start(id);
    return id;
  }
  /// An exception allocates; the guard of steps() is for cycles without one.
  void throwing_steps(int count) {
    for (int i = 0; i < count; ++i) core->step();
  }
  std::shared_ptr<ThrowingArm> add_throwing_arm() {
    auto backend = std::make_shared<ThrowingArm>();
    core->add(std::make_unique<device::Arm>("ill", description, backend, core->period()));
    steps(1);
    return backend;
  }
  void expect_only_the_ill_one_ends(ThrowingArm::Where where, const std::string& words) {
    const auto backend = add_throwing_arm();
    const rcc::NetId ill = start_ptp("ill"), well = start_ptp("left");
    steps(200);
    backend->where = where;
    throwing_steps(2);
    ASSERT_EQ(core->state(ill), NetState::kTerminated);
    EXPECT_EQ(core->status(ill).cause.code, Cause::Code::kDevice);
    EXPECT_EQ(core->status(ill).cause.text.view(), words);
    EXPECT_EQ(core->state(well), NetState::kRunning);
    backend->where = ThrowingArm::Where::kNowhere;
    EXPECT_TRUE(run_to_end(well));
    EXPECT_EQ(core->status(well).cause.code, Cause::Code::kTerminated);
    expect_limits_kept(*left_backend);
    EXPECT_FALSE(core->find_arm("ill")->lost()) << "a driver that is well again is taken up again";
  }
};

TEST_F(LastCatches, ADriverThatThrowsInReadLosesItsDeviceOnly) {
  expect_only_the_ill_one_ends(ThrowingArm::Where::kRead, "ill: its driver failed: socket 7 is gone");
}

TEST_F(LastCatches, ADriverThatThrowsInWriteLosesItsDeviceOnly) {
  expect_only_the_ill_one_ends(ThrowingArm::Where::kWrite, "ill: its driver failed: an exception of unknown type");
}

TEST_F(LastCatches, ADriverThatThrowsInItsBrakeLosesItsDeviceOnly) {
  auto& stop = core->add(std::make_unique<device::EmergencyStop>("e-stop"));
  const auto backend = add_throwing_arm();
  stop.set_healthy(true);
  steps(1);
  stop.set_reset(true);
  steps(1);
  const rcc::NetId well = start_ptp("left");
  steps(100);
  backend->where = ThrowingArm::Where::kBrake;
  stop.press(device::StopCategory::kBrakes);
  throwing_steps(2);
  EXPECT_EQ(core->state(well), NetState::kTerminated);
  EXPECT_EQ(core->status(well).cause.text.view(), "e-stop");
  EXPECT_EQ(left_backend->brakes, 1) << "the other arm's brakes close";
}

class ThrowingSensor final : public device::ForceTorqueBackend {
 public:
  bool read(device::WrenchSample&) override { throw std::runtime_error("no wire"); }
};

class ThrowingGripper final : public device::GripperBackend {
 public:
  bool read(device::GripperSample&) override { throw std::runtime_error("no wire"); }
  void write(const device::GripperSetPoint&) override {}
};

class ThrowingOutput final : public device::SignalOutputBackend<bool> {
 public:
  [[nodiscard]] bool ready() const override { throw std::runtime_error("no wire"); }
  void write(bool) override {}
};

TEST_F(LastCatches, DriversOfEveryKindAreCaught) {
  const auto& sensor = core->add(std::make_unique<device::ForceTorqueSensor>(
      "wrist", std::make_shared<const device::ForceTorqueDescription>(), std::make_shared<ThrowingSensor>()));
  const auto& gripper = core->add(std::make_unique<device::Gripper>(
      "hand", std::make_shared<const device::GripperDescription>(), std::make_shared<ThrowingGripper>()));
  const auto& output = core->add(std::make_unique<device::DigitalOutput>(
      "lamp", device::SignalOutputDescription<bool>{}, std::make_shared<ThrowingOutput>(), core->period()));
  const rcc::NetId well = start_ptp("left");
  throwing_steps(10);
  EXPECT_FALSE(sensor.has_sample());
  EXPECT_TRUE(gripper.lost());
  EXPECT_EQ(gripper.fault().view(), "hand: its driver failed: no wire");
  EXPECT_EQ(output.fault().view(), "lamp: its driver failed: no wire");
  EXPECT_EQ(core->state(well), NetState::kRunning);
}

TEST_F(LastCatches, AnArmThatIsNotReadySaysWhy) {
  const rcc::NetId net = start_ptp("left");
  steps(100);
  left_backend->silent = true;
  steps(2);
  EXPECT_EQ(core->status(net).cause.text.view(), "left: gives no sample that can be used");
}

TEST_F(LastCatches, ALatchIsTheCauseOfWhatItStopped) {
  auto& stop = core->add(std::make_unique<device::EmergencyStop>("e-stop"));
  stop.set_healthy(true);
  steps(1);
  stop.set_reset(true);
  steps(1);
  const rcc::NetId net = start_ptp("left");
  steps(100);
  // The button is wired to the controller, too, which closes its brakes by itself.
  stop.press(device::StopCategory::kBrakes);
  left_backend->brake();
  left_backend->state().fault = 5;
  steps(1);
  EXPECT_EQ(core->status(net).cause.text.view(), "e-stop; left: not ready, fault 5");
}

TEST_F(LastCatches, ANetThatThrowsWhileItIsLoadedIsRejectedWithItsName) {
  net::NetDescription net;
  net.name = "from a plug-in";
  net.add("x", "ThrowsWhenLoaded");
  const auto refused = core->load(net);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), Reports(Code::kInternal, "", {"from a plug-in"}));

  const rcc::NetId id = core->load_async(net);
  while (core->state(id) == NetState::kLoading) std::this_thread::yield();
  EXPECT_EQ(core->state(id), NetState::kRejected);
  EXPECT_THAT(core->diagnostics(id), Reports(Code::kInternal, ""));
  EXPECT_TRUE(core->load(ptp_net("next", "left", {JointVector::Zero(3), joints(0.1, 0, 0)})));
}

TEST_F(LastCatches, WhatFollowsACycleMayFail) {
  left_backend->keep = right_backend->keep = false;
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false, .overrun_limit = 1'000'000});
  const rcc::NetId net = start_ptp("left");
  std::stop_source source;
  int calls = 0;
  testing::internal::CaptureStderr();
  const auto how = clock.run(*core, source.get_token(), [&](rcc::ControlCore&) {
    if (++calls == 100) source.request_stop();
    if (calls >= 10) throw std::runtime_error("the disk is full");
  });
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(how.failure, "");
  EXPECT_EQ(calls, 100);
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kException);
  EXPECT_EQ(core->status(net).cause.text.view(), "what follows each cycle: the disk is full");
  EXPECT_THAT(said, HasSubstr("internal: the disk is full; while doing: what follows each cycle\n"));
  EXPECT_EQ(std::ranges::count(said, '\n'), 7) << "the 1st, 2nd, 4th ... 64th of 91";
}

/// A block of the digest that throws: code inside of the cycle that no net and no device answers for.
TEST_F(LastCatches, ACycleThatFailsEndsTheClockAndNotTheProcess) {
  left_backend->keep = right_backend->keep = false;
  struct Broken final : device::Device {
    Broken() : Device("broken") {}
    [[nodiscard]] std::string_view kind() const override { return "broken"; }
    void begin_cycle(std::int64_t cycle, Nanoseconds) override {
      if (cycle >= 20) throw std::logic_error("an invariant does not hold");
    }
    void add_state(device::StateWords&) const override {}
  };
  core->add(std::make_unique<Broken>());
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false});
  testing::internal::CaptureStderr();
  std::string failure;
  std::jthread([&](const std::stop_token& stop) { failure = clock.run(*core, stop).failure; }).join();
  EXPECT_EQ(failure, "an invariant does not hold; while doing: run cycle 20");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("while doing: run cycle 20"));
}

}  // namespace
}  // namespace takt::test
