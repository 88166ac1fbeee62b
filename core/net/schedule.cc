#include "core/net/schedule.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>

#include <fmt/format.h>

#include "core/net/digraph.h"

namespace takt::net {
namespace {

/// Which nodes read a node in the same cycle. An edge's label is its link, or -1 from a gate to a member.
struct Dependencies {
  std::vector<std::pair<int, int>> edges;
  std::vector<int> links;
};

Dependencies dependencies(const FlatNet& flat) {
  Dependencies all;
  const auto add = [&](int from, int to, int link) {
    all.edges.emplace_back(from, to);
    all.links.push_back(link);
  };
  for (std::size_t l = 0; l < flat.links.size(); ++l) {
    const FlatLink& link = flat.links[l];
    if (link.from >= 0 && !link.delayed) add(link.from, link.to, static_cast<int>(l));
  }
  const auto gated = [&](int fragment) { return flat.fragments[static_cast<std::size_t>(fragment)].gated; };
  const auto gate = [&](int fragment) { return flat.primitive_count() + fragment; };
  for (int p = 0; p < flat.primitive_count(); ++p) {
    if (gated(flat.fragment_of(p))) add(gate(flat.fragment_of(p)), p, -1);
  }
  for (std::size_t f = 1; f < flat.fragments.size(); ++f) {
    const int parent = flat.fragments[f].parent;
    if (gated(parent)) add(gate(parent), gate(static_cast<int>(f)), -1);
  }
  return all;
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

/// Finds and words the cycles, one per strongly connected group of nodes.
class CycleReporter {
 public:
  CycleReporter(const FlatNet& flat, const Digraph& graph, const std::vector<int>& links, LoadReport& report)
      : flat_(flat),
        graph_(graph),
        links_(links),
        report_(report),
        components_(strong_components(graph)),
        reached_by_(static_cast<std::size_t>(graph.node_count()), -1) {}

  /// `nodes`: those that could not be ordered, by id.
  void run(std::span<const int> nodes) {
    std::vector<int> group_of(static_cast<std::size_t>(components_.count), -1);
    std::vector<std::vector<int>> groups;
    for (const int node : nodes) {
      int& group = group_of[static_cast<std::size_t>(component(node))];
      if (group < 0) {
        group = static_cast<int>(groups.size());
        groups.emplace_back();
      }
      groups[static_cast<std::size_t>(group)].push_back(node);
    }
    for (const auto& group : groups) {
      const std::vector<int> chain = shortest_cycle(group);
      if (!chain.empty()) word(chain);
    }
  }

 private:
  [[nodiscard]] int component(int node) const { return components_.of[static_cast<std::size_t>(node)]; }

  /// Edges of the shortest way from `start` back to itself with at most `limit` of them; empty if there is none.
  std::vector<int> shortest_from(int start, std::size_t limit, std::size_t& work) {
    std::vector<int> touched, chain;
    std::vector<std::pair<int, std::size_t>> queue{{start, 0}};
    for (std::size_t head = 0; head < queue.size() && chain.empty(); ++head) {
      const auto [node, length] = queue[head];
      if (length >= limit) break;
      const auto n = static_cast<std::size_t>(node);
      for (int e = graph_.base[n]; e < graph_.base[n + 1]; ++e, ++work) {
        const int to = graph_.edges[static_cast<std::size_t>(e)].to;
        int& reached_by = reached_by_[static_cast<std::size_t>(to)];
        if (component(to) != component(start) || reached_by >= 0) continue;
        reached_by = e;
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

  [[nodiscard]] std::vector<int> walk_back(int start) const {
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

  /// The shortest cycle through each node of the group, until the work is enough; in a big tangle a short one will do.
  std::vector<int> shortest_cycle(const std::vector<int>& group) {
    constexpr std::size_t kEnoughWork = 2'000'000;
    std::vector<int> best;
    std::size_t work = 0;
    for (const int node : group) {
      std::vector<int> chain = shortest_from(node, best.empty() ? group.size() : best.size() - 1, work);
      if (!chain.empty()) best = std::move(chain);
      if (best.size() == 1 || work > kEnoughWork) break;
    }
    return best;
  }

  void word(const std::vector<int>& chain) {
    constexpr std::size_t kMostShown = 24;
    std::string text;
    int first_link = -1;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const int link = links_[static_cast<std::size_t>(graph_.edges[static_cast<std::size_t>(chain[i])].label)];
      if (link < 0) continue;  // from a gate to a member: the member's link follows
      if (first_link < 0) first_link = link;
      if (i >= kMostShown) continue;
      const FlatLink& l = flat_.links[static_cast<std::size_t>(link)];
      text += fmt::format("{}{} -> {}", text.empty() ? "" : ", ", flat_.output_name(l.from, l.from_port),
                          flat_.input_name(l.to, l.to_port));
    }
    if (chain.size() > kMostShown) text += fmt::format(", ... ({} steps in all)", chain.size());
    report_.error(Code::kCycleWithoutDelay, flat_.link_pointer(flat_.links[static_cast<std::size_t>(first_link)]),
                  fmt::format("cycle without a delay: {}", text),
                  "Mark one of these links \"delayed\": true (one cycle, with \"initial\"), or lead it into an input "
                  "that breaks loops: every value here waits for itself");
  }

  const FlatNet& flat_;
  const Digraph& graph_;
  const std::vector<int>& links_;
  LoadReport& report_;
  Components components_;
  std::vector<int> reached_by_;  ///< edge by which the search came to a node, or -1
};

}  // namespace

std::vector<int> schedule(const FlatNet& flat, LoadReport& report) {
  const Dependencies all = dependencies(flat);
  const Digraph graph(flat.node_count(), all.edges);
  std::vector<int> waits_for(static_cast<std::size_t>(flat.node_count()));
  for (const auto& [from, to] : all.edges) ++waits_for[static_cast<std::size_t>(to)];

  const Ranks ranks = rank_by_id(flat);
  std::vector<int> order;
  order.reserve(ranks.rank.size());
  std::priority_queue<int, std::vector<int>, std::greater<>> ready;
  for (const int node : ranks.by_rank) {
    if (waits_for[static_cast<std::size_t>(node)] == 0) ready.push(ranks.rank[static_cast<std::size_t>(node)]);
  }
  while (!ready.empty()) {
    const int node = ranks.by_rank[static_cast<std::size_t>(ready.top())];
    ready.pop();
    order.push_back(node);
    for (const Digraph::Edge& edge : graph.from(node)) {
      const auto to = static_cast<std::size_t>(edge.to);
      if (--waits_for[to] == 0) ready.push(ranks.rank[to]);
    }
  }
  const std::size_t ordered = order.size();
  for (const int node : ranks.by_rank) {
    if (waits_for[static_cast<std::size_t>(node)] > 0) order.push_back(node);
  }
  if (ordered < order.size()) {
    CycleReporter(flat, graph, all.links, report).run(std::span(order).subspan(ordered));
  }
  return order;
}

}  // namespace takt::net
