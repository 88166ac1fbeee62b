// The emulated gripper as a strict one: what each command answers, over a raw connection.
#include "hw/emulators/wsg/emulator.h"

#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "hw/wire/virtual_network.h"
#include "tests/support/fake_signals.h"
#include "tests/support/kinematic_gripper.h"

namespace takt::hw::wsg::emulator_test {
namespace {

struct Raw {
  explicit Raw(double part = 0.0, EmulatorOptions options = {}) {
    auto described = test::fake_gripper_description();
    described.acceleration = 5.0;
    description = std::make_shared<const device::GripperDescription>(described);
    machine = std::make_shared<test::KinematicGripper>(0.11, part);
    emulator = std::make_unique<Emulator>(options, description, network, machine);
    EXPECT_TRUE(emulator->listen({kLoopback, kPort}));
    EXPECT_TRUE(link.connect(network, {kLoopback, kPort}));
    live(5);
  }
  void live(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      clock.set(++k * kMillisecond);
      machine->advance();
      emulator->advance(clock.now());
      link.receive([this](std::string_view bytes) { parser.feed(bytes); });
      while (const auto packet = parser.next()) answers.push_back(*packet);
    }
  }
  /// The statuses that a command gets within so many cycles.
  std::vector<Status> ask(std::uint8_t command, std::string_view payload, int cycles = 3) {
    answers.clear();
    std::string packet;
    append_packet(packet, command, payload);
    link.send(packet);
    live(cycles);
    std::vector<Status> statuses;
    for (const Packet& one : answers)
      if (one.command == command) statuses.push_back(parse_answer(one.payload)->status);
    return statuses;
  }
  std::vector<Status> ask(Command command, std::string_view payload, int cycles = 3) {
    return ask(static_cast<std::uint8_t>(command), payload, cycles);
  }
  std::string parameters() { return std::string(parse_answer(answers.back().payload)->parameters); }

  VirtualClock clock;
  VirtualNetwork network{clock, 1};
  std::shared_ptr<const device::GripperDescription> description;
  std::shared_ptr<test::KinematicGripper> machine;
  std::unique_ptr<Emulator> emulator;
  ByteLink link;
  PacketParser parser;
  std::vector<Packet> answers;
  std::int64_t k = 0;
};

using Statuses = std::vector<Status>;
constexpr Status kOk = Status::kSuccess;

std::string move_to(double width) { return motion_payload(Command::kMove, {.width = width, .speed = 0.4}); }

TEST(WsgEmulator, WrongPacketsAreRefusedEachInItsWay) {
  Raw raw;
  EXPECT_EQ(raw.ask(0x90, ""), Statuses{Status::kUnknownCommand});
  EXPECT_EQ(raw.ask(0x42, std::string(3, '\0')), Statuses{Status::kUnknownCommand});
  EXPECT_EQ(raw.ask(Command::kMove, "short"), Statuses{Status::kFormatError});
  EXPECT_EQ(raw.ask(Command::kHome, ""), Statuses{Status::kFormatError});
  EXPECT_EQ(raw.ask(Command::kSetForce, "long, too"), Statuses{Status::kFormatError});
  EXPECT_EQ(raw.ask(Command::kWidth, "1"), Statuses{Status::kFormatError});
  EXPECT_EQ(raw.ask(Command::kAcknowledge, "yes"), Statuses{Status::kFormatError});
  EXPECT_EQ(raw.ask(Command::kStop, "now"), Statuses{Status::kNoParameterExpected});
  EXPECT_EQ(raw.ask(Command::kLimits, "?"), Statuses{Status::kNoParameterExpected});
  EXPECT_EQ(raw.ask(Command::kTare, ""), Statuses{Status::kNotAvailable});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(raw.ask(Command::kMove, move_to(nan)), Statuses{Status::kInvalidParameter});
  EXPECT_EQ(raw.ask(Command::kSetForce, number_payload(Command::kSetForce, nan)), Statuses{Status::kInvalidParameter});
  std::string packet;
  append_packet(packet, 0x43, std::string(3, '\0'));
  packet.back() = static_cast<char>(packet.back() ^ 1);
  raw.answers.clear();
  raw.link.send(packet);
  raw.live(3);
  ASSERT_FALSE(raw.answers.empty());
  EXPECT_EQ(parse_answer(raw.answers[0].payload)->status, Status::kChecksumError);
  EXPECT_EQ(raw.machine->command().sequence, 0u);
}

TEST(WsgEmulator, SettingsAreClampedAndRead) {
  Raw raw;
  EXPECT_EQ(raw.ask(Command::kSetForce, number_payload(Command::kSetForce, 500.0)), Statuses{kOk});
  EXPECT_EQ(raw.ask(Command::kGetForce, ""), Statuses{kOk});
  EXPECT_EQ(parse_number(Command::kGetForce, raw.parameters()), 80.0);
  EXPECT_EQ(raw.ask(Command::kSetAcceleration, number_payload(Command::kSetAcceleration, 2.0)), Statuses{kOk});
  EXPECT_EQ(raw.ask(Command::kGetAcceleration, ""), Statuses{kOk});
  EXPECT_EQ(parse_number(Command::kGetAcceleration, raw.parameters()), 2.0);
  EXPECT_EQ(raw.ask(Command::kLimits, ""), Statuses{kOk});
  EXPECT_NEAR(parse_limits(raw.parameters())->speed_max, 0.42, 1e-6);
  EXPECT_EQ(raw.ask(Command::kSystemInfo, ""), Statuses{kOk});
  EXPECT_EQ(raw.parameters().size(), 8u);
  EXPECT_EQ(raw.ask(Command::kLoop, "hello"), Statuses{kOk});
  EXPECT_EQ(raw.parameters(), "hello");
}

TEST(WsgEmulator, AMotionIsPendingAndThenDoneAndAnotherIsRefusedMeanwhile) {
  Raw raw;
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.05)), Statuses{Status::kPending});
  EXPECT_TRUE(raw.emulator->flags() & kMoving);
  EXPECT_EQ(raw.emulator->grasp_state(), GraspState::kPositioning);
  EXPECT_EQ(raw.ask(Command::kGrasp, motion_payload(Command::kGrasp, {})), Statuses{Status::kAlreadyRunning});
  raw.answers.clear();
  raw.live(400);
  ASSERT_EQ(raw.answers.size(), 1u);
  EXPECT_EQ(parse_answer(raw.answers[0].payload)->status, kOk);
  EXPECT_EQ(raw.emulator->flags(), kReferenced | kTargetReached);
  EXPECT_NEAR(raw.machine->width(), 0.05, 1e-3);
  EXPECT_EQ(
      raw.ask(Command::kMove, motion_payload(Command::kMove, {.width = 0.02, .speed = 0.4, .relative = true}), 200),
      (Statuses{Status::kPending, kOk}));
  EXPECT_NEAR(raw.machine->width(), 0.07, 1e-3);
}

TEST(WsgEmulator, StopAbortsFastStopLocks) {
  Raw raw;
  (void)raw.ask(Command::kMove, move_to(0.0));
  EXPECT_EQ(raw.ask(Command::kStop, "", 10), (Statuses{Status::kPending, kOk}));
  EXPECT_EQ(parse_answer(raw.answers[0].payload)->status, Status::kAborted) << "the motion's own answer";
  EXPECT_GT(raw.machine->width(), 0.1);
  (void)raw.ask(Command::kMove, move_to(0.0));
  EXPECT_EQ(raw.ask(Command::kFastStop, ""), Statuses{kOk});
  EXPECT_TRUE(raw.emulator->flags() & kFastStopped);
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.0)), Statuses{Status::kAccessDenied});
  EXPECT_EQ(raw.ask(Command::kAcknowledge, "ack"), Statuses{kOk});
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.0)), Statuses{Status::kPending});
}

TEST(WsgEmulator, AGraspFindsAPartOrNone) {
  Raw none;
  EXPECT_EQ(none.ask(Command::kGrasp, motion_payload(Command::kGrasp, {.width = 0.03, .speed = 0.4}), 400),
            (Statuses{Status::kPending, Status::kFailed}));
  EXPECT_EQ(none.emulator->grasp_state(), GraspState::kNoPart);
  Raw some(0.04);
  EXPECT_EQ(some.ask(Command::kGrasp, motion_payload(Command::kGrasp, {.width = 0.03, .speed = 0.4}), 400),
            (Statuses{Status::kPending, kOk}));
  EXPECT_EQ(some.emulator->grasp_state(), GraspState::kHolding);
  some.machine->remove_part();
  some.live(20);
  EXPECT_EQ(some.emulator->grasp_state(), GraspState::kPartLost);
  EXPECT_EQ(some.ask(Command::kRelease, motion_payload(Command::kRelease, {.width = 0.1, .speed = 0.4}), 400),
            (Statuses{Status::kPending, kOk}));
  EXPECT_EQ(some.emulator->grasp_state(), GraspState::kIdle);
}

TEST(WsgEmulator, AMoveThatMeetsSomethingIsBlocked) {
  Raw raw(0.04);
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.0), 400), (Statuses{Status::kPending, Status::kAxisBlocked}));
  EXPECT_TRUE(raw.emulator->flags() & kBlockedMinus);
  EXPECT_NEAR(raw.machine->width(), 0.04, 1e-9);
}

TEST(WsgEmulator, FingersThatAreNotReferencedMoveByHomingOnly) {
  Raw raw(0.0, {.referenced = false});
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.05)), Statuses{Status::kNotInitialized});
  EXPECT_EQ(raw.ask(Command::kHome, std::string_view("\0", 1), 400), (Statuses{Status::kPending, kOk}));
  EXPECT_EQ(raw.ask(Command::kMove, move_to(0.05)), Statuses{Status::kPending});
}

TEST(WsgEmulator, UpdatesComeInTheirPeriodOrOnChangeOnly) {
  Raw raw;
  (void)raw.ask(Command::kWidth, auto_update_payload({true, false, 10}));
  raw.answers.clear();
  raw.live(100);
  EXPECT_EQ(raw.answers.size(), 10u);
  (void)raw.ask(Command::kWidth, auto_update_payload({true, true, 10}));
  raw.live(20);
  raw.answers.clear();
  raw.live(100);
  EXPECT_TRUE(raw.answers.empty()) << "nothing changes";
  (void)raw.ask(Command::kMove, move_to(0.1));
  raw.live(20);
  EXPECT_FALSE(raw.answers.empty());
  (void)raw.ask(Command::kWidth, auto_update_payload({}));
  raw.live(100);
  raw.answers.clear();
  raw.live(100);
  EXPECT_TRUE(raw.answers.empty());
  EXPECT_EQ(raw.ask(Command::kTemperature, auto_update_payload({})), Statuses{kOk});
}

TEST(WsgEmulator, AClientThatGoesWithoutAWordLeavesAFastStopBehind) {
  Raw raw;
  raw.link.close();
  raw.live(3);
  EXPECT_TRUE(raw.emulator->flags() & kFastStopped);
  EXPECT_FALSE(raw.emulator->has_client());
  Raw polite;
  (void)polite.ask(Command::kDisconnect, "");
  polite.link.close();
  polite.live(3);
  EXPECT_FALSE(polite.emulator->flags() & kFastStopped);
}

TEST(WsgEmulator, ASecondClientIsTurnedAway) {
  Raw raw;
  ByteLink second;
  ASSERT_TRUE(second.connect(raw.network, {kLoopback, kPort}));
  raw.live(5);
  EXPECT_FALSE(second.open());
  EXPECT_EQ(raw.ask(Command::kLoop, "still there"), Statuses{kOk});
  const auto news = raw.emulator->news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_NE(news[0].find("second"), std::string::npos);
}

}  // namespace
}  // namespace takt::hw::wsg::emulator_test
