#include "core/expression/expression.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;

/// Calls visit once for every node, operands after the node; stops at kMostDepth.
template <class Visit>
void walk(const ExpressionPtr& node, std::set<const Expression*>& seen, const Visit& visit) {
  if (!node || node->depth > kMostDepth || !seen.insert(node.get()).second) return;
  visit(*node);
  for (const auto& [port, input] : node->inputs) walk(input, seen, visit);
}

template <class Visit>
void walk(const ExpressionPtr& node, const Visit& visit) {
  std::set<const Expression*> seen;
  walk(node, seen, visit);
}

}  // namespace

ExpressionPtr apply(net::ValueType type, std::string primitive,
                    const std::vector<std::pair<std::string, Operand>>& operands, Json parameters, std::string output) {
  auto node = std::make_shared<Expression>();
  node->type = type;
  node->primitive = {.id = {}, .type = std::move(primitive), .parameters = std::move(parameters)};
  node->output = std::move(output);
  for (const auto& [port, operand] : operands) {
    if (!operand.node) {
      node->primitive.parameters[port] = operand.constant;
      continue;
    }
    node->inputs.emplace_back(port, operand.node);
    node->depth = std::max(node->depth, operand.node->depth + 1);
  }
  return node;
}

ExpressionPtr read_resource(net::ValueType type, std::string primitive, const char* key, const std::string& name,
                            net::Resource* resource, std::string output, std::string id) {
  auto node = std::make_shared<Expression>();
  node->type = type;
  node->primitive = {.id = std::move(id), .type = std::move(primitive), .parameters = {{key, name}}};
  node->output = std::move(output);
  node->resource = resource;
  node->resource_name = name;
  return node;
}

ExpressionPtr leaf(net::ValueType type, SubjectPtr subject, std::string name, Json parameters) {
  auto node = std::make_shared<Expression>();
  node->type = type;
  node->primitive.parameters = std::move(parameters);
  node->output = std::move(name);
  node->subject = std::move(subject);
  return node;
}

Diagnostic fault_of(Code code, std::string message, std::string hint) {
  return {.severity = Severity::kError,
          .code = code,
          .file = {},
          .pointer = {},
          .message = std::move(message),
          .hint = std::move(hint)};
}

ExpressionPtr broken(Code code, net::ValueType type, std::string message, std::string hint) {
  auto node = std::make_shared<Expression>();
  node->type = type;
  node->fault = fault_of(code, std::move(message), std::move(hint));
  return node;
}

ExpressionPtr named(const ExpressionPtr& node, std::string id) {
  auto copy = std::make_shared<Expression>(*node);
  copy->primitive.id = std::move(id);
  return copy;
}

std::vector<SubjectPtr> subjects_of(const ExpressionPtr& node) {
  std::vector<SubjectPtr> subjects;
  walk(node, [&subjects](const Expression& e) {
    if (e.subject && std::ranges::find(subjects, e.subject) == subjects.end()) subjects.push_back(e.subject);
  });
  return subjects;
}

Diagnostics faults_of(const ExpressionPtr& node) {
  Diagnostics diagnostics;
  if (!node) {
    diagnostics.error(Code::kMissing, {}, "an empty formula", "Give a sensor or a state");
  } else if (node->depth > kMostDepth) {
    diagnostics.error(Code::kTooLarge, {}, fmt::format("a formula of {} levels", node->depth),
                      fmt::format("Keep it to at most {}", kMostDepth));
  } else {
    walk(node, [&diagnostics](const Expression& e) {
      if (e.fault) diagnostics.add(*e.fault);
    });
  }
  return diagnostics;
}

std::map<std::string, net::Resource*, std::less<>> resources_of(const ExpressionPtr& node) {
  std::map<std::string, net::Resource*, std::less<>> resources;
  walk(node, [&resources](const Expression& e) {
    if (e.resource != nullptr) resources[e.resource_name] = e.resource;
  });
  return resources;
}

}  // namespace takt::expression
