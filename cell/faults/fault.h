#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cell/build/built_cell.h"
#include "cell/faults/emergency_circuit.h"
#include "cell/faults/pushes.h"
#include "core/base/time.h"

namespace takt::cell {

class Fault;

/// How many faults a tool changer has at once.
struct LockFaults {
  int without_air = 0, open = 0;
};

/// What the faults of a run act on, and what several of them share. Thread: the session's.
struct FaultScene {
  using Note = std::function<void(std::string_view what, std::string_view text)>;

  BuiltCell& built;
  std::uint64_t seed;  ///< of the scenario, for noise
  Note note;           ///< for the log: kind of the fault, and what happens
  EmergencyCircuit circuit{built};
  Pushes pushes{built};
  /// Of two faults of one device the newer one holds.
  std::map<std::string, const Fault*, std::less<>> newest_of_device = {};
  std::map<std::string, LockFaults, std::less<>> lock_faults = {};
};

/// Something that happens to the machines at one time, whatever the program does, and what ends it. Thread: the
/// session's, between the cycles.
class Fault {
 public:
  virtual ~Fault() = default;
  virtual void begin(FaultScene& scene) = 0;
  /// After `duration`.
  virtual void end(FaultScene& /*scene*/) {}

  std::optional<Nanoseconds> duration;  ///< null: it happens, and nothing ends
};

}  // namespace takt::cell
