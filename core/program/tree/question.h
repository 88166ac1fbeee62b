#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/activity/scheduler.h"
#include "core/expression/condition.h"
#include "core/program/tree/node.h"

namespace takt::program {

/// Something that a program asks before it goes on: an expression, or a condition over sensors, which an activity of
/// one cycle answers, so that it means what it means in a motion's "until". Immutable.
class Question {
 public:
  /// Diagnostics at the parser: the form, types.
  [[nodiscard]] static Question parse(const nlohmann::ordered_json& json, const std::string& pointer,
                                      NodeParser& parser);

  /// The answer on nominal values; nothing: it is not known before the run.
  [[nodiscard]] std::optional<bool> rehearse(operations::Rehearsal& rehearsal, const Scope& scope,
                                             Diagnostics& diagnostics) const;
  /// An expression is answered at once.
  [[nodiscard]] bool immediate() const { return immediate_; }
  [[nodiscard]] const ValueTemplate& piece() const { return piece_; }

 private:
  friend class QuestionRun;
  ValueTemplate piece_;
  bool immediate_ = true;
};

/// Asks once.
class QuestionRun {
 public:
  QuestionRun(const Question& question, const Scope& scope) : question_(question), scope_(scope) {}

  /// @return kDone when answer() is there; kFailed with diagnostics if it cannot be known.
  operations::Progress advance(Execution& execution, Diagnostics& diagnostics);
  void cancel() {
    if (run_) run_->cancel();
  }
  [[nodiscard]] bool answer() const { return answer_; }

 private:
  operations::Progress begin(Execution& execution, Diagnostics& diagnostics);
  operations::Progress no_answer(Diagnostics& diagnostics) const;

  const Question& question_;
  const Scope& scope_;
  activity::RunPtr run_;  ///< of a condition
  bool answer_ = false;
};

}  // namespace takt::program
