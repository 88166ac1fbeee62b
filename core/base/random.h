#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace takt {

/// The project's own random numbers: the same seed gives the same bits with every compiler and library (row D5).
/// SplitMix64 for the state; independent streams come from a seed and a name, so that a new consumer disturbs no other.
/// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014. Realtime: cyclic.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(seed) {}
  constexpr Random(std::uint64_t seed, std::string_view stream) : state_(seed) {
    for (const char c : stream) state_ = mix(state_ ^ static_cast<unsigned char>(c));
  }

  constexpr std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15ull;
    return mix(state_);
  }
  /// Uniform in [0, 1).
  constexpr double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  constexpr double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// Sum of twelve uniforms of 16 bits, four from each draw: mean 0, variance 1, bounded by +-6, and free of libm, so
  /// equal everywhere.
  constexpr double normal() {
    std::uint64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t draw = bits();
      sum += (draw & 0xffff) + ((draw >> 16) & 0xffff) + ((draw >> 32) & 0xffff) + (draw >> 48);
    }
    // Each of the twelve lies in the middle of its step of 2^-16 on average, hence the six halves.
    return (static_cast<double>(sum) + 6.0) * 0x1p-16 - 6.0;
  }
  /// What Random(state) continues from: for snapshots.
  [[nodiscard]] constexpr std::uint64_t state() const { return state_; }

 private:
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace takt
