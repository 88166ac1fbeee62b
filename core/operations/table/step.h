#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/context.h"
#include "core/base/diagnostics.h"
#include "core/expression/cell.h"
#include "core/net/description.h"
#include "core/operations/table/collision_rehearsal.h"
#include "core/operations/table/parameter.h"
#include "core/operations/table/tool_choice.h"

namespace takt::operations {

/// A net as a step of a program would load it.
struct RehearsedNet {
  std::string step;     ///< name of the step
  std::string pointer;  ///< of the step in its file
  net::NetDescription net;
};

/// The state that checking a program carries along: where arms would be, what would be known.
struct Rehearsal {
  expression::Cell cell;                                          ///< copy; fitted frames enter at their nominal pose
  std::map<std::string, kinematics::JointVector, std::less<>> q;  ///< planned position per arm
  std::map<std::string, device::ControlMode, std::less<>> modes;  ///< of each arm; not there: not known
  std::map<std::string, bool, std::less<>> touched;               ///< the last motion of the arm was guarded
  std::map<std::string, std::string, std::less<>> contacts;       ///< recorded contacts: name, arm
  std::set<std::string, std::less<>> estimates;                   ///< poses that have been fitted
  std::map<std::string, std::string, std::less<>> told_masses;    ///< not checked yet: gripper, pointer of the mass
  std::set<std::string, std::less<>> one_of_many;  ///< objects that a grip moved without a name: it may be any like it
  /// Arms of which a step failed: where they are after it, and with them what they hold, is not known.
  std::set<std::string> lost = {};
  double duration = 0.0;                                  ///< s, of all planned motions and waits
  std::int64_t most_rounds = 2;                           ///< of sequences that do the same each time
  std::int64_t effort = 0;                                ///< nodes that were played
  std::set<std::string, std::less<>>* claimed = nullptr;  ///< gets the devices that nets drive; may be null
  net::Environment* devices = nullptr;                    ///< nets are verified with them; null: they are not
  std::string step;                                       ///< name of the step that is played
  /// The last motion may be left for another one of its arm. Nothing has gone on with it so far.
  struct Open {
    std::string arm, pointer;  ///< arm: as Step::moved_arm() has it
  };
  std::optional<Open> open = {};
  std::vector<RehearsedNet>* nets = nullptr;  ///< gets the nets; may be null
  CollisionRecord collisions = {};
};

/// What comes next does not go on with the motion that may be left: a note says that the arm stops.
void settle_rehearsal(Rehearsal& rehearsal, Diagnostics& diagnostics);

/// Of alternatives only those modes are known in which arms are after each of them.
void keep_agreed_modes(const Rehearsal& other, Rehearsal& rehearsal);

enum class Progress { kRunning, kDone, kFailed };

/// One execution of a step. Destroyed when it is done, failed or given up.
class StepRun {
 public:
  virtual ~StepRun() = default;
  /// Called between cycles, as often as needed; never blocks. Diagnostics, with pointers below the step, say why it
  /// failed.
  virtual Progress advance(activity::Context& context, Diagnostics& diagnostics) = 0;
  /// Asks for a graceful end (row L6); advance() then comes to an end. A step that is done at once needs none.
  virtual void cancel(activity::Context& context) { (void)context; }
  /// Of a step that has absorbed others: which of them is being done, from 0.
  [[nodiscard]] virtual std::size_t part() const { return 0; }
  /// It is the one that is being done: nothing that it goes on with is before it any more.
  [[nodiscard]] virtual bool begun() const { return true; }
  /// It has taken over what it goes on with, in motion.
  [[nodiscard]] virtual bool has_taken_over() const { return false; }
  /// The program may look for what comes next while it runs on: a motion that another one can go on with.
  [[nodiscard]] virtual bool can_blend_out() const { return false; }
};

/// A leaf of a program tree: immutable after parsing.
class Step {
 public:
  virtual ~Step() = default;
  /// Plays the step on the rehearsal's state: everything that can be found wrong before anything moves.
  /// @param pointer  of the step in its file. Realtime: setup.
  virtual void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const = 0;
  /// A new execution; it may refer to the step, which must outlive it.
  [[nodiscard]] virtual std::unique_ptr<StepRun> begin() const = 0;
  /// Takes the step that follows it in its sequence into itself, so that both run as one (blended motions). Called
  /// while a program is made. @return false if they stay two; then `next` is untouched.
  virtual bool absorb(Step& next) {
    (void)next;
    return false;
  }
  /// Of a planned motion: the arm that it moves, or both as one name (moved_by()). Empty: everything before it has to
  /// be over when it begins.
  [[nodiscard]] virtual std::string moved_arm() const { return {}; }
  /// What moved_arm() was left with, as steps of a file; null: the step as it is.
  [[nodiscard]] virtual nlohmann::ordered_json left_steps() const;
  /// The tools that it works with, of each arm that it drives. They are put in force before it is rehearsed, and before
  /// it begins.
  [[nodiscard]] virtual ArmTools arm_tools() const { return {}; }
  /// A planned motion can be planned before the one that it goes on with has ended.
  [[nodiscard]] virtual bool can_blend_from(const expression::Cell& cell) const {
    (void)cell;
    return false;
  }
};

}  // namespace takt::operations
