#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/command/command.h"
#include "core/rcc/control_core.h"

namespace takt::command {

/// What stood in the net in one cycle, as text: names and values of what matters.
struct TracedCycle {
  std::int64_t cycle = -1;
  std::vector<std::pair<std::string, std::string>> values;
};

/// How a command stands.
struct CommandStatus {
  rcc::NetState state = rcc::NetState::kLoading;
  /// Of the end; code kNone before. A start that was refused: kError with the reason.
  net::Cause cause;
  std::int64_t first_cycle = -1;  ///< of the core
  std::int64_t last_cycle = -1;
  /// The last cycles, oldest first: states of commands, set points, what events look at. Of a command that failed.
  std::vector<TracedCycle> last_cycles;

  [[nodiscard]] bool ended() const { return state == rcc::NetState::kTerminated; }
  /// It came to its end in order, by itself or after a cancel.
  [[nodiscard]] bool succeeded() const;
  /// For people: cause, cycle and the last cycles.
  [[nodiscard]] std::string to_string() const;
};

class Runtime;

/// A command that was loaded. A handle: copies are the same; the net is unloaded with the last one, unless it still
/// runs: then it goes on, and stays loaded. Not used by the cycle; one thread, that of the program. Realtime: setup.
class CommandHandle {
 public:
  static constexpr std::size_t kTracedCycles = 16;

  /// Begins in the next cycle. A refusal shows in status().
  void start();
  /// Begins in the cycle after the last one of `predecessor`, so that none is empty; `from_rest` is begun in its place
  /// if the seam does not fit then (docs/cycle.md). @return why it cannot be.
  [[nodiscard]] Findings schedule_after(const CommandHandle& predecessor, const CommandHandle* from_rest = nullptr);
  /// Asks for an end in order. Before the start: it will not begin.
  void cancel();
  /// Ends it at once: its devices stop.
  void abort();
  /// Runs the loop until the command has ended, or for so many cycles at most. @return status().
  CommandStatus wait(std::int64_t most_cycles = 10'000'000);
  [[nodiscard]] CommandStatus status() const;

  /// An observed or captured value: of the newest cycle, or of the last one. @return nothing for null, and for a name
  /// or a type that is not observed. In lock-step, or when it has ended; beside a running cycle use
  /// ControlCore::watch().
  template <class T>
  [[nodiscard]] std::optional<T> value(const std::string& name) const;
  [[nodiscard]] rcc::NetId net() const;
  /// External effects whose times were lost because nobody looked in time; none was lost itself.
  [[nodiscard]] std::int64_t external_times_lost() const;
  /// Takes note of what happened in the last step and calls the handlers of external effects. Runtime::poll() does it
  /// for all.
  void poll();

  struct Impl;  ///< private to handle.cc
  explicit CommandHandle(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

 private:
  std::shared_ptr<Impl> impl_;
};

/// Brings commands into a control core: planning, mapping, LOAD. The core outlives it and its handles.
class Runtime {
 public:
  /// @param step  runs one cycle and all that belongs to it (simulation, recording); default: the core alone
  explicit Runtime(rcc::ControlCore& core, std::function<void()> step = {});

  /// Plans what needs it, checks, maps, verifies. Nothing moves. @return a handle, or all findings.
  [[nodiscard]] Result<CommandHandle> load(const Command& command);
  /// load, start, wait. @return how it ended; what is wrong before is an error with the findings as text.
  CommandStatus execute(const Command& command);
  /// One cycle, then poll().
  void step();
  /// Takes note of what happened in the last step, for all handles that live.
  void poll();
  [[nodiscard]] rcc::ControlCore& core();

  struct Impl;

 private:
  std::shared_ptr<Impl> impl_;
};

}  // namespace takt::command
