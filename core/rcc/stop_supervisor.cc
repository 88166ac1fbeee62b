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
  const device::EmergencyStop* stop = strongest();
  executor_.set_emergency(stop != nullptr ? std::optional(cause_of(*stop, cycle).text) : std::nullopt);
  executor_.stop_where_lost(cycle);
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
  auto everything = take_stop_of_all();
  if (!everything) return;
  everything->cycle = cycle;
  executor_.stop_all(*everything, cycle);
}

void StopSupervisor::stop_all(net::Cause::Code code, std::string_view text) {
  CauseIs is = CauseIs::kFree;
  if (cause_is_.compare_exchange_strong(is, CauseIs::kBeingWritten, std::memory_order_acquire)) {
    cause_ = {.code = code, .text = net::Text(text), .cycle = -1};
    cause_is_.store(CauseIs::kWritten, std::memory_order_release);
  }
  everything_.store(true, std::memory_order_release);
}

std::optional<net::Cause> StopSupervisor::take_stop_of_all() {
  if (!everything_.load(std::memory_order_relaxed) || !everything_.exchange(false, std::memory_order_acq_rel))
    return std::nullopt;
  net::Cause cause{.code = net::Cause::Code::kAborted, .text = net::Text("a stop of all nets"), .cycle = -1};
  if (cause_is_.load(std::memory_order_acquire) == CauseIs::kWritten) {
    cause = cause_;
    cause_is_.store(CauseIs::kFree, std::memory_order_release);
  }
  return cause;
}

}  // namespace takt::rcc
