#include "core/net/reaction_graph.h"

#include <algorithm>
#include <deque>
#include <numeric>

#include <fmt/format.h>

namespace takt::net {
namespace {

Latency latency_between(const FlatNet& flat, int primitive, int in, int out) {
  const PrimitiveInfo& info = *flat.primitives[static_cast<std::size_t>(primitive)].info;
  for (const auto& entry : info.latencies) {
    if (entry.in == info.inputs[static_cast<std::size_t>(in)].name &&
        entry.out == info.outputs[static_cast<std::size_t>(out)].name) {
      return flat.latency(primitive, entry);
    }
  }
  return {};
}

}  // namespace

ReactionGraph::ReactionGraph(const FlatNet& flat)
    : flat_(flat),
      input_count_(static_cast<int>(flat.input_link.size())),
      graph_(node_count(), collect_edges()),
      components_(strong_components(graph_)) {
  index_components();
}

std::vector<std::pair<int, int>> ReactionGraph::collect_edges() {
  for (std::size_t l = 0; l < flat_.links.size(); ++l) {
    const FlatLink& link = flat_.links[l];
    edges_.push_back({input_count_ + flat_.output_base[static_cast<std::size_t>(link.from)] + link.from_port,
                      flat_.input_base[static_cast<std::size_t>(link.to)] + link.to_port,
                      {link.delayed ? 1 : 0, false},
                      static_cast<int>(l)});
  }
  for (int p = 0; p < flat_.primitive_count(); ++p) add_primitive_edges(p);
  std::vector<std::pair<int, int>> ends;
  ends.reserve(edges_.size());
  for (const Edge& e : edges_) ends.emplace_back(e.from, e.to);
  return ends;
}

void ReactionGraph::add_primitive_edges(int primitive) {
  const int inputs = flat_.input_base[static_cast<std::size_t>(primitive)];
  const int outputs = input_count_ + flat_.output_base[static_cast<std::size_t>(primitive)];
  for (int out = 0; out < flat_.output_count(primitive); ++out) {
    for (int in = 0; in < flat_.input_count(primitive); ++in) {
      // What no link feeds never changes.
      if (flat_.input_link[static_cast<std::size_t>(inputs + in)] < 0) continue;
      edges_.push_back({inputs + in, outputs + out, latency_between(flat_, primitive, in, out), -1});
    }
    add_gate_edges(primitive, outputs + out);
  }
}

/// What switches a fragment, or one around it, reaches the outputs of its members: at once, since they were null
/// before, and once more when what an input brought since then comes out.
void ReactionGraph::add_gate_edges(int primitive, int output) {
  const int port = output - input_count_ - flat_.output_base[static_cast<std::size_t>(primitive)];
  const std::string& name = flat_.output(primitive, port).name;
  Latency latest;
  for (const auto& entry : flat_.primitives[static_cast<std::size_t>(primitive)].info->latencies) {
    if (entry.out != name) continue;
    const Latency latency = flat_.latency(primitive, entry);
    latest.cycles = std::max(latest.cycles, latency.cycles);
    latest.data_dependent = latest.data_dependent || latency.data_dependent;
  }
  for (int f = flat_.fragment_of(primitive); f > 0; f = flat_.fragments[static_cast<std::size_t>(f)].parent) {
    const int gate = flat_.input_base[static_cast<std::size_t>(flat_.primitive_count() + f)];
    if (flat_.input_link[static_cast<std::size_t>(gate)] < 0) continue;
    edges_.push_back({gate, output, {}, -1});
    if (latest.cycles > 0 || latest.data_dependent) edges_.push_back({gate, output, latest, -1});
  }
}

void ReactionGraph::index_components() {
  first_member_.resize(static_cast<std::size_t>(components_.count) + 1);
  for (int n = 0; n < node_count(); ++n) ++first_member_[component(n) + 1];
  std::partial_sum(first_member_.begin(), first_member_.end(), first_member_.begin());
  members_.resize(static_cast<std::size_t>(node_count()));
  std::vector<std::size_t> next(first_member_.begin(), first_member_.end() - 1);
  for (int n = 0; n < node_count(); ++n) members_[next[component(n)]++] = n;
  // A way leaves each port of a loop at most once.
  loop_bound_.resize(static_cast<std::size_t>(components_.count));
  for (int n = 0; n < node_count(); ++n) {
    std::int64_t most = 0;
    for (const Digraph::Edge& e : graph_.from(n)) {
      if (component(e.to) == component(n)) most = std::max(most, edge(e.label).latency.cycles);
    }
    loop_bound_[component(n)] += most;
  }
  on_way_.assign(static_cast<std::size_t>(node_count()), false);
}

void ReactionGraph::follow(std::span<const int> outputs) {
  arrivals_.assign(static_cast<std::size_t>(node_count()), {});
  ways_.clear();
  for (const int output : outputs) {
    arrival(input_count_ + output).first = 0;
    arrival(input_count_ + output).last = 0;
  }
  shortest(outputs);
  // Components are numbered against the direction of the edges.
  for (std::size_t c = loop_bound_.size(); c-- > 0;) {
    const std::span members(members_.data() + first_member_[c], members_.data() + first_member_[c + 1]);
    if (members.size() > 1) through_loop(members);
    for (const int node : members) leave(node);
  }
}

/// Fewest cycles to every port: buckets by distance, since most edges weigh 0 or 1.
void ReactionGraph::shortest(std::span<const int> outputs) {
  std::deque<std::pair<int, std::int64_t>> queue;
  for (const int output : outputs) queue.emplace_back(input_count_ + output, 0);
  while (!queue.empty()) {
    const auto [node, first] = queue.front();
    queue.pop_front();
    if (arrival(node).first != first) continue;  // a shorter way was found meanwhile
    for (const Digraph::Edge& e : graph_.from(node)) {
      const std::int64_t cycles = edge(e.label).latency.cycles;
      Arrival& known = arrival(e.to);
      if (known.first != kNever && known.first <= first + cycles) continue;
      known.first = first + cycles;
      known.first_via = e.label;
      if (cycles == 0) {
        queue.emplace_front(e.to, known.first);
      } else {
        queue.emplace_back(e.to, known.first);
      }
    }
  }
}

void ReactionGraph::arrive(int node, const Arrival& from, const Latency& latency, int via) {
  Arrival& known = arrival(node);
  const std::int64_t last = from.last + latency.cycles;
  known.data_dependent = known.data_dependent || from.data_dependent || latency.data_dependent;
  if (last < known.last || (last == known.last && (known.exact || !from.exact))) return;
  known.last = last;
  known.last_via = via;
  known.exact = from.exact;
}

/// Hands the latest arrival on along the edges that leave the component.
void ReactionGraph::leave(int node) {
  const Arrival from = arrival(node);
  if (from.last == kNever) return;
  for (const Digraph::Edge& e : graph_.from(node)) {
    if (component(e.to) != component(node)) arrive(e.to, from, edge(e.label).latency, e.label);
  }
}

/// Latest arrivals inside a loop, from those at its entries.
void ReactionGraph::through_loop(std::span<const int> members) {
  std::vector<std::pair<int, Arrival>> entries;
  for (const int node : members) {
    if (arrival(node).last != kNever) entries.emplace_back(node, arrival(node));
  }
  if (entries.empty()) return;
  bool tried_all = true;
  for (const auto& [node, from] : entries) tried_all = walk(node, from) && tried_all;
  if (!tried_all) {
    Arrival bound{.exact = false};
    for (const auto& [node, from] : entries) bound.last = std::max(bound.last, from.last);
    for (const int node : members) arrive(node, bound, {loop_bound_[component(node)], false}, kStart);
  }
  const bool data_dependent = std::ranges::any_of(members, [this](int n) { return arrival(n).data_dependent; });
  for (const int node : members) arrival(node).data_dependent = data_dependent;
}

/// Every way from `entry` inside its component that passes no port twice.
/// @return false if the steps ran out.
bool ReactionGraph::walk(int entry, const Arrival& from) {
  struct Step {
    int node, next, way;
    Arrival at;
  };
  ways_.push_back({from.last_via, -1});
  std::vector<Step> way{{entry, 0, static_cast<int>(ways_.size()) - 1, from}};
  on_way_[static_cast<std::size_t>(entry)] = true;
  while (!way.empty()) {
    Step& step = way.back();
    const auto edges = graph_.from(step.node);
    if (static_cast<std::size_t>(step.next) == edges.size() || steps_ > kMostSteps) {
      on_way_[static_cast<std::size_t>(step.node)] = false;
      way.pop_back();
      continue;
    }
    const Digraph::Edge& next = edges[static_cast<std::size_t>(step.next++)];
    ++steps_;
    if (component(next.to) != component(entry) || on_way_[static_cast<std::size_t>(next.to)]) continue;
    ways_.push_back({next.label, step.way});
    Step further{next.to, 0, static_cast<int>(ways_.size()) - 1, step.at};
    arrive(next.to, step.at, edge(next.label).latency, -2 - further.way);
    further.at.last += edge(next.label).latency.cycles;
    further.at.data_dependent = further.at.data_dependent || edge(next.label).latency.data_dependent;
    on_way_[static_cast<std::size_t>(next.to)] = true;
    way.push_back(further);
  }
  return steps_ <= kMostSteps;
}

ReactionGraph::Way ReactionGraph::longest_way(int input) const {
  Way way;
  int via = at(input).last_via;
  while (via != kStart) {
    if (via >= 0) {
      way.push_back(via);
      via = arrivals_[static_cast<std::size_t>(edge(via).from)].last_via;
      continue;
    }
    auto w = static_cast<std::size_t>(-2 - via);
    for (; ways_[w].previous >= 0; w = static_cast<std::size_t>(ways_[w].previous)) way.push_back(ways_[w].edge);
    via = ways_[w].edge;
  }
  std::ranges::reverse(way);
  return way;
}

ReactionGraph::Way ReactionGraph::shortest_way(int input) const {
  Way way;
  for (int via = at(input).first_via; via != kStart;) {
    way.push_back(via);
    via = arrivals_[static_cast<std::size_t>(edge(via).from)].first_via;
  }
  std::ranges::reverse(way);
  return way;
}

ReactionGraph::Way ReactionGraph::data_dependent_way(std::span<const int> outputs, int input) const {
  // Breadth first; each port twice: before and after a latency that depends on data.
  struct Reached {
    int via = kNotYet;
    std::size_t from = 0;
  };
  const auto nodes = static_cast<std::size_t>(node_count());
  const std::size_t goal = nodes + static_cast<std::size_t>(input);
  std::vector<Reached> reached(2 * nodes);
  std::deque<std::size_t> queue;
  for (const int output : outputs) {
    queue.push_back(static_cast<std::size_t>(input_count_ + output));
    reached[queue.back()].via = kStart;
  }
  for (; !queue.empty() && reached[goal].via == kNotYet; queue.pop_front()) {
    const std::size_t from = queue.front();
    for (const Digraph::Edge& e : graph_.from(static_cast<int>(from % nodes))) {
      const bool depends = from >= nodes || edge(e.label).latency.data_dependent;
      const std::size_t to = static_cast<std::size_t>(e.to) + (depends ? nodes : 0);
      if (reached[to].via != kNotYet) continue;
      reached[to] = {e.label, from};
      queue.push_back(to);
    }
  }
  Way way;
  for (std::size_t node = goal; reached[node].via >= 0; node = reached[node].from) way.push_back(reached[node].via);
  std::ranges::reverse(way);
  return way;
}

std::vector<int> ReactionGraph::links_of(const Way& way) const {
  std::vector<int> links;
  for (const int number : way) {
    if (edge(number).link >= 0) links.push_back(edge(number).link);
  }
  return links;
}

std::string ReactionGraph::words_of(const Way& way) const {
  constexpr std::size_t kMostShown = 24;
  std::string text;
  std::size_t steps = 0;
  std::string at;  // id of the primitive that the way is in
  for (const int number : way) {
    const Edge& e = edge(number);
    if (e.link < 0 && e.latency.cycles == 0 && !e.latency.data_dependent) continue;
    if (++steps > kMostShown) continue;
    std::string part;
    if (e.link >= 0) {
      const FlatLink& link = flat_.links[static_cast<std::size_t>(e.link)];
      part = fmt::format("{} -> {}{}", flat_.output_name(link.from, link.from_port),
                         flat_.input_name(link.to, link.to_port), link.delayed ? " (delayed: 1 cycle)" : "");
      at = flat_.id(link.to);
    } else if (e.latency.data_dependent) {
      part = fmt::format("through {}: depends on data", at);
    } else {
      part = fmt::format("through {}: {} cycle{}", at, e.latency.cycles, e.latency.cycles == 1 ? "" : "s");
    }
    text += (text.empty() ? "" : ", ") + part;
  }
  if (steps > kMostShown) text += fmt::format(", ... ({} steps in all)", steps);
  return text;
}

}  // namespace takt::net
