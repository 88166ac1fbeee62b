#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::hw {

/// A data frame of classical CAN with an identifier of 11 bits.
struct CanFrame {
  static constexpr std::uint32_t kMostId = 0x7FF;

  std::uint32_t id = 0;
  std::uint8_t size = 0;  ///< bytes of data that count, at most 8
  std::array<std::byte, 8> data{};

  [[nodiscard]] std::span<const std::byte> payload() const { return std::span(data).first(size); }
  bool operator==(const CanFrame&) const = default;
};

}  // namespace takt::hw
