#include "core/device/following_monitor.h"

#include <algorithm>

namespace takt::device {

FollowingMonitor::FollowingMonitor(double bound, Nanoseconds window, Nanoseconds period)
    : bound_(bound), block_length_(static_cast<int>(std::max<Nanoseconds>(1, window / (kBlocks * period) + 1))) {}

void FollowingMonitor::clear() { newest_ = filled_ = in_block_ = 0; }

void FollowingMonitor::sent(const JointVector& q) {
  if (in_block_ == block_length_) {
    newest_ = (newest_ + 1) % (kBlocks + 1);
    filled_ = std::min(filled_ + 1, kBlocks);
    in_block_ = 0;
  }
  const auto block = static_cast<std::size_t>(newest_);
  if (in_block_++ == 0) {
    min_[block] = max_[block] = q;
    return;
  }
  min_[block] = min_[block].cwiseMin(q);
  max_[block] = max_[block].cwiseMax(q);
}

std::optional<FollowingError> FollowingMonitor::check(const JointVector& q) const {
  if (filled_ < kBlocks || in_block_ == 0) return std::nullopt;
  std::optional<FollowingError> worst;
  for (int i = 0; i < q.size(); ++i) {
    double low = min_[0][i], high = max_[0][i];
    for (std::size_t block = 1; block <= kBlocks; ++block) {
      low = std::min(low, min_[block][i]);
      high = std::max(high, max_[block][i]);
    }
    const double error = std::max(low - q[i], q[i] - high);
    if (error > bound_ && (!worst || error > worst->error)) worst = FollowingError{i, error};
  }
  return worst;
}

}  // namespace takt::device
