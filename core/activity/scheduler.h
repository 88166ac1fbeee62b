#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
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

  rcc::ControlCore& core_;
  ActivityPtr model_;
  RunState state_ = RunState::kQueued;
  Findings findings_;
  bool wants_cancel_ = false, blended_ = false;
  Prepared prepared_;
  std::map<std::string, std::string> observed_;               ///< name, port
  std::map<const command::Subject*, std::string> fragments_;  ///< of its commands
  std::int64_t due_cycle_ = 0;                                ///< its start takes effect from here on (row D2)
  rcc::NetId net_ = 0;
  rcc::RequestId request_ = 0;
  std::optional<rcc::Rule> rule_;  ///< to be posted
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

  /// Takes it in; it is carried out as soon as its actuators allow, in the order of calls.
  RunPtr schedule(ActivityPtr model);
  /// Between two cycles: what became of the runs in the last one, and what can begin.
  void poll();
  /// No run is on its way.
  [[nodiscard]] bool idle() const { return runs_.empty(); }

 private:
  struct Predecessors {
    std::vector<ActivityRun*> running;
    bool wait = false;
  };
  void update(ActivityRun& run);
  void finish(ActivityRun& run);
  void fail(ActivityRun& run, Findings findings);
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
  [[nodiscard]] rcc::Rule rule_for(const ActivityRun& run, const Predecessors& before,
                                   const Situation& situation) const;

  rcc::ControlCore& core_;
  const command::Cell& cell_;
  Options options_;
  std::vector<RunPtr> runs_;  ///< in the order of schedule(), until they are over
};

}  // namespace takt::activity
