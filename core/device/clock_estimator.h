#pragma once

#include <array>
#include <cstdint>

#include "core/base/time.h"

namespace takt::device {

/// Learns how a device's clock runs against that of the core's machine, "the core's" below, from pairs (instant on the
/// device's clock, arrival on the core's). An arrival is never early, only late by transport and jitter, so the truth
/// is the lower edge of the pairs: of each block of packets the least delayed counts, a straight line through these
/// gives the drift, and the line is laid under the lowest of them (docs/time.md, "The estimator", with the bound of its
/// error).
///
/// The least transport time cannot be told from an offset of the clocks: what is known of it is given as
/// `transport_min`. One thread. Realtime: cyclic, O(1), every kBlock-th call O(kBlocks).
class ClockEstimator {
 public:
  static constexpr int kBlock = 32;                        ///< packets of which the least delayed counts
  static constexpr int kBlocks = 16;                       ///< that the line is drawn through
  static constexpr double kDriftMax = 500e-6;              ///< more than any quartz; s per s
  static constexpr Nanoseconds kStep = 20 * kMillisecond;  ///< further off than this, the wire changed: begins anew

  explicit ClockEstimator(Nanoseconds transport_min = 0) : transport_min_(transport_min) {}

  /// A packet that the device sent at `device_time` arrived at `received`.
  void add(Nanoseconds device_time, Nanoseconds received);

  [[nodiscard]] bool known() const { return pairs_ > 0; }
  /// On the core's clock. Meaningless before known().
  [[nodiscard]] Nanoseconds to_core(Nanoseconds device_time) const;
  /// Core seconds per device second, less 1.
  [[nodiscard]] double drift() const { return slope_; }
  /// Core time less device time, now.
  [[nodiscard]] Nanoseconds offset() const { return to_core(last_device_) - last_device_; }
  /// The largest delay behind the line in the last full block: what jitter the wire shows.
  [[nodiscard]] Nanoseconds jitter() const { return jitter_; }
  /// How often it began anew because the wire had changed or a clock had been set.
  [[nodiscard]] std::int64_t restarts() const { return restarts_; }

 private:
  struct Point {
    double x = 0.0, y = 0.0;  ///< ns on the device's clock since the first pair; ns of delay more than the first pair
  };

  void begin(Nanoseconds device_time, Nanoseconds received);
  void end_block();
  void fit();
  [[nodiscard]] double line(double x) const { return height_ + slope_ * (x - pivot_); }

  Nanoseconds transport_min_;
  Nanoseconds first_device_ = 0, first_received_ = 0, last_device_ = 0;
  std::int64_t pairs_ = 0;
  std::array<Point, kBlocks> lows_;
  int low_count_ = 0, next_low_ = 0;
  int in_block_ = 0;
  Point low_;          // of the block that is filling
  double high_ = 0.0;  // largest delay behind the line in it
  double pivot_ = 0.0, height_ = 0.0, slope_ = 0.0;
  Nanoseconds jitter_ = 0;
  std::int64_t restarts_ = 0;
};

}  // namespace takt::device
