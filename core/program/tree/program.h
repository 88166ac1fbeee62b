#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/scheduler.h"
#include "core/program/tree/node.h"
#include "core/program/tree/strand.h"

namespace takt::program {

/// What a rehearsal found out.
struct Rehearsed {
  Diagnostics diagnostics;
  double duration = 0.0;                         ///< s: planned motions and waits, guarded motions to their end
  std::set<std::string, std::less<>> estimates;  ///< names of the poses that the program fits
  std::vector<activity::FoundCollision> collisions = {};  ///< in the order in which they were found
  /// What the run's `move`s keep clear of, for its Context; null: of nothing that moves.
  std::shared_ptr<const activity::MeanwhileSpaces> meanwhile = {};
};

/// A program tree, checked for form and types. Immutable (docs/programs.md).
class Program {
 public:
  /// Any step, usually {"do": "sequence", "steps": [...]}: all diagnostics at once. Pointers start with `pointer`.
  /// @param programs  what "call" may call: name to program, with pointers below "/programs"; may be null.
  /// Realtime: setup.
  [[nodiscard]] static Result<Program> parse(const nlohmann::ordered_json& json, const std::string& pointer,
                                             const expression::Cell& cell,
                                             const nlohmann::ordered_json* programs = nullptr);

  /// Plays the whole tree on nominal values: unreachable goals, limits, names that nothing defines, devices that two
  /// branches drive, bodies that collide. A guarded motion is taken to its end; of a branch all cases are played.
  /// @param devices  with them every net that the run will load is verified too; may be null. Realtime: setup.
  /// @param nets  gets the nets of all steps, in the order in which they were played; may be null
  [[nodiscard]] Rehearsed rehearse(const expression::Cell& cell, net::Environment* devices = nullptr,
                                   std::vector<operations::RehearsedNet>* nets = nullptr) const;

  [[nodiscard]] const Node& root() const { return *root_; }
  /// Number of steps that one run executes, repetitions counted as far as they are known; 10^12 means all that is
  /// more.
  [[nodiscard]] std::int64_t step_count() const { return root_ ? root_->count() : 0; }
  /// Names of all nodes, in the order of the file; those of called programs after them.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::unique_ptr<Node> root_;
  std::vector<std::shared_ptr<const SubProgram>> programs_;
  Diagnostics warnings_;  ///< of parse(): the rehearsal has them too
};

/// Runs a program: advance() between cycles until it is done. All its state can be taken as data and put back (row D3).
/// Thread: the one that steps the core (lock-step).
class ProgramRunner {
 public:
  /// `program` and `context` must outlive the runner.
  ProgramRunner(const Program& program, activity::Context& context);
  ~ProgramRunner();
  ProgramRunner(const ProgramRunner&) = delete;
  ProgramRunner& operator=(const ProgramRunner&) = delete;

  /// Runs until it has to wait for the next cycle. A program that makes more than 10 000 steps without waiting is
  /// stopped with a diagnostic (row D1). @return where it is.
  operations::Progress advance();
  /// Graceful end: the steps that run are cancelled, nothing follows, not even a "finally".
  void cancel();

  /// No step begins while it is held; those that run go on.
  void hold(bool held) { execution_.held = held; }
  /// Single-step: a step begins only by step().
  void set_single_step(bool single) { execution_.single = single; }
  /// Lets one step begin.
  void step() { ++execution_.permits; }
  /// Those that wait for it, in the order of the file; the first one would begin.
  [[nodiscard]] const std::vector<AskingStep>& asking() const { return execution_.asking; }

  /// Where it is and what it knows, as data: positions in the tree, variables, measurements, frames. Exact between two
  /// steps; a step that runs is begun anew by restore().
  [[nodiscard]] nlohmann::ordered_json snapshot() const;
  /// A variable, and what it is worth, for people.
  struct Known {
    std::string name, value;
    bool operator==(const Known&) const = default;
  };
  /// All variables that live now, each by a pointer of its own.
  [[nodiscard]] std::map<std::string, Known> variables() const;
  /// Puts a snapshot into a runner that has not begun. Diagnostics: it is none of this program.
  [[nodiscard]] Diagnostics restore(const nlohmann::ordered_json& snapshot);
  /// Begins at the first node of this name, in the first round of what repeats it; what is before it is left out.
  /// Diagnostics: there is none, or it lies where nothing can be entered (a parallel, a called program).
  [[nodiscard]] Diagnostics enter(std::string_view name);

  [[nodiscard]] operations::Progress progress() const { return progress_; }
  /// Why it failed.
  [[nodiscard]] const Diagnostics& diagnostics() const { return diagnostics_; }
  /// Names of the steps that run, joined by " + "; empty before the first and after the last.
  [[nodiscard]] const std::string& current() const { return current_; }
  /// Where in the tree something happens: called from the context's event sink that of the event, else those of the
  /// steps that run ("measure / for_each (2) / touch"), joined by " + ".
  [[nodiscard]] std::string path() const;
  [[nodiscard]] std::int64_t steps_done() const { return execution_.steps_done; }
  /// What the steps that run mean to touch (docs/world.md).
  [[nodiscard]] std::set<std::string, std::less<>> touching() const { return scheduler_.touching(); }

 private:
  [[nodiscard]] Diagnostics put_back(const nlohmann::ordered_json& state);
  void show_current();

  const Program& program_;
  activity::Scheduler scheduler_;  ///< of the motions
  Execution execution_;
  ControlLine strand_;
  Scope scope_;
  std::unique_ptr<NodeRun> run_;
  operations::Progress progress_ = operations::Progress::kRunning;
  std::vector<RunningStep> shown_;
  std::string current_, paths_;
  Diagnostics diagnostics_;
};

}  // namespace takt::program
