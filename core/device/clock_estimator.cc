#include "core/device/clock_estimator.h"

#include <algorithm>
#include <cmath>

namespace takt::device {

namespace {

constexpr int kBlocksForSlope = 4;  // fewer say more about the jitter than about the drift

}  // namespace

void ClockEstimator::begin(Nanoseconds device_time, Nanoseconds received) {
  first_device_ = device_time;
  first_received_ = received;
  low_count_ = next_low_ = in_block_ = 0;
  pivot_ = height_ = slope_ = high_ = 0.0;
}

void ClockEstimator::add(Nanoseconds device_time, Nanoseconds received) {
  if (pairs_++ == 0) begin(device_time, received);
  auto x = static_cast<double>(device_time - first_device_);
  auto y = static_cast<double>((received - device_time) - (first_received_ - first_device_));
  const auto step = static_cast<double>(kStep);
  // Far below the line: the device's clock was set forward. Far above for a whole block: set back, or the wire became
  // slower for good; both ends the old line.
  const bool far_below = y < line(x) - step;
  const bool far_above = in_block_ + 1 == kBlock && std::min(low_.y, y) > line(x) + step;
  if (far_below || far_above) {
    ++restarts_;
    begin(device_time, received);
    x = y = 0.0;
  }
  last_device_ = device_time;
  // Nothing arrives before it was sent: a pair below the line pulls it down at once.
  const double behind = y - line(x);
  if (behind < 0.0) height_ += behind;
  high_ = std::max(high_, behind);
  if (in_block_ == 0 || y - slope_ * x < low_.y - slope_ * low_.x) low_ = {x, y};
  if (++in_block_ == kBlock) end_block();
}

void ClockEstimator::end_block() {
  jitter_ = std::llround(high_);
  lows_[static_cast<std::size_t>(next_low_)] = low_;
  next_low_ = (next_low_ + 1) % kBlocks;
  low_count_ = std::min(low_count_ + 1, kBlocks);
  in_block_ = 0;
  high_ = 0.0;
  fit();
}

void ClockEstimator::fit() {
  double x_mean = 0.0, y_mean = 0.0;
  for (int i = 0; i < low_count_; ++i) {
    x_mean += lows_[static_cast<std::size_t>(i)].x / low_count_;
    y_mean += lows_[static_cast<std::size_t>(i)].y / low_count_;
  }
  double xx = 0.0, xy = 0.0;
  for (int i = 0; i < low_count_; ++i) {
    const auto& low = lows_[static_cast<std::size_t>(i)];
    xx += (low.x - x_mean) * (low.x - x_mean);
    xy += (low.x - x_mean) * (low.y - y_mean);
  }
  slope_ = low_count_ >= kBlocksForSlope && xx > 0.0 ? std::clamp(xy / xx, -kDriftMax, kDriftMax) : 0.0;
  pivot_ = x_mean;
  height_ = y_mean;
  for (int i = 0; i < low_count_; ++i) {
    const auto& low = lows_[static_cast<std::size_t>(i)];
    height_ = std::min(height_, low.y - slope_ * (low.x - pivot_));
  }
}

Nanoseconds ClockEstimator::to_core(Nanoseconds device_time) const {
  const auto x = static_cast<double>(device_time - first_device_);
  return device_time + (first_received_ - first_device_) + std::llround(line(x)) - transport_min_;
}

}  // namespace takt::device
