#include "core/command/effect_check.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "core/command/broken_rule.h"

namespace takt::command {
namespace {

using Handler = CommandTree::Handler;

std::string_view name_of(Effect::Kind kind) {
  static constexpr std::array<std::string_view, 5> kNames = {"start", "stop", "cancel", "raise", "external"};
  return kNames.at(static_cast<std::size_t>(kind));
}

bool mentions(const expression::ExpressionPtr& formula, const expression::SubjectPtr& subject, std::string_view state) {
  if (formula->subject) return formula->subject == subject && formula->output == state;
  return std::ranges::any_of(formula->inputs,
                             [&](const auto& input) { return mentions(input.second, subject, state); });
}

}  // namespace

void EffectCheck::error(const Handler& h, Code code, const char* rule, const std::string& message,
                        const std::string& hint) {
  report_broken_rule(diagnostics_, code, h.path, rule, message, hint);
}

void EffectCheck::check(const Handler& h) {
  switch (h.handler->effect.kind) {
    case Effect::Kind::kStart:
      return check_start(h);
    case Effect::Kind::kStop:
    case Effect::Kind::kCancel:
      return check_end(h);
    case Effect::Kind::kRaise:
      return check_raise(h);
    case Effect::Kind::kExternal:
      return check_external(h);
  }
}

void EffectCheck::check_start(const Handler& h) {
  const expression::SubjectPtr& subject = h.handler->effect.target;
  const int target = tree_.find(subject);
  if (!tree_.at(h.owner).node->is_transaction()) {
    return error(h, Code::kConflict, "C1",
                 fmt::format("'{}' is not a transaction, so there is nothing that it could start", name(h.owner)),
                 "Put the handler on the transaction around it");
  }
  if (target < 0 || tree_.at(target).parent != h.owner) {
    return error(h, Code::kConflict, "C1",
                 fmt::format("start of '{}', which is not directly inside of '{}'", subject->name, name(h.owner)),
                 "Start a command of the handler's own transaction");
  }
  if (tree_.at(target).with_parent) {
    error(h, Code::kInvalidValue, "C5", fmt::format("'{}' starts with its transaction already", subject->name),
          "Use add() in place of add_started(), or remove the handler");
  }
  check_start_condition(h);
}

/// A start does not wait for the end of the transaction that it is in.
void EffectCheck::check_start_condition(const Handler& h) {
  const expression::ExpressionPtr& state = h.handler->state.node();
  for (const expression::SubjectPtr& subject : expression::subjects_of(state)) {
    if (tree_.find(subject) != h.owner || !mentions(state, subject, "completed")) continue;
    error(h, Code::kInvalidValue, "C5", fmt::format("'{}' has ended when it is completed", name(h.owner)),
          "Use the state `completed` of a command inside");
  }
}

void EffectCheck::check_end(const Handler& h) {
  const Effect& effect = h.handler->effect;
  const int target = tree_.find(effect.target);
  if (target >= 0 && tree_.is_inside(target, h.owner)) return;
  error(h, Code::kConflict, "C2",
        fmt::format("{} of '{}', which is neither '{}' nor inside of it", name_of(effect.kind), effect.target->name,
                    name(h.owner)),
        "Put the handler on the target itself or on a transaction around it");
}

void EffectCheck::check_raise(const Handler& h) {
  const expression::SubjectPtr& state = h.handler->effect.target;
  const int owner = tree_.find_raised(state);
  if (owner >= 0 && tree_.is_inside(h.owner, owner)) return;
  error(h, Code::kInvalidValue, "C10",
        fmt::format("'{}' does not belong to a transaction around '{}'", state->name, name(h.owner)),
        "Use TransactionCommand::raised() of a transaction around the handler");
}

void EffectCheck::check_external(const Handler& h) {
  if (h.handler->effect.name.empty())
    diagnostics_.error(Code::kMissing, h.path, "an external effect without a name", "Give it a name");
}

}  // namespace takt::command
