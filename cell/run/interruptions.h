#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/operator.h"
#include "cell/judge/limit_monitor.h"
#include "cell/judge/run_report.h"

namespace takt::cell {

/// Tries a run at many of its cycles: at each of them the process is forked, the child is interrupted in one way and
/// answers what is wrong after it, the parent goes on as if nothing had been. So a thousand cases cost one run and what
/// comes after each interruption. Lock-step runs without film and recording only: a fork has one thread.
/// Whoever runs the program asks in_child() after it, judges there, and calls answer(), which ends the child.
/// Thread: the one that steps the core. Realtime: setup.
class Interruptions {
 public:
  /// kFault: in turn an arm stops by itself, in each category, or a device falls silent for half a second (of the
  /// cell's fault points the plainest of their kinds); a program that goes on after that is cancelled three seconds
  /// later.
  enum class Way { kCancel, kPause, kAbort, kStop0, kStop1, kStop2, kFault };
  static constexpr int kWays = 6;  ///< of people: the first of them
  [[nodiscard]] static std::string_view name_of(Way way);

  struct Plan {
    std::int64_t first = 0, every = 10;  ///< cycles at which the run is tried
    /// What is tried at the n-th of them, from 0 on; nothing: nobody asks there.
    std::function<std::vector<Way>(std::int64_t point)> ways = {};
    std::function<void(std::int64_t cycle)> progress = {};  ///< after each of them
  };
  /// Cancel, pause and abort.
  [[nodiscard]] static std::vector<Way> by_program(std::int64_t point);

  /// One that was tried.
  struct Case {
    Way way = Way::kCancel;
    std::int64_t cycle = 0;
    int number = 0;  ///< from 1 on, in the order of trying: which arm has a fault follows from it
    std::string wrong = {};
  };

  explicit Interruptions(Plan plan) : plan_(std::move(plan)) {}
  /// The same interruption once more, in a run of its own and without a fork: nobody is answered.
  [[nodiscard]] static Interruptions again(const Case& tried);
  [[nodiscard]] Plan& plan() { return plan_; }

  /// Takes the panel of the run, and looks at each cycle.
  void attach(RunOptions& options);

  [[nodiscard]] bool in_child() const { return child_; }
  /// In a child: which way, and whether it is one of the few that are watched for long.
  [[nodiscard]] Way way() const { return way_; }
  [[nodiscard]] bool long_watch() const { return long_watch_; }
  [[nodiscard]] std::int64_t cycle_of_interruption() const { return at_; }
  /// In a child: how long the pause was, in cycles; 0: there was none, or it has not ended.
  [[nodiscard]] std::int64_t paused_cycles() const { return resumed_ < 0 ? 0 : resumed_ - at_; }
  /// In a child: something is wrong.
  void complain(const std::string& what);
  /// In a child: looks at the set points of this cycle; attach() does that for the cycles of the run.
  void watch(const BuiltCell& built);
  /// In a child, after its run: steps on until all machines rest, but no longer than braking takes.
  void come_to_rest(const BuiltCell& built);
  /// Ends the child, with what is wrong: complaints, and limits that were broken in any cycle since the run began.
  [[noreturn]] void answer();
  /// The same after its run: it has to have ended soon, at rest, with nothing held.
  [[noreturn]] void answer_after(const expression::Cell& cell, Nanoseconds period, const RunReport& report);

  /// Within which everything stands, whatever it did, in cycles: on its path a machine brakes with a part of its
  /// acceleration.
  [[nodiscard]] static int braking_cycles(const BuiltCell& built);

  [[nodiscard]] int tried() const { return tried_; }
  /// What was wrong. After twenty nothing more is tried.
  [[nodiscard]] const std::vector<Case>& failed() const { return failed_; }
  /// The same in words: "pause in cycle 1200: ...".
  [[nodiscard]] std::vector<std::string> failures() const;

 private:
  void before_cycle(Operator& panel);
  void fork_child(Way way, std::int64_t cycle);
  void hear(int from, int pid);
  void act(Operator& panel, std::int64_t cycle);
  void pause(Operator& panel, std::int64_t cycle);
  void fault(Operator& panel, std::int64_t cycle);
  void break_something() const;
  void end_faults() const;
  [[nodiscard]] std::string faster_than(double most) const;
  [[nodiscard]] bool rests(const device::Arm& arm) const;

  Plan plan_;
  std::int64_t points_ = 0;
  int tried_ = 0;
  std::vector<Case> failed_;
  const BuiltCell* built_ = nullptr;
  std::map<std::string, std::unique_ptr<LimitMonitor>> monitors_;

  bool child_ = false, long_watch_ = false;
  Way way_ = Way::kCancel;
  std::int64_t at_ = 0, resumed_ = -1;
  int still_ = 0;
  int answer_ = -1;
  std::string complaints_;
};

}  // namespace takt::cell
