#include "core/rcc/lateness_times.h"

#include <algorithm>
#include <cmath>

namespace takt::rcc {

int LatenessTimes::bin_of(Nanoseconds late) {
  const Nanoseconds us = late / kMicrosecond;
  if (us < kFine) return static_cast<int>(std::max<Nanoseconds>(us, 0));
  const double octaves = std::log2(static_cast<double>(us) / kFine);
  return kFine + std::min(static_cast<int>(octaves * kPerOctave), kPerOctave * kOctaves - 1);
}

Nanoseconds LatenessTimes::upper_end(int bin) {
  if (bin < kFine) return (bin + 1) * kMicrosecond;
  const double octaves = static_cast<double>(bin - kFine + 1) / kPerOctave;
  return static_cast<Nanoseconds>(kFine * std::exp2(octaves)) * kMicrosecond;
}

void LatenessTimes::add(Nanoseconds late) {
  ++counts_[static_cast<std::size_t>(bin_of(late))];
  ++count_;
  worst_ = std::max(worst_, late);
}

Nanoseconds LatenessTimes::quantile(double share) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_)));
  std::int64_t below = 0;
  for (int bin = 0; bin < kBins && count_ > 0; ++bin) {
    below += counts_[static_cast<std::size_t>(bin)];
    const bool open = bin == kBins - 1;  // the last one has no end
    if (below >= wanted) return open ? worst_ : std::min(upper_end(bin), worst_);
  }
  return worst_;
}

}  // namespace takt::rcc
