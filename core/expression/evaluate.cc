#include "core/expression/evaluate.h"

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/expression/net_writer.h"
#include "core/net/compiled_net.h"
#include "core/net/primitive.h"

namespace takt::expression {
namespace {

/// The resources that one formula names, as LOAD looks for them.
class OwnResources final : public net::Environment {
 public:
  explicit OwnResources(const ExpressionPtr& node) : resources_(resources_of(node)) {}
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

}  // namespace takt::expression
