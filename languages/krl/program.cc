#include "languages/krl/program.h"

#include <algorithm>
#include <iterator>

#include "languages/krl/builtins.h"

namespace takt::languages::krl {
namespace {

void collect_calls(const Block& statements, std::set<std::string, std::less<>>& names);

void collect_calls(const Expression* one, std::set<std::string, std::less<>>& names) {
  if (one == nullptr) return;
  if (one->kind == Expression::Kind::kCall && find_builtin(one->name) == nullptr) names.insert(one->name);
  for (const ExpressionPtr& part : one->parts) collect_calls(part.get(), names);
}

void collect_calls(const Block& statements, std::set<std::string, std::less<>>& names) {
  for (const Statement& one : statements) {
    for (const ExpressionPtr* part : {&one.a, &one.b, &one.c, &one.d}) collect_calls(part->get(), names);
    for (const ExpressionPtr& goal : one.goals) collect_calls(goal.get(), names);
    collect_calls(one.body, names);
    collect_calls(one.otherwise, names);
    for (const Case& each : one.cases) collect_calls(each.body, names);
  }
}

}  // namespace

ExpressionPtr copy(const Expression& one) {
  auto made = std::make_unique<Expression>();
  made->kind = one.kind;
  made->at = one.at;
  made->name = one.name;
  made->value = one.value;
  made->op = one.op;
  made->names = one.names;
  for (const ExpressionPtr& part : one.parts) made->parts.push_back(part ? copy(*part) : nullptr);
  return made;
}

const Structure* Program::structure(std::string_view name) const {
  const auto found = std::ranges::find_if(structures, [&](const auto& one) { return one->name == name; });
  return found == structures.end() ? nullptr : found->get();
}

std::set<std::string, std::less<>> missing_programs(const std::vector<ModuleText>& modules) {
  Diagnostics unread;
  std::set<std::string, std::less<>> called, known;
  std::vector<ModuleText> all = modules;
  all.push_back(prelude());
  for (const ModuleText& text : all) {
    const Module module = parse_module(text, unread);
    for (const Function& one : module.functions) {
      known.insert(one.name);
      collect_calls(one.body, called);
    }
  }
  std::set<std::string, std::less<>> missing;
  std::ranges::set_difference(called, known, std::inserter(missing, missing.begin()));
  return missing;
}

}  // namespace takt::languages::krl
