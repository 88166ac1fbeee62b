// The emulated controller: its state machine, what it checks, how it falls back.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "tests/hw/fri/controller_bench.h"

namespace takt::hw::fri {
namespace {

using testing::HasSubstr;

TEST(FriController, SendsFromTheBeginningAndIsConvincedByAnswers) {
  ControllerBench bench;
  bench.answers = false;
  bench.cycles(200);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_EQ(bench.measured.quality, Quality::kUnacceptable);
  EXPECT_NEAR(bench.measured.statistics.answer_rate, 0.0, 1e-9);
  bench.answers = true;
  bench.cycles(75);
  EXPECT_EQ(bench.measured.quality, Quality::kBad);
  bench.cycles(23);
  EXPECT_EQ(bench.measured.quality, Quality::kOk);
  bench.cycles(5);
  EXPECT_EQ(bench.measured.quality, Quality::kPerfect);
  EXPECT_NEAR(bench.measured.statistics.latency, 0.0005, 1e-9);
  EXPECT_EQ(bench.measured.power, 0);
}

// A client whose answers are late when it starts has them in reserve.
TEST(FriController, CommandStateWaitsUntilTheQualityIsOkAndBearsWhatIsMissingThen) {
  ControllerBench bench;
  bench.command.flags = kPositionFlags;
  bench.ask(State::kCommand);
  bench.cycles(75);
  EXPECT_EQ(bench.measured.quality, Quality::kBad);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  while (bench.measured.state == State::kMonitor && bench.now < kSecond) bench.cycle();
  EXPECT_EQ(bench.measured.quality, Quality::kOk);
  ASSERT_EQ(bench.measured.state, State::kCommand);
  bench.answers = false;
  bench.cycles(10);
  bench.answers = true;
  bench.cycles(100);
  EXPECT_EQ(bench.measured.state, State::kCommand) << bench.news;
  EXPECT_EQ(bench.measured.power, kAllDrives);
  EXPECT_EQ(bench.measured.control, Control::kPosition);
}

// An arm that was compliant is not where it was told to be. Position control begins where it is, and the remote side,
// which mirrors what it heard a cycle ago, does not know that yet.
TEST(FriController, CommandStateWaitsUntilTheRemoteSideMirrorsWhereTheArmIs) {
  ControllerBench bench;
  bench.mode = bench.machine.mode = device::ControlMode::kCartesianImpedance;
  bench.command.flags = kPositionFlags;
  bench.cycles(150);
  bench.ask(State::kCommand);
  bench.cycles(50);
  ASSERT_EQ(bench.measured.state, State::kMonitor) << "the machine is not in position control";
  bench.mode = bench.machine.mode = device::ControlMode::kPosition;
  bench.machine.commanded = (bench.machine.q.array() + 1e-3).matrix();
  bench.cycle();
  bench.machine.commanded.resize(0);
  bench.cycles(20);
  EXPECT_EQ(bench.measured.state, State::kCommand) << bench.news;
  EXPECT_EQ(bench.controller.fallbacks(), 0u) << bench.news;
  EXPECT_NEAR(bench.controller.at(bench.now).q[0], 0.101, 1e-6);
}

TEST(FriController, TheOffsetCarriesTheCommandAndTheSumIsContinuous) {
  ControllerBench bench;
  bench.start();
  const Joints before = bench.measured.q_before;
  Joints sum = before + bench.measured.q_offset;
  for (int i = 0; i < 200; ++i) {
    bench.command.q = before + Joints::Constant(0.05 * (1.0 - std::cos(0.01 * i * std::acos(0.0))));
    bench.cycle();
    EXPECT_EQ(bench.measured.q_before, before) << "constant, or a client that adds to it runs away";
    EXPECT_LE((bench.measured.q_before + bench.measured.q_offset - sum).cwiseAbs().maxCoeff(), 0.0012);
    sum = bench.measured.q_before + bench.measured.q_offset;
  }
  EXPECT_GT(sum[0], 0.19);
  bench.cycles(3);
  bench.free = false;
  bench.ask(State::kMonitor);
  for (int i = 0; i < 400; ++i) {
    bench.cycle();
    const Joints next = bench.measured.q_before + bench.measured.q_offset;
    EXPECT_LE((next - sum).cwiseAbs().maxCoeff(), 0.0012);
    sum = next;
  }
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_NEAR(bench.measured.q_offset.norm(), 0.0, 1e-7);
  EXPECT_EQ(bench.controller.fallbacks(), 0u);
}

TEST(FriController, AStartWithAnotherPositionIsAnInterpolationError) {
  ControllerBench bench;
  bench.command.flags = kPositionFlags;
  bench.cycles(150);
  bench.free = true;
  bench.command.q = Joints::Constant(0.15);
  bench.ask(State::kCommand);
  bench.cycles(200);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_THAT(bench.news, HasSubstr("FRI interpolation error: joint 1 commanded 0.0500 rad off"));
  EXPECT_NEAR(bench.machine.q[0], 0.1, 1e-7) << "nothing moved";
}

struct BadCommand {
  const char* name;
  void (*spoil)(Command& command);
  const char* message;
};
void PrintTo(const BadCommand& bad, std::ostream* out) { *out << bad.name; }

class FriFallback : public testing::TestWithParam<BadCommand> {};

TEST_P(FriFallback, ABadCommandEndsCommandStateAndTheArmStops) {
  ControllerBench bench;
  bench.start();
  bench.cycles(10);
  GetParam().spoil(bench.command);
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_EQ(bench.measured.power, 0);
  EXPECT_EQ(bench.controller.fallbacks(), 1u);
  EXPECT_THAT(bench.news, HasSubstr(GetParam().message));
  bench.command.q = Joints::Constant(0.1);
  bench.cycles(500);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "nothing restarts by itself";
  EXPECT_NEAR(bench.machine.q[0], 0.1, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    All, FriFallback,
    testing::Values(
        BadCommand{"NotANumber", [](Command& c) { c.q[3] = std::numeric_limits<double>::quiet_NaN(); }, "not finite"},
        BadCommand{"Infinite", [](Command& c) { c.q[6] = std::numeric_limits<double>::infinity(); }, "not finite"},
        BadCommand{"Step", [](Command& c) { c.q[2] += 0.01; }, "joint a3: 10.000 rad/s beyond"},
        BadCommand{"Kink", [](Command& c) { c.q[2] += 0.0001; }, "joint a3: 100.0 rad/s^2 beyond 27.9"},
        BadCommand{"Range", [](Command& c) { c.q[1] = 3.1; }, "joint a2: 3.1000 rad is out of range"},
        BadCommand{"NoFlags", [](Command& c) { c.flags = 0; }, "no position is commanded"}),
    [](const auto& tested) { return tested.param.name; });

TEST(FriController, CommandsMayAccelerateAsTheFileOfTheControllerAllows) {
  constexpr std::array<double, kJoints> kDegrees{1200.0, 1200.0, 1600.0, 1600.0, 2500.0, 4400.0, 4400.0};
  for (int joint = 0; joint < kJoints; ++joint) {
    for (const double share : {0.99, 1.01}) {
      ControllerBench bench;
      bench.start();
      const double step = share * kDegrees.at(static_cast<std::size_t>(joint)) * std::numbers::pi / 180.0 * 1e-6;
      for (int i = 0; i < 20; ++i) {
        bench.command.q[joint] += step;
        bench.cycle();
      }
      EXPECT_EQ(bench.controller.state(), share < 1.0 ? State::kCommand : State::kMonitor) << joint << bench.news;
    }
  }
}

/// A client that goes on by a step with each message that it sees is late by a step for each that it misses.
TEST(FriController, AClientThatCountsItsMessagesMayMissSome) {
  for (const int gap : {1, 2, 5}) {
    ControllerBench bench({.cycle = kMillisecond}, lwr());
    bench.start();
    const Joints begin = bench.command.q;
    for (int cycle = 0, answer = 0; cycle < 3000; ++cycle) {
      bench.answers = cycle % 97 >= gap;
      if (bench.answers) ++answer;
      const double x = 0.3 * std::sin(1e-3 * answer);
      bench.command.q = begin + Joints::Constant(x * x);  // at most 0.09 rad/s
      bench.cycle();
    }
    EXPECT_EQ(bench.controller.state(), State::kCommand) << gap << " in a row: " << bench.news;
    EXPECT_NEAR(bench.machine.q[0], bench.command.q[0], 1e-3);
  }
}

TEST(FriController, OldForeignAndRepeatedAnswersCountForNothing) {
  ControllerBench bench;
  bench.start();
  const Command good = bench.command;
  const auto forged = [&](std::uint16_t reflected) {
    Command command = good;
    command.reflected = reflected;
    command.q.setConstant(2.0);
    bench.controller.take(command, bench.now);
  };
  for (int i = 0; i < 100; ++i) {
    bench.cycle();
    for (const int age : {0, 2, 5, 100, -1, -7, 30'000})
      forged(static_cast<std::uint16_t>(bench.measured.sequence - age));
  }
  EXPECT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  EXPECT_EQ(bench.controller.stale(), 700u);
}

TEST(FriController, DrivesThatAreLostEndCommandState) {
  ControllerBench bench;
  bench.start();
  bench.machine.ready = false;
  bench.machine.fault = 3;
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kMonitor);
  EXPECT_EQ(bench.measured.power, 0);
  EXPECT_EQ(bench.measured.error, 1);
  EXPECT_THAT(bench.news, HasSubstr("drives are off"));
}

TEST(FriController, JointImpedanceTakesWhatIsFlaggedAndKrlsDefaultsElse) {
  ControllerBench bench;
  bench.start(Control::kJointImpedance, kJointPosition | kJointStiffness);
  bench.command.stiffness.setConstant(300.0);
  bench.command.damping.setConstant(0.2);
  bench.cycles(2);
  EXPECT_EQ(bench.controller.mode(), device::ControlMode::kJointImpedance);
  EXPECT_EQ(bench.controller.compliance().stiffness[4], 300.0);
  EXPECT_EQ(bench.controller.compliance().damping_ratio[4], 0.7) << "not flagged";
  bench.command.flags |= kJointDamping | kJointTorque;
  bench.command.tau[6] = 5.0;
  bench.cycles(2);
  EXPECT_EQ(bench.controller.compliance().damping_ratio[4], 0.2);
  EXPECT_EQ(bench.controller.compliance().feed_forward[6], 5.0);
  EXPECT_EQ(bench.measured.control, Control::kJointImpedance);
  bench.command.damping.setZero();
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kCommand) << "as clients that command torques do";
  EXPECT_EQ(bench.controller.compliance().damping_ratio[4], bench.arm->impedance.joint.lower.damping_ratio[4]);
  bench.command.damping[0] = -0.1;
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "no damping is negative";
}

// Clients that command torques alone leave positions out, and what stands in the field is no position.
TEST(FriController, TorquesWithoutAPositionAreAddedWhereKrlHoldsTheArm) {
  ControllerBench bench;
  bench.free = true;
  bench.command.q.setConstant(std::numeric_limits<double>::quiet_NaN());
  bench.command.tau[6] = 2.0;
  bench.start(Control::kJointImpedance, kJointTorque);
  bench.cycles(500);
  EXPECT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  EXPECT_EQ(bench.controller.compliance().feed_forward[6], 2.0);
  EXPECT_NEAR(bench.controller.at(bench.now).q[0], 0.1, 1e-7);
  EXPECT_LE(bench.measured.q_offset.norm(), 1e-7);
}

TEST(FriController, WrenchesWithoutAPoseAreAddedWhereKrlHoldsTheArm) {
  ASSERT_TRUE(lwr());
  ControllerBench bench({}, lwr());
  bench.machine.q = lwr()->home;
  bench.free = true;
  bench.command.wrench.force.z() = 3.0;
  bench.start(Control::kCartesianImpedance, kCartesianWrench);
  bench.cycles(500);
  EXPECT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  EXPECT_EQ(bench.controller.compliance().feed_forward[2], 3.0);
  EXPECT_LE((bench.controller.at(bench.now).q - lwr()->home).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(FriController, APostureWithoutAPoseMovesTheElbowAndHoldsTheTool) {
  ASSERT_TRUE(lwr());
  ControllerBench bench({}, lwr());
  bench.machine.q = lwr()->home;
  const Eigen::Isometry3d X_BF = lwr()->chain->forward(lwr()->home);
  bench.start(Control::kCartesianImpedance, kJointPosition | kCartesianStiffness | kCartesianDamping);
  for (int i = 0; i < 400; ++i) {
    bench.command.q[2] += 1e-6 * std::min(i, 400 - i);
    bench.command.cartesian_stiffness << 1000.0, 1000.0, 1000.0, 100.0, 100.0, 100.0;
    bench.command.cartesian_damping.setConstant(0.7);
    bench.cycle();
    ASSERT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  }
  bench.cycles(3);
  const device::JointVector q = bench.controller.at(bench.now).q;
  EXPECT_NEAR(q[2], lwr()->home[2] + 0.04, 1e-5);
  EXPECT_LE((lwr()->chain->forward(q).translation() - X_BF.translation()).norm(), 1e-6);
}

TEST(FriController, APositionIsCommandedInPositionModeOrItDoesNotStart) {
  ControllerBench bench;
  bench.command.flags = kJointTorque;
  bench.cycles(150);
  bench.ask(State::kCommand);
  bench.cycles(100);
  EXPECT_EQ(bench.controller.state(), State::kMonitor);
  EXPECT_THAT(bench.news, HasSubstr("FRI interpolation error: no position is commanded"));
}

// Clients that want torques, or an arm that a hand guides, command the position that was measured. What pushes the arm
// accelerates it as hard as it likes: here with 45 rad/s^2, where commands in position may have 20.9.
TEST(FriController, AnArmThatIsPushedMayBeToldToBeWhereItWasMeasured) {
  ControllerBench bench;
  bench.command.damping.setConstant(0.7);
  bench.start(Control::kJointImpedance, kJointImpedanceFlags);
  const double from = to_seconds(bench.now);
  bench.pushed = [from](double now) { return 0.1 + 0.005 * (1.0 - std::cos(95.0 * (now - from))); };
  for (int i = 0; i < 400; ++i) {
    bench.command.q = bench.measured.q;
    bench.cycle();
    ASSERT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  }
  bench.pushed = [](double now) { return 0.1 + 0.05 * (now - std::floor(now / 0.02) * 0.02) / 0.02; };
  for (int i = 0; i < 40; ++i) {
    bench.command.q = bench.measured.q;
    bench.cycle();
  }
  EXPECT_EQ(bench.controller.state(), State::kMonitor) << "speeds are observed in every mode";
  EXPECT_THAT(bench.news, HasSubstr("rad/s beyond"));
}

TEST(FriController, AStiffnessBeyondWhatTheDeviceAllowsEndsCommandState) {
  ControllerBench bench;
  bench.start(Control::kJointImpedance, kJointPosition | kJointStiffness);
  bench.command.stiffness.setConstant(300.0);
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kCommand);
  bench.command.stiffness[0] = 2500.0;
  bench.cycles(2);
  EXPECT_EQ(bench.measured.state, State::kMonitor) << "beyond what the device allows";
}

TEST(FriController, ACartesianCommandIsFollowedByTheJointsOnTheirBranch) {
  ASSERT_TRUE(lwr());
  ControllerBench bench({}, lwr());
  bench.machine.q = lwr()->home;
  bench.command.X_BT = lwr()->chain->forward(lwr()->home);
  bench.start(Control::kCartesianImpedance, kCartesianPosition);
  Eigen::Isometry3d X_BT = bench.command.X_BT;
  for (int i = 0; i < 300; ++i) {
    X_BT.translation().x() += 1e-6 * std::min(i, 300 - i);
    bench.command.X_BT = X_BT;
    bench.cycle();
    ASSERT_EQ(bench.controller.state(), State::kCommand) << bench.news;
  }
  bench.cycles(3);
  const Eigen::Isometry3d reached = lwr()->chain->forward(bench.controller.at(bench.now).q);
  EXPECT_LE((reached.translation() - X_BT.translation()).norm(), 1e-6);
  EXPECT_LE((bench.measured.X_BT.translation() - X_BT.translation()).norm(), 1e-6);
  EXPECT_EQ(bench.controller.mode(), device::ControlMode::kCartesianImpedance);
  bench.command.X_BT.translation().x() += 5.0;
  bench.cycles(2);
  EXPECT_THAT(bench.news, HasSubstr("cannot be reached"));
}

TEST(FriController, WhatItSaysOfTheArmIsThatOfTheModel) {
  ASSERT_TRUE(lwr());
  ControllerBench bench({.task_frame_is_tool = false}, lwr());
  bench.machine.q = lwr()->home;
  bench.machine.tau_external = device::JointVector::Zero(kJoints);
  bench.cycles(1);
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  lwr()->chain->jacobian(lwr()->home, X_BF, J);
  EXPECT_LE((bench.measured.jacobian - J).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((bench.measured.mass - lwr()->chain->mass_matrix(lwr()->home)).cwiseAbs().maxCoeff(), 1e-12);
  // A force at the flange is found again from the torques that it makes.
  kinematics::Vector6 force;
  force << 3.0, -4.0, 5.0, 0.1, 0.2, -0.3;
  bench.machine.tau_external = J.transpose() * force;
  bench.cycles(1);
  EXPECT_LE((bench.measured.wrench_external.force - force.head<3>()).norm(), 1e-4);
  EXPECT_LE((bench.measured.wrench_external.torque - force.tail<3>()).norm(), 1e-4);
}

}  // namespace
}  // namespace takt::hw::fri
