#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/activity/mode_change.h"
#include "core/command/mapping.h"
#include "core/rcc/control_core.h"

namespace takt::activity {

/// Where one execution of an activity stands.
enum class RunState : std::uint8_t {
  kQueued,     ///< waits for others that have its actuators
  kLoaded,     ///< its net is loaded; it starts when its predecessors end, or are left
  kRunning,    ///< its net is evaluated in each cycle
  kCompleted,  ///< it came to its end, or another one went on with it
  kCancelled,  ///< it came to rest because somebody asked for it
  kFailed      ///< findings() says why
};
[[nodiscard]] std::string_view name_of(RunState state);

/// What an event did to a motion: as it was measured, beside what LOAD certified for the net (rows O6, O7).
struct Reaction {
  std::string activity;           ///< its name
  std::string event;              ///< where its handler stands in the command, for people
  std::int64_t event_cycle = -1;  ///< of the core, in which the event was there first; -1: it never was
  std::int64_t braking_cycle =
      -1;  ///< of the first set point that brakes; -1: none, or the clock's rate was not steady
  std::int64_t least = 0, most = 0;  ///< certified cycles from a sensor of the event to the set point
};

/// What it took to make an activity ready to start, CPU time of the program's thread, s.
struct Preparation {
  double planning = 0.0;
  double total = 0.0;  ///< planning, mapping to a net, LOAD
};

/// One execution of an activity. Shared by the scheduler and whoever asked for it. Thread: the program's.
class ActivityRun {
 public:
  ActivityRun(rcc::ControlCore& core, ActivityPtr model) : core_(core), model_(std::move(model)) {}
  ~ActivityRun();
  ActivityRun(const ActivityRun&) = delete;
  ActivityRun& operator=(const ActivityRun&) = delete;

  [[nodiscard]] const std::string& name() const { return model_->name(); }
  [[nodiscard]] RunState state() const { return state_; }
  [[nodiscard]] bool started() const { return state_ >= RunState::kRunning; }
  [[nodiscard]] bool over() const { return state_ >= RunState::kCompleted; }
  [[nodiscard]] const Findings& findings() const { return findings_; }
  /// It went on with its predecessor in motion.
  [[nodiscard]] bool blended() const { return blended_; }
  /// Core cycles of its first and last evaluation; -1: not yet.
  [[nodiscard]] std::int64_t first_cycle() const { return net_ != 0 ? core_.status(net_).first_cycle : -1; }
  [[nodiscard]] std::int64_t last_cycle() const { return net_ != 0 ? core_.status(net_).last_cycle : -1; }
  /// Core cycle in which it was asked for.
  [[nodiscard]] std::int64_t asked_cycle() const { return asked_cycle_; }
  [[nodiscard]] const Preparation& preparation() const { return preparation_; }
  /// What its events did to its motions so far. Only of events that come from sensors.
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return reactions_; }
  /// Of one motion, while it runs: how many of the motions that it is made of are behind it; nothing while what it goes
  /// on with is not left.
  [[nodiscard]] std::optional<std::size_t> part() const;
  /// The net; 0: none was loaded.
  [[nodiscard]] rcc::NetId net() const { return net_; }
  /// The newest value of an observation of the command (Command::observe, capture). T: any value type.
  template <class T>
  [[nodiscard]] std::optional<T> value(const std::string& observation) const;

  /// Asks for a graceful end (row L6): it brakes on its path. What waits only is given up.
  void cancel();
  /// The stop reaction, now.
  void abort();

 private:
  friend class Scheduler;
  [[nodiscard]] bool shares_actuator(const ActivityRun& other) const;
  /// A port inside of the fragment of one of its commands; null: there is none.
  [[nodiscard]] const net::Slot<net::Real>* clock_port(const command::SubjectPtr& command, const char* port) const;

  /// Where an event and the clock of the motion that it cancels stand in the net, and how the clock was a cycle ago.
  struct Watched {
    const net::Slot<net::Boolean>* event = nullptr;
    const net::Slot<net::Real>*rate = nullptr, *derivative = nullptr;
    double rate_before = 0.0;
    bool steady_before = false;
    bool compared = false;  ///< the clock ran steadily when the event came, so its first fall is the brake
  };
  void watch_brakes(const std::vector<command::BrakePorts>& brakes);
  void look_at_events();

  rcc::ControlCore& core_;
  ActivityPtr model_;
  RunState state_ = RunState::kQueued;
  Findings findings_;
  bool wants_cancel_ = false, blended_ = false;
  Prepared prepared_;
  std::map<std::string, std::string> observed_;               ///< name, port
  std::map<const command::Subject*, std::string> fragments_;  ///< of its commands
  std::vector<Reaction> reactions_;
  std::vector<Watched> watched_;  ///< one for each reaction
  Preparation preparation_;
  std::int64_t asked_cycle_ = -1;
  std::int64_t due_cycle_ = 0;  ///< its start takes effect from here on (row D2)
  rcc::NetId net_ = 0;
  rcc::RequestId request_ = 0;
  std::optional<rcc::Rule> rule_;       ///< to be posted
  std::int64_t queue_full_since_ = -1;  ///< cycle in which it could not be posted for the first time
  std::optional<ModeChange> change_;    ///< of control modes, before or after its net
  ControlModes modes_before_;           ///< in which its arms were; empty: nothing was changed yet
  bool goes_back_ = false;              ///< the change is the one after it
};
using RunPtr = std::shared_ptr<ActivityRun>;

/// Decides for each actuator which activity follows which, and how (docs/activity-layer.md). It looks at its runs
/// between cycles, never waits, and belongs to the thread of the program. Realtime: setup.
class Scheduler {
 public:
  struct Options {
    std::int64_t latency_cycles = 2;  ///< from a program's wish to its effect (row D2)
    std::int64_t margin_cycles = 3;   ///< beyond that, until a motion is taken over
    std::int64_t lead_cycles = 4;     ///< in which it may be taken over
  };
  Scheduler(rcc::ControlCore& core, const command::Cell& cell, const Options& options)
      : core_(core), cell_(cell), options_(options) {}

  /// The way out of a failure that nothing but time mends.
  static constexpr const char* kAgain = "ask for it again when that is mended";

  /// Takes it in; it is carried out as soon as its actuators allow, in the order of calls.
  RunPtr schedule(ActivityPtr model);
  /// Prepares it now if that can be, and not in the next poll(): the world is as whoever asks for it sees it.
  void prepare(const RunPtr& run) {
    if (run->state_ == RunState::kQueued && !held_) try_begin(*run);
  }
  /// Between two cycles: what became of the runs in the last one, and what can begin.
  void poll();
  /// No run is on its way.
  [[nodiscard]] bool idle() const { return runs_.empty(); }
  /// All that run come to rest, all that wait are given up.
  void cancel();
  /// None begins while it is held; those that run go on.
  void hold(bool held) { held_ = held; }
  [[nodiscard]] std::string current() const;
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return reactions_; }

 private:
  struct Predecessors {
    std::vector<ActivityRun*> running;
    bool wait = false;
  };
  void update(ActivityRun& run);
  void finish(ActivityRun& run);
  /// It changes control modes: before its net (the run is loaded), without one (it runs), or after it.
  void begin_change(ActivityRun& run);
  void go_back(ActivityRun& run);
  void follow_change(ActivityRun& run);
  void complete(ActivityRun& run);
  /// If it has changed control modes and returns from them, it goes back first; that may fail too, and both are told.
  void fail(ActivityRun& run, Findings findings);
  void end_failed(ActivityRun& run);
  /// What waits behind it for the same actuators is given up.
  void give_up_followers(const ActivityRun& run);
  void try_begin(ActivityRun& run);
  [[nodiscard]] Predecessors predecessors_of(const ActivityRun& run) const;
  /// Nothing: not known yet.
  [[nodiscard]] std::optional<Situation> situation_of(const ActivityRun& run, const Predecessors& before) const;
  [[nodiscard]] std::optional<Precedent> precedent(const std::string& actuator, const Predecessors& before,
                                                   bool& wait) const;
  /// The clock of a command runs at a rate that does not change.
  [[nodiscard]] static bool is_steady(const ActivityRun& run, const command::SubjectPtr& command);
  [[nodiscard]] static bool is_as_planned(const ActivityRun& run, const command::SubjectPtr& command, double period);
  [[nodiscard]] std::optional<Precedent::Leaving> leaving(const ActivityRun& run, const Forecast& forecast) const;
  void load(ActivityRun& run, const Predecessors& before, const Situation& situation);
  /// When the run's net starts, and what it takes over. An error: no rule has room for that.
  [[nodiscard]] Result<rcc::Rule> rule_for(const ActivityRun& run, const Predecessors& before,
                                           const Situation& situation) const;
  void post(ActivityRun& run);

  rcc::ControlCore& core_;
  const command::Cell& cell_;
  Options options_;
  std::vector<RunPtr> runs_;         ///< in the order of schedule(), until they are over
  std::vector<Reaction> reactions_;  ///< of runs that are over
  bool held_ = false;
};

}  // namespace takt::activity
