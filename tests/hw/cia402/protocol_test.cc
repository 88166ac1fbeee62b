// The state machine of CiA 402 and the messages of CANopen, against the numbers of the standards.
#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "hw/cia402/protocol/canopen.h"
#include "hw/cia402/protocol/drive_state.h"

namespace takt::hw::cia402 {
namespace {

using State = DriveState;

constexpr std::array<State, 8> kAllStates{
    State::kNotReadyToSwitchOn, State::kSwitchOnDisabled, State::kReadyToSwitchOn,     State::kSwitchedOn,
    State::kOperationEnabled,   State::kQuickStopActive,  State::kFaultReactionActive, State::kFault};

TEST(Cia402State, StatusWordsAsDrivesSendThem) {
  // Words seen on buses: with voltage, remote, warnings and target bits set.
  EXPECT_EQ(state_of(0x0250), State::kSwitchOnDisabled);
  EXPECT_EQ(state_of(0x0670), State::kSwitchOnDisabled);
  EXPECT_EQ(state_of(0x0231), State::kReadyToSwitchOn);
  EXPECT_EQ(state_of(0x0233), State::kSwitchedOn);
  EXPECT_EQ(state_of(0x1637), State::kOperationEnabled);
  EXPECT_EQ(state_of(0x0217), State::kQuickStopActive);
  EXPECT_EQ(state_of(0x021F), State::kFaultReactionActive);
  EXPECT_EQ(state_of(0x0218), State::kFault);
  EXPECT_EQ(state_of(0x0238), State::kFault);
  EXPECT_EQ(state_of(0x0000), State::kNotReadyToSwitchOn);
}

TEST(Cia402State, EveryStateComesBackFromItsWordWhateverTheOtherBits) {
  for (const State state : kAllStates) {
    for (const std::uint16_t others : {0x0000, 0x0010, 0x0290, 0x1200, 0xFE90})
      EXPECT_EQ(state_of(static_cast<std::uint16_t>(status_of(state) | others)), state) << name_of(state);
  }
}

TEST(Cia402State, AWordThatNoStateHasIsNotReady) {
  for (const std::uint16_t word : {0x0001, 0x0022, 0x0060 | 0x0001, 0x004F, 0x0009})
    EXPECT_EQ(state_of(word), State::kNotReadyToSwitchOn) << word;
}

TEST(Cia402State, TransitionsOfTheStandard) {
  EXPECT_EQ(next_state(State::kSwitchOnDisabled, 0x06, 0), State::kReadyToSwitchOn);
  EXPECT_EQ(next_state(State::kReadyToSwitchOn, 0x07, 6), State::kSwitchedOn);
  EXPECT_EQ(next_state(State::kReadyToSwitchOn, 0x0F, 6), State::kSwitchedOn) << "one step at a time";
  EXPECT_EQ(next_state(State::kSwitchedOn, 0x0F, 7), State::kOperationEnabled);
  EXPECT_EQ(next_state(State::kOperationEnabled, 0x07, 15), State::kSwitchedOn);
  EXPECT_EQ(next_state(State::kOperationEnabled, 0x06, 15), State::kReadyToSwitchOn);
  EXPECT_EQ(next_state(State::kOperationEnabled, 0x02, 15), State::kQuickStopActive);
  EXPECT_EQ(next_state(State::kOperationEnabled, 0x00, 15), State::kSwitchOnDisabled);
  EXPECT_EQ(next_state(State::kQuickStopActive, 0x00, 2), State::kSwitchOnDisabled);
  EXPECT_EQ(next_state(State::kQuickStopActive, 0x0F, 2), State::kQuickStopActive) << "transition 16 is optional";
  EXPECT_EQ(next_state(State::kSwitchOnDisabled, 0x0F, 0), State::kSwitchOnDisabled) << "not in one leap";
}

TEST(Cia402State, AFaultIsResetByARisingEdgeOnly) {
  EXPECT_EQ(next_state(State::kFault, 0x80, 0x00), State::kSwitchOnDisabled);
  EXPECT_EQ(next_state(State::kFault, 0x80, 0x80), State::kFault);
  EXPECT_EQ(next_state(State::kFault, 0x0F, 0x00), State::kFault);
  EXPECT_EQ(next_state(State::kFaultReactionActive, 0x80, 0x00), State::kFaultReactionActive);
}

TEST(Cia402State, NoControlWordEnablesADriveThatWasNotSwitchedOn) {
  for (const State state : kAllStates) {
    if (state == State::kSwitchedOn || state == State::kOperationEnabled) continue;
    for (std::uint32_t word = 0; word <= 0xFFFF; ++word)
      ASSERT_NE(next_state(state, static_cast<std::uint16_t>(word), 0), State::kOperationEnabled) << word;
  }
}

TEST(Cia402State, AMasterThatWantsADriveOnGetsThereFromEveryState) {
  for (State state : {State::kSwitchOnDisabled, State::kReadyToSwitchOn, State::kSwitchedOn}) {
    for (int i = 0; i < 4; ++i) state = next_state(state, control_for(Wanted::kOn, state), 0);
    EXPECT_EQ(state, State::kOperationEnabled);
  }
  for (const State state : kAllStates) {
    EXPECT_EQ(control_for(Wanted::kOff, state), kDisableVoltage);
    const State after = next_state(state, control_for(Wanted::kQuickStop, state), 0);
    EXPECT_NE(after, State::kOperationEnabled) << name_of(state);
    EXPECT_EQ(control_for(Wanted::kOn, state) & kFaultReset, 0);
  }
}

std::vector<int> bytes_of(const CanFrame& frame) {
  std::vector<int> bytes;
  for (const std::byte byte : frame.payload()) bytes.push_back(std::to_integer<int>(byte));
  return bytes;
}
CanFrame raw(std::uint32_t id, const std::vector<int>& bytes) {
  CanFrame frame{.id = id, .size = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::transform(bytes, frame.data.begin(), [](int byte) { return static_cast<std::byte>(byte); });
  return frame;
}
using Bytes = std::vector<int>;
using Kind = SdoMessage::Kind;

TEST(Canopen, TransfersByteForByte) {
  const auto sent = [](Kind kind, ObjectId id, std::uint8_t size, std::uint32_t value) {
    return bytes_of(sdo_frame(kSdoRequestId | 5, {kind, id, size, value}));
  };
  EXPECT_EQ(sent(Kind::kRead, kStatusWord, 4, 0), (Bytes{0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));
  EXPECT_EQ(sent(Kind::kWrite, kMode, 1, 8), (Bytes{0x2F, 0x60, 0x60, 0, 8, 0, 0, 0}));
  EXPECT_EQ(sent(Kind::kWrite, kControlWord, 2, 0x0F), (Bytes{0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0}));
  EXPECT_EQ(sent(Kind::kWrite, {0x1600, 1}, 4, 0x60400010), (Bytes{0x23, 0, 0x16, 1, 0x10, 0, 0x40, 0x60}));
  EXPECT_EQ(sdo_frame(kSdoRequestId | 5, {}).id, 0x605u);
  const auto abort = sdo_answer(raw(0x585, {0x80, 0, 0x10, 2, 0, 0, 2, 6}));
  ASSERT_TRUE(abort);
  EXPECT_EQ(abort->kind, Kind::kAbort);
  EXPECT_EQ(abort->id, (ObjectId{0x1000, 2}));
  EXPECT_EQ(abort->value, 0x06020000u);
  const auto read = sdo_answer(raw(0x585, {0x4B, 0x41, 0x60, 0, 0x37, 0x16, 0xAA, 0xAA}));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->size, 2);
  EXPECT_EQ(read->value, 0x1637u) << "bytes beyond the size do not count";
}

TEST(Canopen, AnswersByteForByte) {
  const auto sent = [](Kind kind, ObjectId id, std::uint8_t size, std::uint32_t value) {
    return bytes_of(sdo_frame(kSdoAnswerId | 5, {kind, id, size, value}));
  };
  EXPECT_EQ(sent(Kind::kReadAnswer, kStatusWord, 2, 0x1637), (Bytes{0x4B, 0x41, 0x60, 0, 0x37, 0x16, 0, 0}));
  EXPECT_EQ(sent(Kind::kWriteAnswer, kMode, 1, 8), (Bytes{0x60, 0x60, 0x60, 0, 0, 0, 0, 0})) << "without the value";
  EXPECT_EQ(sent(Kind::kAbort, {0x1000, 2}, 1, 0x06020000), (Bytes{0x80, 0, 0x10, 2, 0, 0, 2, 6}))
      << "a code has four bytes, whatever the size";
  for (const Kind kind : {Kind::kReadAnswer, Kind::kWriteAnswer, Kind::kAbort}) {
    const auto back = sdo_answer(sdo_frame(kSdoAnswerId | 5, {kind, kMode, 1, 8}));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->kind, kind);
    EXPECT_EQ(back->id, kMode);
  }
}

TEST(Canopen, ASizeThatIsNotSaidIsFour) {
  const auto read = sdo_answer(raw(0x585, {0x42, 0x64, 0x60, 0, 1, 2, 3, 4}));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->size, 4);
  EXPECT_EQ(read->value, 0x04030201u);
}

TEST(Canopen, WhatIsNoExpeditedTransferIsNone) {
  EXPECT_FALSE(sdo_answer(raw(0x585, {0x41, 8, 0x10, 0, 20, 0, 0, 0}))) << "segmented";
  EXPECT_FALSE(sdo_request(raw(0x605, {0x40, 0x41, 0x60})));
  EXPECT_FALSE(sdo_request(raw(0x585, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(sdo_request(raw(0x605, {0xC0, 0x41, 0x60, 0, 0, 0, 0, 0})));
}

TEST(Canopen, EveryFrameIsReadOrRefusedInBounds) {
  for (std::uint32_t id = 0; id <= CanFrame::kMostId; ++id) {
    for (std::uint8_t size = 0; size <= 8; ++size) {
      for (const int first : {0x00, 0x22, 0x40, 0x43, 0x60, 0x80, 0xFF}) {
        CanFrame frame{.id = id, .size = size};
        frame.data[0] = static_cast<std::byte>(first);
        for (const auto& message : {sdo_request(frame), sdo_answer(frame)}) {
          if (!message) continue;
          EXPECT_EQ(size, 8);
          EXPECT_TRUE(message->size >= 1 && message->size <= 4);
        }
        EXPECT_EQ(heartbeat_state(frame).has_value(), id > 0x700 && id <= 0x77F && size == 1);
        EXPECT_EQ(emergency_code(frame).has_value(), id > 0x80 && id <= 0xFF && size == 8);
        EXPECT_EQ(nmt_command(frame, 5).has_value(), id == 0 && size == 2);
      }
    }
  }
}

TEST(Canopen, ManagementHeartbeatsAndEmergencies) {
  EXPECT_EQ(bytes_of(nmt_frame(NmtCommand::kStart, 5)), (Bytes{1, 5}));
  EXPECT_EQ(bytes_of(nmt_frame(NmtCommand::kEnterPreOperational, 0)), (Bytes{0x80, 0}));
  EXPECT_EQ(nmt_command(raw(0, {1, 0}), 9), NmtCommand::kStart) << "all nodes";
  EXPECT_EQ(nmt_command(raw(0, {2, 9}), 9), NmtCommand::kStop);
  EXPECT_FALSE(nmt_command(raw(0, {1, 8}), 9)) << "another one";
  EXPECT_EQ(heartbeat_frame(5, NmtState::kOperational), raw(0x705, {5}));
  EXPECT_EQ(heartbeat_state(raw(0x701, {127})), NmtState::kPreOperational);
  EXPECT_EQ(emergency_frame(3, 0x8611, 1), raw(0x83, {0x11, 0x86, 1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(emergency_code(raw(0x83, {0x30, 0x81, 1, 0, 0, 0, 0, 0})), 0x8130);
  EXPECT_EQ(sync_frame(), raw(0x80, {}));
}

TEST(Canopen, NumbersAreLittleEndianAndBounded) {
  std::array<std::byte, 3> bytes{};
  put(0x0A0B0C0D, 4, bytes, 1);
  EXPECT_EQ(get(bytes, 0, 4), 0x0C0D00u) << "what does not fit is left out";
  EXPECT_EQ(get(bytes, 2, 1), 0x0Cu);
  EXPECT_EQ(get(bytes, 3, 2), 0u);
}

TEST(Canopen, AbortAndErrorCodesHaveWordsOfTheirOwn) {
  std::set<std::string> texts;
  for (const SdoAbort code :
       {SdoAbort::kUnknownCommand, SdoAbort::kNotReadable, SdoAbort::kNotWritable, SdoAbort::kNoObject,
        SdoAbort::kNotMappable, SdoAbort::kTooLongForPdo, SdoAbort::kWrongLength, SdoAbort::kNoSubindex,
        SdoAbort::kOutOfRange, SdoAbort::kWrongState})
    texts.insert(text_of_abort(static_cast<std::uint32_t>(code)));
  texts.insert(text_of_abort(0x12345678));
  EXPECT_EQ(texts.size(), 11u);
  EXPECT_NE(text_of_error(0x8611), text_of_error(0x8130));
  EXPECT_EQ(text_of_error(0x8499), text_of_error(kErrorVelocity)) << "the range, where the code has no words";
  EXPECT_FALSE(text_of_error(0xFF01).empty());
}

TEST(Canopen, ProcessDataFitIntoAFrame) {
  const auto bits = [](const auto& objects) {
    int sum = 0;
    for (const MappedObject& object : objects) sum += object.bits;
    return sum;
  };
  EXPECT_EQ(bits(kOutputs1), 56);
  EXPECT_EQ(bits(kOutputs2), 32);
  EXPECT_EQ(bits(kInputs1), 56);
  EXPECT_EQ(bits(kInputs2), 48);
  EXPECT_EQ(kOutputs1[0].word(), 0x60400010u);
  EXPECT_EQ(kOutputs1[1].word(), 0x607A0020u);
}

}  // namespace
}  // namespace takt::hw::cia402
