#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/command/command_tree.h"
#include "core/command/start_order.h"
#include "core/kinematics/types.h"

namespace takt::command {

/// Where the arms of a tree are when its commands begin, as far as that can be known before. A planned motion that
/// follows others on its arm must begin where the last one comes to its natural end: that it does, and is not cut
/// short, has to follow from what starts it. Used by plan() (motion_action.h); commands come in the order of their
/// ranks. Realtime: setup.
class StartPositions {
 public:
  /// @param places  where arms are before the first cycle; of others their set point counts
  StartPositions(const CommandTree& tree, expression::Places places);

  /// Where each arm of command `i` is when it begins. @return diagnostics without locations if that depends on the run.
  [[nodiscard]] Result<expression::Places> begin_of(int i) const;
  /// The same, and where the other arms of the tree are then: of size 0 where that depends on the run.
  [[nodiscard]] Result<expression::Places> all_at_begin_of(int i) const;
  /// The same for a command that says itself where its arm is when it begins. @return diagnostics if it will be
  /// elsewhere, as far as that is known. @param q  rad or m
  [[nodiscard]] Result<expression::Places> all_at_given_begin(int i, const kinematics::JointVector& q) const;
  /// Takes note of where command `i`, which is planned by now or needs no plan, comes to its natural end.
  void note(int i);
  /// Command `i` could not be planned: where its arms are after it is not known.
  void note_unplanned(int i) { unplanned_.insert(i); }
  /// Where command `i` begins depends on one that could not be planned: its errors may come from there.
  [[nodiscard]] bool follows_unplanned(int i) const;
  /// Where an arm is when the tree has ended; nothing if that depends on the run, or nothing drives it. A cancel from
  /// outside does not count: what follows a tree that was cancelled is given up.
  [[nodiscard]] std::optional<kinematics::JointVector> end_of(const std::string& device) const;
  /// TreeEnd::left.
  [[nodiscard]] const CommandNode* left_in_motion() const;
  /// Where every arm is once all have come to their natural ends; one that does not say is where it was.
  [[nodiscard]] const expression::Places& nominal_ends() const { return nominal_; }

 private:
  void add_others(int i, expression::Places& places) const;
  [[nodiscard]] bool is_last_of_all(int i) const;
  [[nodiscard]] bool cuts_short(const EventHandler& handler, int i) const;
  [[nodiscard]] bool speaks_of_end(const expression::ExpressionPtr& state, int i) const;
  [[nodiscard]] const CommandNode& node(int i) const { return *tree_.at(i).node; }
  [[nodiscard]] kinematics::JointVector before_all(const std::string& device, const expression::MountedArm& arm) const;
  [[nodiscard]] std::optional<kinematics::JointVector> begin_of(int i, const std::string& device,
                                                                const expression::MountedArm& arm) const;
  [[nodiscard]] bool in_first_cycle(int i) const;
  [[nodiscard]] const std::vector<int>& drivers_of(const std::string& device) const;
  [[nodiscard]] int last_of(const std::vector<int>& commands) const;
  [[nodiscard]] std::vector<int> rivals_before(int i, const std::string& device) const;
  [[nodiscard]] bool begins_at_end_of(int i, int before) const;
  [[nodiscard]] bool is_natural_end(const expression::ExpressionPtr& state, int before, int i) const;
  [[nodiscard]] bool may_be_cancelled(int before, int i) const;
  [[nodiscard]] bool may_be_stopped(int before, int i) const;
  [[nodiscard]] bool is_forwarded_to(int i, int around, bool by_all) const;
  [[nodiscard]] bool runs_for_certain(int i) const;
  [[nodiscard]] bool follows_for_certain(const expression::ExpressionPtr& state) const;
  [[nodiscard]] bool is_cut_short(int i) const;
  void report_unknown(int i, const std::string& device, Diagnostics& diagnostics) const;

  const CommandTree& tree_;
  StartOrder order_;
  std::map<std::string, std::vector<int>> drivers_;            ///< of each device and actuator: who gives it set points
  std::map<std::string, const expression::MountedArm*> arms_;  ///< those of the tree, by the name of the device
  expression::Places begins_, nominal_;
  std::map<int, expression::Places> ends_;  ///< of commands that begin at a known position
  std::set<int> unplanned_;
};

}  // namespace takt::command
