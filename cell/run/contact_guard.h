#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cell/build/built_cell.h"
#include "core/collision/contact_rules.h"

namespace takt::cell {

/// Looks at the contacts of the simulation: one that no step means is a fault (docs/world.md, "Collisions in the run").
/// It goes on to look until the blow has passed its peak.
/// The rules are those of the rehearsal (collision::ContactRules). Thread: the program's. Realtime: setup.
class ContactGuard {
 public:
  /// What the steps in force mean to touch; asked only when something new touches.
  using TouchingNow = std::function<collision::Touching()>;

  /// The cell must outlive it.
  explicit ContactGuard(BuiltCell& built);

  /// After a cycle, or several. @param contacts  what World::take_contacts() gave
  void look(std::span<const sim::BodyContact> contacts, const TouchingNow& touching);
  /// Something has touched that nothing allows.
  [[nodiscard]] bool has_crashed() const { return !crashes_.empty(); }
  /// After that: its force has passed its peak, or half a second has gone by.
  [[nodiscard]] bool is_over() const;
  /// What has touched so, with the force of the first cycle and the greatest.
  [[nodiscard]] Diagnostics faults() const;

 private:
  using Pair = std::pair<int, int>;  ///< numbers of bodies in the simulation
  struct Crash {
    Pair pair;
    Nanoseconds begin = 0, peak_time = 0;
    double first = 0.0, peak = 0.0;  ///< N
  };

  [[nodiscard]] collision::Touching all_touching(const TouchingNow& touching) const;
  [[nodiscard]] bool is_known(const Pair& pair);
  [[nodiscard]] bool is_allowed(const Pair& pair, const collision::Touching& touching) const;
  void note_crash(const Pair& pair, double force);
  [[nodiscard]] Diagnostic fault(const Crash& crash) const;

  BuiltCell& built_;
  std::vector<std::string> names_;          ///< of the bodies in the simulation
  std::vector<int> numbers_;                ///< of the same in the shapes; -1: it has none there
  std::vector<bool> machines_;              ///< by number of the body; what objects do among themselves is no fault
  std::map<Pair, Nanoseconds> in_contact_;  ///< allowed once, and when they touched last
  std::vector<Crash> crashes_;
};

}  // namespace takt::cell
