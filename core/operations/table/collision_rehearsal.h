#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/activity/motion_collisions.h"
#include "core/base/diagnostics.h"
#include "core/operations/review/move_review.h"
#include "core/operations/review/timeline.h"

/// What planned motions are checked with while a program is rehearsed (docs/world.md). Nothing happens where the cell
/// has no shapes, or its file switches the check off. Realtime: setup.
namespace takt::operations {

struct Rehearsal;

/// What a rehearsal knows for the check. Copied with it.
struct CollisionRecord {
  expression::FingerWidths widths;  ///< of grippers that have moved, m
  /// Of all branches since the outermost parallel began; outside of one: empty.
  PlayedSteps played;
  int branch = 0;                                          ///< the one that is being played; 0: no parallel
  std::shared_ptr<BranchParents> branches = {};            ///< all that there were in the outermost parallel
  bool timed = true;                                       ///< the times of this branch are known so far
  std::vector<activity::FoundCollision>* found = nullptr;  ///< who wants to see the collisions; null: nobody
  activity::ConcurrentMotions meanwhile = {};              ///< what others do while a `move` is carried out
};

/// The cell as the rehearsal believes it to be now. The cell has shapes.
[[nodiscard]] collision::CellState situation_of(const Rehearsal& rehearsal);

/// Bodies that overlap before anything moves.
void check_start(const Rehearsal& rehearsal, Diagnostics& diagnostics);

/// A planned motion, from where the rehearsal has the cell when it begins. In a parallel it is kept until all branches
/// are known. @param unknown  arms of which nobody knows where they are meanwhile
void check_planned(Rehearsal& rehearsal, activity::CheckedMotion motion, Diagnostics& diagnostics,
                   const std::set<std::string>& unknown = {});

/// A planned motion of a net that has several.
struct TimedMotion {
  activity::CheckedMotion motion;
  double begin = 0.0;                       ///< s after the net begins
  bool timed = true;                        ///< that is known
  int branch = 0;                           ///< that it is one of, in a parallel; 0: that which is being played
  std::string arm = {};                     ///< of a `move`
  std::vector<std::string> moves = {};      ///< pointers of the `move`s in it
  std::set<std::string> never_beside = {};  ///< PlayedStep::never_beside
};
/// The same of several on one clock.
void check_together(Rehearsal& rehearsal, std::vector<TimedMotion> motions, Diagnostics& diagnostics,
                    const std::set<std::string>& unknown = {});

/// What the fingers of a gripper meet on their way to where note_fingers() has put them.
/// @param before  the cell when they began   @param closes  what is between them may be touched
/// @param pointer  of the step
void check_fingers(const Rehearsal& rehearsal, const std::string& gripper, const collision::CellState& before,
                   bool closes, const std::string& pointer, Diagnostics& diagnostics);

/// Another branch within the one that is being played: what runs at the same time in one net. @return its number; 0:
/// there is no parallel
[[nodiscard]] int branch_within(Rehearsal& rehearsal);

/// Whether motions are checked: there are shapes, and the file does not switch it off.
[[nodiscard]] bool checks_motions(const Rehearsal& rehearsal);

/// The next planned motion is that of such `move`s. @param pointers  of them; none: it is not
/// @param may_wait  it begins at rest
void note_moves(Rehearsal& rehearsal, const std::string& arm, std::vector<std::string> pointers, bool may_wait);

/// How long what comes now takes is not known: times of this branch are not any more.
void invalidate_timing(Rehearsal& rehearsal);

/// The fingers of a gripper have moved. @param object  that they hold now; empty: none
void note_fingers(Rehearsal& rehearsal, const std::string& gripper, double width, const std::string& object);

/// Branches that run at the same time: made before the first is played, asked once all are.
class BranchesTogether {
 public:
  /// @param parallel  pointer of what they belong to
  BranchesTogether(Rehearsal& rehearsal, const std::string& parallel);
  /// Another branch begins at the time at which all do.
  void begin_branch();
  void end_branch();
  /// Once all are played: whether a `move` in one of them has to be planned anew for what others do. Then the rehearsal
  /// is as it was when this was made, and all of them are to be played again.
  /// @param said  by playing them
  [[nodiscard]] bool play_again(const Diagnostics& said);
  /// Checks the motions of all of them against each other. Of a parallel in a branch of another one the outer does it.
  void finish(Diagnostics& diagnostics);

 private:
  void note();
  void go_back();

  Rehearsal& rehearsal_;
  int outer_;   ///< branch
  bool timed_;  ///< of the outer one
  bool all_timed_ = true;
  std::optional<collision::CellState> begin_;  ///< of the outermost
  std::optional<MoveReview> review_;           ///< likewise
  std::unique_ptr<const Rehearsal> before_;    ///< likewise
  std::size_t nets_ = 0, found_ = 0;           ///< how many there were before
};

}  // namespace takt::operations
