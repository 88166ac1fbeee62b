#include "core/net/stop_bound.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

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

}  // namespace takt::net
