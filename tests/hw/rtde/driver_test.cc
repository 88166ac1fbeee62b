// The driver against the emulated controller on a virtual wire: what it refuses, and what happens when one of them
// fails.
#include "hw/rtde/driver.h"

#include <algorithm>
#include <cstdlib>

#include <gmock/gmock.h>

#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "hw/emulators/rtde/rtde_service.h"
#include "hw/emulators/rtde/script_service.h"
#include "hw/rtde/kind/lock_step_robot.h"
#include "tests/hw/rtde/controller_bench.h"
#include "tests/support/fake_arm.h"

namespace takt::hw::rtde {
namespace {

using testing::HasSubstr;

/// A core with one arm: the driver, the wire and the controller around an ideal arm.
class DriverBench {
 public:
  explicit DriverBench(const DriverOptions& options = {}, const ControllerOptions& controller = {},
                       const hw::VirtualFaults& faults = {.wire = {.transport = 100'000, .jitter = 200'000}})
      : ideal(std::make_shared<test::FakeArm>(test::ur5()->home)),
        robot(std::make_shared<LockStepRobot>(
            options, controller, device::DriverRequest{.device = "arm", .description = test::ur5(), .seed = 3}, ideal,
            faults)),
        arm("arm", test::ur5(), robot, kMillisecond) {
    ideal->keep = false;
    EXPECT_TRUE(robot->begin());
  }
  void cycle() {
    arm.begin_cycle(k, k * kMillisecond);
    if (swinging) propose();
    if (const auto trip = arm.check()) trips.push_back(std::string(trip->view()));
    arm.hand_over();
    ++k;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// As the core does: a net that holds a lost arm ends.
  void run(int count) {
    for (int i = 0; i < count; ++i) {
      cycle();
      if (!arm.lost() || !arm.held()) continue;
      arm.stop();
      swinging = false;
    }
  }
  [[nodiscard]] bool wait_until_ready(int most = 4000) {
    for (int i = 0; i < most && arm.phase() != device::Arm::Phase::kFrozen; ++i) cycle();
    return arm.phase() == device::Arm::Phase::kFrozen;
  }
  /// A net that turns the first joint to and fro.
  void begin_swing() {
    EXPECT_FALSE(arm.refusal());
    arm.hold();
    begin = k;
    start = arm.set_point().q;
    swinging = true;
  }
  void propose() {
    const double t = to_seconds((k - begin) * kMillisecond), w = 2.0;
    const double soft = std::min(1.0, t);  // the motion grows within a second
    device::JointVector q = start, dq = device::JointVector::Zero(6), ddq = dq;
    const double s = soft * soft * soft * (10.0 - 15.0 * soft + 6.0 * soft * soft);
    const double ds = t < 1.0 ? 30.0 * soft * soft * (1.0 - soft) * (1.0 - soft) : 0.0;
    const double dds = t < 1.0 ? 60.0 * soft * (1.0 - soft) * (1.0 - 2.0 * soft) : 0.0;
    const double a = 0.2 * std::sin(w * t), da = 0.2 * w * std::cos(w * t), dda = -w * w * a;
    q[0] += s * a;
    dq[0] = ds * a + s * da;
    ddq[0] = dds * a + 2.0 * ds * da + s * dda;
    arm.propose(q, dq, ddq);
  }
  [[nodiscard]] double speed() const { return std::abs(ideal->state().dq[0]); }
  [[nodiscard]] Controller& controller() { return robot->robot().controller(); }
  [[nodiscard]] std::string fault() const { return arm.fault_text(); }

  std::shared_ptr<test::FakeArm> ideal;
  std::shared_ptr<LockStepRobot> robot;
  device::Arm arm;
  std::int64_t k = 0, begin = 0;
  device::JointVector start;
  bool swinging = false;
  std::vector<std::string> trips;
};

/// Whatever the cause was: until somebody resets the driver, no program is uploaded.
void expect_rest_until_reset(DriverBench& bench) {
  const auto uploads = bench.robot->driver().counts().uploads;
  bench.run(3000);
  EXPECT_TRUE(bench.arm.lost()) << "no start without a reset";
  EXPECT_EQ(bench.robot->driver().counts().uploads, uploads);
  EXPECT_THAT(bench.fault(), HasSubstr("reset the arm"));
  bench.robot->driver().reset();
  bench.run(500);
}

/// Nothing moves until a net is started; then it does.
void expect_rest_then_motion(DriverBench& bench) {
  const auto stands = bench.ideal->state().q;
  bench.cycles(500);
  EXPECT_LE((bench.ideal->state().q - stands).cwiseAbs().maxCoeff(), 1e-9) << "nothing moves by itself";
  ASSERT_TRUE(bench.wait_until_ready()) << bench.fault();
  bench.begin_swing();
  bench.run(1500);
  EXPECT_GT(bench.speed() + std::abs(bench.ideal->state().q[0] - stands[0]), 0.01);
  EXPECT_FALSE(bench.arm.lost()) << bench.fault();
  EXPECT_TRUE(bench.trips.empty()) << bench.trips.front();
}

TEST(RtdeDriver, StartsItsProgramAndMoves) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready()) << bench.fault();
  EXPECT_EQ(bench.robot->driver().counts().uploads, 1u);
  expect_rest_then_motion(bench);
  EXPECT_LE(bench.robot->driver().counts().loop_delay, 3) << "packages until the program follows";
}

TEST(RtdeDriver, ACutCableStopsTheArmAndNothingResumes) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  ASSERT_GT(bench.speed(), 0.1);
  bench.robot->network().set_cut(true);
  bench.run(250);
  EXPECT_LT(bench.speed(), 1e-6) << "the program on the controller brakes by itself";
  EXPECT_TRUE(bench.arm.lost());
  EXPECT_FALSE(bench.controller().programs().running()) << "its watchdog has stopped it";
  bench.run(1000);
  EXPECT_THAT(bench.fault(), HasSubstr("connection to the controller was lost"));
  bench.robot->network().set_cut(false);
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
  EXPECT_EQ(bench.robot->driver().counts().uploads, 2u);
}

TEST(RtdeDriver, AFrozenDriverStopsTheArm) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.robot->frozen = true;
  bench.run(400);
  EXPECT_LT(bench.speed(), 1e-6);
  EXPECT_FALSE(bench.controller().programs().running());
  bench.robot->frozen = false;
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
}

/// A hiccup of a few cycles is bridged by the program on the controller.
TEST(RtdeDriver, AShortSilenceIsBridged) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.robot->frozen = true;
  bench.run(17);
  bench.robot->frozen = false;
  bench.run(500);
  EXPECT_FALSE(bench.arm.lost()) << bench.fault();
  EXPECT_GT(bench.speed(), 0.01);
}

/// Every fourth package is the one before once more.
TEST(RtdeDriver, RepeatedPackagesAreIgnoredAndTold) {
  DriverBench bench({}, {.fresh_packages = 3});
  ASSERT_TRUE(bench.wait_until_ready()) << bench.fault();
  bench.begin_swing();
  bench.run(3000);
  EXPECT_FALSE(bench.arm.lost()) << bench.fault();
  EXPECT_GT(bench.speed(), 0.01);
  EXPECT_GT(bench.robot->driver().counts().repeated, 50u);
  const auto lines = bench.robot->news();
  EXPECT_EQ(std::ranges::count_if(lines, [](const auto& line) { return line.contains("repeats packages"); }), 1);
}

/// A controller that hangs may send its last state for ever.
TEST(RtdeDriver, AControllerThatOnlyRepeatsItsStateIsLost) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.controller().set_stuck(true);
  bench.run(1000);
  EXPECT_TRUE(bench.arm.lost());
  EXPECT_THAT(bench.fault(), HasSubstr("connection to the controller was lost"));
  EXPECT_NEAR(bench.speed(), 0.0, 1e-3);
}

/// TCP loses nothing: what is lost on the cable comes late. TAKT_LOSS_MINUTES=60 makes it an hour.
TEST(RtdeDriver, PackagesThatAreLateByUpToTheMarginStopNothing) {
  DriverOptions options;
  options.margin = 6 * kMillisecond;
  DriverBench bench(options, {}, {.wire = {.transport = 100'000, .jitter = 6 * kMillisecond}, .stream_piece = 40});
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  const char* minutes = std::getenv("TAKT_LOSS_MINUTES");
  const std::int64_t end = bench.k + 60'000 * (minutes != nullptr ? std::max(1, std::atoi(minutes)) : 1);
  while (bench.k < end && !bench.arm.lost()) bench.run(1000);
  EXPECT_FALSE(bench.arm.lost()) << bench.fault() << " at " << bench.k << " ms";
  EXPECT_TRUE(bench.swinging);
  EXPECT_TRUE(bench.trips.empty()) << bench.trips.front();
  EXPECT_EQ(bench.robot->driver().counts().uploads, 1u);
}

TEST(RtdeDriver, AControllerThatRestartsMovesNothing) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.robot->robot().restart();
  bench.run(300);
  EXPECT_TRUE(bench.arm.lost());
  bench.run(3000);
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, AProtectiveStopIsReportedAndEndsWithUnlockAndReset) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.controller().protective_stop("test");
  bench.run(400);
  EXPECT_THAT(bench.fault(), HasSubstr("protective stop"));
  EXPECT_LT(bench.speed(), 1e-6);
  bench.run(5500);
  EXPECT_TRUE(bench.arm.lost());
  EXPECT_TRUE(bench.controller().power().unlock());
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
}

// Something was pushed: the machine stops by itself, and its controller says so until somebody has looked at it.
TEST(RtdeDriver, AMachineThatStopsByItselfIsAProtectiveStopOfItsController) {
  DriverBench bench;
  int opened = 0;
  bench.robot->robot().open_brakes = [&] {
    ++opened;
    bench.ideal->state().ready = true;
  };
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(500);
  bench.ideal->brake();
  bench.run(200);
  EXPECT_THAT(bench.fault(), HasSubstr("protective stop"));
  EXPECT_EQ(bench.controller().power().safety(), SafetyMode::kProtectiveStop);
  const auto stands = bench.ideal->state().q;
  bench.run(6000);
  EXPECT_EQ(opened, 0) << "nobody has looked yet";
  ASSERT_TRUE(bench.controller().power().unlock());
  bench.run(100);
  EXPECT_GE(opened, 1);
  EXPECT_LE((bench.ideal->state().q - stands).cwiseAbs().maxCoeff(), 1e-9) << "it is taken over where it stands";
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, AnEmergencyStopIsReportedAndEndsWithReleaseAndReset) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.controller().emergency_stop(true);
  bench.run(200);
  EXPECT_THAT(bench.fault(), HasSubstr("safety stop"));
  EXPECT_TRUE(bench.arm.sample().braked);
  bench.controller().emergency_stop(false);
  bench.run(200);
  EXPECT_THAT(bench.fault(), HasSubstr("no power"));
  bench.controller().power().release_brakes();
  expect_rest_until_reset(bench);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, AProgramThatSomebodyStoppedWaitsForAReset) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.controller().programs().stop();
  bench.run(2000);
  EXPECT_THAT(bench.fault(), HasSubstr("stopped at the controller"));
  EXPECT_EQ(bench.robot->driver().counts().uploads, 1u);
  bench.robot->driver().reset();
  bench.run(500);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, AProgramOfSomebodyElseIsLeftAlone) {
  DriverBench bench;
  ASSERT_TRUE(bench.controller().programs().start("def other():\n  while True:\n    sync()\n  end\nend\n"));
  bench.run(1000);
  EXPECT_THAT(bench.fault(), HasSubstr("another program"));
  EXPECT_EQ(bench.robot->driver().counts().uploads, 0u);
  bench.controller().programs().stop();
  ASSERT_TRUE(bench.wait_until_ready()) << bench.fault();
  ASSERT_TRUE(bench.controller().programs().start("def other():\n  while True:\n    sync()\n  end\nend\n"));
  bench.run(1000);
  EXPECT_TRUE(bench.arm.lost());
  EXPECT_EQ(bench.robot->driver().counts().uploads, 1u);
}

TEST(RtdeDriver, APausedProgramGoesOnOnlyByANewStart) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.begin_swing();
  bench.run(1600);
  bench.controller().programs().pause();
  bench.run(500);
  EXPECT_THAT(bench.fault(), HasSubstr("paused"));
  EXPECT_LT(bench.speed(), 1e-6);
  EXPECT_TRUE(bench.controller().programs().resume());
  bench.run(100);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, WhatIsNotTheExpectedRobotIsRefusedWithWhatToChange) {
  ControllerOptions ur10;
  ur10.model = "UR10";
  DriverBench wrong({}, ur10);
  wrong.run(500);
  EXPECT_THAT(wrong.fault(), HasSubstr("the robot is a UR10 (Give the address of a UR5"));

  DriverBench series({}, test::e_series());
  series.run(500);
  EXPECT_THAT(series.fault(), HasSubstr("series=e"));

  ControllerOptions local = test::e_series();
  local.remote_control = false;
  DriverBench pendant({.e_series = true}, local);
  pendant.run(500);
  EXPECT_THAT(pendant.fault(), HasSubstr("remote control"));

  ControllerOptions old;
  old.version = {3, 8, 0, 0};
  DriverBench registers({}, old);
  registers.run(500);
  EXPECT_THAT(registers.fault(), HasSubstr("has no field"));
  EXPECT_THAT(registers.fault(), HasSubstr("registers=lower"));
  DriverBench lower({.registers = RegisterHalf::kLower}, old);
  EXPECT_TRUE(lower.wait_until_ready()) << lower.fault();
}

TEST(RtdeDriver, ASecondDriverIsRefused) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  VirtualClock clock;
  clock.set(bench.k * kMillisecond);
  Driver second({}, {.device = "second", .description = test::ur5()}, bench.robot->network(), clock);
  for (int i = 0; i < 200; ++i) {
    bench.cycle();
    clock.set(bench.k * kMillisecond);
    second.poll();
  }
  ASSERT_TRUE(second.problems().has_errors());
  EXPECT_THAT(second.problems().to_string(), HasSubstr("another client writes the input 'input_int_register_24'"));
  EXPECT_FALSE(bench.arm.lost()) << "and the first one goes on";
}

TEST(RtdeDriver, ThePayloadIsTheOneThatWasTold) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.robot->set_payload({.mass = 1.25, .p_FC = Eigen::Vector3d(0.0, 0.01, 0.05)});
  bench.run(3000);
  EXPECT_FALSE(bench.arm.lost()) << bench.fault();
  EXPECT_EQ(bench.controller().settings().payload, 1.25);
  EXPECT_EQ(bench.controller().settings().payload_cog.z(), 0.05);
  bench.controller().settings().payload = 4.0;
  bench.run(100);
  EXPECT_THAT(bench.fault(), HasSubstr("another payload"));
}

TEST(RtdeDriver, TheForceAtTheToolIsASensor) {
  DriverBench bench;
  bench.ideal->state().tau_external = device::JointVector::Zero(6);
  ASSERT_TRUE(bench.wait_until_ready());
  // A force of 10 N down at the flange, as the joints feel it.
  const auto& q = bench.ideal->state().q;
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  test::ur5()->chain->jacobian(q, X_BF, J);
  Vector6 wrench = Vector6::Zero();
  wrench[2] = -10.0;
  bench.ideal->state().tau_external = J.transpose() * wrench;
  bench.run(100);
  device::WrenchSample sample;
  ASSERT_TRUE(bench.robot->force_torque()->read(sample));
  const Eigen::Vector3d in_base = X_BF.linear() * sample.wrench.force;
  EXPECT_NEAR(in_base.z(), -10.0, 0.2);
  EXPECT_NEAR(in_base.head<2>().norm(), 0.0, 0.2);
  EXPECT_LT(sample.wrench.torque.norm(), 0.1) << "the force acts at the origin of the flange";
}

// The controller's torque is about its own tool centre point, wherever that is.
TEST(RtdeDriver, TheForceAtTheToolIsToldAboutTheFlange) {
  DriverBench bench;
  bench.ideal->state().tau_external = device::JointVector::Zero(6);
  bench.controller().motion().kinematics().set_tool(Eigen::Isometry3d(Eigen::Translation3d(0.05, 0.0, 0.2)));
  ASSERT_TRUE(bench.wait_until_ready());
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  test::ur5()->chain->jacobian(bench.ideal->state().q, X_BF, J);
  Vector6 wrench = Vector6::Zero();
  wrench[0] = 12.0;
  bench.ideal->state().tau_external = J.transpose() * wrench;
  bench.run(100);
  device::WrenchSample sample;
  ASSERT_TRUE(bench.robot->force_torque()->read(sample));
  EXPECT_NEAR((X_BF.linear() * sample.wrench.force).x(), 12.0, 0.2);
  EXPECT_LT(sample.wrench.torque.norm(), 0.1) << "12 N with a lever of 0.2 m would be 2.4 Nm";
}

TEST(RtdeDriver, FreedriveKeepsNetsAway) {
  DriverBench bench;
  ASSERT_TRUE(bench.wait_until_ready());
  bench.robot->driver().set_freedrive(true);
  bench.run(200);
  EXPECT_THAT(bench.fault(), HasSubstr("led by hand"));
  EXPECT_TRUE(bench.controller().settings().freedrive);
  bench.robot->driver().set_freedrive(false);
  bench.run(200);
  EXPECT_FALSE(bench.controller().settings().freedrive);
  expect_rest_then_motion(bench);
}

TEST(RtdeDriver, NoControllerIsReported) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  Driver driver({}, {.device = "arm", .description = test::ur5()}, network, clock);
  for (int i = 0; i < 3000; ++i) {
    clock.set(i * kMillisecond);
    driver.poll();
  }
  device::ArmSample sample;
  EXPECT_FALSE(driver.read(sample));
  EXPECT_GE(driver.counts().connections, 2u) << "it tries again";
  EXPECT_LE(driver.counts().connections, 4u) << "but not all the time";
}

/// The same seed gives the same run, bit for bit.
TEST(RtdeDriver, RunsRepeat) {
  const auto run = [] {
    DriverBench bench;
    if (!bench.wait_until_ready()) return device::JointVector();
    bench.begin_swing();
    bench.run(1000);
    return bench.ideal->state().q;
  };
  const device::JointVector first = run();
  ASSERT_EQ(first.size(), 6);
  EXPECT_EQ(run(), first);
}

}  // namespace
}  // namespace takt::hw::rtde
