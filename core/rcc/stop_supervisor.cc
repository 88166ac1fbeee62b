#include "core/rcc/stop_supervisor.h"

#include "core/net/format_text.h"

namespace takt::rcc {

using device::StopCategory;

const device::EmergencyStop* StopSupervisor::strongest() const {
  const device::EmergencyStop* strongest = nullptr;
  for (const device::EmergencyStop* stop : latches_)
    if (stop->latched() && (strongest == nullptr || stop->category() < strongest->category())) strongest = stop;
  return strongest;
}

net::Cause StopSupervisor::cause_of(const device::EmergencyStop& stop, std::int64_t cycle) {
  const net::Text text =
      stop.silent() ? net::format_text("{}: its input sends nothing", stop.name()) : net::Text(stop.name());
  return {.code = net::Cause::Code::kDevice, .text = text, .cycle = cycle};
}

void StopSupervisor::begin(std::int64_t cycle) {
  executor_.stop_where_lost(cycle);
  const device::EmergencyStop* stop = strongest();
  if (stop != nullptr && stop->category() != StopCategory::kBrakes)
    executor_.stop_on_path(cause_of(*stop, cycle), cycle);
}

void StopSupervisor::close_brakes(bool at_once) {
  for (Braked& one : arms_) {
    const bool due = !one.arm->lost() && (at_once || (!one.arm->held() && one.arm->at_rest()));
    if (one.closed || !due) continue;
    one.closed = true;
    one.arm->brake();
  }
}

void StopSupervisor::finish(std::int64_t cycle) {
  executor_.allow_starts();
  if (const device::EmergencyStop* stop = strongest()) {
    const bool at_once = stop->category() == StopCategory::kBrakes;
    executor_.stop_for_emergency(cause_of(*stop, cycle), /*those_on_path=*/at_once, cycle);
    if (stop->pressed() && stop->category() != StopCategory::kStopAndHold) close_brakes(at_once);
  } else {
    for (Braked& one : arms_) one.closed = false;
  }
  if (!everything_) return;
  everything_->cycle = cycle;
  executor_.stop_all(*everything_, cycle);
  everything_.reset();
}

}  // namespace takt::rcc
