#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace takt::device {

/// What became of the samples of a device.
struct InletCounts {
  std::uint64_t accepted = 0;   ///< newer than all before
  std::uint64_t repeated = 0;   ///< the same sample again
  std::uint64_t reordered = 0;  ///< came after a newer one: dropped
  std::uint64_t lost = 0;       ///< never came
  std::uint64_t restarts = 0;   ///< the device began to count anew
};

/// Sorts samples by the number that the device gives them: only a sample newer than all before is accepted.
/// One thread. Realtime: cyclic, O(1).
class SampleInlet {
 public:
  /// A device that counts anew is believed after so many samples in a row that are all too old, each newer than the
  /// one before.
  static constexpr int kRestartAfter = 8;

  /// @param sequence  the device's number, > 0. @return true if this sample is the newest.
  bool accept(std::uint64_t sequence) {
    if (newest_ == 0 || sequence > newest_) {
      counts_.lost += newest_ == 0 ? 0 : sequence - newest_ - 1;
      return take(sequence);
    }
    const std::uint64_t back = newest_ - sequence;
    const bool seen = back < 64 && (seen_ >> back & 1) != 0;
    if (back < 64) seen_ |= std::uint64_t{1} << back;
    if (seen) {
      ++counts_.repeated;
    } else {
      ++counts_.reordered;
      if (back < 64 && counts_.lost > 0) --counts_.lost;
    }
    old_in_a_row_ = sequence > last_old_ ? old_in_a_row_ + 1 : 1;
    last_old_ = sequence;
    if (seen || old_in_a_row_ < kRestartAfter) return false;
    ++counts_.restarts;
    newest_ = 0;
    return take(sequence);
  }

  [[nodiscard]] const InletCounts& counts() const { return counts_; }
  [[nodiscard]] std::uint64_t newest() const { return newest_; }

 private:
  bool take(std::uint64_t sequence) {
    const std::uint64_t ahead = newest_ == 0 ? 64 : sequence - newest_;
    seen_ = (ahead >= 64 ? 0 : seen_ << ahead) | 1;
    newest_ = sequence;
    old_in_a_row_ = 0;
    last_old_ = 0;
    ++counts_.accepted;
    return true;
  }

  InletCounts counts_;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit i: the sample `newest_ - i` has come
  std::uint64_t last_old_ = 0;
  int old_in_a_row_ = 0;
};

}  // namespace takt::device
