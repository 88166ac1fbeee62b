#pragma once

#include <array>
#include <cstddef>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/motion/path.h"

namespace takt::device {

/// The motion between two states, `length` s apart, `time` s after the first: the one polynomial of fifth degree that
/// has both states' q, dq and ddq. Before the first and after the second it is that state, bit for bit.
/// Both of one size. Realtime: cyclic, O(n).
[[nodiscard]] motion::JointSample interpolate(const motion::JointSample& from, const motion::JointSample& to,
                                              double length, double time);

/// The set points of the last cycles by time: what an agent resamples to the device's instants (row T3).
/// One thread. Realtime: cyclic.
class SetPointSeries {
 public:
  static constexpr std::size_t kCapacity = 512;  ///< half a second of cycles of 1 ms

  enum class Place {
    kEmpty,   ///< no set point at all
    kBefore,  ///< before the first: that one is given
    kInside,
    kBeyond  ///< after the newest: that one is given
  };

  void clear() { size_ = 0; }
  /// Newer than all before, else it is ignored. The oldest goes when the series is full.
  void add(const ArmSetPoint& set_point);
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Nanoseconds newest() const { return size_ == 0 ? 0 : at(size_ - 1).stamp; }
  [[nodiscard]] const ArmSetPoint& first() const { return at(0); }

  /// The motion at `time`. O(log n). `out` is untouched if there is none.
  [[nodiscard]] Place sample(Nanoseconds time, motion::JointSample& out) const;

 private:
  [[nodiscard]] const ArmSetPoint& at(std::size_t i) const { return points_[(first_ + i) % kCapacity]; }

  std::array<ArmSetPoint, kCapacity> points_;
  std::size_t first_ = 0, size_ = 0;
};

}  // namespace takt::device
