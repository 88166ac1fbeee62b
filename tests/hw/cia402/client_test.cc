// The driver and its drives when something fails: nothing moves on, nothing steps, nothing begins anew by itself.
#include "hw/cia402/client.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "hw/can/datagram_can.h"
#include "hw/wire/posix_network.h"
#include "tests/hw/cia402/twin_rig.h"
#include "tests/support/limit_oracle.h"

namespace takt::hw::cia402 {
namespace {

using Phase = device::Arm::Phase;
using Vector = device::JointVector;

/// A core with an arm of three drives, one cycle at a time.
class Cia402Drives : public testing::Test {
 protected:
  static constexpr Nanoseconds kPeriod = kMillisecond;

  explicit Cia402Drives(const TwinOptions& options = {})
      : rig(options), arm("arm", rig.description, rig.backend, kPeriod) {}

  [[nodiscard]] Twin& twin() { return *rig.twin; }
  [[nodiscard]] Node& node(std::size_t joint) { return twin().emulator().node(joint); }
  [[nodiscard]] bool ready() const { return arm.phase() == Phase::kFrozen; }
  void cycle() {
    arm.begin_cycle(k, k * kPeriod);
    if (arm.lost() && arm.held()) arm.stop();
    if (arm.phase() == Phase::kFollowing) propose();
    EXPECT_FALSE(arm.check());
    arm.hand_over();
    ++k;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  template <class Condition>
  bool until(const Condition& condition, int most = 3000) {
    for (int i = 0; i < most && !condition(); ++i) cycle();
    return condition();
  }
  bool becomes_ready() {
    return until([this] { return ready(); });
  }
  /// All joints swing to and fro from now on.
  void swing() {
    ASSERT_FALSE(arm.refusal()) << arm.refusal()->view();
    arm.hold();
    begin = k;
    from = arm.set_point().q;
    told = rig.tap->told.size();
  }
  /// It swings, and moves fast.
  void move() {
    ASSERT_TRUE(becomes_ready()) << arm.fault_text();
    swing();
    ASSERT_TRUE(until([this] { return std::abs(arm.set_point().dq[0]) > 0.25; }));
  }
  /// What the joints were told since the last swing began has no step, and ends at rest.
  void expect_a_stop_within_limits(double smoothness = 1.1) {
    cycles(1500);
    const auto& l = arm.description().limits;
    const auto list = [](const Vector& v) { return std::vector<double>(v.begin(), v.end()); };
    test::LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                             1e-12);
    for (std::size_t i = told; i < rig.tap->told.size(); ++i) oracle.add(list(rig.tap->told[i].q));
    EXPECT_LE(oracle.velocity.share, 1.0);
    EXPECT_LE(oracle.acceleration.share, smoothness);
    EXPECT_TRUE(rig.tap->told.back().dq.isZero(0.0));
    EXPECT_FALSE(arm.held());
  }
  void expect_nothing_moves_until_reset() {
    const Vector stands = rig.tap->told.back().q;
    cycles(1000);
    EXPECT_FALSE(ready());
    EXPECT_EQ(rig.tap->told.back().q, stands);
    twin().reset();
    ASSERT_TRUE(becomes_ready()) << arm.fault_text();
    EXPECT_LE((rig.tap->told.back().q - stands).cwiseAbs().maxCoeff(), 1e-6);
    swing();
    cycles(300);
    EXPECT_TRUE(arm.held()) << arm.fault_text();
  }

  test::Cia402TwinRig rig;
  device::Arm arm;
  std::int64_t k = 0;

 private:
  void propose() {
    constexpr double kRate = 2.0, kSwing = 0.2;  // rad/s of the phase, rad
    const double t = to_seconds((k - begin) * kPeriod), phase = std::max(0.0, t);
    // 1 - cos, faded in by a polynomial, so that it begins with rest.
    const double fade = std::min(1.0, phase), f = fade * fade * fade * (10.0 - 15.0 * fade + 6.0 * fade * fade);
    const double df = fade < 1.0 ? 30.0 * fade * fade * (1.0 - fade) * (1.0 - fade) : 0.0;
    const double ddf = fade < 1.0 ? 60.0 * fade * (1.0 - fade) * (1.0 - 2.0 * fade) : 0.0;
    const double w = kRate * phase, s = 1.0 - std::cos(w), ds = kRate * std::sin(w), dds = kRate * kRate * std::cos(w);
    const Vector one = Vector::Constant(from.size(), kSwing);
    arm.propose(from + f * s * one, (df * s + f * ds) * one, (ddf * s + 2.0 * df * ds + f * dds) * one);
  }

  std::int64_t begin = 0;
  Vector from;
  std::size_t told = 0;
};

TEST_F(Cia402Drives, AllOfThemAreFoundSetUpAndSwitchedOn) {
  ASSERT_TRUE(becomes_ready()) << arm.fault_text();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(node(i).state(), NmtState::kOperational);
    EXPECT_EQ(node(i).drive().state(), DriveState::kOperationEnabled);
    EXPECT_EQ(node(i).objects().value(kModeDisplay), 8u);
    EXPECT_EQ(node(i).objects().value(kSyncPeriod), 4000u);
    EXPECT_EQ(node(i).objects().value(kConsumedHeartbeat), 127u << 16 | 150u);
  }
  EXPECT_EQ(arm.sample().tau.size(), 3);
  EXPECT_EQ(rig.backend->timing().driver_delay + rig.backend->timing().dead_time, 9 * kMillisecond);
}

TEST_F(Cia402Drives, AnErrorOfOneStopsAllAndIsTheCause) {
  move();
  node(1).drive().fail(kErrorFollowing, k * kPeriod);
  ASSERT_TRUE(until([this] { return arm.lost(); }, 50));
  cycles(5);
  EXPECT_EQ(arm.sample().fault, drive_fault(1, kErrorFollowing));
  EXPECT_NE(arm.fault_text().find("a2"), std::string::npos) << arm.fault_text();
  expect_a_stop_within_limits();
  EXPECT_EQ(node(1).drive().state(), DriveState::kFault);
  EXPECT_EQ(node(0).drive().state(), DriveState::kSwitchOnDisabled) << "quick stop, then off";
  expect_nothing_moves_until_reset();
}

TEST_F(Cia402Drives, ADriverThatIsKilledLeavesThemToTheirOwnStop) {
  move();
  for (int i = 0; i < 1000; ++i, ++k) twin().pass_cycle_without_driver();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(node(i).drive().state(), DriveState::kFault);
    EXPECT_EQ(node(i).objects().value(kErrorCode), kErrorSync);
  }
  expect_a_stop_within_limits();
  expect_nothing_moves_until_reset();
}

TEST_F(Cia402Drives, ACableThatIsCutStopsThemAndItTakesAReset) {
  move();
  twin().wire().set_cut(true);
  cycles(1000);
  EXPECT_TRUE(rig.tap->told.back().dq.isZero(0.0));
  EXPECT_FALSE(arm.held());
  EXPECT_EQ(node(0).objects().value(kErrorCode), kErrorSync);
  twin().wire().set_cut(false);
  expect_a_stop_within_limits();
  expect_nothing_moves_until_reset();
}

TEST_F(Cia402Drives, ADriveThatStartsAnewIsSetUpAnewAndWaitsForAReset) {
  move();
  node(2).restart(k * kPeriod);
  ASSERT_TRUE(until([this] { return arm.lost(); }, 200));
  ASSERT_TRUE(until([this] { return twin().client().bus().phase() == FieldBus::Phase::kRunning; }));
  EXPECT_FALSE(ready());
  rig.arm->state().ready = true;  // its brakes were closed in motion
  cycles(500);
  expect_nothing_moves_until_reset();
}

TEST_F(Cia402Drives, BrakesThatADriveClosedOpenWhenItIsSwitchedOnAgain) {
  int opened = 0;
  twin().emulator().set_brakes({}, [&] {
    ++opened;
    rig.arm->state().ready = true;
  });
  move();
  node(2).take(nmt_frame(NmtCommand::kResetNode, static_cast<NodeId>(3)), k * kPeriod);
  ASSERT_TRUE(until([this] { return arm.lost(); }, 200));
  EXPECT_GE(rig.arm->brakes, 1);
  cycles(500);
  EXPECT_EQ(opened, 0) << "nobody has switched the drives on";
  twin().reset();
  EXPECT_TRUE(becomes_ready()) << arm.fault_text();
  EXPECT_EQ(opened, 1);
}

TEST_F(Cia402Drives, WithoutPowerTheyAreInFaultAndAResetNeedsPower) {
  move();
  rig.arm->state().ready = false;
  rig.arm->state().dq.setZero();
  ASSERT_TRUE(until([this] { return arm.lost(); }, 50));
  cycles(200);
  EXPECT_EQ(arm.sample().fault & 0xFFFF, kErrorPower);
  twin().reset();
  cycles(500);
  EXPECT_FALSE(ready()) << "a drive without power does not switch on";
  rig.arm->state().ready = true;
  EXPECT_TRUE(becomes_ready()) << arm.fault_text();
}

TEST_F(Cia402Drives, ASetPointThatIsAStepIsRefusedByTheDrive) {
  ASSERT_TRUE(becomes_ready());
  // Behind the driver's back: its own guard would not let it pass.
  Dictionary& objects = node(0).objects();
  ASSERT_TRUE(until([&] { return objects.value(kControlWord) == kEnableOperation; }));
  objects.set(kTargetPosition, 50'000'000);
  node(0).drive().take_outputs();
  node(0).drive().begin_cycle(k * kPeriod + 4 * kPeriod);
  EXPECT_EQ(node(0).drive().state(), DriveState::kFaultReactionActive);
  EXPECT_EQ(objects.value(kErrorCode), kErrorVelocity);
}

TEST_F(Cia402Drives, BrakesAreAtOnceAndReset) {
  move();
  arm.brake();
  ASSERT_TRUE(until([this] { return arm.lost(); }, 100));
  cycles(100);
  EXPECT_EQ(rig.arm->brakes, 1);
  EXPECT_EQ(arm.sample().fault, static_cast<std::uint32_t>(ClientFault::kSwitchedOff));
  rig.arm->state().ready = true;
  cycles(500);
  EXPECT_FALSE(ready());
  twin().reset();
  EXPECT_TRUE(becomes_ready()) << arm.fault_text();
}

struct Cia402LostSetPoints : Cia402Drives, testing::WithParamInterface<int> {};

/// Each cycle has six frames to the drives, and SYNC.
TEST_P(Cia402LostSetPoints, AreBridgedThreeTimesInARow) {
  move();
  const int lost = GetParam();
  // Cycles of the bus begin with every fourth of the core: of the next ones, SYNC and set points are lost.
  ASSERT_TRUE(until([this] { return k % 4 == 0; }));
  twin().wire().set_cut(true);
  cycles(4 * lost);
  twin().wire().set_cut(false);
  cycles(100);
  if (lost <= 2) {
    EXPECT_TRUE(arm.held()) << arm.fault_text();
    EXPECT_EQ(arm.phase(), Phase::kFollowing);
  } else if (lost >= 5) {
    EXPECT_FALSE(arm.held());
    expect_a_stop_within_limits(2.0);
  }
}
INSTANTIATE_TEST_SUITE_P(Cycles, Cia402LostSetPoints, testing::Values(1, 2, 5, 8, 30));

TEST_F(Cia402Drives, TheSameSeedGivesTheSameBits) {
  test::Cia402TwinRig other;
  const auto read = [](test::Cia402TwinRig& one) {
    device::ArmSample sample;
    (void)one.twin->read(sample);
    return std::vector<std::byte>(one.twin->state().begin(), one.twin->state().end());
  };
  for (int i = 0; i < 500; ++i) ASSERT_EQ(read(rig), read(other)) << i;
}

/// A bus on which something is not as it must be.
class Cia402WrongBus : public testing::Test {
 protected:
  void pass(Nanoseconds time) {
    for (const Nanoseconds end = clock.now() + time; clock.now() < end; clock.set(clock.now() + kMillisecond / 10)) {
      if (clock.now() % (4 * kMillisecond) == 0) bus.begin_cycle(clock.now());
      (void)bus.poll(clock.now());
      for (std::string& line : bus.lines()) lines += line + "\n";
      while (const auto frame = drives.receive()) node.take(*frame, clock.now());
      node.pass(clock.now());
    }
  }

  VirtualClock clock;
  VirtualNetwork network{clock, 1};
  const Endpoint there{kLoopback, kCanPort};
  DatagramCan drives{std::move(*network.open_datagrams(there)), {}, clock};
  Node node{1, {}, [this](const CanFrame& frame) { (void)drives.send(frame); }};
  CanopenBus bus{test::fake_arm_description(1),
                 {},
                 std::make_unique<DatagramCan>(std::move(*network.open_datagrams({})), there, clock)};
  std::string lines;
};

TEST_F(Cia402WrongBus, ADriveIsFoundAndSetUp) {
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRunning) << lines;
  EXPECT_NEAR(bus.data(0).increments_per_rad, 104857600 / 6.283185307179586, 1e-3);
  EXPECT_NEAR(bus.data(0).torque_unit, 0.1, 1e-12) << "1 Nm of the motor behind a gear of 100, in thousandths";
}

TEST_F(Cia402WrongBus, AnotherProfileIsRefused) {
  node.objects().set(kDeviceType, 401);
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
  EXPECT_NE(lines.find("401"), std::string::npos) << lines;
}

TEST_F(Cia402WrongBus, ADriveWithoutTheModeIsRefused) {
  node.objects().set(kSupportedModes, 1);
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
  EXPECT_NE(lines.find("6502h"), std::string::npos) << lines;
}

TEST_F(Cia402WrongBus, AGearThatNobodyEnteredIsRefused) {
  node.objects().set(kGearMotorTurns, 0);
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
  EXPECT_NE(lines.find("6091h"), std::string::npos) << lines;
}

TEST_F(Cia402WrongBus, ARangeThatThePositionDoesNotHoldIsRefused) {
  node.objects().set(kGearMotorTurns, 1'000'000);
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
}

TEST_F(Cia402WrongBus, ASecondMasterIsRefused) {
  pass(kSecond);
  (void)drives.send(sync_frame());
  pass(10 * kMillisecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
  EXPECT_FALSE(lines.empty());
}

TEST_F(Cia402WrongBus, AnObjectThatTheDriveLacksIsNamed) {
  pass(2 * kMillisecond);
  node.objects() = {};
  pass(kSecond);
  EXPECT_EQ(bus.phase(), FieldBus::Phase::kRefused);
  EXPECT_NE(lines.find("drive 1"), std::string::npos) << lines;
}

/// With threads and sockets, beside the wall clock. No time is judged: machines are shared.
TEST(Cia402Sockets, TheDriverFindsTheDrivesOverSocketsAndSwitchesThemOn) {
  auto description = std::make_shared<device::ArmDescription>(test::fake_arm_description(3));
  description->cycle = 4 * kMillisecond;
  const device::DriverRequest request{.device = "arm", .description = description};
  MonotonicClock clock;
  auto server = PosixNetwork().open_datagrams({kLoopback, 0});
  ASSERT_TRUE(server);
  const Endpoint there = (*server)->local();
  auto machine = std::make_shared<test::FakeArm>(Vector::Zero(3));
  // A machine that is busy misses cycles.
  Emulator emulator(request, {.bridged = 100}, std::make_unique<DatagramCan>(std::move(*server), Endpoint{}, clock),
                    machine);
  std::atomic<bool> end = false;
  std::thread drives([&] {
    while (!end) {
      emulator.advance(clock.now());
      (void)emulator.link().wait(kMillisecond / 2);
    }
  });
  {
    auto link = PosixNetwork().open_datagrams({kLoopback, 0});
    auto bus = std::make_unique<CanopenBus>(*description, BusOptions{},
                                            std::make_unique<DatagramCan>(std::move(*link), there, clock));
    Driver driver(request, {.cycle = 4 * kMillisecond, .margin = 4 * kMillisecond}, std::move(bus), clock, 0);
    device::ArmSample sample;
    for (int i = 0; i < 20'000 && !sample.ready; ++i) {
      (void)driver.read(sample);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(sample.ready) << driver.fault_text(sample.fault);
  }
  end = true;
  drives.join();
  EXPECT_NE(emulator.node(0).drive().state(), DriveState::kOperationEnabled) << "it switches them off at its end";
}

}  // namespace
}  // namespace takt::hw::cia402
