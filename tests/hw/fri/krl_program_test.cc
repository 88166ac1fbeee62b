// The KRL programs of the emulated controller: when they start and stop it, and what they answer.
#include "hw/emulators/fri/krl_program.h"

#include <array>
#include <utility>

#include <gmock/gmock.h>

#include "tests/hw/fri/controller_bench.h"

namespace takt::hw::fri {
namespace {

using testing::HasSubstr;

TEST(FriController, FriControlWantsStopBeforeItStartsAgain) {
  using namespace fri_control_words;
  ControllerBench bench({.krl = "fri_control"});
  bench.command.flags = kPositionFlags;
  bench.cycles(150);
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kOpened);
  bench.command.krl.integer[kStrategy] = 10;
  bench.command.krl.integer[kCommand] = kStart;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kStarted);
  EXPECT_EQ(bench.measured.state, State::kCommand);
  bench.answers = false;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  bench.answers = true;
  bench.cycles(300);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "it believes that it runs";
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kStarted);
  bench.command.krl.integer[kCommand] = kStop;
  bench.cycles(30);
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kOpened);
  bench.command.krl.integer[kCommand] = kStart;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kCommand);
}

TEST(FriController, RosControlStartsInPositionFirstAndOnlyWithThePerfectQuality) {
  using namespace ros_control_words;
  ControllerBench bench({.krl = "ros_control"});
  bench.command.flags = kPositionFlags;
  bench.command.krl.integer[kStrategy] = 30;
  bench.command.krl.integer[kCommand] = kStart;
  bench.cycles(95);
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kInitialised);
  bench.cycles(60);
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kStart);
  EXPECT_EQ(bench.measured.control, Control::kPosition) << "the first strategy is preset";
  bench.command.krl.integer[kCommand] = kStop;
  bench.cycles(30);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  bench.command.krl.integer[kCommand] = kStart;
  bench.command.flags = kJointImpedanceFlags;
  bench.command.damping.setConstant(0.7);
  bench.cycles(50);
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  EXPECT_EQ(bench.measured.state, State::kCommand);
}

/// Answers missing until the controller has given up, then answers again.
void fall_back(ControllerBench& bench) {
  bench.answers = false;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  bench.answers = true;
  bench.cycles(300);
}

TEST(FriController, KukasSampleStartsWhenTheClientIsReadyAndIsAskedToLeaveAfterAFallback) {
  using namespace kuka_sample_words;
  ControllerBench bench({.krl = "kuka_sample"});
  bench.command.flags = kPositionFlags;
  bench.command.krl.integer[kCommand] = 1;
  bench.cycles(150);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  const float before = bench.measured.krl.real[kProbe];
  bench.command.krl.integer[kCommand] = kReady;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kCommand) << bench.news;
  EXPECT_NE(bench.measured.krl.real[kProbe], before) << "what the client echoes";
  EXPECT_EQ(bench.measured.krl.integer[kCommand], 0);
  fall_back(bench);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "nothing restarts by itself";
  EXPECT_EQ(bench.measured.krl.integer[kCommand], kLeave);
  bench.command.krl.integer[kCommand] = 1;
  bench.cycles(30);
  bench.command.krl.integer[kCommand] = kReady;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kCommand) << "the next client";
  bench.command.krl.integer[kCommand] = 1;
  bench.cycles(30);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
}

TEST(FriController, RcprgServesARequestOnceAndStartsInJointImpedance) {
  using namespace rcprg_words;
  ControllerBench bench({.krl = "rcprg"});
  bench.command.flags = kJointPosition;
  bench.cycles(150);
  bench.command.krl.integer[kCommand] = kStart;
  bench.cycles(30);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "without the bit it is no request";
  bench.command.krl.boolean = kRequest;
  bench.cycles(16);
  EXPECT_EQ(bench.measured.krl.boolean & kRequest, kRequest);
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kCommand) << bench.news;
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  EXPECT_EQ(bench.measured.krl.boolean & kRequest, 0) << "served, whether or not the bit is still held";
  fall_back(bench);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "a bit that is held is no new request";
  bench.command.krl.boolean = 0;
  bench.cycles(30);
  bench.command.krl.boolean = kRequest;
  bench.cycles(50);
  EXPECT_EQ(bench.measured.state, State::kCommand);
  const auto ask = [&](int command) {
    bench.command.krl.boolean = 0;
    bench.cycles(30);
    bench.command.krl.integer[kCommand] = command;
    bench.command.krl.boolean = kRequest;
    bench.cycles(40);
  };
  ask(kStop);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  ask(kReopen);
  EXPECT_THAT(bench.news, HasSubstr("OFF: friClose\nMON: friOpen"));
}

TEST(FriController, OpenKcAnswersEachCommandWithItsEchoACountAndACode) {
  using namespace openkc_words;
  ControllerBench bench({.krl = "openkc"});
  bench.command.flags = kJointPosition;
  bench.cycles(150);
  int count = 0;
  const auto answer_to = [&](int command) {
    bench.command.krl.boolean = 0;
    bench.cycles(30);
    bench.command.krl.integer[kCommand] = command;
    bench.command.krl.boolean = kRequest;
    bench.cycles(60);
    EXPECT_EQ(bench.measured.krl.integer[kEcho], command);
    EXPECT_EQ(bench.measured.krl.integer[kCount], ++count);
    return bench.measured.krl.integer[kAnswer];
  };
  bench.command.krl.integer[kStrategy] = 30;
  EXPECT_EQ(answer_to(kSetStrategy), kDone);
  EXPECT_EQ(answer_to(kStart), kDone);
  EXPECT_EQ(bench.measured.state, State::kCommand);
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  EXPECT_EQ(answer_to(kToPosition), kRefused) << "strategies are changed in monitor state";
  EXPECT_EQ(answer_to(kStart), kRefused) << "it runs";
  EXPECT_EQ(answer_to(kStop), kDone);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_EQ(answer_to(kToPosition), kDone);
  EXPECT_EQ(bench.measured.control, Control::kPosition);
  EXPECT_EQ(answer_to(kToAxis), kDone);
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  EXPECT_EQ(answer_to(kToCartesian), kDone);
  EXPECT_EQ(bench.measured.control, Control::kCartesianImpedance);
  EXPECT_EQ(answer_to(kToGravity), kRefused) << "in which FRI cannot command";
  EXPECT_EQ(answer_to(kSetAxis), kDone);
  EXPECT_EQ(answer_to(kReset), kDone);
  EXPECT_EQ(answer_to(77), kRefused);
}

TEST(FriController, IsseHandsStrategyAndToolOverStepByStep) {
  using namespace isse_words;
  ASSERT_TRUE(lwr());
  ControllerBench bench({.krl = "isse"}, lwr());
  bench.machine.q = lwr()->home;
  bench.command.flags = kJointPosition;
  bench.cycles(150);
  // 0.1 m along the flange's axis, turned by 90 degrees about it; 2 kg in (10, 0, 50) mm.
  const std::array<float, 16> values{0, 0, 100, 90, 0, 0, 2, 10, 0, 50, 0, 0, 0, 0.01F, 0.01F, 0.02F};
  bench.command.krl.integer[kStrategy] = 30;
  bench.command.krl.boolean = kRequest;
  for (int step = 1; step <= kSteps; ++step) {
    if (step > 1) bench.command.krl.real[kValue] = values[static_cast<std::size_t>(step - 2)];
    if (step == kMass) {
      const float mass = std::exchange(bench.command.krl.real[kValue], -1.0F);
      bench.command.krl.integer[kStep] = step;
      bench.cycles(20);
      EXPECT_EQ(bench.measured.krl.integer[kStep], step - 1) << "no mass is negative";
      bench.command.krl.real[kValue] = mass;
    }
    bench.command.krl.integer[kStep] = step;
    bench.cycles(20);
    EXPECT_EQ(bench.measured.krl.integer[kStep], step);
    EXPECT_EQ(bench.measured.krl.boolean & kRequest, step < kSteps ? kRequest : bench.measured.krl.boolean & kRequest);
  }
  bench.cycles(60);
  EXPECT_EQ(bench.measured.state, State::kCommand) << bench.news;
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  EXPECT_EQ(bench.measured.krl.boolean & kRequest, 0) << "it is done";
  const Eigen::Isometry3d X_FT = lwr()->chain->forward(bench.measured.q).inverse() * bench.measured.X_BT;
  EXPECT_LE((X_FT.translation() - Eigen::Vector3d(0.0, 0.0, 0.1)).norm(), 1e-6);
  EXPECT_LE((X_FT.linear() - Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()).matrix()).norm(), 1e-6);
  const kinematics::Payload load{2.0, {0.01, 0.0, 0.05}, Eigen::Vector3d(0.01, 0.01, 0.02).asDiagonal()};
  EXPECT_LE((bench.measured.mass - lwr()->chain->mass_matrix(bench.measured.q, load)).cwiseAbs().maxCoeff(), 1e-5);
  fall_back(bench);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "nothing restarts by itself";
}

}  // namespace
}  // namespace takt::hw::fri
