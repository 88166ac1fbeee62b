#pragma once

#include <coroutine>
#include <deque>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/activity/context.h"
#include "core/activity/scheduler.h"
#include "core/activity/task.h"

namespace takt::activity {

/// Why a program cannot go on as it wanted to. Thrown by execute(), begin_execute(), use() and their awaitable forms;
/// never in a cycle.
class ActivityError : public std::runtime_error {
 public:
  explicit ActivityError(Diagnostics diagnostics)
      : std::runtime_error(diagnostics.to_string()), diagnostics_(std::move(diagnostics)) {}
  [[nodiscard]] const Diagnostics& diagnostics() const { return diagnostics_; }

 private:
  Diagnostics diagnostics_;
};

/// The program was asked to end (Runtime::cancel): what ran has come to rest, and nothing begins any more.
class ProgramCancelled final : public ActivityError {
 public:
  ProgramCancelled();
};

/// The loop of a program: it resumes coroutines until all wait, lets the scheduler look, and runs one cycle. In
/// lock-step nothing else happens, so a program repeats to the bit. Owned by the program; one thread. Realtime: setup.
class Runtime {
 public:
  struct Options {
    Scheduler::Options scheduler = {};
    std::int64_t most_cycles = 100'000'000;  ///< that a blocking call waits; then it throws
    Variables* variables = nullptr;          ///< what the program measures; null: the runtime has its own
    EventSink event = {};                    ///< is told what happened; may be empty
    RealtimeSupport realtime = {};           ///< both outlive the runtime
    /// Writes a channel of speed in place of the runtime, for a core that only follows; may be empty.
    std::function<void(const std::string& channel, double value)> write_speed = {};
    /// Called with the name of each activity that is asked for; it may cancel() the program. May be empty.
    std::function<void(const std::string& name)> before_activity = {};
  };
  /// @param cell       devices and frames; see declare_channels()
  /// @param run_cycle  runs one cycle of the core, and of the simulation around it
  Runtime(rcc::ControlCore& core, expression::Cell& cell, std::function<void()> run_cycle, const Options& options);
  Runtime(rcc::ControlCore& core, expression::Cell& cell, std::function<void()> run_cycle)
      : Runtime(core, cell, std::move(run_cycle), Options{}) {}
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  [[nodiscard]] rcc::ControlCore& core() { return core_; }
  [[nodiscard]] expression::Cell& cell() { return cell_; }
  [[nodiscard]] const expression::Cell& cell() const { return cell_; }

  RunPtr schedule(ActivityPtr model);
  /// One step of the loop. Throws ActivityError inside of a coroutine.
  void step();
  /// Steps until it holds. Throws ActivityError after most_cycles, and inside of a coroutine, which has to wait by
  /// co_await; ProgramCancelled when the program was cancelled meanwhile.
  void run_until(const std::function<bool()>& holds);
  /// Throws ActivityError inside of a coroutine: who blocks there says so before anything begins.
  void require_outside() const;
  /// Runs a coroutine to its end; what it throws comes out here. Throws ActivityError inside of a coroutine.
  void run(Task task);
  /// Begins a coroutine that runs beside; what it throws comes out of the next step.
  void spawn(Task task);

  /// Ends the program in order: what runs comes to rest on its path, what waits is given up. When all have, what the
  /// program waits for throws ProgramCancelled, and so does whatever it asks for from now on.
  void cancel();
  [[nodiscard]] bool cancelled() const { return cancelled_; }
  /// No activity begins while it is held; those that run go on.
  void hold(bool held) { scheduler_.hold(held); }
  /// No activity runs or waits, and no spawned coroutine goes on.
  [[nodiscard]] bool idle() const { return scheduler_.idle() && spawned_.empty(); }
  /// Forgets all coroutines: after an exception their owners are gone. Activities that run go on.
  void drop_coroutines();
  /// What has failed and nobody has asked about: neither waited for it, nor read failure() or diagnostics() of the run.
  /// They count as asked about from now on. @param given_up  those too that were given up because another one failed
  [[nodiscard]] Diagnostics take_failures(bool given_up = true);
  /// Names of the activities that run, joined by " + ".
  [[nodiscard]] std::string current() const { return scheduler_.current(); }
  /// What they mean to touch (docs/world.md).
  [[nodiscard]] std::set<std::string, std::less<>> touching() const { return scheduler_.touching(); }
  /// What the events of activities did so far (Reaction), in the order in which their activities ended.
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return scheduler_.reactions(); }

  /// Awaitable: goes on in the first step in which it holds.
  class When {
   public:
    When(Runtime& runtime, std::function<bool()> holds) : runtime_(runtime), holds_(std::move(holds)) {}
    [[nodiscard]] bool await_ready() const {
      if (!holds_()) return false;
      runtime_.spend();
      return true;
    }
    void await_suspend(std::coroutine_handle<> handle) { runtime_.waiting_.push_back({std::move(holds_), handle}); }
    void await_resume() const { runtime_.require_going(); }

   private:
    Runtime& runtime_;
    std::function<bool()> holds_;
  };
  [[nodiscard]] When when(std::function<bool()> holds) { return {*this, std::move(holds)}; }
  /// Awaitable: so many cycles.
  [[nodiscard]] When cycles(std::int64_t count);

  /// Of force/torque sensors, as they were tared: activities that are made later take them out.
  [[nodiscard]] expression::Biases& biases() { return context_.variables.biases; }
  [[nodiscard]] const expression::Biases& biases() const { return context_.variables.biases; }

  /// What operations of the program use when they have ended, as steps of a file do: touches, parts that are carried.
  [[nodiscard]] Context& context() { return context_; }

  /// The rate at which the motions of an arm aim, [0, 1]: override, pause and resume, without a plan (row P2). Throws
  /// ActivityError for an arm that is not there or any other rate.
  void set_speed(const std::string& arm, double rate);
  void pause(const std::string& arm) { write_speed(arm, 0.0); }
  void resume(const std::string& arm) { write_speed(arm, speeds_.contains(arm) ? speeds_.at(arm) : 1.0); }

 private:
  struct Waiting {
    std::function<bool()> holds;
    std::coroutine_handle<> handle;
  };
  void write_speed(const std::string& arm, double rate);
  /// Counts what a coroutine did without a wait; throws for a program that never waits (row D1).
  void spend();
  /// Throws when the program is to end.
  void require_going() const;
  void resume_coroutines();
  /// Tells of what has failed and nobody has asked about, once.
  void report_failures();
  void poll_spawned();

  rcc::ControlCore& core_;
  expression::Cell& cell_;
  std::function<void()> run_cycle_;
  Options options_;
  Scheduler scheduler_;
  Variables own_variables_;
  Context context_;
  std::map<std::string, double> speeds_;
  std::vector<Waiting> waiting_;
  std::vector<RunPtr> begun_;   ///< not over, or over in the last cycle
  std::vector<RunPtr> failed_;  ///< that nobody had asked about in the cycle after
  std::deque<Task> spawned_;    ///< a coroutine may spawn another one while this is walked
  bool resuming_ = false, cancelled_ = false;
  std::int64_t spent_in_cycle_ = -1;
  int spent_ = 0;
};

/// Declares the channels that the motions of a cell's arms use (docs/activity-layer.md). Before the first cycle.
[[nodiscard]] Diagnostics declare_channels(rcc::ControlCore& core, expression::Cell& cell);

}  // namespace takt::activity
