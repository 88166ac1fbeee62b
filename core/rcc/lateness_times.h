#pragma once

#include <array>
#include <cstdint>

#include "core/base/time.h"

namespace takt::rcc {

/// How late something periodic happened: a histogram of fixed size. One thread at a time.
class LatenessTimes {
 public:
  /// Realtime: cyclic.
  void add(Nanoseconds late);

  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] Nanoseconds worst() const { return worst_; }
  /// The lateness that this share of them, 0 to 1, does not exceed: to a microsecond below 1 ms, to 5 % above. 0 if
  /// there are none.
  [[nodiscard]] Nanoseconds quantile(double share) const;

 private:
  static constexpr Nanoseconds kMicrosecond = 1000;
  static constexpr int kFine = 1000;     // bins of 1 us
  static constexpr int kPerOctave = 16;  // above: bins of 1/16 of an octave
  static constexpr int kOctaves = 20;    // up to 1000 s
  static constexpr int kBins = kFine + kPerOctave * kOctaves;
  [[nodiscard]] static int bin_of(Nanoseconds late);
  [[nodiscard]] static Nanoseconds upper_end(int bin);

  std::array<std::int64_t, kBins> counts_{};
  std::int64_t count_ = 0;
  Nanoseconds worst_ = 0;
};

}  // namespace takt::rcc
