#include "core/program/tree/node.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::program {
namespace {

/// More steps than this without a cycle between them are a program that never waits.
constexpr int kStepBudget = 10'000;

/// A rehearsal plays so many nodes: a few seconds of planning.
constexpr std::int64_t kMostEffort = 3'000;

}  // namespace

bool Execution::charge(const std::string& pointer, Diagnostics& diagnostics) {
  const std::int64_t cycle = context.core.cycle();
  if (cycle != spent_in_cycle) {
    spent = 0;
    spent_in_cycle = cycle;
  }
  ++begun;
  if (++spent <= kStepBudget) return true;
  diagnostics.error(Code::kTooLarge, pointer, fmt::format("{} steps without a single cycle between them", kStepBudget),
                    "Put a wait or a motion inside the sequence");
  return false;
}

bool Execution::may_begin(const Node& step) {
  if (held) return false;
  if (!single) return true;
  if (permits == 0) {
    asking.push_back({step.name, step.pointer});
    return false;
  }
  --permits;
  return true;
}

void Execution::enter(const std::string& name) {
  const Inside inside(*this, name);
  current.push_back({name, path()});
  context.event("program", "begin", name);
}

void Execution::leave(const std::string& name, std::string_view how, std::string_view why) {
  const auto step = std::ranges::find(current, name, &RunningStep::name);
  const std::string path = step->path;
  current.erase(step);
  told = &path;
  context.event("program", how, why.empty() ? name : fmt::format("{}: {}", name, why));
  told = nullptr;
}

Outcome Execution::advance_in(const std::string& name, NodeRun& run, Diagnostics& diagnostics, std::int64_t round) {
  const Inside inside(*this, name, round);
  return run.advance(*this, diagnostics);
}

std::string Execution::path() const {
  if (told != nullptr) return *told;
  std::string text;
  for (const auto& [name, round] : around) {
    if (name->empty()) continue;
    text += (text.empty() ? "" : " / ") + *name;
    if (round > 0) text += fmt::format(" ({})", round);
  }
  return text;
}

std::string messages_of(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& diagnostic : diagnostics.list()) text += (text.empty() ? "" : "; ") + diagnostic.message;
  return text;
}

EvalContext Execution::eval_context(const Scope& scope) const {
  return {.mode = EvalContext::Mode::kRun,
          .scope = &scope,
          .cell = &context.cell,
          .measured = &context.variables,
          .q = nullptr,
          .time = context.core.time()};
}

void Node::collect_names(std::vector<std::string>& names) const {
  if (!name.empty()) names.push_back(name);
}

std::optional<nlohmann::ordered_json> Node::state_before(std::string_view wanted) const {
  if (name.empty() || name != wanted) return std::nullopt;
  return nlohmann::ordered_json::object();
}

bool spend_rehearsal(operations::Rehearsal& rehearsal, const Node& node, Diagnostics& diagnostics) {
  if (++rehearsal.effort == kMostEffort) {
    diagnostics.note(node.pointer,
                     fmt::format("the rehearsal ends here, after {} steps: what follows is not checked", kMostEffort),
                     "fewer repetitions");
  }
  return rehearsal.effort < kMostEffort;
}

Diagnostics as_warnings(const Diagnostics& diagnostics, std::string_view why) {
  Diagnostics result;
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (diagnostic.severity == Severity::kError) {
      diagnostic.severity = Severity::kWarning;
      diagnostic.message += fmt::format("; {}", why);
    }
    result.add(std::move(diagnostic));
  }
  return result;
}

EvalContext sight_of(const operations::Rehearsal& rehearsal, const Scope& scope) {
  return {.mode = EvalContext::Mode::kRehearse,
          .scope = &scope,
          .cell = &rehearsal.cell,
          .measured = nullptr,
          .q = &rehearsal.q,
          .time = 0};
}

bool declare(const std::vector<Declaration>& declarations, const EvalContext& eval_context, Scope& scope,
             Diagnostics& diagnostics) {
  Diagnostics own;
  for (const Declaration& declaration : declarations) {
    Variable variable{declaration.type, Value::unknown(declaration.type), {}};
    if (declaration.nominal) variable.nominal = declaration.nominal->value(eval_context, own);
    Value value =
        declaration.initial ? declaration.initial->value(eval_context, own) : Value::unknown(declaration.type);
    scope.declare(declaration.name, variable);
    scope.assign(*scope.find(declaration.name), std::move(value), eval_context.rehearsing());
  }
  const bool declared = !own.has_errors();
  diagnostics.append(own);
  return declared;
}

std::int64_t saturated(std::int64_t times, std::int64_t count) {
  if (times <= 0 || count <= 0) return 0;
  return count > Node::kMostSteps / times ? Node::kMostSteps : std::min(Node::kMostSteps, times * count);
}

}  // namespace takt::program
