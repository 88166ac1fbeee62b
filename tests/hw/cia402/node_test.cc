// An emulated node is strict: what a real one refuses, it refuses.
#include "hw/emulators/cia402/node.h"

#include <vector>

#include <gtest/gtest.h>

namespace takt::hw::cia402 {
namespace {

using Kind = SdoMessage::Kind;

class Cia402Node : public testing::Test {
 protected:
  Cia402Node() {
    node.set_measurable(true);
    node.drive().measure({}, 0.0, true);
    node.pass(0);
  }
  SdoMessage ask(const SdoMessage& request) {
    sent.clear();
    node.take(sdo_frame(kSdoRequestId | 5, request), now);
    if (sent.size() != 1) return {};
    return sdo_answer(sent.front()).value_or(SdoMessage{});
  }
  SdoMessage read(const ObjectId& id) { return ask({.kind = Kind::kRead, .id = id}); }
  /// 0: it was written, else why not.
  std::uint32_t write(const ObjectId& id, std::uint8_t size, std::uint32_t value) {
    const SdoMessage answer = ask({Kind::kWrite, id, size, value});
    return answer.kind == Kind::kWriteAnswer ? 0 : answer.value;
  }
  static std::uint32_t code(SdoAbort abort) { return static_cast<std::uint32_t>(abort); }
  /// Process data as a master sets them up.
  void map() {
    std::uint8_t sub = 0;
    for (const MappedObject& object : kOutputs1) ASSERT_EQ(write({0x1600, ++sub}, 4, object.word()), 0u);
    ASSERT_EQ(write({0x1600, 0}, 1, sub), 0u);
    ASSERT_EQ(write({0x1400, 1}, 4, kOutputs1Id | 5), 0u);
    ASSERT_EQ(write({0x1601, 1}, 4, kOutputs2[0].word()), 0u);
    ASSERT_EQ(write({0x1601, 0}, 1, 1), 0u);
    ASSERT_EQ(write({0x1401, 1}, 4, kOutputs2Id | 5), 0u);
    sub = 0;
    for (const MappedObject& object : kInputs1) ASSERT_EQ(write({0x1A00, ++sub}, 4, object.word()), 0u);
    ASSERT_EQ(write({0x1A00, 0}, 1, sub), 0u);
    ASSERT_EQ(write({0x1800, 1}, 4, kInputs1Id | 5), 0u);
    ASSERT_EQ(write(kMode, 1, 8), 0u);
    node.take(nmt_frame(NmtCommand::kStart, 5), now);
  }
  void outputs(std::uint16_t control, std::uint8_t size = 7) {
    CanFrame first{.id = kOutputs1Id | 5, .size = size}, second{.id = kOutputs2Id | 5, .size = 4};
    put(control, 2, first.data, 0);
    put(8, 1, first.data, 6);
    node.take(first, now);
    node.take(second, now);
  }
  DriveState cycle(std::uint16_t control) {
    outputs(control);
    now += 4 * kMillisecond;
    sent.clear();
    node.take(sync_frame(), now);
    return node.drive().state();
  }
  void enable() {
    map();
    for (const std::uint16_t word : {0x06, 0x07, 0x0F}) (void)cycle(word);
    ASSERT_EQ(node.drive().state(), DriveState::kOperationEnabled);
  }

  std::vector<CanFrame> sent;
  Nanoseconds now = 0;
  Node node{5, {}, [this](const CanFrame& frame) { sent.push_back(frame); }};
};

TEST_F(Cia402Node, SaysThatItHasStarted) {
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0], heartbeat_frame(5, NmtState::kBootUp));
}

TEST_F(Cia402Node, AnswersWhatItIsAskedAndNothingElse) {
  EXPECT_EQ(read(kDeviceType).value & 0xFFFF, 402u);
  EXPECT_EQ(read(kModeDisplay).size, 1);
  EXPECT_EQ(read({0x2000, 0}).value, code(SdoAbort::kNoObject));
  EXPECT_EQ(read({0x1016, 9}).value, code(SdoAbort::kNoSubindex));
  sent.clear();
  node.take(sdo_frame(kSdoRequestId | 6, {}), now);
  EXPECT_TRUE(sent.empty()) << "for another node";
  CanFrame segmented{.id = kSdoRequestId | 5, .size = 8};
  put(0x21, 1, segmented.data, 0);
  node.take(segmented, now);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sdo_answer(sent[0])->value, code(SdoAbort::kUnknownCommand));
}

TEST_F(Cia402Node, TellsWhereItIsBeforeAnyProcessDataRun) {
  node.drive().measure({.q = 0.5}, 0.0, true);
  EXPECT_NEAR(static_cast<std::int32_t>(read(kPosition).value), 0.5 * 100.0 * (1u << 20) / (2.0 * 3.14159265358979),
              1.0);
}

TEST_F(Cia402Node, RefusesWhatIsNotWrittenLikeThat) {
  EXPECT_EQ(write(kStatusWord, 2, 1), code(SdoAbort::kNotWritable));
  EXPECT_EQ(write(kDeviceType, 4, 1), code(SdoAbort::kNotWritable));
  EXPECT_EQ(write(kMode, 2, 8), code(SdoAbort::kWrongLength));
  EXPECT_EQ(write(kMode, 1, 9), code(SdoAbort::kOutOfRange));
  EXPECT_EQ(write(kCycleExponent, 1, 0xFA), code(SdoAbort::kOutOfRange)) << "microseconds";
  EXPECT_EQ(write(kCycleExponent, 1, 0xFD), 0u);
  EXPECT_EQ(write({0x2000, 0}, 1, 0), code(SdoAbort::kNoObject));
}

TEST_F(Cia402Node, MapsOnlyWhatCanBeMappedWhileTheMessageIsEmpty) {
  EXPECT_EQ(write({0x1600, 1}, 4, 0x10000020), code(SdoAbort::kNotMappable)) << "the device type";
  EXPECT_EQ(write({0x1600, 1}, 4, kStatusWord.index << 16 | 16), code(SdoAbort::kNotMappable)) << "an input";
  EXPECT_EQ(write({0x1600, 1}, 4, kControlWord.index << 16 | 8), code(SdoAbort::kNotMappable)) << "half of it";
  EXPECT_EQ(write({0x1600, 1}, 4, 0x20000010), code(SdoAbort::kNoObject));
  for (std::uint8_t sub = 1; sub <= 3; ++sub) EXPECT_EQ(write({0x1600, sub}, 4, kOutputs1[1].word()), 0u);
  EXPECT_EQ(write({0x1600, 0}, 1, 3), code(SdoAbort::kTooLongForPdo));
  EXPECT_EQ(write({0x1600, 0}, 1, 2), 0u);
  EXPECT_EQ(write({0x1600, 1}, 4, kOutputs1[0].word()), code(SdoAbort::kWrongState));
  node.take(nmt_frame(NmtCommand::kStart, 0), now);
  EXPECT_EQ(write({0x1600, 0}, 1, 0), code(SdoAbort::kWrongState)) << "in operation";
  EXPECT_EQ(write({0x1400, 1}, 4, kOutputs1Id | 5), code(SdoAbort::kWrongState));
}

TEST_F(Cia402Node, GoesThroughTheStatesAndReportsThem) {
  map();
  EXPECT_EQ(cycle(0x06), DriveState::kReadyToSwitchOn);
  ASSERT_EQ(sent.size(), 1u) << "only one message of inputs is mapped";
  EXPECT_EQ(state_of(static_cast<std::uint16_t>(get(sent[0].data, 0, 2))), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(cycle(0x07), DriveState::kSwitchedOn);
  EXPECT_EQ(cycle(0x0F), DriveState::kOperationEnabled);
  EXPECT_NE(get(sent[0].data, 0, 2) & kFollowsTarget, 0u);
  EXPECT_EQ(cycle(0x02), DriveState::kQuickStopActive);
  EXPECT_EQ(cycle(0x02), DriveState::kSwitchOnDisabled) << "it stood";
}

TEST_F(Cia402Node, AShortMessageIsNone) {
  enable();
  for (int i = 0; i < 10; ++i) {
    outputs(0x0F, 5);
    now += 4 * kMillisecond;
    node.take(sync_frame(), now);
  }
  EXPECT_EQ(node.objects().value(kErrorCode), kErrorOutputsMissing);
}

// The target comes from the message that maps 607Ah, whichever it is; the other need not exist.
class Cia402Target : public Cia402Node, public testing::WithParamInterface<std::uint16_t> {};

TEST_P(Cia402Target, OneMessageOfOutputsIsEnough) {
  const std::uint16_t number = GetParam();
  const auto mapping = static_cast<std::uint16_t>(0x1600 + number),
             parameters = static_cast<std::uint16_t>(0x1400 + number);
  constexpr std::uint32_t kNoRemoteFrames = 1u << 30;  // as python's canopen writes it
  const std::uint32_t id = number == 0 ? kOutputs1Id | 5 : kOutputs2Id | 5;
  ASSERT_EQ(write({mapping, 1}, 4, kOutputs1[0].word()), 0u);
  ASSERT_EQ(write({mapping, 2}, 4, kOutputs1[1].word()), 0u);
  ASSERT_EQ(write({mapping, 0}, 1, 2), 0u);
  ASSERT_EQ(write({parameters, 1}, 4, id | kNoRemoteFrames), 0u);
  ASSERT_EQ(write(kMode, 1, 8), 0u);
  node.take(nmt_frame(NmtCommand::kStart, 5), now);
  const auto cycle_with = [&](std::uint16_t control, std::uint32_t target) {
    CanFrame frame{.id = id, .size = 6};
    put(control, 2, frame.data, 0);
    put(target, 4, frame.data, 2);
    node.take(frame, now);
    now += 4 * kMillisecond;
    node.take(sync_frame(), now);
  };
  for (const std::uint16_t word : {0x06, 0x07, 0x0F}) cycle_with(word, 0);
  constexpr std::uint32_t kStep = 10000;  // increments a cycle: 0.15 rad/s
  for (std::uint32_t i = 1; i <= 50; ++i) cycle_with(0x0F, i * kStep);
  EXPECT_EQ(node.drive().state(), DriveState::kOperationEnabled);
  EXPECT_EQ(node.objects().value(kErrorCode), 0u);
  const double target = 50.0 * kStep * 2.0 * 3.14159265358979 / (100.0 * (1u << 20));
  EXPECT_NEAR(node.drive().at(now + 4 * kMillisecond).q, target, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Messages, Cia402Target, testing::Values(std::uint16_t{0}, std::uint16_t{1}));

TEST_F(Cia402Node, IdentifiersOfInputsAreThoseOfTheBus) {
  map();
  node.take(nmt_frame(NmtCommand::kEnterPreOperational, 5), now);
  ASSERT_EQ(write({0x1800, 1}, 4, 1u << 30 | kInputs1Id | 5), 0u);
  node.take(nmt_frame(NmtCommand::kStart, 5), now);
  (void)cycle(0x06);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].id, kInputs1Id | 5);
}

TEST_F(Cia402Node, ResetOfCommunicationForgetsTheProcessDataAndKeepsTheDrive) {
  enable();
  ASSERT_EQ(write(kQuickStopRamp, 4, 12345), 0u);
  sent.clear();
  node.take(nmt_frame(NmtCommand::kResetCommunication, 5), now);
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(sent[0], heartbeat_frame(5, NmtState::kBootUp));
  EXPECT_EQ(node.state(), NmtState::kPreOperational);
  EXPECT_NE(node.drive().state(), DriveState::kOperationEnabled);
  EXPECT_EQ(read({0x1600, 0}).value, 0u);
  EXPECT_EQ(read(kQuickStopRamp).value, 12345u);
}

TEST_F(Cia402Node, MissesItsMaster) {
  enable();
  ASSERT_EQ(write(kConsumedHeartbeat, 4, 127u << 16 | 20), 0u);
  node.take(heartbeat_frame(kMasterNode, NmtState::kOperational), now);
  for (int i = 0; i < 5; ++i) (void)cycle(0x0F);
  EXPECT_EQ(node.drive().state(), DriveState::kOperationEnabled) << "20 ms";
  (void)cycle(0x0F);
  node.pass(now);
  EXPECT_EQ(node.objects().value(kErrorCode), kErrorHeartbeat);
  EXPECT_EQ(node.state(), NmtState::kPreOperational);
}

TEST_F(Cia402Node, LeavingOperationIsAFaultOfADriveThatIsLed) {
  enable();
  node.take(nmt_frame(NmtCommand::kStop, 5), now);
  EXPECT_EQ(node.state(), NmtState::kStopped);
  EXPECT_NE(node.drive().state(), DriveState::kOperationEnabled);
  sent.clear();
  node.take(sdo_frame(kSdoRequestId | 5, {}), now);
  EXPECT_TRUE(sent.empty()) << "a stopped node has no service data";
}

TEST_F(Cia402Node, FaultsAreReportedAndTakenBack) {
  enable();
  node.drive().fail(0x4310, now);
  sent.clear();
  node.pass(now);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(emergency_code(sent[0]), 0x4310);
  EXPECT_EQ(read(kErrorRegister).value, 1u);
  (void)cycle(0x0F);
  EXPECT_EQ(node.drive().state(), DriveState::kFault);
  (void)cycle(0x00);
  (void)cycle(0x80);
  EXPECT_EQ(node.drive().state(), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(emergency_code(sent[0]), 0);
  EXPECT_EQ(read(kErrorCode).value, 0u);
}

TEST_F(Cia402Node, ProducesHeartbeatsAtTheRateThatItIsTold) {
  ASSERT_EQ(write(kProducedHeartbeat, 2, 100), 0u);
  sent.clear();
  for (; now < kSecond; now += kMillisecond) node.pass(now);
  EXPECT_EQ(sent.size(), 10u);
}

}  // namespace
}  // namespace takt::hw::cia402
