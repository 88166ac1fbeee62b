#include "core/command/formula_check.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/command/broken_rule.h"

namespace takt::command {

void FormulaCheck::error(Code code, const std::string& location, const char* rule, const std::string& message,
                         const std::string& hint) {
  report_broken_rule(diagnostics_, code, location, rule, message, hint);
}

void FormulaCheck::check(const expression::ExpressionPtr& formula, const std::string& location) {
  diagnostics_.append(expression::faults_of(formula), location);
  if (!formula || formula->depth > expression::kMostDepth) return;
  check_leaves(formula, location);
}

void FormulaCheck::check_leaves(const expression::ExpressionPtr& formula, const std::string& location) {
  if (formula->subject) return check_leaf(*formula, location);
  for (const auto& [port, input] : formula->inputs) check_leaves(input, location);
}

void FormulaCheck::check_leaf(const expression::Expression& leaf, const std::string& location) {
  const std::string& name = leaf.subject->name;
  if (leaf.subject->kind == expression::Subject::Kind::kRaised) return check_raised(leaf, location);
  if (leaf.subject->kind == expression::Subject::Kind::kActuator) return check_driven(name, location);
  const int of = tree_.find(leaf.subject);
  if (of < 0) {
    return error(
        Code::kUnknownName, location, "C6",
        fmt::format("a state of '{}', which is not, or more than once, in the tree '{}'", name, tree_.at(0).path),
        "Use states of commands and actions in this tree");
  }
  if (leaf.output == "timed_out" && !(node(of).until && node(of).seconds)) {
    return error(Code::kRequires, location, "C8", fmt::format("'{}' has no timeout, so it never times out", name),
                 "Use a wait for a state, with a timeout");
  }
  if (leaf.subject->kind == expression::Subject::Kind::kAction) check_state(of, leaf, location);
}

void FormulaCheck::check_raised(const expression::Expression& leaf, const std::string& location) {
  if (tree_.find_raised(leaf.subject) >= 0) return;
  error(Code::kInvalidValue, location, "C10", fmt::format("state '{}' is raised in another tree", leaf.subject->name),
        "Use TransactionCommand::raised() of a transaction around this formula");
}

void FormulaCheck::check_driven(const std::string& actuator, const std::string& location) {
  for (int i = 0; i < tree_.size(); ++i) {
    if (node(i).is_runtime() && drives(*node(i).actuator, actuator)) return;
  }
  error(Code::kUnknownName, location, "C6", fmt::format("no command in this tree gives '{}' set points", actuator),
        "Name an actuator of a command in this tree");
}

/// The action of command i has the state.
void FormulaCheck::check_state(int i, const expression::Expression& leaf, const std::string& location) {
  check_via(node(i), leaf, location);
  std::vector<std::string> offered = node(i).model().states();
  offered.insert(offered.end(), {"started", "completed"});
  if (std::ranges::find(offered, leaf.output) != offered.end()) return;
  error(Code::kUnknownName, location, "C8", fmt::format("{} has no state '{}'", leaf.subject->name, leaf.output),
        fmt::format("Use one of {}", fmt::join(offered, ", ")));
}

/// Which points a motion passes is known once it is planned.
void FormulaCheck::check_via(const CommandNode& command, const expression::Expression& leaf,
                             const std::string& location) {
  if (leaf.output != "via_passed" || command.model().needs_plan()) return;
  const auto index = leaf.primitive.parameters.value("index", 0);
  const int count = command.model().via_count();
  if (count == 0 || (index >= 0 && index < count)) return;  // none: it has no such state
  error(Code::kUnknownName, location, "C8", fmt::format("{} passes no point {}", leaf.subject->name, index),
        fmt::format("Choose a point from 0 to {}", count - 1));
}

}  // namespace takt::command
