#include "core/net/stop_bound.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "core/net/digraph.h"
#include "core/net/flat_net.h"

namespace takt::net {
namespace {

/// The longest bound that a Cancel of the net declares; 0: none does.
double declared_seconds(const FlatNet& flat) {
  double longest = 0.0;
  for (const FlatPrimitive& primitive : flat.primitives) {
    if (primitive.info->cancel_bound.empty()) continue;
    const auto given = primitive.description->parameters.find(primitive.info->cancel_bound);
    if (given == primitive.description->parameters.end() || !given->is_number()) continue;
    longest = std::max(longest, given->get<double>());
  }
  return longest;
}

/// Fewest of the cycles that the ways from a Cancel to a Termination take at most.
std::optional<std::int64_t> cycles_to_end(const FlatNet& flat, const NetReport& report) {
  std::set<std::string> cancels, ends;
  for (int p = 0; p < flat.primitive_count(); ++p) {
    const PrimitiveInfo& info = *flat.primitives[static_cast<std::size_t>(p)].info;
    if (!info.cancel_bound.empty()) cancels.insert(flat.id(p));
    if (!info.termination) continue;
    for (int port = 0; port < flat.input_count(p); ++port) ends.insert(flat.input_name(p, port));
  }
  std::optional<std::int64_t> fewest;
  for (const NetReport::Reaction& reaction : report.reactions) {
    if (reaction.data_dependent || !cancels.contains(reaction.source) || !ends.contains(reaction.sink)) continue;
    fewest = std::min(fewest.value_or(reaction.maximum_cycles), reaction.maximum_cycles);
  }
  return fewest;
}

}  // namespace

std::int64_t StopBound::in_cycles(Nanoseconds period) const {
  return static_cast<std::int64_t>(std::ceil(seconds / to_seconds(period))) + cycles + (declared ? 0 : 2);
}

std::optional<StopBound> find_stop_bound(const FlatNet& flat, const std::vector<Primitive*>& primitives,
                                         const NetReport& report) {
  const double declared = declared_seconds(flat);
  if (declared > 0.0) return StopBound{.seconds = declared, .cycles = 0, .declared = true};
  const auto cycles = cycles_to_end(flat, report);
  if (!cycles) return std::nullopt;
  StopBound bound{.seconds = 0.0, .cycles = *cycles};
  // One may wait for the other, so the times add up.
  for (const Primitive* primitive : primitives) bound.seconds += primitive->stop_time_bound();
  return bound;
}

PathStop find_path_stop(const FlatNet& flat, std::span<Primitive* const> primitives,
                        std::span<const std::pair<Resource*, int>> drivers) {
  std::vector<std::pair<int, int>> from_to;
  from_to.reserve(flat.links.size());
  for (const FlatLink& link : flat.links) from_to.emplace_back(link.from, link.to);
  const Digraph links(flat.node_count(), from_to);
  PathStop stop;
  std::vector<bool> fed(static_cast<std::size_t>(flat.node_count()), false);
  std::vector<int> open;
  const auto reach = [&](int node) {
    if (fed[static_cast<std::size_t>(node)]) return;
    fed[static_cast<std::size_t>(node)] = true;
    open.push_back(node);
  };
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const double seconds = primitives[i] == nullptr ? 0.0 : primitives[i]->stop_time_bound();
    stop.seconds += seconds;
    if (seconds > 0.0) reach(static_cast<int>(i));
  }
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    for (const Digraph::Edge& edge : links.from(node)) reach(edge.to);
  }
  std::set<const Resource*> others;
  for (const auto& [device, driver] : drivers)
    if (!fed[static_cast<std::size_t>(driver)]) others.insert(device);
  for (const auto& [device, driver] : drivers)
    if (!others.contains(device)) stop.devices.push_back(device);
  return stop;
}

}  // namespace takt::net
