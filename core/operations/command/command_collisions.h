#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/operations/command/command_builder.h"

/// Planned motions of one transaction against each other and against the cell (docs/world.md). Realtime: setup.
namespace takt::operations {

/// What the commands of a tree mean to touch.
[[nodiscard]] collision::Touching touching(const CommandBuilder& tree);

/// When commands begin after the first, s: of those that begin with their transaction, or when a planned motion of
/// which that is known has completed. Of others nothing is known before the run.
[[nodiscard]] std::map<const OperationCommand*, double> begin_times(const CommandBuilder& tree);

/// A planned motion of a tree as it is checked.
struct TreeMotion {
  const CommandBuilder::Part* part = nullptr;
  activity::CheckedMotion motion = {};
  double begin = 0.0;                       ///< s after the tree; where it is not known, when it may be at the soonest
  bool timed = false;                       ///< `begin` is known
  std::size_t line = 0;                     ///< motions of one line follow each other, those of two may run together
  std::set<std::string> never_beside = {};  ///< PlayedStep::never_beside
};
/// In the order of the tree, which has to be planned and has to outlive them.
[[nodiscard]] std::vector<TreeMotion> motions_of(const CommandBuilder& tree, const Rehearsal& rehearsal);

/// How long the commands of a tree take. Where that is not known, times are not known from here on.
void rehearse_time(const CommandBuilder& tree, Rehearsal& rehearsal);

/// Checks the planned motions of a tree: those of which it is known when they begin on one clock, each other for itself
/// from where its arm begins. Where other arms of the tree are meanwhile is not known then: notes say where two motions
/// would meet if the times fit (possible_meetings.h).
void check_motions(const CommandBuilder& tree, Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::operations
