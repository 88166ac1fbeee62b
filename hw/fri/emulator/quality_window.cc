#include "hw/fri/emulator/quality_window.h"

#include <algorithm>
#include <cmath>

namespace takt::hw::fri {

void QualityWindow::add(bool answered, Nanoseconds round_trip) {
  Entry& entry = entries_[next_];
  entry = {};
  entry.answered = answered;
  if (answered) {
    entry.round_trip = to_seconds(round_trip);
    entry.jitter = std::abs(entry.round_trip - last_round_trip_);
    last_round_trip_ = entry.round_trip;
  } else {
    ++misses_;
  }
  next_ = (next_ + 1) % kWindow;
  ++count_;
}

int QualityWindow::answered() const {
  return static_cast<int>(std::ranges::count_if(entries_, [](const Entry& entry) { return entry.answered; }));
}

Quality QualityWindow::quality() const {
  const double share = answered() / static_cast<double>(kWindow);
  if (share >= rules_.perfect) return Quality::kPerfect;
  if (share >= rules_.ok) return Quality::kOk;
  return share >= rules_.bad ? Quality::kBad : Quality::kUnacceptable;
}

Statistics QualityWindow::statistics() const {
  Statistics statistics;
  const double total = static_cast<double>(std::clamp<std::uint64_t>(count_, 1, kWindow));
  const double answered_count = std::max(1, answered());
  for (const Entry& entry : entries_) {
    statistics.latency += entry.round_trip / answered_count;
    statistics.jitter += entry.jitter / answered_count;
  }
  statistics.answer_rate = answered() / total;
  statistics.miss_rate = 1.0 - statistics.answer_rate;
  statistics.misses = misses_;
  return statistics;
}

}  // namespace takt::hw::fri
