#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cell/file/operator.h"
#include "cell/judge/run_report.h"

namespace takt::serve {

/// A program that runs, as operators at a page see and steer it: it begins when one of them says so, pauses, goes on
/// step by step, at a share of its speed, and ends. What they ask is taken up before the next cycle. Any thread, but
/// for the hooks of the run.
class ProgramDesk {
 public:
  enum class State { kAwaitsStart, kRuns, kPaused, kAwaitsStep, kEnded };
  static constexpr std::size_t kLog = 4096;  ///< entries that are kept

  struct View {
    State state = State::kAwaitsStart;
    double speed = 1.0;                 ///< share of the planned speed, 0 to 1
    bool steps = false;                 ///< single steps are possible: not beside a cycle in real time
    bool single = false;                ///< each step waits for its permission
    bool cancelled = false;             ///< an end was asked for
    cell::NextStep next;                ///< of kAwaitsStep: what would begin
    double planned = 0.0;               ///< s: duration that was predicted; 0: not known yet
    std::vector<std::string> running;   ///< paths of the steps that run: "sort / for_each (2) / grip"
    std::string verdict;                ///< of kEnded
    std::vector<std::string> findings;  ///< of kEnded: what went wrong, in words
  };

  /// @param steps  the simulated time may stand while somebody decides about a step
  /// @param interrupt  of the run: 1 or more ends the waiting; may be null
  ProgramDesk(bool steps, const std::atomic<int>* interrupt);

  [[nodiscard]] View view() const;
  struct Entry {
    std::int64_t sequence = 0;  ///< from 1 on, without gaps
    cell::LogEntry entry;
  };
  /// What the run told of itself, from a number on.
  [[nodiscard]] std::vector<Entry> log_from(std::int64_t sequence, std::size_t most) const;

  // -- What operators ask. @return false: not in this state ---------------------------------------------------------
  /// Begins, or goes on without stops.
  [[nodiscard]] bool go_on();
  /// Motions come to rest on their paths, no step begins.
  [[nodiscard]] bool pause();
  /// The next step begins, and the one after it waits.
  [[nodiscard]] bool step();
  /// @param share  0 to 1
  [[nodiscard]] bool set_speed(double share);
  /// Ends in order.
  [[nodiscard]] bool cancel();
  /// STOP: with it the program ends.
  void abort();

  // -- Hooks of the run, on its thread
  // ---------------------------------------------------------------------------------
  /// RunOptions::operate.
  void operate(cell::Operator& panel);
  /// RunOptions::before_step: waits for whoever decides. @param idle  called about 20 times a second meanwhile
  [[nodiscard]] cell::StepAnswer before_step(const cell::NextStep& next, const std::function<void()>& idle);
  /// RunOptions::tell.
  void heard(const cell::LogEntry& entry);
  void set_planned(double seconds);
  void ended(const cell::RunReport& report);

 private:
  [[nodiscard]] bool interrupted() const { return interrupt_ != nullptr && interrupt_->load() > 0; }
  [[nodiscard]] State state() const;

  const std::atomic<int>* interrupt_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  View view_;
  bool begun_ = false, waits_ = false, paused_ = false, ended_ = false;
  int permits_ = 0;
  /// What was asked and is not passed on yet.
  struct Wanted {
    std::optional<bool> pause = {};
    std::optional<double> speed = {};
    bool cancel = false, abort = false;
  } wanted_;
  std::deque<Entry> log_;
  std::int64_t next_sequence_ = 1;
};
[[nodiscard]] std::string_view name_of(ProgramDesk::State state);

}  // namespace takt::serve
