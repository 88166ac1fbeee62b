#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/device.h"

namespace takt::device {

/// The latch of an emergency stop (row S4). It starts latched and latches again whenever its chain is opened, however
/// short; it is reset only by a rising edge of the reset signal that is seen in a later cycle than the stop, while the
/// chain has been healthy since the cycle before. While it is latched no net may start, and every net that holds an arm
/// ends: by categories 1 and 2 its arms come to rest on their paths, together (row S1), and by 1 their brakes close
/// then; by 0 they close at once. Nothing resumes by itself.
///
/// Inputs are written from any thread, lock-free, and kept in one atomic word, so the cycle sees them in the order in
/// which they were written and never half of them. An opening stays in that word until the cycle has seen it. Each
/// write is also a sign of life: with `input_age_max` an input that writes no more counts as an open chain.
/// The cycle thread calls begin_cycle().
class EmergencyStop final : public Device {
 public:
  static constexpr std::string_view kKind = "emergency_stop";

  /// @param input_age_max  the input writes at least once in that time, by the core's clock, or it counts as open. 0:
  /// it writes only what changes, as a simulated button does
  explicit EmergencyStop(std::string name, Nanoseconds input_age_max = 0);

  [[nodiscard]] std::string_view kind() const override { return kKind; }

  // -- Inputs: any thread. They count from the next cycle on. Realtime: cyclic, lock-free. ----------------------------
  /// The chain of buttons, doors and enabling devices is closed. False before it is first set.
  void set_healthy(bool healthy);
  /// How arms come to rest when the chain is opened from now on; an open chain that is given a stronger one takes it.
  void set_category(StopCategory category);
  /// Opens the chain with this category, in one write.
  void press(StopCategory category);
  /// The level of the reset button.
  void set_reset(bool pressed);
  /// The input lives and nothing has changed.
  void beat();

  // -- As of the newest cycle: cycle thread. --------------------------------------------------------------------------
  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;
  [[nodiscard]] bool latched() const { return latched_; }
  /// It is latched and has been open before: somebody pressed it.
  [[nodiscard]] bool pressed() const { return latched_ && was_open_; }
  /// The input has written nothing for `input_age_max`.
  [[nodiscard]] bool silent() const { return silent_; }
  /// Of this stop: the strongest since it was latched. Before the first one, and once it is reset, as it was set.
  [[nodiscard]] StopCategory category() const { return category_; }

 private:
  template <class Change>
  void write(Change change);

  /// Bits 0: chain closed, 1: reset pressed, 2-3: category, 4-5: opened since the last cycle, 0 or 3 less the strongest
  /// category of that, 8 and up: number of writes.
  std::atomic<std::uint64_t> input_;
  const Nanoseconds input_age_max_;

  bool reset_before_ = true;  // a button that is stuck from the beginning gives no edge
  bool healthy_before_ = false;
  bool latched_ = true;
  bool was_open_ = false;
  bool silent_ = false;
  StopCategory category_ = StopCategory::kStopThenBrakes;
  std::uint64_t writes_before_ = 0;
  Nanoseconds written_ = 0;  // time of the first cycle that saw the newest write
};

}  // namespace takt::device
