#include "hw/wsg/protocol/packet.h"

#include <array>
#include <utility>

namespace takt::hw::wsg {
namespace {

constexpr char kPreambleByte = '\xAA';

/// Of the polynomial 0x1021, the highest bit first, as the published table of the interface has it. The interface
/// shifts the sum to the right all the same, so that this is none of the CRC-16s with a name.
constexpr std::array<std::uint16_t, 256> kTable = [] {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000) != 0 ? crc << 1 ^ 0x1021 : crc << 1;
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

}  // namespace

std::uint16_t checksum(std::string_view bytes, std::uint16_t crc) {
  for (const char byte : bytes)
    crc = static_cast<std::uint16_t>(kTable[(crc ^ static_cast<std::uint8_t>(byte)) & 0xFF] ^ crc >> 8);
  return crc;
}

void append_packet(std::string& out, std::uint8_t command, std::string_view payload) {
  const std::size_t begin = out.size();
  out.append(kPreambleSize, kPreambleByte);
  append(out, command);
  append(out, static_cast<std::uint16_t>(payload.size()));
  out += payload;
  append(out, checksum(std::string_view(out).substr(begin)));
}

void PacketParser::skip(std::size_t count) {
  buffer_.erase(0, count);
  skipped_ += count;
}

/// Everything before what may be a preamble is skipped. @return false: it is not whole yet
bool PacketParser::find_preamble() {
  constexpr std::string_view kPreamble = "\xAA\xAA\xAA";
  const std::size_t begin = buffer_.find(kPreamble);
  if (begin != buffer_.npos) {
    if (begin > 0) skip(begin);
    return true;
  }
  const std::size_t kept = std::min(buffer_.size() - (buffer_.find_last_not_of(kPreambleByte) + 1), kPreambleSize);
  if (kept < buffer_.size()) skip(buffer_.size() - kept);
  return false;
}

std::optional<Packet> PacketParser::next() {
  while (find_preamble()) {
    if (buffer_.size() < kHeaderSize) return std::nullopt;
    PayloadReader header(std::string_view(buffer_).substr(kPreambleSize));
    const auto command = header.take<std::uint8_t>();
    const std::size_t size = header.take<std::uint16_t>();
    if (size > kLargestPayload) {
      skip(1);
      continue;
    }
    const std::size_t whole = kHeaderSize + size + kChecksumSize;
    if (buffer_.size() < whole) return std::nullopt;
    const bool intact = checksum(std::string_view(buffer_).substr(0, whole)) == 0;
    Packet packet{command, buffer_.substr(kHeaderSize, size), intact};
    if (packet.intact) {
      buffer_.erase(0, whole);
    } else {
      skip(1);
    }
    return packet;
  }
  return std::nullopt;
}

}  // namespace takt::hw::wsg
