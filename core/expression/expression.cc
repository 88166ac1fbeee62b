#include "core/expression/expression.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/net_writer.h"
#include "core/net/compiled_net.h"
#include "core/net/primitive.h"

namespace takt::command {
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

/// The resources that one formula names, as LOAD looks for them.
class OwnResources final : public net::Environment {
 public:
  explicit OwnResources(const ExpressionPtr& node) {
    walk(node, [this](const Expression& e) {
      if (e.resource != nullptr) resources_[e.resource_name] = e.resource;
    });
  }
  net::Resource* find(std::string_view name) override {
    const auto found = resources_.find(name);
    return found == resources_.end() ? nullptr : found->second;
  }
  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, resource] : resources_) names.push_back(name);
    return names;
  }

 private:
  std::map<std::string, net::Resource*, std::less<>> resources_;
};

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
    diagnostics.error(Code::kMissing, {}, "an empty formula", "a sensor or a state");
  } else if (node->depth > kMostDepth) {
    diagnostics.error(Code::kTooLarge, {}, fmt::format("a formula of {} levels", node->depth),
                      fmt::format("at most {}", kMostDepth));
  } else {
    walk(node, [&diagnostics](const Expression& e) {
      if (e.fault) diagnostics.add(*e.fault);
    });
  }
  return diagnostics;
}

template <class T>
struct CompiledFormula<T>::Net {
  ExpressionPtr node;
  std::unique_ptr<net::CompiledNet> compiled;
  const net::Slot<T>* slot = nullptr;
};

template <class T>
CompiledFormula<T>::CompiledFormula(const ExpressionPtr& node) {
  if (faults_of(node).has_errors() || !subjects_of(node).empty()) return;
  NetWriter writer;
  const std::string port = writer.port_of(node);
  writer.net.add("end", "Termination", {{"condition", true}});
  OwnResources resources(node);
  auto net = net::CompiledNet::compile(writer.net, resources);
  if (!net) return;
  const auto* slot = (*net)->template find<T>(port);
  if (slot != nullptr) net_ = std::make_unique<Net>(Net{node, std::move(*net), slot});
}
template <class T>
CompiledFormula<T>::~CompiledFormula() = default;
template <class T>
CompiledFormula<T>::CompiledFormula(CompiledFormula&&) noexcept = default;
template <class T>
CompiledFormula<T>& CompiledFormula<T>::operator=(CompiledFormula&&) noexcept = default;

template <class T>
std::optional<T> CompiledFormula<T>::now() {
  if (!net_) return std::nullopt;
  net_->compiled->evaluate({});
  if (net_->compiled->signals().fail) return std::nullopt;
  return net_->slot->null != 0 ? std::nullopt : std::optional<T>(net_->slot->value);
}

template <class T>
std::optional<T> evaluate(const ExpressionPtr& node) {
  return CompiledFormula<T>(node).now();
}

template class CompiledFormula<net::Boolean>;
template std::optional<net::Boolean> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Integer>;
template std::optional<net::Integer> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Real>;
template std::optional<net::Real> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Text>;
template std::optional<net::Text> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Vector>;
template std::optional<net::Vector> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Rotation>;
template std::optional<net::Rotation> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Frame>;
template std::optional<net::Frame> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Twist>;
template std::optional<net::Twist> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::Wrench>;
template std::optional<net::Wrench> evaluate(const ExpressionPtr&);
template class CompiledFormula<net::JointArray>;
template std::optional<net::JointArray> evaluate(const ExpressionPtr&);

}  // namespace takt::command
