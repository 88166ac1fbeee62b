#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/activity/meanwhile.h"
#include "core/operations/review/timeline.h"

/// Motions of `move` beside what other branches do meanwhile (docs/planning.md, "ConcurrentMotionCheck machines that
/// move"). Realtime: setup.
namespace takt::operations {

/// Branches of a parallel by number, each with the one that it is a part of. Number 0 is what is around all of them.
using BranchParents = std::vector<int>;

/// Looks at what the branches of a parallel have done in the rehearsal, and says what each `move` has to keep clear of
/// when they are played again. Owned by the rehearsal of one outermost parallel.
class MoveReview {
 public:
  /// What becomes of motions at times that are not known, where no path keeps clear of all that they sweep.
  enum class Unclear {
    kLeftOut,  ///< they are left out, and a note says so
    kInTheWay  ///< there is no path
  };
  /// @param parallel  its pointer   @param spaces  what was found; null: nothing so far
  MoveReview(std::string parallel, std::shared_ptr<const activity::MeanwhileSpaces> spaces,
             Unclear unclear = Unclear::kLeftOut)
      : parallel_(std::move(parallel)), unclear_(unclear), before_(spaces), spaces_(std::move(spaces)) {}

  /// @param said  what playing all branches has said   @return true: a `move` has to be planned again
  [[nodiscard]] bool review(const Timeline& timeline, const BranchParents& parents, const Diagnostics& said);

  /// For the branches when they are played again, and for the run.
  [[nodiscard]] const std::shared_ptr<const activity::MeanwhileSpaces>& spaces() const { return spaces_; }
  /// What people should know of it.
  [[nodiscard]] const Diagnostics& notes() const { return notes_; }

 private:
  /// Times after a `move` begins in which others have been in its way, s.
  struct Window {
    double from = 0.0, to = 0.0;
  };
  struct Known {
    std::vector<Window> windows = {};
    std::vector<Window> first_windows = {};  ///< without a wait
    int tries = 0;                           ///< how often windows were added
    double wait = 0.0;                       ///< s: how much later it begins
    bool waits_in_vain = false;              ///< no later begin is of use
    bool reviewed = false;                   ///< it was played with what others do in mind
    bool beside_any = false;                 ///< it was planned beside motions of which it is not known when they begin
    bool leaves_out_any = false;             ///< no path keeps clear of those
  };

  static void join(std::vector<Window>& windows);
  void review_step(const Timeline& timeline, const BranchParents& parents, const PlayedStep& step,
                   const Diagnostics& said, std::map<std::string, activity::MeanwhileSpace>& found);
  /// What was found when this parallel was played before, in a loop or by another call; null: nothing.
  [[nodiscard]] std::shared_ptr<const activity::MeanwhileSpace> of_rounds_before(const std::string& pointer) const;
  /// No path keeps clear of what others sweep: it begins when the next of their motions has ended, if there is one.
  static void wait_longer(const PlayedStep& step, const std::vector<double>& ends, Known& known);
  /// No path keeps clear of what may come at any time: it is left out from now on.
  void give_up_any(const PlayedStep& step, const Diagnostics& said, Known& known);

  std::string parallel_;
  Unclear unclear_;
  std::shared_ptr<const activity::MeanwhileSpaces> before_, spaces_;
  std::map<std::string, Known> known_;  ///< by the pointer of the first `move` of a step
  int rounds_ = 0;
  Diagnostics notes_;
};

}  // namespace takt::operations
