#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace takt::device {

/// What became of the samples of a device.
struct InletCounts {
  std::uint64_t accepted = 0;     ///< newer than all before
  std::uint64_t repeated = 0;     ///< the same sample again
  std::uint64_t reordered = 0;    ///< came after a newer one: dropped
  std::uint64_t lost = 0;         ///< never came
  std::uint64_t implausible = 0;  ///< a number, a clock or a value that cannot be: dropped
  std::uint64_t restarts = 0;     ///< new sessions after the first (DeviceSession)
};

/// Sorts samples by their number, which only grows: only a sample newer than all before is accepted.
/// One thread. Realtime: cyclic, O(1).
class SampleInlet {
 public:
  /// @param number  > 0. @return true if this sample is the newest.
  bool accept(std::uint64_t number) {
    if (newest_ == 0 || number > newest_) {
      counts_.lost += newest_ == 0 ? 0 : number - newest_ - 1;
      take(number);
      return true;
    }
    const std::uint64_t back = newest_ - number;
    if (seen(number)) {
      ++counts_.repeated;
    } else {
      ++counts_.reordered;
      if (back < kWindow && counts_.lost > 0) --counts_.lost;
    }
    if (back < kWindow) seen_ |= std::uint64_t{1} << back;
    return false;
  }

  /// True if the sample has come and is among the last 64 numbers.
  [[nodiscard]] bool seen(std::uint64_t number) const {
    const std::uint64_t back = newest_ - number;
    return number <= newest_ && back < kWindow && (seen_ >> back & 1) != 0;
  }
  [[nodiscard]] const InletCounts& counts() const { return counts_; }
  [[nodiscard]] InletCounts& counts() { return counts_; }
  [[nodiscard]] std::uint64_t newest() const { return newest_; }

 private:
  static constexpr std::uint64_t kWindow = 64;

  void take(std::uint64_t number) {
    const std::uint64_t ahead = newest_ == 0 ? kWindow : number - newest_;
    seen_ = (ahead >= kWindow ? 0 : seen_ << ahead) | 1;
    newest_ = number;
    ++counts_.accepted;
  }

  InletCounts counts_;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit i: the sample `newest_ - i` has come
};

}  // namespace takt::device
