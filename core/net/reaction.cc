#include "core/net/reaction.h"

#include <algorithm>
#include <deque>
#include <numeric>

#include <fmt/format.h>

#include "core/net/digraph.h"

namespace takt::net {
namespace {

constexpr std::int64_t kNever = -1;

/// Ports as nodes of a graph: inputs first, then outputs. Edges: through a link (0 or 1 cycle), through a primitive.
class Certificate {
 public:
  Certificate(const FlatNet& flat, LoadReport& report)
      : flat_(flat),
        report_(report),
        input_count_(static_cast<int>(flat.input_link.size())),
        graph_(node_count(), collect_edges()),
        components_(strong_components(graph_)) {
    index_components();
  }

  std::vector<NetReport::Reaction> run() {
    std::vector<int> sources;
    for (int p = 0; p < flat_.primitive_count(); ++p) {
      if (info(p).source && flat_.output_count(p) > 0) sources.push_back(p);
    }
    std::ranges::sort(sources, {}, [&](int p) { return flat_.id(p); });
    if (sources.size() * (edges_.size() + static_cast<std::size_t>(node_count())) > kMostWork) {
      report_.note({}, fmt::format("no reaction certificate: {} sources are too many", sources.size()));
      return {};
    }
    collect_sinks();
    std::vector<NetReport::Reaction> all;
    for (const int source : sources) certify(source, all);
    return all;
  }

 private:
  static constexpr std::size_t kMostWork = 20'000'000;
  static constexpr std::size_t kMostSteps = 200'000;  ///< of the search inside loops, per net

  struct Arrival {
    std::int64_t first = kNever, last = kNever;
    bool data_dependent = false;
  };

  [[nodiscard]] int node_count() const { return static_cast<int>(flat_.input_link.size()) + flat_.output_base.back(); }
  [[nodiscard]] int input_node(int node, int port) const {
    return flat_.input_base[static_cast<std::size_t>(node)] + port;
  }
  [[nodiscard]] int output_node(int node, int port) const {
    return input_count_ + flat_.output_base[static_cast<std::size_t>(node)] + port;
  }
  [[nodiscard]] const PrimitiveInfo& info(int primitive) const {
    return *flat_.primitives[static_cast<std::size_t>(primitive)].info;
  }

  static Latency latency(const PrimitiveInfo& info, int in, int out) {
    for (const auto& entry : info.latencies) {
      if (entry.in == info.inputs[static_cast<std::size_t>(in)].name &&
          entry.out == info.outputs[static_cast<std::size_t>(out)].name) {
        return entry.latency;
      }
    }
    return {};
  }

  void add_edge(int from, int to, const Latency& weight) {
    edges_.emplace_back(from, to);
    weights_.push_back(weight);
  }

  const std::vector<std::pair<int, int>>& collect_edges() {
    for (const FlatLink& link : flat_.links) {
      add_edge(output_node(link.from, link.from_port), input_node(link.to, link.to_port),
               {link.delayed ? 1 : 0, false});
    }
    for (int p = 0; p < flat_.primitive_count(); ++p) {
      for (int out = 0; out < flat_.output_count(p); ++out) {
        for (int in = 0; in < flat_.input_count(p); ++in) {
          add_edge(input_node(p, in), output_node(p, out), latency(info(p), in, out));
        }
        add_gates(p, out);
      }
    }
    return edges_;
  }

  /// What switches a fragment, or one around it, reaches the outputs of its members.
  void add_gates(int primitive, int out) {
    for (int f = flat_.fragment_of(primitive); f > 0; f = flat_.fragments[static_cast<std::size_t>(f)].parent) {
      const int gate = input_node(flat_.primitive_count() + f, 0);
      if (flat_.input_link[static_cast<std::size_t>(gate)] >= 0) add_edge(gate, output_node(primitive, out), {});
    }
  }

  void index_components() {
    first_member_.resize(static_cast<std::size_t>(components_.count) + 1);
    for (int n = 0; n < node_count(); ++n) ++first_member_[component(n) + 1];
    std::partial_sum(first_member_.begin(), first_member_.end(), first_member_.begin());
    members_.resize(static_cast<std::size_t>(node_count()));
    std::vector<std::size_t> next(first_member_.begin(), first_member_.end() - 1);
    for (int n = 0; n < node_count(); ++n) members_[next[component(n)]++] = n;
    loop_weight_.resize(static_cast<std::size_t>(components_.count));
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (component(edges_[e].first) == component(edges_[e].second)) {
        loop_weight_[component(edges_[e].first)] += weights_[e].cycles;
      }
    }
    on_way_.assign(static_cast<std::size_t>(node_count()), false);
  }

  [[nodiscard]] std::size_t component(int node) const {
    return static_cast<std::size_t>(components_.of[static_cast<std::size_t>(node)]);
  }

  void collect_sinks() {
    for (int p = 0; p < flat_.primitive_count(); ++p) {
      const bool whole = info(p).termination || info(p).monitor || !info(p).claims.empty();
      for (int port = 0; port < flat_.input_count(p); ++port) {
        const OnNull on_null = flat_.input(p, port).spec.on_null;
        if (whole || on_null == OnNull::kStop || on_null == OnNull::kCountsAsTrue) sinks_.emplace_back(p, port);
      }
    }
    std::ranges::sort(sinks_, {}, [&](const auto& sink) { return flat_.input_name(sink.first, sink.second); });
  }

  void certify(int source, std::vector<NetReport::Reaction>& all) {
    arrivals_.assign(static_cast<std::size_t>(node_count()), {});
    for (int port = 0; port < flat_.output_count(source); ++port) {
      arrivals_[static_cast<std::size_t>(output_node(source, port))] = {0, 0, false};
    }
    shortest(source);
    // Components are numbered against the direction of the edges.
    for (std::size_t c = loop_weight_.size(); c-- > 0;) {
      const std::span members(members_.data() + first_member_[c], members_.data() + first_member_[c + 1]);
      if (members.size() > 1) through_loop(members);
      for (const int node : members) leave(node);
    }
    for (const auto& [node, port] : sinks_) {
      const Arrival& arrival = arrivals_[static_cast<std::size_t>(input_node(node, port))];
      if (arrival.first == kNever) continue;
      all.push_back({flat_.id(source),
                     flat_.input_name(node, port),
                     arrival.first,
                     arrival.last,
                     arrival.data_dependent,
                     true,
                     {}});
    }
  }

  /// Fewest cycles to every port: buckets by distance, since most edges weigh 0 or 1.
  void shortest(int source) {
    std::deque<std::pair<int, std::int64_t>> queue;
    for (int port = 0; port < flat_.output_count(source); ++port) queue.emplace_back(output_node(source, port), 0);
    while (!queue.empty()) {
      const auto [node, first] = queue.front();
      queue.pop_front();
      if (arrivals_[static_cast<std::size_t>(node)].first != first) continue;  // a shorter way was found meanwhile
      for (const Digraph::Edge& edge : graph_.from(node)) {
        const std::int64_t cycles = weights_[static_cast<std::size_t>(edge.label)].cycles;
        std::int64_t& known = arrivals_[static_cast<std::size_t>(edge.to)].first;
        if (known != kNever && known <= first + cycles) continue;
        known = first + cycles;
        if (cycles == 0) {
          queue.emplace_front(edge.to, known);
        } else {
          queue.emplace_back(edge.to, known);
        }
      }
    }
  }

  void arrive(int node, std::int64_t last, bool data_dependent) {
    Arrival& arrival = arrivals_[static_cast<std::size_t>(node)];
    arrival.last = std::max(arrival.last, last);
    arrival.data_dependent = arrival.data_dependent || data_dependent;
  }

  /// Hands the latest arrival on along the edges that leave the component.
  void leave(int node) {
    const Arrival arrival = arrivals_[static_cast<std::size_t>(node)];
    if (arrival.last == kNever) return;
    for (const Digraph::Edge& edge : graph_.from(node)) {
      if (component(edge.to) == component(node)) continue;
      const Latency& weight = weights_[static_cast<std::size_t>(edge.label)];
      arrive(edge.to, arrival.last + weight.cycles, arrival.data_dependent || weight.data_dependent);
    }
  }

  /// Latest arrivals inside a loop, from those at its entries.
  void through_loop(std::span<const int> members) {
    std::vector<std::pair<int, Arrival>> entries;
    for (const int node : members) {
      const Arrival& arrival = arrivals_[static_cast<std::size_t>(node)];
      if (arrival.last != kNever) entries.emplace_back(node, arrival);
    }
    if (entries.empty()) return;
    bool exact = true;
    for (const auto& [node, arrival] : entries) exact = exact && walk(node, arrival);
    std::int64_t bound = 0;
    bool data_dependent = false;
    for (const auto& [node, arrival] : entries) {
      bound = std::max(bound, arrival.last + loop_weight_[component(node)]);
      data_dependent = data_dependent || arrival.data_dependent;
    }
    for (const int node : members) {
      if (!exact) arrive(node, bound, data_dependent);
      data_dependent = data_dependent || arrivals_[static_cast<std::size_t>(node)].data_dependent;
    }
    for (const int node : members) arrivals_[static_cast<std::size_t>(node)].data_dependent = data_dependent;
  }

  /// Every way from `entry` inside its component that passes no port twice.
  /// @return false if the steps ran out.
  bool walk(int entry, const Arrival& arrival) {
    struct Step {
      int node, next;
      std::int64_t last;
    };
    std::vector<Step> way{{entry, 0, arrival.last}};
    on_way_[static_cast<std::size_t>(entry)] = true;
    while (!way.empty()) {
      Step& step = way.back();
      const auto edges = graph_.from(step.node);
      if (static_cast<std::size_t>(step.next) == edges.size() || steps_ > kMostSteps) {
        on_way_[static_cast<std::size_t>(step.node)] = false;
        way.pop_back();
        continue;
      }
      const Digraph::Edge& edge = edges[static_cast<std::size_t>(step.next++)];
      ++steps_;
      if (component(edge.to) != component(entry) || on_way_[static_cast<std::size_t>(edge.to)]) continue;
      const Latency& weight = weights_[static_cast<std::size_t>(edge.label)];
      const std::int64_t last = step.last + weight.cycles;
      arrive(edge.to, last, arrival.data_dependent || weight.data_dependent);
      on_way_[static_cast<std::size_t>(edge.to)] = true;
      way.push_back({edge.to, 0, last});
    }
    return steps_ <= kMostSteps;
  }

  const FlatNet& flat_;
  LoadReport& report_;
  int input_count_;
  std::vector<std::pair<int, int>> edges_;
  std::vector<Latency> weights_;
  Digraph graph_;
  Components components_;
  std::vector<int> members_;  ///< nodes by component; those of c are [first_member_[c], first_member_[c + 1])
  std::vector<std::size_t> first_member_;
  std::vector<std::int64_t> loop_weight_;  ///< per component: cycles of all its edges
  std::vector<bool> on_way_;
  std::vector<std::pair<int, int>> sinks_;
  std::vector<Arrival> arrivals_;
  std::size_t steps_ = 0;
};

}  // namespace

std::vector<NetReport::Reaction> reactions(const FlatNet& flat, LoadReport& report) {
  const bool any = std::ranges::any_of(flat.primitives, [](const FlatPrimitive& p) { return p.info->source; });
  if (!any) return {};
  return Certificate(flat, report).run();
}

}  // namespace takt::net
