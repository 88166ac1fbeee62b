// What steps and nodes of a rehearsal have in common.
#include "core/operations/table/step.h"

#include <nlohmann/json.hpp>

namespace takt::operations {

nlohmann::ordered_json Step::left_steps() const { return {}; }

void keep_agreed_modes(const Rehearsal& other, Rehearsal& rehearsal) {
  std::erase_if(rehearsal.modes, [&](const auto& known) {
    const auto found = other.modes.find(known.first);
    return found == other.modes.end() || found->second != known.second;
  });
}

void settle_rehearsal(Rehearsal& rehearsal, Diagnostics& diagnostics) {
  if (!rehearsal.open) return;
  diagnostics.note(rehearsal.open->pointer, "what comes next is not a motion of this arm: it stops at the goal",
                   "a motion of the same arm next, or no blend");
  rehearsal.open.reset();
}

}  // namespace takt::operations
