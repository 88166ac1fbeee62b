#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/fault_entry.h"

namespace takt::cell {

/// Gives a cell whose scenario presses a button the latch for it, and checks the arms and bodies that the faults name.
/// Realtime: setup.
void add_emergency_stop(const std::vector<FaultEntry>& faults, BuiltCell& built, Diagnostics& diagnostics);

/// Lets the faults of a scenario happen to its simulated machines. Thread: the session's.
class Faults {
 public:
  using Note = std::function<void(std::string_view what, std::string_view text)>;

  /// @param seed  of the scenario, for noise
  Faults(const std::vector<FaultEntry>& entries, BuiltCell& built, std::uint64_t seed)
      : entries_(entries), built_(built), seed_(seed) {}

  /// Before each cycle: what is due happens now. The latch is closed once before the first cycles: somebody resets it
  /// in the morning. @param now  since the machines began
  void apply(Nanoseconds now, const Note& note);
  /// No net can start yet, or any more.
  [[nodiscard]] bool latched() const;

 private:
  void happen(const FaultEntry& fault, Nanoseconds now, const Note& note);
  void press(const FaultEntry& fault, Nanoseconds now);
  void begin_push(const FaultEntry& fault, Nanoseconds now);
  void end_pushes(Nanoseconds now);
  void end_wrong(Nanoseconds now, const Note& note);
  void begin_lock_fault(const FaultEntry& fault, Nanoseconds now, const Note& note);
  void end_lock_faults(Nanoseconds now, const Note& note);
  void set_lock_faults(const std::string& changer);
  /// What all that push a body exert on it.
  void push(int body);

  struct Push {
    int body;
    Eigen::Vector3d force;  ///< N
    Nanoseconds until;
  };

  struct LockFault {
    std::string changer;
    bool opens;
    Nanoseconds until;
  };

  const std::vector<FaultEntry>& entries_;
  BuiltCell& built_;
  std::uint64_t seed_;
  std::size_t next_ = 0;
  std::map<std::string, std::pair<Nanoseconds, FaultEntry::Kind>> wrong_until_;  ///< devices; how their fault came
  std::vector<Push> pushes_;
  std::vector<LockFault> lock_faults_;
  std::optional<Nanoseconds> brakes_at_;  ///< when the circuit of the button closes all brakes
  bool opened_ = false;                   ///< the latch has been open once
  bool reset_pending_ = true;             ///< the reset button is pressed in this cycle
};

}  // namespace takt::cell
