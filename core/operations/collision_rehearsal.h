#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/activity/motion_collisions.h"
#include "core/base/diagnostics.h"

/// What planned motions are checked with while a program is rehearsed (docs/world.md). Nothing happens where the cell
/// has no shapes, or its file switches the check off. Realtime: setup.
namespace takt::activity {

struct Rehearsal;

/// Something of a branch at a time of the rehearsal: how it believes the cell to be, and the motion that begins then.
struct PlayedStep {
  double begin = 0.0;  ///< s
  int branch = 0;
  bool timed = true;  ///< `begin` is known
  collision::Situation before;
  std::optional<CheckedMotion> motion = {};
  double stops = 0.0;  ///< s after its begin: the motion goes no further, it touches

  [[nodiscard]] double end() const { return begin + (motion ? motion->duration() : 0.0); }
};

/// What a rehearsal knows for the check. Copied with it.
struct CollisionRecord {
  command::FingerWidths widths;  ///< of grippers that have moved, m
  /// Of all branches since the outermost parallel began; outside of one: empty.
  std::vector<std::shared_ptr<const PlayedStep>> played;
  int branch = 0;                                ///< the one that is being played; 0: no parallel
  std::shared_ptr<int> branches = {};            ///< how many there were
  bool timed = true;                             ///< the times of this branch are known so far
  std::vector<FoundCollision>* found = nullptr;  ///< who wants to see the collisions; null: nobody
};

/// The cell as the rehearsal believes it to be now. The cell has shapes.
[[nodiscard]] collision::Situation situation_of(const Rehearsal& rehearsal);

/// Bodies that overlap before anything moves.
void check_start(const Rehearsal& rehearsal, Diagnostics& diagnostics);

/// A planned motion, from where the rehearsal has the cell when it begins. In a parallel it is kept until all branches
/// are known. @param unknown  arms of which nobody knows where they are meanwhile
void check_planned(Rehearsal& rehearsal, CheckedMotion motion, Diagnostics& diagnostics,
                   const std::set<std::string>& unknown = {});

/// How long what comes now takes is not known: times of this branch are not any more.
void lose_time(Rehearsal& rehearsal);

/// The fingers of a gripper have moved. @param object  that they hold now; empty: none
void note_fingers(Rehearsal& rehearsal, const std::string& gripper, double width, const std::string& object);

/// Branches that run at the same time: made before the first is played, asked once all are.
class BranchesTogether {
 public:
  explicit BranchesTogether(Rehearsal& rehearsal);
  /// Another branch begins at the time at which all do.
  void begin_branch();
  void end_branch();
  /// Checks the motions of all of them against each other. Of a parallel in a branch of another one the outer does it.
  void finish(Diagnostics& diagnostics);

 private:
  void note();

  Rehearsal& rehearsal_;
  int outer_;   ///< branch
  bool timed_;  ///< of the outer one
  bool all_timed_ = true;
  std::optional<collision::Situation> begin_;  ///< of the outermost
};

}  // namespace takt::activity
