#include "core/rcc/stop_supervisor.h"

namespace takt::rcc {

using device::StopCategory;

const device::EmergencyStop* StopSupervisor::strongest() const {
  const device::EmergencyStop* strongest = nullptr;
  for (const device::EmergencyStop* stop : latches_)
    if (stop->latched() && (strongest == nullptr || stop->category() < strongest->category())) strongest = stop;
  return strongest;
}

void StopSupervisor::begin(std::int64_t cycle) {
  executor_.stop_where_lost(cycle);
  const device::EmergencyStop* stop = strongest();
  if (stop != nullptr && stop->category() != StopCategory::kBrakes)
    executor_.stop_on_path(cause_of(*stop, cycle), cycle);
}

void StopSupervisor::finish(std::int64_t cycle, const std::vector<device::Arm*>& arms) {
  executor_.allow_starts();
  if (const device::EmergencyStop* stop = strongest()) {
    const bool at_once = stop->category() == StopCategory::kBrakes;
    executor_.stop_for_emergency(cause_of(*stop, cycle), /*those_on_path=*/at_once, cycle);
    const bool closes = stop->pressed() && stop->category() != StopCategory::kStopAndHold;
    for (device::Arm* arm : arms)
      if (closes && !arm->lost() && (at_once || (!arm->held() && arm->at_rest()))) arm->brake();
  }
  if (!everything_) return;
  everything_->cycle = cycle;
  executor_.stop_all(*everything_, cycle);
  everything_.reset();
}

}  // namespace takt::rcc
