#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/kinematics/types.h"

namespace takt::device {

/// The state of one device as 64-bit words without padding, for the digest (row D4). Realtime: cyclic.
class StateWords {
 public:
  /// Sixteen joint vectors with their sizes, and some more.
  static constexpr std::size_t kCapacity = 16 * (kinematics::kMaxJoints + 1) + 32;

  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(std::int64_t x) { add(static_cast<std::uint64_t>(x)); }
  void add(std::uint64_t x) { words_.at(size_++) = x; }
  void add(const kinematics::JointVector& v) {
    add(static_cast<std::uint64_t>(v.size()));
    for (int i = 0; i < v.size(); ++i) add(v[i]);
  }
  void add(const Eigen::Vector3d& v) {
    for (const double x : v) add(x);
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(words_.data(), size_)); }

 private:
  std::array<std::uint64_t, kCapacity> words_;
  std::size_t size_ = 0;
};

}  // namespace takt::device
