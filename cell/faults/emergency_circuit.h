#pragma once

#include <optional>

#include "cell/build/built_cell.h"
#include "core/base/time.h"
#include "core/device/backend.h"

namespace takt::cell {

/// The emergency stop of a cell whose scenario presses one: the button, the latch of the core behind it, and the
/// circuit beside the core that closes the brakes. Without a latch in the cell nothing happens. Thread: the session's.
class EmergencyCircuit {
 public:
  explicit EmergencyCircuit(BuiltCell& built) : built_(built) {}

  /// The core leads the arms to rest; this circuit closes their brakes, whatever the core does.
  /// @param brakes_after  of category 1
  void press(device::StopCategory category, Nanoseconds brakes_after);
  /// The button is pulled, the latch reset.
  void reset();
  /// Before the faults of a cycle. The latch is closed once before the first cycles: somebody resets it in the morning.
  void begin_cycle();
  /// After the faults of a cycle: closes the brakes when they are due.
  void end_cycle();
  /// No net can start yet, or any more.
  [[nodiscard]] bool latched() const;

 private:
  BuiltCell& built_;
  std::optional<Nanoseconds> brakes_at_;
  bool opened_ = false;        ///< the latch has been open once
  bool reset_pending_ = true;  ///< the reset button is pressed in this cycle
};

}  // namespace takt::cell
