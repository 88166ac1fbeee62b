#include "core/net/reaction.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "core/net/reaction_graph.h"

namespace takt::net {
namespace {

/// Edges walked over all sources or demands of a net: less than half a second.
constexpr std::size_t kMostWork = 20'000'000;
/// Links of all critical paths together; lines beyond go without.
constexpr std::size_t kMostPathLinks = 2'000'000;

const PrimitiveInfo& info_of(const FlatNet& flat, int primitive) {
  return *flat.primitives[static_cast<std::size_t>(primitive)].info;
}

std::vector<int> outputs_of(const FlatNet& flat, int primitive) {
  std::vector<int> outputs(static_cast<std::size_t>(flat.output_count(primitive)));
  std::iota(outputs.begin(), outputs.end(), flat.output_base[static_cast<std::size_t>(primitive)]);
  return outputs;
}

std::vector<int> sources(const FlatNet& flat) {
  std::vector<int> found;
  for (int p = 0; p < flat.primitive_count(); ++p) {
    if (info_of(flat, p).source && flat.output_count(p) > 0) found.push_back(p);
  }
  std::ranges::sort(found, {}, [&](int p) { return flat.id(p); });
  return found;
}

/// Inputs (node, port) where a reaction counts.
std::vector<std::pair<int, int>> sinks(const FlatNet& flat) {
  std::vector<std::pair<int, int>> found;
  for (int p = 0; p < flat.primitive_count(); ++p) {
    const PrimitiveInfo& info = info_of(flat, p);
    const bool whole = info.termination || info.monitor || !info.claims.empty();
    for (int port = 0; port < flat.input_count(p); ++port) {
      const OnNull on_null = flat.input(p, port).spec.on_null;
      if (whole || on_null == OnNull::kStop || on_null == OnNull::kCountsAsTrue) found.emplace_back(p, port);
    }
  }
  std::ranges::sort(found, {}, [&](const auto& sink) { return flat.input_name(sink.first, sink.second); });
  return found;
}

std::string cycles(std::int64_t count) { return fmt::format("{} cycle{}", count, count == 1 ? "" : "s"); }

class DemandCheck {
 public:
  DemandCheck(const FlatNet& flat, NetReport& net_report, LoadReport& report)
      : flat_(flat), net_report_(net_report), report_(report), graph_(flat) {}

  void run() {
    int followed = -1;
    for (const FlatDemand& demand : flat_.demands) {
      const int output = flat_.output_base[static_cast<std::size_t>(demand.from)] + demand.from_port;
      if (output != followed) work_ += graph_.size();
      if (work_ > kMostWork) {
        report_.error(Code::kTooLarge, flat_.demand_pointer(demand), "too many demands for a net of this size",
                      "List demands from one output one after the other: the path from there is followed once");
        return;
      }
      if (output != followed) graph_.follow(std::span(&output, 1));
      followed = output;
      check(demand, output);
    }
  }

 private:
  void check(const FlatDemand& demand, int output) {
    const DemandDescription& wanted = flat_.description(demand);
    const int input = flat_.input_base[static_cast<std::size_t>(demand.to)] + demand.to_port;
    const std::string from = flat_.output_name(demand.from, demand.from_port);
    const std::string to = flat_.input_name(demand.to, demand.to_port);
    const std::string place = flat_.demand_pointer(demand);
    const ReactionGraph::Arrival& arrival = graph_.at(input);
    if (arrival.first == ReactionGraph::kNever) {
      report_.error(Code::kReactionBound, place,
                    fmt::format("nothing leads from '{}' to '{}', so it never arrives", from, to),
                    fmt::format("Link the two, or drop the demand of at most {}", cycles(wanted.maximum_cycles)));
      return;
    }
    if (arrival.data_dependent) {
      work_ += graph_.size();
      report_.error(Code::kReactionBound, place,
                    fmt::format("no bound from '{}' to '{}': the time depends on data: {}", from, to,
                                graph_.words_of(graph_.data_dependent_way(std::span(&output, 1), input))),
                    fmt::format("Add a path with a fixed latency beside it: at most {} are demanded",
                                cycles(wanted.maximum_cycles)));
      return;
    }
    if (arrival.last > wanted.maximum_cycles) {
      report_.error(
          Code::kReactionBound, place + "/maximum_cycles",
          fmt::format("'{}' can take {} to '{}': {}", from, cycles(arrival.last), to,
                      arrival.exact ? graph_.words_of(graph_.longest_way(input))
                                    : "an upper bound, since the loop on the path is too tangled"),
          fmt::format("Take a delay out of this path: at most {} are demanded", cycles(wanted.maximum_cycles)));
    }
    const std::int64_t minimum = wanted.minimum_cycles.value_or(0);
    if (arrival.first < minimum) {
      report_.error(Code::kReactionBound, place + "/minimum_cycles",
                    fmt::format("'{}' can take only {} to '{}': {}", from, cycles(arrival.first), to,
                                graph_.words_of(graph_.shortest_way(input))),
                    fmt::format("Put a delay into this path: at least {} are demanded", cycles(minimum)));
    }
    net_report_.demands.push_back({from, to, wanted.maximum_cycles, minimum, arrival.first, arrival.last,
                                   graph_.links_of(graph_.longest_way(input))});
    work_ += 4 * net_report_.demands.back().links.size();
  }

  const FlatNet& flat_;
  NetReport& net_report_;
  LoadReport& report_;
  ReactionGraph graph_;
  std::size_t work_ = 0;
};

}  // namespace

void certify_reactions(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  const std::vector<int> from = sources(flat);
  if (from.empty()) return;
  ReactionGraph graph(flat);
  if (from.size() * graph.size() > kMostWork) {
    report.note({}, fmt::format("no reaction certificate: {} sources are too many", from.size()));
    return;
  }
  const auto to = sinks(flat);
  std::size_t path_links = 0;
  for (const int source : from) {
    graph.follow(outputs_of(flat, source));
    for (const auto& [node, port] : to) {
      const int input = flat.input_base[static_cast<std::size_t>(node)] + port;
      const ReactionGraph::Arrival& arrival = graph.at(input);
      if (arrival.first == ReactionGraph::kNever) continue;
      net_report.reactions.push_back({flat.id(source),
                                      flat.input_name(node, port),
                                      arrival.first,
                                      arrival.last,
                                      arrival.data_dependent,
                                      arrival.exact,
                                      {}});
      if (!arrival.exact || path_links > kMostPathLinks) continue;
      net_report.reactions.back().links = graph.links_of(graph.longest_way(input));
      path_links += net_report.reactions.back().links.size();
    }
  }
}

void check_demands(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  if (!flat.demands.empty()) DemandCheck(flat, net_report, report).run();
}

}  // namespace takt::net
