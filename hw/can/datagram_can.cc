#include "hw/can/datagram_can.h"

#include <algorithm>

namespace takt::hw {
namespace {

constexpr std::size_t kChecked = kCanDatagramSize - 4;
constexpr std::size_t kData = 8;

/// CRC-32 of IEEE 802.3, bit by bit: 16 bytes take less time than a system call.
std::uint32_t crc32(std::span<const std::byte> bytes) {
  std::uint32_t crc = ~0u;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xEDB8'8320u : 0u);
  }
  return ~crc;
}

void put32(std::uint32_t word, std::span<std::byte> at) {
  for (std::size_t i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(word >> (8 * i));
}
std::uint32_t get32(std::span<const std::byte> at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= std::to_integer<std::uint32_t>(at[i]) << (8 * i);
  return word;
}

bool all_zero(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

}  // namespace

CanDatagram encode(const CanFrame& frame) {
  CanDatagram datagram{};
  const std::span<std::byte> bytes(datagram);
  put32(frame.id, bytes);
  bytes[4] = static_cast<std::byte>(frame.size);
  std::ranges::copy(frame.payload(), bytes.begin() + kData);
  put32(crc32(bytes.first(kChecked)), bytes.subspan(kChecked));
  return datagram;
}

std::optional<CanFrame> decode_can(std::span<const std::byte> datagram) {
  if (datagram.size() != kCanDatagramSize) return std::nullopt;
  if (crc32(datagram.first(kChecked)) != get32(datagram.subspan(kChecked))) return std::nullopt;
  CanFrame frame{.id = get32(datagram), .size = std::to_integer<std::uint8_t>(datagram[4])};
  if (frame.id > CanFrame::kMostId || frame.size > frame.data.size()) return std::nullopt;
  if (!all_zero(datagram.subspan(5, 3)) || !all_zero(datagram.first(kChecked).subspan(kData + frame.size)))
    return std::nullopt;
  std::ranges::copy(datagram.subspan(kData, frame.size), frame.data.begin());
  return frame;
}

DatagramCan::DatagramCan(std::unique_ptr<DatagramLink> link, const Endpoint& peer, const Clock& clock)
    : link_(std::move(link)), peer_(peer), fixed_(peer.port != 0), clock_(clock) {}

bool DatagramCan::send(const CanFrame& frame) {
  const bool sent = peer_.port != 0 && link_->send(encode(frame), peer_);
  ++(sent ? counts_.sent : counts_.unsent);
  return sent;
}

bool DatagramCan::is_stranger(const Endpoint& from) {
  const Nanoseconds now = clock_.read().machine;
  const bool free = !fixed_ && (peer_.port == 0 || now - heard_ > kSecond);
  if (!free && from != peer_) return true;
  peer_ = from;
  heard_ = now;
  return false;
}

std::optional<CanFrame> DatagramCan::receive() {
  std::array<std::byte, DatagramLink::kLargest> buffer;
  while (const auto received = link_->receive(buffer)) {
    const auto frame =
        received->size <= buffer.size() ? decode_can(std::span(buffer).first(received->size)) : std::nullopt;
    if (!frame) {
      ++counts_.misread;
    } else if (is_stranger(received->from)) {
      ++counts_.strangers;
    } else {
      ++counts_.received;
      return frame;
    }
  }
  return std::nullopt;
}

}  // namespace takt::hw
