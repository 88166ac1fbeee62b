#pragma once

#include <map>
#include <optional>

#include "core/operations/command_builder.h"

/// Planned motions of one transaction against each other and against the cell (docs/world.md). Realtime: setup.
namespace takt::activity {

/// What the commands of a tree mean to touch.
[[nodiscard]] collision::Touching touching(const CommandBuilder& tree);

/// When commands begin after the first, s: of those that begin with their transaction, or when a planned motion of
/// which that is known has completed. Of others nothing is known before the run.
[[nodiscard]] std::map<const OperationCommand*, double> begin_times(const CommandBuilder& tree);

/// Checks the planned motions of a tree: those of which it is known when they begin on one clock, each other for itself
/// from where its arm begins. Where other arms of the tree are meanwhile is not known then: notes say where two motions
/// would meet if the times fit (possible_meetings.h).
void check_motions(const CommandBuilder& tree, Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::activity
