// Frames of Modbus TCP against the examples of the public specification, and cut at every byte.
#include "hw/modbus/protocol/frame.h"

#include <vector>

#include <gtest/gtest.h>

namespace takt::hw::modbus::frame_test {
namespace {

std::string bytes(std::initializer_list<unsigned> values) {
  std::string text;
  for (const unsigned value : values) text += static_cast<char>(value);
  return text;
}

using Values = std::vector<std::uint16_t>;

/// The examples of "MODBUS Application Protocol Specification V1.1b3", chapter 6, and what they say.
struct Example {
  Request request;
  std::string asked, answered;
  Values values;
};
const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      {{Function::kReadCoils, 19, 19},
       bytes({1, 0, 0x13, 0, 0x13}),
       bytes({1, 3, 0xCD, 0x6B, 0x05}),
       {1, 0, 1, 1, 0, 0, 1, 1, 1, 1, 0, 1, 0, 1, 1, 0, 1, 0, 1}},
      {{Function::kReadDiscreteInputs, 196, 22},
       bytes({2, 0, 0xC4, 0, 0x16}),
       bytes({2, 3, 0xAC, 0xDB, 0x35}),
       {0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 0, 1, 1, 0, 1, 1, 1, 0, 1, 0, 1, 1}},
      {{Function::kReadHoldingRegisters, 107, 3},
       bytes({3, 0, 0x6B, 0, 3}),
       bytes({3, 6, 0x02, 0x2B, 0, 0, 0, 0x64}),
       {555, 0, 100}},
      {{Function::kReadInputRegisters, 8, 1}, bytes({4, 0, 8, 0, 1}), bytes({4, 2, 0, 0x0A}), {10}},
      {{Function::kWriteCoil, 172, 1, {1}}, bytes({5, 0, 0xAC, 0xFF, 0}), bytes({5, 0, 0xAC, 0xFF, 0}), {}},
      {{Function::kWriteRegister, 1, 1, {3}}, bytes({6, 0, 1, 0, 3}), bytes({6, 0, 1, 0, 3}), {}},
      {{Function::kWriteCoils, 19, 10, {1, 0, 1, 1, 0, 0, 1, 1, 1, 0}},
       bytes({15, 0, 0x13, 0, 0x0A, 2, 0xCD, 0x01}),
       bytes({15, 0, 0x13, 0, 0x0A}),
       {}},
      {{Function::kWriteRegisters, 1, 2, {10, 258}},
       bytes({16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2}),
       bytes({16, 0, 1, 0, 2}),
       {}}};
  return all;
}

TEST(ModbusFrame, ExamplesOfTheSpecification) {
  for (const Example& example : examples()) {
    SCOPED_TRACE(static_cast<int>(example.request.function));
    EXPECT_EQ(encode(example.request), example.asked);
    const auto request = parse_request(example.asked);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->function, example.request.function);
    EXPECT_EQ(request->address, example.request.address);
    EXPECT_EQ(request->count, example.request.count);
    EXPECT_EQ(request->values, example.request.values);
    EXPECT_EQ(encode_answer(*request, example.values), example.answered);
    Values values(example.request.writes() ? 0 : example.request.count);
    ASSERT_TRUE(parse_answer(example.request, example.answered, values));
    EXPECT_EQ(values, example.values);
  }
}

TEST(ModbusFrame, EveryOtherLengthOfAnExampleIsRefused) {
  for (const Example& example : examples()) {
    SCOPED_TRACE(static_cast<int>(example.request.function));
    Values values(example.request.writes() ? 0 : example.request.count);
    for (std::size_t size = 1; size < example.asked.size(); ++size)
      EXPECT_EQ(parse_request(example.asked.substr(0, size)).error(), Exception::kIllegalValue) << size;
    EXPECT_EQ(parse_request(example.asked + '\0').error(), Exception::kIllegalValue);
    for (std::size_t size = 0; size < example.answered.size(); ++size)
      EXPECT_FALSE(parse_answer(example.request, example.answered.substr(0, size), values)) << size;
    EXPECT_FALSE(parse_answer(example.request, example.answered + '\0', values));
  }
}

TEST(ModbusFrame, ValuesThatCannotBeAreRefused) {
  EXPECT_EQ(parse_request("").error(), Exception::kIllegalFunction);
  EXPECT_EQ(parse_request(bytes({7, 0, 0, 0, 1})).error(), Exception::kIllegalFunction);
  EXPECT_EQ(parse_request(bytes({0, 0, 0, 0, 1})).error(), Exception::kIllegalFunction);
  EXPECT_EQ(parse_request(bytes({1, 0, 0, 0, 0})).error(), Exception::kIllegalValue) << "none";
  EXPECT_EQ(parse_request(bytes({1, 0, 0, 0x07, 0xD1})).error(), Exception::kIllegalValue) << "2001 coils";
  EXPECT_TRUE(parse_request(bytes({1, 0, 0, 0x07, 0xD0})));
  EXPECT_EQ(parse_request(bytes({3, 0, 0, 0, 126})).error(), Exception::kIllegalValue);
  EXPECT_EQ(parse_request(bytes({5, 0, 0, 0xFF, 1})).error(), Exception::kIllegalValue);
  EXPECT_EQ(parse_request(bytes({5, 0, 0, 0, 1})).error(), Exception::kIllegalValue);
  EXPECT_EQ(parse_request(bytes({5, 0, 0, 0, 0}))->values, Values{0}) << "off";
  EXPECT_EQ(parse_request(bytes({15, 0, 0, 0, 8, 2, 0, 0})).error(), Exception::kIllegalValue) << "a byte too many";
  EXPECT_EQ(parse_request(bytes({16, 0, 0, 0, 1, 1, 0, 0})).error(), Exception::kIllegalValue);
  for (const Function function : {Function::kReadCoils, Function::kReadHoldingRegisters, Function::kWriteCoils,
                                  Function::kWriteRegisters, Function::kWriteCoil, Function::kWriteRegister}) {
    const std::uint16_t most = most_values(function);
    EXPECT_LE(encode({function, 0, most, Values(most)}).size(), kLargestPdu);
  }
}

TEST(ModbusFrame, ExceptionsAndAnswersToOtherRequests) {
  const Request read{Function::kReadHoldingRegisters, 0, 1};
  Values values(1);
  const auto refused = parse_answer(read, encode_exception(3, Exception::kIllegalAddress), values);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().exception, Exception::kIllegalAddress);
  EXPECT_EQ(encode_exception(3, Exception::kIllegalAddress), bytes({0x83, 2}));
  const auto strange = parse_answer(read, bytes({4, 2, 0, 1}), values);
  ASSERT_FALSE(strange);
  EXPECT_FALSE(strange.error().exception);
  EXPECT_FALSE(parse_answer(read, bytes({3, 3, 0, 1}), values)) << "the count of bytes";
  Values two(2);
  EXPECT_FALSE(parse_answer(read, bytes({3, 2, 0, 1}), two)) << "our own room is another";
  for (const auto& [exception, name] :
       std::vector<std::pair<Exception, std::string>>{{Exception::kIllegalFunction, "illegal function"},
                                                      {Exception::kIllegalAddress, "illegal address"},
                                                      {Exception::kIllegalValue, "illegal value"},
                                                      {Exception::kServerFailure, "failure of the server"},
                                                      {Exception::kBusy, "busy"},
                                                      {static_cast<Exception>(99), "unknown exception"}})
    EXPECT_EQ(name_of(exception), name);
}

TEST(ModbusFrame, MeansTheSameHoweverItIsCut) {
  std::string stream;
  for (std::size_t i = 0; i < examples().size(); ++i)
    append_frame(stream, {static_cast<std::uint16_t>(i + 300), 17, examples()[i].asked});
  EXPECT_EQ(stream.substr(0, 7), bytes({0x01, 0x2C, 0, 0, 0, 6, 17}));
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    FrameParser parser;
    std::vector<Frame> frames;
    for (const std::string& piece : {stream.substr(0, cut), stream.substr(cut)}) {
      parser.feed(piece);
      while (auto frame = parser.next()) frames.push_back(std::move(*frame));
    }
    ASSERT_EQ(frames.size(), examples().size()) << cut;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].transaction, i + 300);
      EXPECT_EQ(frames[i].unit, 17);
      EXPECT_EQ(frames[i].pdu, examples()[i].asked);
    }
    EXPECT_EQ(parser.waiting(), 0u);
  }
}

TEST(ModbusFrame, AHeaderThatCannotBeBreaksTheStream) {
  for (const std::string& header : {bytes({0, 1, 0, 1, 0, 6, 1}), bytes({0, 1, 0, 0, 0, 1, 1}),
                                    bytes({0, 1, 0, 0, 0, 255, 1}), bytes({0, 1, 0, 0, 1, 0, 1})}) {
    FrameParser parser;
    parser.feed(header);
    EXPECT_FALSE(parser.next());
    EXPECT_TRUE(parser.broken());
    parser.feed(header);
    EXPECT_FALSE(parser.next());
    parser.reset();
    EXPECT_FALSE(parser.broken());
  }
}

}  // namespace
}  // namespace takt::hw::modbus::frame_test
