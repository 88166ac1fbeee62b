#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/device.h"

namespace takt::device {

/// The latch of an emergency stop (row S4): it starts latched, latches again whenever its chain is not healthy, and is
/// reset only by a rising edge of the reset signal while the chain is healthy. While it is latched no net may start,
/// and every net that holds an arm ends: by categories 1 and 2 its arms come to rest on their paths, together (row S1),
/// and by 1 their brakes close then; by 0 they close at once. Nothing resumes by itself.
///
/// Inputs may be set from any thread; they count from the next cycle on. The cycle thread calls begin_cycle().
class EmergencyStop final : public Device {
 public:
  static constexpr std::string_view kKind = "emergency_stop";

  explicit EmergencyStop(std::string name) : Device(std::move(name)) {}

  [[nodiscard]] std::string_view kind() const override { return kKind; }

  /// The chain of buttons, doors and enabling devices is closed. False before it is first set.
  void set_healthy(bool healthy) { healthy_.store(healthy, std::memory_order_relaxed); }
  /// How arms come to rest while the chain is open.
  void set_category(StopCategory category) { category_.store(category, std::memory_order_relaxed); }
  [[nodiscard]] StopCategory category() const { return category_.load(std::memory_order_relaxed); }
  /// The level of the reset button.
  void set_reset(bool pressed) { reset_.store(pressed, std::memory_order_relaxed); }

  void begin_cycle(std::int64_t, Nanoseconds) override {
    const bool healthy = healthy_.load(std::memory_order_relaxed), reset = reset_.load(std::memory_order_relaxed);
    if (healthy && reset && !reset_before_) latched_ = false;
    if (!healthy) latched_ = true;
    was_open_ = was_open_ || !latched_;
    reset_before_ = reset;
  }
  void add_state(StateWords& words) const override { words.add(std::uint64_t{latched_}); }
  [[nodiscard]] bool latched() const { return latched_; }
  /// It is latched and has been open before: somebody pressed it.
  [[nodiscard]] bool pressed() const { return latched_ && was_open_; }

 private:
  std::atomic<bool> healthy_ = false, reset_ = false;
  std::atomic<StopCategory> category_ = StopCategory::kStopThenBrakes;
  bool reset_before_ = true;  // a button that is stuck from the beginning gives no edge
  bool latched_ = true;
  bool was_open_ = false;
};

}  // namespace takt::device
