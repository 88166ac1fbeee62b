#include "core/expression/comparison.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::expression {
namespace {

/// The first device or channel in a formula; empty: there is none.
std::string source_of(const ExpressionPtr& node) {
  if (!node->resource_name.empty()) return node->resource_name;
  for (const auto& [port, input] : node->inputs)
    if (std::string name = source_of(input); !name.empty()) return name;
  return {};
}

void collect(const ExpressionPtr& node, std::set<const Expression*>& seen, std::vector<Comparison>& comparisons) {
  if (!node || !seen.insert(node.get()).second) return;
  const std::string& type = node->primitive.type;
  const bool above = type == "GreaterThan";
  const auto& parameters = node->primitive.parameters;
  if ((above || type == "LessThan") && node->inputs.size() == 1 && node->inputs.front().first == "a" &&
      parameters.contains("b") && parameters.at("b").is_number()) {
    const ExpressionPtr& quantity = node->inputs.front().second;
    const std::string source = source_of(quantity);
    std::string text = fmt::format("{} {} {:g}", source.empty() ? "a value" : source, above ? "above" : "below",
                                   parameters.at("b").get<double>());
    if (std::ranges::find(comparisons, text, &Comparison::text) == comparisons.end())
      comparisons.push_back({.quantity = RealSensor(quantity), .text = std::move(text)});
  }
  for (const auto& [port, input] : node->inputs) collect(input, seen, comparisons);
}

}  // namespace

std::vector<Comparison> comparisons_of(const State& state) {
  std::vector<Comparison> comparisons;
  std::set<const Expression*> seen;
  if (state.node() && state.node()->depth <= kMostDepth) collect(state.node(), seen, comparisons);
  return comparisons;
}

}  // namespace takt::expression
