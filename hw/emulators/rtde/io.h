#pragma once

#include <array>
#include <bitset>
#include <cstdint>

namespace takt::hw::rtde {

/// What a digital output does when programs start and end, as the script functions number it.
enum class WithProgram : std::uint8_t {
  kKeep = 0,
  kLowWithout = 1,   ///< low from the end of a program on
  kHighWithout = 2,  ///< high from the end of a program on
  kHighWith = 3,     ///< high while a program runs, low else
  kLowOnStop = 4,    ///< low if the robot stopped by itself: not emulated, keeps its value
  kPulse = 5,        ///< not emulated, keeps its value
};

/// Digital and analog terminals of an emulated controller. Bits of digital values: 0-7 standard, 8-15 configurable,
/// 16-17 tool.
struct Terminals {
  static constexpr int kConfigurable = 8, kTool = 16;
  static constexpr unsigned kAnalogOut = 2;  ///< bit of the first analog output in `analog_types`

  std::uint32_t digital_in = 0, digital_out = 0;
  std::array<double, 2> analog_in{}, analog_out{};  ///< V or A; outputs as a share of the range, 0..1
  std::array<double, 2> tool_analog_in{};
  std::uint8_t analog_types = 0b1111;          ///< bits: in 0, in 1, out 0, out 1; 1 = voltage
  std::uint8_t tool_analog_types = 0b11;       ///< bits: in 0, in 1; 1 = voltage
  std::array<WithProgram, 18> with_program{};  ///< of each digital output
  int tool_voltage = 0;                        ///< 0, 12 or 24

  void set_digital_out(int bit, bool value) {
    const std::uint32_t mask = 1u << bit;
    digital_out = value ? digital_out | mask : digital_out & ~mask;
  }
  /// The outputs whose bit is set in the mask; `first` is the bit of the first one.
  void set_digital_out(std::uint8_t mask, std::uint8_t values, int first) {
    const std::uint32_t shifted = std::uint32_t{mask} << first;
    digital_out = (digital_out & ~shifted) | ((std::uint32_t{values} << first) & shifted);
  }
  /// Of one analog terminal, by its bit in `analog_types` or `tool_analog_types`.
  static void set_type(std::uint8_t& types, unsigned bit, bool voltage) {
    const auto mask = static_cast<std::uint8_t>(1u << bit);
    types = static_cast<std::uint8_t>(voltage ? types | mask : types & ~mask);
  }
  /// A program has started, or ended.
  void follow_program(bool runs) {
    for (std::size_t i = 0; i < with_program.size(); ++i) {
      const WithProgram what = with_program[i];
      if (what == WithProgram::kHighWith || (what == WithProgram::kLowWithout && !runs))
        set_digital_out(static_cast<int>(i), runs);
      else if (what == WithProgram::kHighWithout && !runs)
        set_digital_out(static_cast<int>(i), true);
    }
  }
  [[nodiscard]] bool digital_output(int bit) const { return (digital_out >> bit & 1) != 0; }
  [[nodiscard]] bool digital_input(int bit) const { return (digital_in >> bit & 1) != 0; }
};

/// The general registers between programs and clients, one direction.
struct Registers {
  static constexpr int kCount = 48, kBits = 128;
  std::array<std::int32_t, kCount> ints{};
  std::array<double, kCount> reals{};
  std::bitset<kBits> bits;

  /// 32 bits from `first` on.
  [[nodiscard]] std::uint32_t word(int first) const {
    return static_cast<std::uint32_t>(
        ((bits >> static_cast<std::size_t>(first)) & std::bitset<kBits>(0xffff'ffff)).to_ulong());
  }
  void set_word(int first, std::uint32_t word) {
    for (int i = 0; i < 32; ++i) bits[static_cast<std::size_t>(first + i)] = (word >> i & 1) != 0;
  }
};

}  // namespace takt::hw::rtde
