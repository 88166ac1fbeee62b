#pragma once

#include <optional>
#include <string>

#include "core/operations/command/command_builder.h"
#include "core/operations/review/move_review.h"

/// Motions of `move` in a transaction beside what its other commands do meanwhile (docs/planning.md, "Beside machines
/// that move"). Realtime: setup.
namespace takt::operations {

struct Rehearsal;

/// Has a transaction planned again until each `move` in it keeps clear of the others, for one rehearsal of its step.
/// Of a transaction in a parallel that does it: branches and commands run at the same time.
class CommandReview {
 public:
  /// Both must outlive it.
  CommandReview(const OperationCommand& root, Rehearsal& rehearsal);

  /// What its commands have to be made with.
  [[nodiscard]] const activity::ConcurrentMotions& meanwhile() const { return meanwhile_; }
  /// Once all are planned. @param wrong  what planning has said   @return true: they are to be made and planned again
  [[nodiscard]] bool plan_again(const CommandBuilder& tree, const Diagnostics& wrong);
  /// Gives the rehearsal what was found, for the run; notes say what people should know of it.
  void finish(Diagnostics& diagnostics);

 private:
  [[nodiscard]] bool is_in_parallel() const;
  /// What they do, as the review wants it. Where they could not be planned, what they did before, without the `move`s.
  [[nodiscard]] PlayedSteps steps_of(const CommandBuilder& tree, bool planned);

  const OperationCommand& root_;
  Rehearsal& rehearsal_;
  activity::ConcurrentMotions meanwhile_;
  std::optional<MoveReview> review_;  ///< null: there is nothing to review
  PlayedSteps last_ = {};
  BranchParents branches_ = {};
};

/// The pointer under which a transaction finds what was found for its `move`s: that of the outermost parallel around
/// it, else its own.
[[nodiscard]] activity::ConcurrentMotions meanwhile_of(const OperationCommand& root,
                                                       activity::ConcurrentMotions around);

}  // namespace takt::operations
