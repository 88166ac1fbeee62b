#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "scenario/cell_builder.h"
#include "scenario/fault.h"

namespace takt::scenario {

/// Checks the names in faults against the cell, and gives it what they need, the latch of a button for instance.
/// Realtime: setup.
void add_faults(const FaultList& faults, BuiltCell& built, Diagnostics& diagnostics);

/// Lets the faults of a scenario happen to its simulated machines. Thread: the session's.
class Faults {
 public:
  using Note = FaultContext::Note;

  /// @param seed  of the scenario, for noise
  Faults(const FaultList& entries, BuiltCell& built, std::uint64_t seed)
      : entries_(entries), context_{.built = built, .seed = seed} {}

  /// Before each cycle: what is due happens now. The latch is closed once before the first cycles: somebody resets it
  /// in the morning.
  void apply(const Note& note);
  /// No net can start yet, or any more.
  [[nodiscard]] bool latched() const;

 private:
  void update_button();
  void begin(const Fault& fault);
  void end_what_is_over();
  void close_brakes();

  const FaultList& entries_;
  FaultContext context_;
  std::size_t next_ = 0;
  std::vector<Nanoseconds> until_;  ///< when each of the active ones ends
  bool opened_ = false;             ///< the latch has been open once
};

}  // namespace takt::scenario
