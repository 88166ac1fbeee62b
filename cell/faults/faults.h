#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cell/faults/fault.h"
#include "cell/file/description.h"

namespace takt::cell {

/// A fault and the time at which it begins.
struct ScheduledFault {
  Nanoseconds at = 0;
  std::unique_ptr<Fault> fault;
};

/// The faults of a scenario, in the order of their times: all diagnostics at once, with pointers. A cell whose scenario
/// presses the button gets the latch behind it. Realtime: setup.
[[nodiscard]] Result<std::vector<ScheduledFault>> make_faults(const std::vector<FaultEntry>& entries, BuiltCell& built);

/// Diagnostics for faults that cannot happen to machines alone, without the core.
[[nodiscard]] Diagnostics check_faults_of_machines(const std::vector<FaultEntry>& entries);

/// One entry of "faults", of all kinds that are registered.
[[nodiscard]] const Form& fault_form();

/// Lets faults happen to the simulated machines of a cell. Thread: the session's.
class Faults {
 public:
  using Note = FaultScene::Note;

  /// @param faults  outlive it; @param seed  of the scenario, for noise
  Faults(const std::vector<ScheduledFault>& faults, BuiltCell& built, std::uint64_t seed, Note note)
      : faults_(faults), scene_{.built = built, .seed = seed, .note = std::move(note)} {}

  /// Before each cycle: what is due happens now. @param now  since the machines began
  void apply(Nanoseconds now);
  /// No net can start yet, or any more.
  [[nodiscard]] bool latched() const { return scene_.circuit.latched(); }

 private:
  struct Lasting {
    Fault* fault;
    Nanoseconds until;
  };

  const std::vector<ScheduledFault>& faults_;
  FaultScene scene_;
  std::size_t next_ = 0;
  std::vector<Lasting> lasting_;
};

}  // namespace takt::cell
