#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

/// Numbers as all interfaces of a Universal Robots controller have them: big-endian, packed, without padding.
namespace takt::hw::rtde {

template <class T>
concept WireNumber = std::integral<T> || std::same_as<T, double> || std::same_as<T, float>;

namespace wire {
template <std::size_t size>
struct UnsignedOf;
template <>
struct UnsignedOf<1> {
  using type = std::uint8_t;
};
template <>
struct UnsignedOf<2> {
  using type = std::uint16_t;
};
template <>
struct UnsignedOf<4> {
  using type = std::uint32_t;
};
template <>
struct UnsignedOf<8> {
  using type = std::uint64_t;
};
template <class T>
using Bits = typename UnsignedOf<sizeof(T)>::type;
}  // namespace wire

/// Appends to a string of bytes. Realtime: cyclic while the string has room.
template <WireNumber T>
void append(std::string& bytes, T value) {
  const auto bits = std::bit_cast<wire::Bits<T>>(value);
  for (std::size_t i = sizeof(T); i-- > 0;) bytes.push_back(static_cast<char>((bits >> (8 * i)) & 0xff));
}

/// Takes numbers and texts from the front of some bytes. Past the end every number is 0 and ok() turns false, for good.
/// Realtime: cyclic.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <WireNumber T>
  [[nodiscard]] T take() {
    if (rest_.size() < sizeof(T)) {
      fail();
      return T{};
    }
    wire::Bits<T> bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bits = static_cast<wire::Bits<T>>((static_cast<std::uint64_t>(bits) << 8) | static_cast<std::uint8_t>(rest_[i]));
    }
    rest_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(bits);
  }
  [[nodiscard]] std::string_view take_text(std::size_t length) {
    if (rest_.size() < length) {
      fail();
      return {};
    }
    const std::string_view text = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return text;
  }
  /// All that is left.
  [[nodiscard]] std::string_view take_rest() {
    const std::string_view text = rest_;
    rest_ = {};
    return text;
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  /// Everything that was asked for was there.
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  void fail() {
    rest_ = {};
    ok_ = false;
  }

  std::string_view rest_;
  bool ok_ = true;
};

/// A number of the wire or of a script as an integer: the nearest that T has; 0 for what is no number.
template <std::integral T>
[[nodiscard]] T saturated(double value) {
  if (!(value == value)) return 0;
  if (value <= static_cast<double>(std::numeric_limits<T>::min())) return std::numeric_limits<T>::min();
  if (value >= static_cast<double>(std::numeric_limits<T>::max())) return std::numeric_limits<T>::max();
  return static_cast<T>(value);
}

}  // namespace takt::hw::rtde
