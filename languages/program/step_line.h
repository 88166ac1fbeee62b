#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/program/tree/strand.h"

namespace takt::languages {

/// What begins as one: motions that are blended into each other, or one other step.
class StepGroup {
 public:
  virtual ~StepGroup() = default;
  /// As a step of a program. Diagnostics: what no step can do; null then.
  [[nodiscard]] virtual nlohmann::ordered_json to_step(Diagnostics& diagnostics) const = 0;
  /// Puts diagnostics of that step where the program has it.
  virtual void locate(Diagnostics& diagnostics) const = 0;
};

/// Runs groups of steps one after the other on the line of control of a node, and others beside them. The last motion
/// of a group may be left open, so that the next group goes on with it. What an interpreter drives.
class StepLine {
 public:
  StepLine(const program::Node& node, program::Execution& execution) : node_(node), execution_(execution) {}

  /// Nothing runs on the line but what was left open; a group may begin.
  [[nodiscard]] bool idle() const { return !main_ && !braking_; }
  /// Nothing runs on it, and nothing is open.
  [[nodiscard]] bool settled() const { return !main_ && open_arm().empty(); }
  [[nodiscard]] bool beside() const { return !beside_.empty(); }
  /// The group that runs; the one whose last motion was left open. Null: there is none.
  [[nodiscard]] const StepGroup* main() const { return main_ ? main_->group.get() : nullptr; }
  [[nodiscard]] const StepGroup* open() const { return open_arm().empty() ? nullptr : open_.get(); }

  /// While idle(). @return false with failures
  bool begin(std::shared_ptr<const StepGroup> group);
  bool begin_beside(std::shared_ptr<const StepGroup> group);
  /// Between cycles. @return true if something has ended: something else may begin in the same cycle
  bool advance();
  /// Brakes on the path what runs on the line; how that comes to an end does not matter.
  void stop();
  /// The same with what runs beside.
  void cancel();

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// What has failed is not over before all of it has ended.
  void fail(const Diagnostics& diagnostics);
  [[nodiscard]] const Diagnostics& failures() const { return failures_; }

 private:
  struct Running {
    std::shared_ptr<const StepGroup> group;
    std::unique_ptr<program::Node> node = {};
    std::unique_ptr<program::Scope> scope = {};
    std::unique_ptr<program::NodeRun> run = {};
    std::unique_ptr<program::ControlLine> line = {};  ///< of what runs beside
  };

  [[nodiscard]] const std::string& open_arm() const { return execution_.strand->open_arm(); }
  bool make(Running& running);
  bool advance_main();
  bool advance_open();
  bool advance_beside();
  void end(program::Outcome outcome, Diagnostics& own, const StepGroup* group);

  const program::Node& node_;
  program::Execution& execution_;
  std::unique_ptr<Running> main_;
  std::shared_ptr<const StepGroup> open_;
  std::deque<std::unique_ptr<Running>> past_;  ///< what is open refers to its node, and so does what takes it over
  std::vector<Running> beside_;
  Diagnostics failures_;
  bool braking_ = false, cancelled_ = false, failed_ = false, stopped_ = false;
};

}  // namespace takt::languages
