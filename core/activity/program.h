#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/step.h"

namespace takt::activity {

/// A node of a program tree: a step, or a sequence of nodes that may be repeated.
struct Node {
  std::string name;            ///< for people; "lin" and the like where the file gives none
  std::string pointer;         ///< JSON pointer in the file
  std::unique_ptr<Step> step;  ///< null for a sequence
  std::vector<Node> children;
  /// Names of the steps that `step` has absorbed: they run as one with it.
  std::vector<std::string> absorbed;
  std::int64_t times = 1;  ///< how often a sequence runs; 0 if there is no step in it
};

/// What a rehearsal found out.
struct Rehearsed {
  Findings findings;
  double duration = 0.0;                         ///< s: planned motions and waits, guarded motions to their end
  std::set<std::string, std::less<>> estimates;  ///< names of the poses that the program fits
};

/// A program tree, checked for form. Immutable.
class Program {
 public:
  /// {"do": "sequence", "steps": [...]}: all findings at once. Pointers start with `pointer`. Realtime: setup.
  [[nodiscard]] static Result<Program> parse(const nlohmann::ordered_json& json, const std::string& pointer,
                                             const command::Cell& cell);

  /// Plays the whole tree on nominal values: unreachable goals, limits, names that nothing defines. A guarded motion
  /// is taken to its end.
  /// @param devices  with them every net that the run will load is verified too; may be null. Realtime: setup.
  /// @param nets  gets the nets of all steps, in the order in which they were played; may be null
  [[nodiscard]] Rehearsed rehearse(const command::Cell& cell, net::Environment* devices = nullptr,
                                   std::vector<RehearsedNet>* nets = nullptr) const;

  [[nodiscard]] const Node& root() const { return root_; }
  /// Number of steps that one run executes, repetitions counted; 10^12 stands for all that is more.
  [[nodiscard]] std::int64_t step_count() const;
  /// Names of all nodes, in the order of the file.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  Node root_;
};

/// Runs a program: advance() between cycles until it is done. All its state is the stack of positions in the tree and
/// the run of the current step (row D3). Thread: the one that steps the core (lock-step).
class ProgramRunner {
 public:
  /// `program` and `context` must outlive the runner.
  ProgramRunner(const Program& program, Context& context);

  /// Runs until it has to wait for the next cycle. A program that makes more than 10 000 steps without waiting is
  /// stopped with a finding (row D1). @return where it is.
  Progress advance();
  /// Graceful end: the current step is cancelled, nothing follows.
  void cancel();

  [[nodiscard]] Progress progress() const { return progress_; }
  /// Why it failed.
  [[nodiscard]] const Findings& findings() const { return findings_; }
  /// Name of the current step; empty before the first and after the last.
  [[nodiscard]] const std::string& current() const { return current_; }
  [[nodiscard]] std::int64_t steps_done() const { return steps_done_; }

 private:
  struct Position {
    const Node* node;
    std::size_t child = 0;
    std::int64_t round = 0;
  };

  bool enter_next();
  void follow_part();

  const Program& program_;
  Context& context_;
  std::vector<Position> stack_;
  const Node* leaf_ = nullptr;
  std::unique_ptr<StepRun> run_;
  Progress progress_ = Progress::kRunning;
  bool cancelled_ = false;
  std::string current_;
  std::size_t part_ = 0;  ///< of a leaf with absorbed steps
  std::int64_t steps_done_ = 0;
  Findings findings_;
};

}  // namespace takt::activity
