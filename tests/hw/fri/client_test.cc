// What the driver asks of KRL, how it goes from one control mode to another, and what it says when it cannot.
#include "hw/fri/client.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "hw/drivers.h"
#include "hw/wire/posix_network.h"
#include "tests/hw/fri/twin_bench.h"

namespace takt::test {
namespace {

using device::ControlMode;
using hw::fri::State;
using hw::fri::TwinOptions;
using testing::HasSubstr;
using Phase = device::Arm::Phase;

TEST(FriClient, BecomesReadyWithinASecondAndHoldsTheArmWhereItStands) {
  FriBench bench;
  bench.rig.arm->state().q.setConstant(0.7);
  ASSERT_TRUE(bench.becomes_ready(1000)) << bench.arm.fault_text();
  EXPECT_EQ(bench.report().state, State::kCommand);
  EXPECT_NEAR((bench.told().array() - 0.7).abs().maxCoeff(), 0.0, 1e-7);
}

TEST(FriClient, ACycleThatIsNotTheSitesIsRefusedWithBothNames) {
  TwinOptions options;
  options.controller.cycle = 2 * kMillisecond;
  FriBench bench(options);
  EXPECT_FALSE(bench.becomes_ready());
  EXPECT_THAT(bench.arm.fault_text(), HasSubstr("'cycle_ms'"));
}

TEST(FriClient, AKrlProgramOfAnotherConventionIsTold) {
  TwinOptions options;
  options.controller.krl = "ros_control";
  FriBench bench(options);
  EXPECT_FALSE(bench.becomes_ready(9000));
  EXPECT_THAT(bench.arm.fault_text(), HasSubstr("in the convention of the site"));
  EXPECT_EQ(bench.controller().state(), State::kMonitor);
}

class FriConventions : public testing::TestWithParam<std::string> {};

/// A fallback, a reset, and all modes, with each KRL program.
TEST_P(FriConventions, StartsAgainOnlyWhenItIsResetAndChangesModes) {
  TwinOptions options;
  options.client.krl = options.controller.krl = GetParam();
  FriBench bench(options);
  ASSERT_TRUE(bench.becomes_ready());
  bench.twin().wire().lose_next(50'000, 25);
  ASSERT_TRUE(bench.until([&] { return bench.controller().state() == State::kMonitor; }, 60));
  bench.cycles(3000);
  EXPECT_EQ(bench.controller().state(), State::kMonitor);
  EXPECT_THAT(bench.arm.fault_text(), HasSubstr("fell back to monitor state"));
  bench.twin().reset();
  ASSERT_TRUE(bench.becomes_ready()) << bench.arm.fault_text();
  for (const ControlMode mode : {ControlMode::kJointImpedance, ControlMode::kPosition}) {
    ASSERT_FALSE(bench.arm.refuse_change(mode));
    bench.arm.change_mode(mode);
    EXPECT_EQ(bench.arm.phase(), Phase::kChanging);
    ASSERT_TRUE(bench.until([&] { return bench.arm.phase() == Phase::kFrozen && bench.arm.mode() == mode; }))
        << bench.arm.fault_text();
    EXPECT_EQ(bench.controller().mode(), mode);
  }
  bench.start(0.1);
  bench.cycles(1000);
  EXPECT_EQ(bench.nets_ended, 0);
}

std::string name_of_convention(const testing::TestParamInfo<std::string>& tested) { return tested.param; }
INSTANTIATE_TEST_SUITE_P(All, FriConventions, testing::ValuesIn(hw::fri::driver_conventions()), name_of_convention);

TEST(FriClient, AProgramThatIsForOthersIsRefusedBeforeAnythingRuns) {
  const auto fri = hw::fri_kind();
  const auto* kind = dynamic_cast<const device::ArmDriverKind*>(fri.get());
  ASSERT_TRUE(kind);
  Diagnostics diagnostics;
  const nlohmann::ordered_json site = {{"address", "virtual"}, {"krl", "rcprg"}};
  ObjectReader object(site, "", diagnostics);
  FormReader reader(kind->form(), object);
  const auto settings = kind->read(reader);
  EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
  const auto arm = std::make_shared<const device::ArmDescription>(compliant_arm_description(7));
  const auto twin = kind->connect_in_process(*settings, {.device = "arm", .description = arm},
                                             std::make_shared<FakeArm>(device::JointVector::Zero(7)));
  ASSERT_FALSE(twin);
  EXPECT_THAT(twin.error().to_string(),
              HasSubstr("'rcprg' (Load a program that speaks takt, fri_control, ros_control;"));
}

/// The modes of the bench's arm: to joint impedance in 1 s, and on.
struct ModeBench : FriBench {
  ModeBench() {
    EXPECT_TRUE(becomes_ready());
    change(ControlMode::kJointImpedance);
  }
  void change(ControlMode mode) {
    ASSERT_FALSE(arm.refuse_change(mode)) << arm.refuse_change(mode)->view();
    arm.change_mode(mode);
    ASSERT_TRUE(until([&] { return arm.phase() == Phase::kFrozen && arm.mode() == mode; })) << arm.fault_text();
  }
};

TEST(FriClient, TheComplianceOfTheCoreArrivesAtTheArm) {
  ModeBench bench;
  EXPECT_EQ(bench.rig.arm->state().mode, ControlMode::kJointImpedance);
  bench.arm.hold();
  device::Compliance compliance = bench.arm.compliance();
  const device::JointVector q = bench.arm.set_point().q, rest = device::JointVector::Zero(7);
  compliance.stiffness[3] += 2.0;
  compliance.feed_forward[5] = 0.1;
  for (int i = 0; i < 10; ++i) {
    bench.arm.begin_cycle(bench.k, bench.k * kMillisecond);
    bench.arm.propose(q, rest, rest, compliance);
    ASSERT_FALSE(bench.arm.check());
    bench.arm.hand_over();
    ++bench.k;
  }
  const device::Compliance& given = bench.rig.arm->given.back();
  EXPECT_EQ(given.stiffness[3], compliance.stiffness[3]);
  EXPECT_NEAR(given.feed_forward[5], 0.1, 1e-7);
  EXPECT_NEAR(given.damping_ratio[0], 0.7, 1e-7);
}

TEST(FriClient, AxesThatTheTaskFrameDoesNotHaveStopTheArm) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  device::Compliance compliance;
  compliance.mode = ControlMode::kCartesianImpedance;
  compliance.in_tool_axes = true;
  compliance.stiffness = compliance.damping_ratio = compliance.feed_forward = device::JointVector::Constant(6, 0.5);
  bench.rig.backend->write_compliance(compliance);
  bench.cycles(10);
  EXPECT_NE(bench.arm.phase(), Phase::kNotReady) << "equal in all directions: any axes will do";
  compliance.stiffness[2] = 0.1;
  bench.rig.backend->write_compliance(compliance);
  bench.cycles(10);
  EXPECT_EQ(bench.arm.phase(), Phase::kNotReady);
  EXPECT_THAT(bench.arm.fault_text(), HasSubstr("task_frame"));
}

TEST(FriClient, BrakingIsAskedOfKrlAndTheArmIsAtRestBefore) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.start(1.0);
  bench.cycles(300);
  const std::size_t from = bench.rig.tap->told.size();
  bench.arm.brake();
  bench.cycles(400);
  EXPECT_EQ(bench.nets_ended, 1);
  EXPECT_EQ(bench.controller().state(), State::kMonitor);
  EXPECT_EQ(bench.controller().fallbacks(), 0u) << "it was asked for";
  const auto& told = bench.rig.tap->told;
  for (std::size_t i = from + 2; i < told.size(); ++i) {
    const device::JointVector bend = told[i].q - 2.0 * told[i - 1].q + told[i - 2].q;
    ASSERT_LE(bend.cwiseAbs().maxCoeff(), 1.1 * 10.0 * 1e-6) << "within the limits of acceleration";
  }
  EXPECT_THAT(bench.arm.fault_text(), HasSubstr("brakes were asked for"));
}

TEST(FriClient, NewsAreToldOnce) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  const auto news = bench.twin().news();
  EXPECT_THAT(news, testing::Contains(HasSubstr("FRI state CMD")));
  EXPECT_THAT(news, testing::Contains(HasSubstr("controller: CMD: position")));
  bench.cycles(100);
  for (const std::string& line : bench.twin().news())
    EXPECT_THAT(line, HasSubstr("quality")) << "nothing else happened";
}

/// The thread of the driver, over sockets and at the machine's pace: no figures, as the machine may be busy.
TEST(FriDriver, ItsThreadAnswersAndAsksForMonitorStateWhenItEnds) {
  const auto description = std::make_shared<const device::ArmDescription>(compliant_arm_description(7));
  const device::DriverRequest request{.device = "arm", .description = description};
  const auto machine = std::make_shared<FakeArm>(device::JointVector::Zero(7));
  auto link = std::move(*hw::PosixNetwork().open_datagrams({hw::kLoopback, 0}));
  const hw::Endpoint remote = link->local();
  // All that matters happens on a busy machine too: it may answer late by half a second.
  hw::fri::ControllerOptions controller;
  controller.quality = {.perfect = 0.02, .ok = 0.02, .bad = 0.02};
  controller.bridged = 500;
  hw::fri::Emulator emulator(request, controller, std::move(*hw::PosixNetwork().open_datagrams({hw::kLoopback, 0})),
                             remote, machine);
  MonotonicClock clock;
  auto driver = std::make_unique<hw::fri::Driver>(request, hw::fri::ClientOptions{}, std::move(link), clock, 0);
  std::int64_t cycle = 0;
  const auto emulate = [&] {
    emulator.advance(++cycle * kMillisecond);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  while (emulator.controller().state() != State::kCommand && cycle < 20'000) emulate();
  EXPECT_EQ(emulator.controller().state(), State::kCommand);
  std::atomic<bool> ended = false;
  std::jthread end([&] {
    driver.reset();
    ended = true;
  });
  while (!ended) emulate();
  for (int i = 0; i < 100; ++i) emulate();
  EXPECT_EQ(emulator.controller().state(), State::kMonitor);
  EXPECT_EQ(emulator.controller().fallbacks(), 0u) << "it was asked for";
}

/// A twin around a model's arm that stands at home, with a tool that is turned and off the flange's axis.
struct WrenchBench {
  explicit WrenchBench(bool task_frame_is_tool) {
    TwinOptions options;
    options.client.task_frame_is_tool = options.controller.task_frame_is_tool = task_frame_is_tool;
    machine->state().tau_external = device::JointVector::Zero(hw::fri::kJoints);
    twin = std::make_unique<hw::fri::Twin>(device::DriverRequest{.device = "arm", .description = lwr, .seed = 3},
                                           options, machine);
    Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
    X_FT.translate(Eigen::Vector3d(0.05, -0.02, 0.2)).rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()));
    twin->set_tool({.X_FT = X_FT, .payload = {}});
    cycles(50);
  }
  void cycles(int count) {
    device::ArmSample ignored;
    for (int i = 0; i < count; ++i) (void)twin->read(ignored);
  }
  device::WrenchSample sample() {
    device::WrenchSample out;
    EXPECT_TRUE(twin->force_torque()->read(out));
    return out;
  }

  std::shared_ptr<const device::ArmDescription> lwr = *device::read_arm("models/lwr4plus");
  std::shared_ptr<FakeArm> machine = std::make_shared<FakeArm>(lwr->home);
  std::unique_ptr<hw::fri::Twin> twin;
};

// The controller sends it about its own tool centre point, in axes of $STIFFNESS.TASKFRAME, torques backwards.
TEST(FriClient, TheWrenchOfTheControllerIsASensorInTheFlange) {
  for (const bool task_frame_is_tool : {false, true}) {
    WrenchBench bench(task_frame_is_tool);
    Eigen::Isometry3d X_BF;
    kinematics::Jacobian J;
    bench.lwr->chain->jacobian(bench.lwr->home, X_BF, J);
    kinematics::Vector6 at_flange;
    at_flange << 12.0, -7.0, 20.0, 0.5, -0.4, 0.3;
    bench.machine->state().tau_external = J.transpose() * at_flange;
    bench.cycles(20);
    const device::WrenchSample felt = bench.sample();
    const Eigen::Matrix3d R_FB = X_BF.linear().transpose();
    EXPECT_LE((felt.wrench.force - R_FB * at_flange.head<3>()).norm(), 1e-3) << task_frame_is_tool;
    EXPECT_LE((felt.wrench.torque - R_FB * at_flange.tail<3>()).norm(), 1e-3) << task_frame_is_tool;
  }
}

TEST(FriClient, TheWrenchComesAgainFromAControllerThatCountsAnew) {
  WrenchBench bench(false);
  const device::WrenchSample before = bench.sample();
  bench.cycles(10);
  EXPECT_EQ(bench.sample().sequence, before.sequence + 10);
  bench.twin->restart_controller();
  bench.cycles(1500);  // it speaks from another port, which is believed once the old one has been silent for a second
  const device::WrenchSample after = bench.sample();
  EXPECT_GT(after.sequence, before.sequence + 100);
  EXPECT_GT(after.stamp, before.stamp + 150 * kMillisecond);
}

}  // namespace
}  // namespace takt::test
