#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/kinematics/types.h"
#include "core/motion/path.h"

namespace takt::emulation {

/// Folds the state of an emulated device into one word that stays where it is: a block of the digest (row D4).
/// Realtime: cyclic.
class StateHash {
 public:
  void begin() { hash_ = 0; }
  void add(std::uint64_t word) {
    std::uint64_t z = (hash_ ^ word) + 0x9E3779B97F4A7C15ull;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    hash_ = z ^ (z >> 31);
  }
  void add(std::int64_t x) { add(static_cast<std::uint64_t>(x)); }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) add(static_cast<double>(values.coeff(i)));
  }
  void add(const motion::JointSample& state) {
    add(state.q);
    add(state.dq);
    add(state.ddq);
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(&hash_, 1)); }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace takt::emulation
