#include "core/net/schedule.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>

#include <fmt/format.h>

namespace takt::net {
namespace {

/// Which nodes read a node in the same cycle; the edges of node n are [base[n], base[n+1]).
struct Graph {
  struct Edge {
    int to;
    int link;  ///< -1: from a gate to a member of its fragment
  };
  std::vector<int> base;
  std::vector<Edge> edges;
  std::vector<int> incoming;

  [[nodiscard]] std::span<const Edge> from(int node) const {
    const auto n = static_cast<std::size_t>(node);
    return {edges.data() + base[n], edges.data() + base[n + 1]};
  }
};

template <class Visit>
void for_each_edge(const FlatNet& flat, Visit visit) {
  for (std::size_t l = 0; l < flat.links.size(); ++l) {
    const FlatLink& link = flat.links[l];
    if (link.from >= 0 && !link.delayed) visit(link.from, Graph::Edge{link.to, static_cast<int>(l)});
  }
  const auto gate = [&](int fragment) { return flat.primitive_count() + fragment; };
  for (int p = 0; p < flat.primitive_count(); ++p) {
    const int fragment = flat.fragment_of(p);
    if (flat.fragments[static_cast<std::size_t>(fragment)].gated) visit(gate(fragment), Graph::Edge{p, -1});
  }
  for (std::size_t f = 1; f < flat.fragments.size(); ++f) {
    const int parent = flat.fragments[f].parent;
    if (flat.fragments[static_cast<std::size_t>(parent)].gated) {
      visit(gate(parent), Graph::Edge{gate(static_cast<int>(f)), -1});
    }
  }
}

Graph make_graph(const FlatNet& flat) {
  const std::size_t nodes = static_cast<std::size_t>(flat.node_count());
  Graph graph{std::vector<int>(nodes + 1), {}, std::vector<int>(nodes)};
  for_each_edge(flat, [&](int from, Graph::Edge edge) {
    ++graph.base[static_cast<std::size_t>(from) + 1];
    ++graph.incoming[static_cast<std::size_t>(edge.to)];
  });
  std::partial_sum(graph.base.begin(), graph.base.end(), graph.base.begin());
  graph.edges.resize(static_cast<std::size_t>(graph.base.back()));
  std::vector<int> next(graph.base.begin(), graph.base.end() - 1);
  for_each_edge(flat, [&](int from, Graph::Edge edge) {
    graph.edges[static_cast<std::size_t>(next[static_cast<std::size_t>(from)]++)] = edge;
  });
  return graph;
}

/// Nodes sorted by id, and each node's place in that list.
struct Ranks {
  std::vector<int> by_rank, rank;
};

Ranks rank_by_id(const FlatNet& flat) {
  Ranks ranks{std::vector<int>(static_cast<std::size_t>(flat.node_count())), {}};
  std::iota(ranks.by_rank.begin(), ranks.by_rank.end(), 0);
  // The index decides between equal ids, which are errors anyway.
  std::ranges::sort(ranks.by_rank, [&](int a, int b) {
    const int order = flat.id(a).compare(flat.id(b));
    return order != 0 ? order < 0 : a < b;
  });
  ranks.rank.resize(ranks.by_rank.size());
  for (std::size_t r = 0; r < ranks.by_rank.size(); ++r) {
    ranks.rank[static_cast<std::size_t>(ranks.by_rank[r])] = static_cast<int>(r);
  }
  return ranks;
}

/// Finds and words the cycles among nodes that could not be ordered.
class CycleReporter {
 public:
  CycleReporter(const FlatNet& flat, const Graph& graph, std::vector<bool> open, LoadReport& report)
      : flat_(flat),
        graph_(graph),
        open_(std::move(open)),
        report_(report),
        component_(open_.size(), -1),
        reached_by_(open_.size(), -1) {}

  void run(const std::vector<int>& by_rank) {
    find_components(by_rank);
    std::vector<std::vector<int>> members(static_cast<std::size_t>(components_));
    for (const int node : by_rank) {
      if (const int c = component_[static_cast<std::size_t>(node)]; c >= 0)
        members[static_cast<std::size_t>(c)].push_back(node);
    }
    std::ranges::sort(members);  // components are numbered by the walk; report them by their first member
    for (const auto& nodes : members) report_component(nodes);
  }

 private:
  struct Step {
    int node;
    int edge;  ///< index into graph_.edges by which the node was reached
  };

  bool inside(int node, int component) const { return component_[static_cast<std::size_t>(node)] == component; }

  /// Tarjan's strongly connected components with a stack of our own.
  void find_components(const std::vector<int>& by_rank) {
    const std::size_t nodes = open_.size();
    std::vector<int> number(nodes, -1), low(nodes), next(nodes), stack;
    std::vector<bool> on_stack(nodes);
    std::vector<int> path;
    int counter = 0;
    const auto enter = [&](int node) {
      const auto n = static_cast<std::size_t>(node);
      number[n] = low[n] = counter++;
      next[n] = graph_.base[n];
      stack.push_back(node);
      on_stack[n] = true;
      path.push_back(node);
    };
    for (const int root : by_rank) {
      if (!open_[static_cast<std::size_t>(root)] || number[static_cast<std::size_t>(root)] >= 0) continue;
      enter(root);
      while (!path.empty()) {
        const auto n = static_cast<std::size_t>(path.back());
        if (next[n] < graph_.base[n + 1]) {
          const int to = graph_.edges[static_cast<std::size_t>(next[n]++)].to;
          const auto t = static_cast<std::size_t>(to);
          if (!open_[t]) continue;
          if (number[t] < 0) {
            enter(to);
          } else if (on_stack[t]) {
            low[n] = std::min(low[n], number[t]);
          }
          continue;
        }
        path.pop_back();
        if (!path.empty()) {
          const auto p = static_cast<std::size_t>(path.back());
          low[p] = std::min(low[p], low[n]);
        }
        if (low[n] == number[n]) close_component(static_cast<int>(n), stack, on_stack);
      }
    }
  }

  void close_component(int root, std::vector<int>& stack, std::vector<bool>& on_stack) {
    const bool single = stack.back() == root;
    const bool loop = std::ranges::any_of(graph_.from(root), [&](const Graph::Edge& edge) { return edge.to == root; });
    const int number = single && !loop ? -1 : components_++;
    for (int node = -1; node != root;) {
      node = stack.back();
      stack.pop_back();
      on_stack[static_cast<std::size_t>(node)] = false;
      component_[static_cast<std::size_t>(node)] = number;
    }
  }

  /// Shortest way from `start` back to itself inside its component, as indices of edges; empty if longer than `limit`.
  std::vector<int> shortest_from(int start, std::size_t limit, std::size_t& work) {
    const int component = component_[static_cast<std::size_t>(start)];
    std::vector<int> touched;
    std::vector<int> chain;
    std::vector<std::pair<int, std::size_t>> queue{{start, 0}};
    for (std::size_t head = 0; head < queue.size() && chain.empty(); ++head) {
      const auto [node, length] = queue[head];
      if (length >= limit) break;
      const auto n = static_cast<std::size_t>(node);
      for (int e = graph_.base[n]; e < graph_.base[n + 1]; ++e, ++work) {
        const int to = graph_.edges[static_cast<std::size_t>(e)].to;
        if (!inside(to, component) || (to != start && reached_by_[static_cast<std::size_t>(to)] >= 0)) continue;
        reached_by_[static_cast<std::size_t>(to)] = e;
        touched.push_back(to);
        if (to == start) {
          chain = walk_back(start);
          break;
        }
        queue.emplace_back(to, length + 1);
      }
    }
    for (const int node : touched) reached_by_[static_cast<std::size_t>(node)] = -1;
    return chain;
  }

  std::vector<int> walk_back(int start) const {
    std::vector<int> chain;
    int node = start;
    do {
      const int e = reached_by_[static_cast<std::size_t>(node)];
      chain.push_back(e);
      node = static_cast<int>(std::ranges::upper_bound(graph_.base, e) - graph_.base.begin()) - 1;
    } while (node != start);
    std::ranges::reverse(chain);
    return chain;
  }

  void report_component(const std::vector<int>& nodes) {
    // The shortest cycle through each node, until the work is enough; in a big tangle a short one will do.
    constexpr std::size_t kEnoughWork = 2'000'000;
    std::vector<int> best;
    std::size_t work = 0;
    for (const int node : nodes) {
      std::vector<int> chain = shortest_from(node, best.empty() ? open_.size() + 1 : best.size() - 1, work);
      if (!chain.empty()) best = std::move(chain);
      if (best.size() == 1 || work > kEnoughWork) break;
    }
    word(best);
  }

  void word(const std::vector<int>& chain) {
    constexpr std::size_t kMostShown = 24;
    std::string text;
    int first_link = -1;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const int link = graph_.edges[static_cast<std::size_t>(chain[i])].link;
      if (link < 0) continue;  // from a gate to its member: the member's link follows
      if (first_link < 0) first_link = link;
      if (i >= kMostShown) continue;
      const FlatLink& l = flat_.links[static_cast<std::size_t>(link)];
      text += fmt::format("{}{} -> {}", text.empty() ? "" : ", ", flat_.output_name(l.from, l.from_port),
                          flat_.input_name(l.to, l.to_port));
    }
    if (chain.size() > kMostShown) text += fmt::format(", ... ({} links in all)", chain.size());
    report_.error(flat_.link_pointer(flat_.links[static_cast<std::size_t>(first_link)]),
                  fmt::format("cycle without a delay: {}", text),
                  "every value here waits for itself; mark one of these links \"delayed\": true (one cycle, with "
                  "\"initial\"), or lead it into an input that breaks loops");
  }

  const FlatNet& flat_;
  const Graph& graph_;
  std::vector<bool> open_;
  LoadReport& report_;
  std::vector<int> component_;
  std::vector<int> reached_by_;  ///< edge by which the search came to a node, or -1
  int components_ = 0;
};

}  // namespace

std::vector<int> schedule(const FlatNet& flat, LoadReport& report) {
  Graph graph = make_graph(flat);
  const Ranks ranks = rank_by_id(flat);
  std::vector<int> order;
  order.reserve(ranks.rank.size());
  std::priority_queue<int, std::vector<int>, std::greater<>> ready;
  for (const int node : ranks.by_rank) {
    if (graph.incoming[static_cast<std::size_t>(node)] == 0) ready.push(ranks.rank[static_cast<std::size_t>(node)]);
  }
  while (!ready.empty()) {
    const int node = ranks.by_rank[static_cast<std::size_t>(ready.top())];
    ready.pop();
    order.push_back(node);
    for (const Graph::Edge& edge : graph.from(node)) {
      if (--graph.incoming[static_cast<std::size_t>(edge.to)] == 0)
        ready.push(ranks.rank[static_cast<std::size_t>(edge.to)]);
    }
  }
  if (order.size() == ranks.rank.size()) return order;
  std::vector<bool> open(ranks.rank.size(), true);
  for (const int node : order) open[static_cast<std::size_t>(node)] = false;
  for (const int node : ranks.by_rank) {
    if (open[static_cast<std::size_t>(node)]) order.push_back(node);
  }
  CycleReporter(flat, graph, std::move(open), report).run(ranks.by_rank);
  return order;
}

}  // namespace takt::net
