#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/program/tree/node.h"

namespace takt::program {

/// A motion that its step has left running, because the next step may go on with it.
struct OpenStep {
  std::unique_ptr<operations::Step> step;    ///< null if the tree owns it
  std::unique_ptr<operations::StepRun> run;  ///< it refers to the step
  std::string arm;                           ///< that it moves
  std::string name, pointer;                 ///< of the part that is being done; of the whole step
  std::int64_t parts = 1;                    ///< steps that it consists of
  /// The steps with what their expressions were worth, and the frames that were made of poses for them, by name: to
  /// begin them again from a snapshot.
  std::shared_ptr<const nlohmann::ordered_json> steps, frames;
};

/// One line of control: a program, or a branch of a parallel. It has at most one step that was left open. All steps but
/// a motion that goes on with it wait for its end (docs/programs.md).
class ControlLine {
 public:
  /// The arm of the motion that was left open; empty: there is none.
  [[nodiscard]] const std::string& open_arm() const;
  /// Leaves a step open. Its name stays among those that run.
  void leave_open(OpenStep step) {
    open_ = std::make_unique<OpenStep>(std::move(step));
    ++opened_;
  }
  /// How many were left open so far; the number of the one that failed last, from 1.
  [[nodiscard]] int opened() const { return opened_; }
  [[nodiscard]] int failed() const { return failed_; }
  /// While something cleans up, only the end of the whole program cancels what it has left open.
  void protect(bool on) { protected_ += on ? 1 : -1; }
  /// Looks at the step that was left open. @return kDone: there is none (any more)
  operations::Progress advance(Execution& execution, Diagnostics& diagnostics);
  /// Something goes on with the step that was left open: it is over.
  void hand_over(Execution& execution) { close(execution, "end"); }
  /// What the line of control comes to, once nothing of it is left open: `outcome`, or kFailed with diagnostics. After
  /// a failure what is open is cancelled.
  Outcome settle(Outcome outcome, Execution& execution, Diagnostics& diagnostics);
  void cancel(Execution& execution);

  /// The open step as data; null: there is none.
  [[nodiscard]] nlohmann::ordered_json state() const;
  /// Begins it again.
  void restore(const nlohmann::ordered_json& state, Execution& execution, Diagnostics& diagnostics);

 private:
  void close(Execution& execution, std::string_view how);

  std::unique_ptr<OpenStep> open_;
  int opened_ = 0, failed_ = 0, protected_ = 0;
};

/// Waits until the motion that was left open is over, before something asks the machines. @return kDone: go on
Outcome settle(Execution& execution, Diagnostics& diagnostics);
/// The same, if what a value is worth changes while machines move.
Outcome settle_for(Execution& execution, const ValueTemplate& piece, Diagnostics& diagnostics);
Outcome settle_for(Execution& execution, const std::vector<Declaration>& declarations, Diagnostics& diagnostics);

/// The frames that a step's poses were put into (ValueTemplate::resolve), in `steps` under names of their own, so that
/// another round of the same step does not move them. @return name and pose of each
[[nodiscard]] nlohmann::ordered_json keep_frames(nlohmann::ordered_json& steps, const world::FrameGraph& frames);

/// Advances one line of control among several.
class OnControlLine {
 public:
  OnControlLine(Execution& execution, ControlLine& strand)
      : execution_(execution), before_(std::exchange(execution.strand, &strand)) {}
  ~OnControlLine() { execution_.strand = before_; }
  OnControlLine(const OnControlLine&) = delete;
  OnControlLine& operator=(const OnControlLine&) = delete;

 private:
  Execution& execution_;
  ControlLine* before_;
};

/// The run of a node that is not over before nothing of it is left open. What was left open before it may stay so.
class SettledRun final : public NodeRun {
 public:
  explicit SettledRun(std::unique_ptr<NodeRun> run) : run_(std::move(run)) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override;
  void cancel(Execution& execution) override;
  /// That of the node; once that has ended, also what it has come to.
  [[nodiscard]] nlohmann::ordered_json state() const override;
  void restore(const nlohmann::ordered_json& state, Execution& execution, Diagnostics& diagnostics) override;

 private:
  std::unique_ptr<NodeRun> run_;
  std::optional<int> opened_before_;
  std::optional<Outcome> ended_;
  Diagnostics diagnostics_;  ///< of what has ended
};

}  // namespace takt::program
