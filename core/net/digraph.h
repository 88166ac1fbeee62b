#pragma once

#include <span>
#include <utility>
#include <vector>

namespace takt::net {

/// A directed graph on the nodes 0..n-1, its edges stored node by node. For core/net and for who writes nets.
struct Digraph {
  struct Edge {
    int to;
    int label;  ///< number of the edge as it was given
  };
  std::vector<int> base;  ///< edges of node n: [base[n], base[n + 1])
  std::vector<Edge> edges;

  Digraph(int node_count, std::span<const std::pair<int, int>> from_to);
  [[nodiscard]] int node_count() const { return static_cast<int>(base.size()) - 1; }
  [[nodiscard]] std::span<const Edge> from(int node) const {
    const auto n = static_cast<std::size_t>(node);
    return {edges.data() + base[n], edges.data() + base[n + 1]};
  }
};

/// Strongly connected components.
struct Components {
  std::vector<int> of;  ///< number per node; an edge between two components leads to the smaller number
  int count = 0;
};

/// Tarjan's algorithm with a stack of its own, O(nodes + edges). Source: Tarjan, "Depth-first search and linear graph
/// algorithms", 1972.
[[nodiscard]] Components strong_components(const Digraph& graph);

}  // namespace takt::net
