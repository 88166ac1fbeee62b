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
/// The rules are those of the rehearsal (collision::ContactRules). Thread: the program's. Realtime: setup.
class ContactGuard {
 public:
  /// What the steps in force mean to touch; asked only when something new touches.
  using TouchingNow = std::function<collision::Touching()>;

  /// The cell must outlive it.
  explicit ContactGuard(BuiltCell& built);

  /// After a cycle, or several. @param contacts  what World::take_contacts() gave
  /// @return diagnostics of contacts that nothing allows
  [[nodiscard]] Diagnostics look(std::span<const sim::BodyContact> contacts, const TouchingNow& touching);

 private:
  using Pair = std::pair<int, int>;  ///< numbers of bodies in the simulation

  [[nodiscard]] collision::Touching all_touching(const TouchingNow& touching) const;
  [[nodiscard]] bool is_known(const Pair& pair);
  [[nodiscard]] bool is_allowed(const Pair& pair, const collision::Touching& touching) const;
  [[nodiscard]] Diagnostic fault(const Pair& pair, double force) const;

  BuiltCell& built_;
  std::vector<std::string> names_;          ///< of the bodies in the simulation
  std::vector<int> numbers_;                ///< of the same in the shapes; -1: it has none there
  std::vector<bool> machines_;              ///< by number of the body; what objects do among themselves is no fault
  std::map<Pair, Nanoseconds> in_contact_;  ///< allowed once, and when they touched last
};

}  // namespace takt::cell
