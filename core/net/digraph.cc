#include "core/net/digraph.h"

#include <algorithm>
#include <numeric>

namespace takt::net {

Digraph::Digraph(int node_count, std::span<const std::pair<int, int>> from_to)
    : base(static_cast<std::size_t>(node_count) + 1), edges(from_to.size()) {
  for (const auto& [from, to] : from_to) ++base[static_cast<std::size_t>(from) + 1];
  std::partial_sum(base.begin(), base.end(), base.begin());
  std::vector<int> next(base.begin(), base.end() - 1);
  for (std::size_t e = 0; e < from_to.size(); ++e) {
    const auto [from, to] = from_to[e];
    edges[static_cast<std::size_t>(next[static_cast<std::size_t>(from)]++)] = {to, static_cast<int>(e)};
  }
}

Components strong_components(const Digraph& graph) {
  const std::size_t nodes = static_cast<std::size_t>(graph.node_count());
  Components components{std::vector<int>(nodes, -1), 0};
  std::vector<int> number(nodes, -1), low(nodes), next(nodes), open, path;
  int counter = 0;
  const auto enter = [&](int node) {
    const auto n = static_cast<std::size_t>(node);
    number[n] = low[n] = counter++;
    next[n] = graph.base[n];
    open.push_back(node);
    path.push_back(node);
  };
  const auto close = [&](int root) {
    for (int node = -1; node != root; open.pop_back()) {
      node = open.back();
      components.of[static_cast<std::size_t>(node)] = components.count;
    }
    ++components.count;
  };
  for (std::size_t root = 0; root < nodes; ++root) {
    if (number[root] < 0) enter(static_cast<int>(root));
    while (!path.empty()) {
      const auto n = static_cast<std::size_t>(path.back());
      if (next[n] < graph.base[n + 1]) {
        const auto to = static_cast<std::size_t>(graph.edges[static_cast<std::size_t>(next[n]++)].to);
        if (number[to] < 0) {
          enter(static_cast<int>(to));
        } else if (components.of[to] < 0) {  // still open
          low[n] = std::min(low[n], number[to]);
        }
        continue;
      }
      path.pop_back();
      if (!path.empty()) {
        int& below = low[static_cast<std::size_t>(path.back())];
        below = std::min(below, low[n]);
      }
      if (low[n] == number[n]) close(static_cast<int>(n));
    }
  }
  return components;
}

}  // namespace takt::net
