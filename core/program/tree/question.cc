#include "core/program/tree/question.h"
#include "core/program/tree/strand.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/command_activity.h"
#include "core/command/actions/device_commands.h"
#include "core/operations/table/rehearsed_net.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// It ends in its first cycle, and observes the answer.
command::WaitCommand asking(const expression::Condition& condition, const expression::Cell& cell,
                            const expression::Biases& biases) {
  return command::wait_command(condition, 0.0, cell, biases);
}

}  // namespace

Question Question::parse(const Json& json, const std::string& pointer, NodeParser& parser) {
  Question question;
  if (json.is_string() || json.is_boolean()) {
    if (json.is_string() && !is_expression(json.get<std::string>())) {
      parser.diagnostics().error(Code::kSyntax, pointer,
                                 fmt::format("'{}' is not an expression", json.get<std::string>()),
                                 "Give \"$...\", or a condition {...}");
      return question;
    }
    question.piece_ = parser.value(json, pointer, Type::boolean());
    return question;
  }
  question.immediate_ = false;
  question.piece_ = ValueTemplate::parse(json, pointer, parser.diagnostics());
  Diagnostics own;
  expression::Cell cell = parser.cell();
  const auto resolved = question.piece_.resolve(parser.eval_context(), cell, expression::unit_in_condition, own);
  parser.diagnostics().append(own);
  const auto condition = expression::parse_condition(*resolved.json, pointer, parser.cell());
  if (condition) return question;
  for (const Diagnostic& diagnostic : condition.error().list()) {
    if (!question.piece_.depends(diagnostic.pointer)) parser.diagnostics().add(diagnostic);
  }
  return question;
}

std::optional<bool> Question::rehearse(operations::Rehearsal& rehearsal, const Scope& scope,
                                       Diagnostics& diagnostics) const {
  const EvalContext eval_context = sight_of(rehearsal, scope);
  if (immediate_) {
    const Value value = piece_.value(eval_context, diagnostics);
    return value.null() ? std::nullopt : std::optional(value.boolean());
  }
  Diagnostics own;
  const auto resolved = piece_.resolve(eval_context, rehearsal.cell, expression::unit_in_condition, own);
  const auto condition = expression::parse_condition(*resolved.json, piece_.pointer(), rehearsal.cell);
  if (!condition) own.append(condition.error());
  if (condition && !own.has_errors()) {
    operations::rehearse_command(asking(*condition, rehearsal.cell, {}), "question", rehearsal, piece_.pointer(), own);
  }
  diagnostics.append(own);
  return std::nullopt;
}

operations::Progress QuestionRun::advance(Execution& execution, Diagnostics& diagnostics) {
  const Outcome ready =
      question_.immediate_ ? settle_for(execution, question_.piece_, diagnostics) : settle(execution, diagnostics);
  if (ready != Outcome::kDone)
    return ready == Outcome::kRunning ? operations::Progress::kRunning : operations::Progress::kFailed;
  if (question_.immediate_) {
    Diagnostics own;
    const Value value = question_.piece_.value(execution.eval_context(scope_), own);
    diagnostics.append(own);
    if (own.has_errors()) return operations::Progress::kFailed;
    if (value.null()) return no_answer(diagnostics);
    answer_ = value.boolean();
    return operations::Progress::kDone;
  }
  if (!run_) return begin(execution, diagnostics);
  if (!run_->over()) return operations::Progress::kRunning;
  if (run_->state() == activity::RunState::kFailed) {
    diagnostics.append(run_->diagnostics_inside(), question_.piece_.pointer());
    return operations::Progress::kFailed;
  }
  const auto held = run_->value<net::Boolean>(command::observed::kCondition);
  if (!held) return no_answer(diagnostics);
  answer_ = *held;
  return operations::Progress::kDone;
}

operations::Progress QuestionRun::begin(Execution& execution, Diagnostics& diagnostics) {
  activity::Context& context = execution.context;
  Diagnostics own;
  const auto resolved =
      question_.piece_.resolve(execution.eval_context(scope_), context.cell, expression::unit_in_condition, own);
  diagnostics.append(own);
  if (own.has_errors()) return operations::Progress::kFailed;
  if (!resolved.unknown.empty()) return no_answer(diagnostics);
  const auto condition = expression::parse_condition(*resolved.json, question_.piece_.pointer(), context.cell);
  if (!condition) {
    diagnostics.append(condition.error());
    return operations::Progress::kFailed;
  }
  const auto make = [condition = *condition, biases = context.variables.biases](
                        const activity::PlanningContext& planning) { return asking(condition, planning.cell, biases); };
  run_ = context.scheduler->schedule(activity::command_activity("question", {}, make));
  context.scheduler->prepare(run_);
  return operations::Progress::kRunning;
}

operations::Progress QuestionRun::no_answer(Diagnostics& diagnostics) const {
  diagnostics.error(Code::kConditionNotMet, question_.piece_.pointer(),
                    "this cannot be decided: a value is not known, or a sensor did not answer",
                    "Ask known(x) before, whether a value is there");
  return operations::Progress::kFailed;
}

}  // namespace takt::program
