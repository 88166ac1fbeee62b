#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/activity/actuator_state.h"
#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/command/actions/compliance_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/command.h"
#include "core/motion/leg.h"

/// What an activity is made of (docs/activity-layer.md). Realtime: setup.
namespace takt::activity {

class RunView;

/// A motion that another one may go on with, and how far before its goal.
struct BlendSource {
  std::shared_ptr<const motion::Motion> motion;
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();  ///< the frame that its Cartesian pieces move
  motion::Blend blend;
  std::shared_ptr<const motion::Motion> partner = {};  ///< of a second arm on the same clock, with the same law
  Eigen::Isometry3d partner_X_FM = Eigen::Isometry3d::Identity();  ///< the same frame in the flange of that one
  std::string arm = {};                                            ///< whose motion it is; of two the leader
  std::optional<expression::State> abort_if = {};  ///< must not hold on what is left of it (DualEntryMotion::abort_if)
  std::optional<command::SpringParameters> compliance = {};  ///< of the arm meanwhile
};

/// What precedes on an actuator when an activity is prepared.
struct Predecessor {
  /// When everything before has come to its natural end.
  ActuatorState at_end;
  /// The motion that runs on it and may be left, at this path time at the soonest, with this lead (s).
  struct BlendOut {
    BlendSource motion;
    double tau = 0.0, lead = 0.0;
    /// Its clock runs at rate 1 and in whole cycles: the state at tau is the one that will be sent.
    bool exact = true;
  };
  std::optional<BlendOut> leaving;
};

/// A planned motion of another activity, which runs or is about to begin.
struct ConcurrentMotion {
  std::string name;  ///< of the activity
  command::PlannedMotion motion;
  command::Actuator actuator;
  std::optional<double> begin = {};                  ///< s from now, negative: since; nothing: it is not known
  std::set<std::string, std::less<>> touching = {};  ///< what it means to touch: the first touch ends it
};

/// All that an activity may know when it is prepared.
struct PlanningContext {
  const expression::Cell& cell;
  Nanoseconds period = kMillisecond;
  std::map<std::string, Predecessor, std::less<>> predecessors;  ///< of each of its actuators
  bool checks_collisions = false;  ///< of programs that nobody rehearses: planned motions must not collide
  bool is_part = false;            ///< something may come after it in the same net
  /// Of these programs: what other machines do meanwhile, as far as it is planned.
  std::vector<ConcurrentMotion> beside = {};
};

/// What an activity says of one of its actuators.
struct EndState {
  ActuatorState after;
  /// The motions of which one is its last on this actuator, each with the command whose clock shows where it is. Empty:
  /// it is not left before its end.
  struct Last {
    expression::SubjectPtr command;
    BlendSource motion;
  };
  std::vector<Last> last;
  /// It does not drive it any more when one of `last` of another actuator moves: that one may be left without it.
  bool released = false;
};

/// One of the endings of an activity, of which exactly one comes: by which state that shows from the begin
/// of that ending on, and what is known of its actuators then.
struct Ending {
  expression::State taken;
  std::map<std::string, ActuatorState, std::less<>> after;
};

/// A planned motion inside of an activity: how people see where it has come to.
struct PlannedPart {
  expression::SubjectPtr command;   ///< whose clock shows where it is
  std::vector<double> handed_over;  ///< path time at which each of its motions but the last hands over, s
  double begin = 0.0;               ///< path time at which it goes on with its predecessor's blend behind it, s
};

/// Where an activity that goes on with another one in motion is done with the rest of that one: from this path time (s)
/// on of the clock of this command.
struct HandOver {
  expression::SubjectPtr command;
  double time = 0.0;
};

/// Control modes of arms, by name.
using ControlModes = std::map<std::string, device::ControlMode, std::less<>>;

/// An activity that can become a net: of a command, or one that was written by hand.
struct PlannedActivity {
  std::optional<command::Command> command;
  std::map<std::string, EndState, std::less<>> end_states;  ///< of each of its actuators
  std::vector<Ending> endings = {};                         ///< where there is more than one; empty: end_states say all
  std::map<std::string, std::vector<device::Seam>, std::less<>> begins;  ///< in which it may take an arm over
  std::map<std::string, HandOver, std::less<>> taken_over;  ///< of each actuator that it can go on with in motion
  std::vector<PlannedPart> motions = {};                    ///< of one motion: its parts; of others: none
  std::function<expression::State(double)> at_share;  ///< of one motion: at or past this share of its path; else empty
  /// Control modes that arms are brought into before the command begins; without a command that is all. Only of
  /// activities that begin alone.
  ControlModes modes;
  bool returns = false;  ///< after the command they go back into the modes that they were in
  std::shared_ptr<const net::NetDescription> net = {};  ///< written by hand, in place of a command
  /// Devices that mean to touch something while it runs: an arm with its tool, a gripper (docs/world.md).
  std::set<std::string, std::less<>> touching = {};
  /// What has come of it, asked once its net has ended in order and was not cancelled: errors make the run fail
  /// (RunFailure::kAborted). Empty: nothing can be wrong.
  std::function<Diagnostics(const RunView&)> verdict = {};
  /// Its net knows that it may fail: what follows on its actuators waits for its end, as far as it is not continued.
  bool can_fail = false;
};

/// An operation in real time that knows what comes before it. Immutable: it may be carried out any number of times,
/// each time as a new command. Any thread.
class ActivityModel {
 public:
  explicit ActivityModel(std::string name) : name_(std::move(name)) {}
  virtual ~ActivityModel() = default;
  ActivityModel(const ActivityModel&) = delete;
  ActivityModel& operator=(const ActivityModel&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// The devices that it drives.
  [[nodiscard]] virtual std::vector<std::string> actuators() const = 0;
  /// It begins only when nothing holds its actuators any more, and what follows waits for its end: it changes control
  /// modes.
  [[nodiscard]] virtual bool begins_alone() const { return false; }
  /// It keeps clear of what other machines do meanwhile: it is planned after what is asked for in the same cycle.
  [[nodiscard]] virtual bool avoids_others() const { return false; }
  /// Plans it, from rest where the predecessor ends, and from the predecessor in motion where that may be left.
  /// @return diagnostics: why it cannot be done.
  [[nodiscard]] virtual Result<PlannedActivity> prepare(const PlanningContext& planning) const = 0;
  /// This and the one after it as one activity, blended into each other. @return null: they stay two.
  [[nodiscard]] virtual std::shared_ptr<const ActivityModel> blended_into(const ActivityModel& next) const {
    (void)next;
    return nullptr;
  }

 private:
  std::string name_;
};
using ActivityPtr = std::shared_ptr<const ActivityModel>;

}  // namespace takt::activity
