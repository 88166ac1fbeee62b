#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/activity/mode_change.h"
#include "core/activity/planning_job.h"
#include "core/activity/reaction_watch.h"
#include "core/activity/run_state.h"
#include "core/activity/run_trace.h"
#include "core/command/external_watch.h"
#include "core/rcc/control_core.h"

namespace takt::activity {

/// What it took to make an activity ready to start, CPU time of the program's thread, s.
struct Preparation {
  double planning = 0.0;
  double total = 0.0;  ///< planning, mapping to a net, LOAD
};

class RunView;

/// One execution of an activity. Shared by the scheduler, which moves it on, and whoever asked for it. Thread: the
/// program's. Realtime: setup.
class ActivityRun {
 public:
  ActivityRun(rcc::ControlCore& core, ActivityPtr model) : core_(core), model_(std::move(model)) {}
  ~ActivityRun();
  ActivityRun(const ActivityRun&) = delete;
  ActivityRun& operator=(const ActivityRun&) = delete;

  [[nodiscard]] const std::string& name() const { return model_->name(); }
  [[nodiscard]] RunState state() const { return state_; }
  /// It has begun to act, what it goes on with is behind it, or it is over.
  [[nodiscard]] bool started() const { return (began_ && !carries()) || over(); }
  [[nodiscard]] bool over() const { return is_final(state_); }
  /// Why it failed. Whoever asks has taken its outcome: the program knows of it (Runtime::take_failures()).
  [[nodiscard]] RunFailure failure() const { return taken(failure_); }
  [[nodiscard]] const Diagnostics& diagnostics() const { return taken(diagnostics_); }
  /// The same with locations below the activity, without its name: for who has a location of its own for it.
  [[nodiscard]] Diagnostics diagnostics_inside() const;
  /// It went on with its predecessor in motion.
  [[nodiscard]] bool blended() const { return blended_; }
  /// Core cycles of its first and last evaluation; -1: not yet.
  [[nodiscard]] std::int64_t first_cycle() const { return status().first_cycle; }
  [[nodiscard]] std::int64_t last_cycle() const { return status().last_cycle; }
  /// Why its net ended; code kNone: it has not, or there is none.
  [[nodiscard]] net::Cause cause() const { return status().cause; }
  /// Core cycle in which it was asked for.
  [[nodiscard]] std::int64_t asked_cycle() const { return asked_cycle_; }
  [[nodiscard]] const Preparation& preparation() const { return preparation_; }
  /// What its events did to its motions so far. Only of events that come from sensors.
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return reactions_.reactions(); }
  /// The last cycles of its net, oldest first: to explain a failure.
  [[nodiscard]] std::vector<TracedCycle> last_cycles() const { return trace_.cycles(); }
  /// External effects whose cycle is not known because the program looked too late; no effect is ever lost.
  [[nodiscard]] std::int64_t external_times_lost() const { return externals_.times_lost(); }
  /// Of one motion, while it runs: how many of the motions that it is made of are behind it; nothing while what it goes
  /// on with is not left.
  [[nodiscard]] std::optional<std::size_t> part() const;
  /// The net; 0: none was loaded.
  [[nodiscard]] rcc::NetId net() const { return net_; }
  /// The same, to read its monitors; of a run that is over as they were in its last cycle. Null: none was loaded.
  [[nodiscard]] rcc::NetHandle compiled_net() const {
    return unloaded_ != nullptr || net_ == 0 ? unloaded_ : core_.net(net_);
  }
  /// One part of a composition, by its number from 0: "/1", "/1/0" inside of it.
  [[nodiscard]] RunView inside(const std::string& part) const;
  /// There is an observation of this name.
  [[nodiscard]] bool observes(const std::string& observation) const { return port_of(observation) != nullptr; }
  /// What it observes under names that begin so: the rest of each.
  [[nodiscard]] std::vector<std::string> observed_after(const std::string& begin) const;
  /// It runs, and what it does is still the rest of a motion that it goes on with: that one is not over yet.
  [[nodiscard]] bool carries() const;
  /// The newest value of an observation of the command (Command::observe, capture). T: any value type. Of a composition
  /// whose parts have it: that of the only part that does.
  template <class T>
  [[nodiscard]] std::optional<T> value(const std::string& observation) const;

  /// The same of a state; null counts as not holding.
  [[nodiscard]] bool was_true(const std::string& observation) const;

  /// Asks for a graceful end (row L6): it brakes on its path, whoever carries out the rest of that by then. What only
  /// waits is given up.
  void cancel() { wants_cancel_ = true; }
  /// The stop reaction, now.
  void abort();

 private:
  friend class Scheduler;
  friend class Runtime;
  friend class RunView;
  friend class RunPlanner;
  friend class StartConditions;

  /// The ports of a path clock in the net.
  struct Clock {
    const net::Slot<net::Real>*time = nullptr, *rate = nullptr, *rate_derivative = nullptr;

    /// Its motion runs.
    [[nodiscard]] bool runs() const { return time->null == 0; }
    /// Its rate does not change.
    [[nodiscard]] bool is_steady() const { return rate->value > 0.0 && rate_derivative->value == 0.0; }
  };
  template <class T>
  [[nodiscard]] const T& taken(const T& outcome) const {
    taken_ = taken_ || state_ == RunState::kFailed;
    return outcome;
  }
  [[nodiscard]] rcc::NetStatus status() const;
  /// Null: nothing of this name, or several parts have it.
  [[nodiscard]] const std::string* port_of(const std::string& observation) const;
  /// The only part that observes it; empty: the run itself does, none does, or several do.
  [[nodiscard]] std::string only_part_with(const std::string& observation) const;
  [[nodiscard]] bool shares_actuator(const ActivityRun& other) const;
  /// The rest of the other run's motion is still what it does.
  [[nodiscard]] bool carries(const ActivityRun& other) const;
  [[nodiscard]] bool is_before(const HandOver& hand_over) const;
  /// Null: the command is no planned motion of this run.
  [[nodiscard]] const Clock* clock_of(const expression::SubjectPtr& command) const;
  /// Keeps what is to be read of its net, which was loaded just now. @return diagnostics: an external effect could not
  /// be watched.
  [[nodiscard]] Diagnostics attach(command::MappedCommand mapped);
  /// After a cycle in which its net was evaluated.
  void after_cycle();
  /// Calls the handlers of external effects.
  void call_externals() { externals_.poll(); }
  void unload();
  /// The same, as if it had never been loaded.
  void forget_net();
  /// Its arms are not in the control modes any more in which they shall be after it.
  [[nodiscard]] bool must_return() const { return planned_.returns && !modes_before_.empty(); }

  rcc::ControlCore& core_;
  ActivityPtr model_;
  RunState state_ = RunState::kQueued;
  RunFailure failure_ = RunFailure::kNone;
  Diagnostics diagnostics_;
  bool wants_cancel_ = false, began_ = false, blended_ = false;
  mutable bool taken_ = false;            ///< somebody has asked what came of it
  std::shared_ptr<ActivityRun> carrier_;  ///< that carries out the rest of this one; null: this one itself
  std::string cancelled_with_;        ///< name of the run whose rest it carried when that was cancelled; empty: none
  bool after_all_ = false;            ///< no rule has room for its predecessors: it begins when all are over
  std::shared_ptr<PlanningJob> job_;  ///< that is being planned
  std::shared_ptr<PlanningJob> planned_with_;  ///< that it was planned by
  PlannedActivity planned_;
  Preparation preparation_;
  std::int64_t asked_cycle_ = -1;
  std::int64_t due_cycle_ = 0;  ///< its start takes effect from here on (row D2)
  bool alone_ = false;          ///< Scheduler::set_alone() when it was asked for

  rcc::NetId net_ = 0;
  rcc::NetHandle unloaded_;  ///< the net once the core has been asked to forget it: its values can still be read
  rcc::RequestId request_ = 0;
  std::optional<rcc::Rule> rule_;                       ///< to be posted
  std::int64_t queue_full_since_ = -1;                  ///< cycle in which it could not be posted for the first time
  std::optional<rcc::NetStatus> status_;                ///< of a net that has ended
  std::map<std::string, std::string> observed_;         ///< name, port
  std::map<const expression::Subject*, Clock> clocks_;  ///< of its planned motions
  command::ExternalWatch externals_;
  ReactionWatch reactions_;
  RunTrace trace_;

  std::optional<ModeChange> change_;     ///< of control modes, before or after its net
  ControlModes modes_before_;            ///< in which its arms were; empty: nothing was changed yet
  RunEvent outcome_ = RunEvent::kEnded;  ///< of kReturning: what it comes to afterwards
};
using RunPtr = std::shared_ptr<ActivityRun>;

/// What can be read of a run, or of one part of a composition. A cheap value; the run outlives it. Thread: the
/// program's.
class RunView {
 public:
  RunView(const ActivityRun& run, std::string part = {})  // NOLINT: a run is a view of itself
      : run_(run), part_(std::move(part)) {}

  /// It is no part of a composition.
  [[nodiscard]] bool is_whole() const { return part_.empty(); }
  [[nodiscard]] RunView inside(const std::string& part) const { return {run_, part_ + part}; }
  [[nodiscard]] const std::string& name() const { return run_.name(); }
  /// Of a part: queued where it has not begun, running until it ended.
  [[nodiscard]] RunState state() const;
  [[nodiscard]] RunFailure failure() const;
  /// It ended in order and was not cancelled: how it ended counts. Of a part: its net knows that it has failed.
  [[nodiscard]] bool may_have_failed() const;
  /// Of a composition the only part that observes this, else itself.
  [[nodiscard]] RunView narrowed_to(const std::string& observation) const;
  [[nodiscard]] bool observes(const std::string& observation) const { return run_.observes(named(observation)); }
  template <class T>
  [[nodiscard]] std::optional<T> value(const std::string& observation) const {
    return run_.value<T>(named(observation));
  }
  [[nodiscard]] bool was_true(const std::string& observation) const { return run_.was_true(named(observation)); }
  /// What it observes under names that begin so: the rest of each.
  [[nodiscard]] std::vector<std::string> observed_after(const std::string& begin) const {
    return run_.observed_after(named(begin));
  }

 private:
  [[nodiscard]] std::string named(const std::string& observation) const {
    return command::scoped_name(part_, observation);
  }

  const ActivityRun& run_;
  std::string part_;
};

/// What a part shows of its life beside what its command observes.
inline constexpr const char *kPartStarted = "part started", *kPartCompleted = "part completed",
                            *kPartCancelled = "part cancelled", *kPartFailed = "part failed";

/// The numbers that a state compares are shown as they are when it is entered. @param key  with which the names of what
/// it shows begin
void capture_compared(command::Command& command, const expression::State& state, const std::string& key);
/// What capture_compared() has shown: "wrist above 30: 31.2"; empty: nothing, or the state was not entered.
[[nodiscard]] std::string compared_text(const RunView& run, const std::string& key);

/// What is wrong where a state that must not hold has ended a run.
/// @param silent    it was unknown whether it holds
/// @param compared  what was compared (compared_text()), or empty
void add_abort_diagnostic(bool silent, const std::string& compared, std::string pointer, Diagnostics& diagnostics);

/// The state has held, or was null (row N3), while the command ran: what it fails by (Command::fails_if).
[[nodiscard]] expression::State not_allowed(const expression::State& state, const command::Command& command);
/// Likewise of a guarded motion: its condition was null before it held; and where it must hold, it never did and nobody
/// cancelled the motion.
[[nodiscard]] expression::State not_touched(const expression::State& until, bool must_touch,
                                            const command::Command& command);
/// The command is cancelled when a state holds, or is null (row N3), fails, and shows that. @param key  with which the
/// names of what it shows begin
void add_abort(command::Command& command, const expression::State& state, const std::string& key);
/// The same as an error at "/abort_if" once it has ended; empty: the state never held.
[[nodiscard]] Diagnostics abort_diagnostics(const RunView& run, const std::string& key);

}  // namespace takt::activity
