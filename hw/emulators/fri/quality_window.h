#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/time.h"
#include "hw/fri/protocol/packet.h"

namespace takt::hw::fri {

/// From which share of answered datagrams on the quality is what. KUKA publishes no thresholds: these are ours.
struct QualityRules {
  double perfect = 0.99, ok = 0.85, bad = 0.70;
};

/// How well the remote side answers, over the last kWindow cycles. What has not been sent yet counts as unanswered, so
/// that the quality of a new connection grows. One thread. Realtime: cyclic.
class QualityWindow {
 public:
  static constexpr std::size_t kWindow = 100;

  explicit QualityWindow(const QualityRules& rules) : rules_(rules) {}

  /// One more datagram was answered in time, or was not. @param round_trip  ns, of one that was
  void add(bool answered, Nanoseconds round_trip);
  [[nodiscard]] Quality quality() const;
  [[nodiscard]] Statistics statistics() const;

 private:
  struct Entry {
    bool answered = false;
    Nanoseconds round_trip = 0, jitter = 0;
  };

  QualityRules rules_;
  std::array<Entry, kWindow> entries_{};
  std::size_t next_ = 0;
  int answered_ = 0;                           // of the entries
  Nanoseconds round_trips_ = 0, jitters_ = 0;  // their sums
  std::uint64_t count_ = 0;
  Nanoseconds last_round_trip_ = 0;
  std::uint32_t misses_ = 0;
};

}  // namespace takt::hw::fri
