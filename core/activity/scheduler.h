#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/activity/run_planner.h"

namespace takt::activity {

/// What a program needs when the cycle does not wait for it. Both null: lock-step.
struct RealtimeSupport {
  /// StartConditions::Options::margin_cycles beside a planning thread: plans of one motion take 1 to 20 ms.
  static constexpr std::int64_t kMargin = 40;

  PlanningThread* planning = nullptr;               ///< plans beside the program
  const std::vector<rcc::Event>* events = nullptr;  ///< of all cycles since the program looked last
};

/// Decides for each actuator which activity follows which, and how, and moves each execution through the states of
/// run_state.h (docs/activity-layer.md). It polls its runs between cycles, never waits, and belongs to the thread of
/// the program. Realtime: setup.
class Scheduler {
 public:
  using Options = StartConditions::Options;
  Scheduler(rcc::ControlCore& core, const expression::Cell& cell, const Options& options,
            const RealtimeSupport& realtime = {})
      : core_(core),
        cell_(cell),
        planner_(core, cell, options, realtime.planning),
        events_(realtime.events),
        latency_cycles_(options.latency_cycles) {}

  /// Takes it in; it is carried out as soon as its actuators allow, in the order of calls.
  RunPtr schedule(ActivityPtr model);
  /// Of what is asked for from now on: nothing else of the program moves beside it, so its planned motions are checked
  /// for collisions once more before they begin (Options::checks_collisions checks them always).
  void set_alone(bool alone) { alone_ = alone; }
  /// Plans it now if that is possible, and not in the next poll(): the world is as whoever asks for it sees it.
  void prepare(const RunPtr& run) {
    if (run->state() == RunState::kQueued && !held_) try_plan(*run);
  }
  /// Between two cycles: what became of the runs in the last one, and what can begin.
  void poll();
  /// No run waits or runs.
  [[nodiscard]] bool idle() const { return runs_.empty(); }
  /// All that run come to rest, all that wait are given up.
  void cancel();
  /// None begins while it is held; those that run go on.
  void hold(bool held) { held_ = held; }
  /// Names of what runs, joined by " + ".
  [[nodiscard]] std::string current() const;
  /// What those that run mean to touch (PlannedActivity::touching).
  [[nodiscard]] std::set<std::string, std::less<>> touching() const;
  /// Of runs that are over, in the order in which they ended.
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return reactions_; }

 private:
  /// The only place in which the state of a run changes. An event that the table does not have is a programming error
  /// (abort).
  static void apply(ActivityRun& run, RunEvent event);

  // What happened to a run in each of its states.
  void follow(ActivityRun& run);
  void follow_loaded(ActivityRun& run);
  void follow_switching(ActivityRun& run);
  void follow_running(ActivityRun& run);
  /// Another one does what is left of it.
  void follow_carried(ActivityRun& run);
  void follow_returning(ActivityRun& run);
  /// What the core has said since the last poll().
  [[nodiscard]] std::span<const rcc::Event> events() const {
    return events_ != nullptr ? std::span<const rcc::Event>(*events_) : core_.events();
  }
  /// Whether the core has refused its start; then it has failed.
  bool poll_answer(ActivityRun& run);

  // Up to the start.
  void try_plan(ActivityRun& run);
  void try_start(ActivityRun& run);
  void post(ActivityRun& run);

  // Its end.
  void end_of_net(ActivityRun& run);
  /// Who has taken its motion over. Null: nobody.
  [[nodiscard]] RunPtr successor_of(const ActivityRun& run) const;
  /// Over, or first back into the control modes of before.
  void end(ActivityRun& run, RunEvent outcome);
  /// What came first is kept as the reason.
  void fail(ActivityRun& run, RunFailure why, Diagnostics diagnostics);
  void begin_return(ActivityRun& run);
  /// The run is over: what waits behind it for the same actuators is given up, but after an end in order.
  void finish(ActivityRun& run, RunEvent outcome);
  void give_up_followers(const ActivityRun& run);

  rcc::ControlCore& core_;
  const expression::Cell& cell_;
  RunPlanner planner_;
  bool alone_ = false;
  const std::vector<rcc::Event>* events_;  ///< null: those of the core, of its last cycle
  std::int64_t latency_cycles_;
  std::vector<RunPtr> runs_;         ///< in the order of schedule(), until they are over
  std::vector<Reaction> reactions_;  ///< of runs that are over
  bool held_ = false;
};

}  // namespace takt::activity
