#include "hw/emulators/fri/quality_window.h"

#include <algorithm>
#include <cmath>

namespace takt::hw::fri {

void QualityWindow::add(bool answered, Nanoseconds round_trip) {
  Entry& entry = entries_[next_];
  answered_ -= entry.answered ? 1 : 0;
  round_trips_ -= entry.round_trip;
  jitters_ -= entry.jitter;
  entry = {};
  entry.answered = answered;
  if (answered) {
    entry.round_trip = round_trip;
    entry.jitter = std::abs(round_trip - last_round_trip_);
    last_round_trip_ = round_trip;
  } else {
    ++misses_;
  }
  answered_ += answered ? 1 : 0;
  round_trips_ += entry.round_trip;
  jitters_ += entry.jitter;
  next_ = (next_ + 1) % kWindow;
  ++count_;
}

Quality QualityWindow::quality() const {
  const double share = answered_ / static_cast<double>(kWindow);
  if (share >= rules_.perfect) return Quality::kPerfect;
  if (share >= rules_.ok) return Quality::kOk;
  return share >= rules_.bad ? Quality::kBad : Quality::kUnacceptable;
}

Statistics QualityWindow::statistics() const {
  Statistics statistics;
  const auto total = static_cast<double>(std::clamp<std::uint64_t>(count_, 1, kWindow));
  const double answers = std::max(1, answered_);
  statistics.latency = to_seconds(round_trips_) / answers;
  statistics.jitter = to_seconds(jitters_) / answers;
  statistics.answer_rate = answered_ / total;
  statistics.miss_rate = 1.0 - statistics.answer_rate;
  statistics.misses = misses_;
  return statistics;
}

}  // namespace takt::hw::fri
