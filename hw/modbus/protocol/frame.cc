#include "hw/modbus/protocol/frame.h"

#include <algorithm>

namespace takt::hw::modbus {
namespace {

constexpr std::uint8_t kExceptionBit = 0x80;
constexpr std::uint16_t kCoilOn = 0xFF00;
constexpr std::size_t kRequestHead = 5;  // function, address, count or value

void put_word(std::string& out, std::uint16_t value) {
  out += static_cast<char>(value >> 8);
  out += static_cast<char>(value & 0xFF);
}

std::uint8_t byte_at(std::string_view bytes, std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); }

std::uint16_t word_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}

bool is_known(std::uint8_t function) { return (function >= 1 && function <= 6) || function == 15 || function == 16; }

std::size_t byte_count(bool bits, std::size_t count) { return bits ? (count + 7) / 8 : 2 * count; }

void put_values(std::string& out, bool bits, std::span<const std::uint16_t> values) {
  if (!bits) {
    for (const std::uint16_t value : values) put_word(out, value);
    return;
  }
  const std::size_t begin = out.size();
  out.append(byte_count(true, values.size()), '\0');
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] != 0) out[begin + i / 8] = static_cast<char>(out[begin + i / 8] | 1 << i % 8);
}

/// @param bytes  byte_count() of them
void take_values(std::string_view bytes, bool bits, std::span<std::uint16_t> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = bits ? byte_at(bytes, i / 8) >> i % 8 & 1 : word_at(bytes, 2 * i);
}

/// Of one coil or register: the value is in the place of the count.
std::expected<Request, Exception> parse_single(Request request, std::uint16_t word, std::size_t size) {
  if (size != kRequestHead) return std::unexpected(Exception::kIllegalValue);
  const bool coil = request.function == Function::kWriteCoil;
  if (coil && word != 0 && word != kCoilOn) return std::unexpected(Exception::kIllegalValue);
  request.count = 1;
  request.values = {coil ? static_cast<std::uint16_t>(word == kCoilOn) : word};
  return request;
}

}  // namespace

void append_frame(std::string& out, const Frame& frame) {
  put_word(out, frame.transaction);
  put_word(out, 0);
  put_word(out, static_cast<std::uint16_t>(frame.pdu.size() + 1));
  out += static_cast<char>(frame.unit);
  out += frame.pdu;
}

std::optional<Frame> FrameParser::next() {
  if (broken_ || buffer_.size() < kHeaderSize) return std::nullopt;
  const std::size_t length = word_at(buffer_, 4);  // with the unit
  broken_ = word_at(buffer_, 2) != 0 || length < 2 || length > kLargestPdu + 1;
  if (broken_) buffer_.clear();
  const std::size_t whole = kHeaderSize - 1 + length;
  if (broken_ || buffer_.size() < whole) return std::nullopt;
  Frame frame{word_at(buffer_, 0), byte_at(buffer_, 6), buffer_.substr(kHeaderSize, length - 1)};
  buffer_.erase(0, whole);
  return frame;
}

std::string_view name_of(Exception exception) {
  switch (exception) {
    case Exception::kIllegalFunction:
      return "illegal function";
    case Exception::kIllegalAddress:
      return "illegal address";
    case Exception::kIllegalValue:
      return "illegal value";
    case Exception::kServerFailure:
      return "failure of the server";
    case Exception::kBusy:
      return "busy";
  }
  return "unknown exception";
}

std::uint16_t most_values(Function function) {
  switch (function) {
    case Function::kReadCoils:
    case Function::kReadDiscreteInputs:
      return 2000;
    case Function::kReadHoldingRegisters:
    case Function::kReadInputRegisters:
      return 125;
    case Function::kWriteCoils:
      return 1968;
    case Function::kWriteRegisters:
      return 123;
    default:  // of one coil or register
      return 1;
  }
}

std::string encode(const Request& request) {
  std::string pdu(1, static_cast<char>(request.function));
  put_word(pdu, request.address);
  if (request.function == Function::kWriteCoil || request.function == Function::kWriteRegister) {
    const std::uint16_t value = request.values.at(0);
    put_word(pdu, request.of_bits() ? (value != 0 ? kCoilOn : std::uint16_t{0}) : value);
    return pdu;
  }
  put_word(pdu, request.count);
  if (!request.writes()) return pdu;
  pdu += static_cast<char>(byte_count(request.of_bits(), request.count));
  put_values(pdu, request.of_bits(), request.values);
  return pdu;
}

std::expected<Request, Exception> parse_request(std::string_view pdu) {
  if (pdu.empty() || !is_known(byte_at(pdu, 0))) return std::unexpected(Exception::kIllegalFunction);
  if (pdu.size() < kRequestHead) return std::unexpected(Exception::kIllegalValue);
  Request request{static_cast<Function>(byte_at(pdu, 0)), word_at(pdu, 1), word_at(pdu, 3)};
  if (request.function == Function::kWriteCoil || request.function == Function::kWriteRegister)
    return parse_single(request, request.count, pdu.size());
  if (request.count == 0 || request.count > most_values(request.function))
    return std::unexpected(Exception::kIllegalValue);
  if (!request.writes()) {
    if (pdu.size() != kRequestHead) return std::unexpected(Exception::kIllegalValue);
    return request;
  }
  const std::size_t bytes = byte_count(request.of_bits(), request.count);
  if (pdu.size() != kRequestHead + 1 + bytes || byte_at(pdu, kRequestHead) != bytes)
    return std::unexpected(Exception::kIllegalValue);
  request.values.resize(request.count);
  take_values(pdu.substr(kRequestHead + 1), request.of_bits(), request.values);
  return request;
}

std::string encode_answer(const Request& request, std::span<const std::uint16_t> values) {
  if (request.writes()) return encode(request).substr(0, kRequestHead);
  std::string pdu(1, static_cast<char>(request.function));
  pdu += static_cast<char>(byte_count(request.of_bits(), values.size()));
  put_values(pdu, request.of_bits(), values);
  return pdu;
}

std::string encode_exception(std::uint8_t function, Exception exception) {
  return {static_cast<char>(function | kExceptionBit), static_cast<char>(exception)};
}

std::expected<void, Refusal> parse_answer(const Request& request, std::string_view pdu,
                                          std::span<std::uint16_t> values) {
  const auto function = static_cast<std::uint8_t>(request.function);
  if (pdu.size() == 2 && byte_at(pdu, 0) == (function | kExceptionBit))
    return std::unexpected(Refusal{static_cast<Exception>(byte_at(pdu, 1))});
  if (request.writes()) {
    if (pdu != encode_answer(request, {})) return std::unexpected(Refusal{});
    return {};
  }
  const std::size_t bytes = byte_count(request.of_bits(), request.count);
  if (pdu.size() != 2 + bytes || byte_at(pdu, 0) != function || byte_at(pdu, 1) != bytes ||
      values.size() != request.count)
    return std::unexpected(Refusal{});
  take_values(pdu.substr(2), request.of_bits(), values);
  return {};
}

}  // namespace takt::hw::modbus
