#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

/// Packets of the command interface: AA AA AA, command, size of the payload, payload, CRC-16. Little endian; mm, mm/s,
/// mm/s^2, N as binary32. Realtime: cyclic while strings have room, unless it says otherwise.
namespace takt::hw::wsg {

inline constexpr std::uint16_t kPort = 1000;
inline constexpr std::size_t kPreambleSize = 3, kHeaderSize = 6, kChecksumSize = 2;
/// Bytes; the longest that any command here has is 34.
inline constexpr std::size_t kLargestPayload = 256;

/// The CRC-16 of the interface; that of what a packet begins with goes on over the rest. A packet that is whole and
/// ends with its checksum gives 0.
[[nodiscard]] std::uint16_t checksum(std::string_view bytes, std::uint16_t crc = 0xFFFF);

void append_packet(std::string& out, std::uint8_t command, std::string_view payload);

struct Packet {
  std::uint8_t command = 0;
  std::string payload;
  bool intact = true;  ///< false: the checksum is another one, nothing of it counts
};

/// Cuts a byte stream into packets. What is between packets is skipped; after a packet that is not intact the search
/// for the next preamble begins behind its first byte. Keeps at most one packet, whatever comes.
class PacketParser {
 public:
  void feed(std::string_view bytes) { buffer_.append(bytes); }
  /// @return the next packet; nothing: more bytes are needed.
  [[nodiscard]] std::optional<Packet> next();
  /// Bytes that belonged to no packet.
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }
  /// Bytes of a packet that is not whole yet.
  [[nodiscard]] std::size_t waiting() const { return buffer_.size(); }
  void reset() { buffer_.clear(); }

 private:
  void skip(std::size_t count);
  [[nodiscard]] bool find_preamble();

  std::string buffer_;
  std::uint64_t skipped_ = 0;
};

// -- Numbers -------------------------------------------------------------------------------------------------------
template <std::unsigned_integral T>
void append(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(value >> 8 * i & 0xFF);
}
inline void append(std::string& out, float value) { append(out, std::bit_cast<std::uint32_t>(value)); }

/// Takes numbers from the front of a payload. Beyond its end all are 0, and whole() is false.
class PayloadReader {
 public:
  explicit PayloadReader(std::string_view bytes) : bytes_(bytes) {}
  template <std::unsigned_integral T>
  T take() {
    whole_ = whole_ && bytes_.size() >= sizeof(T);
    if (!whole_) return 0;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(bytes_[i])) << 8 * i;
    bytes_.remove_prefix(sizeof(T));
    return static_cast<T>(value);
  }
  double take_float() { return static_cast<double>(std::bit_cast<float>(take<std::uint32_t>())); }
  [[nodiscard]] bool whole() const { return whole_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  bool whole_ = true;
};

}  // namespace takt::hw::wsg
