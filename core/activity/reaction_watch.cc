#include "core/activity/reaction_watch.h"

#include <algorithm>
#include <utility>

namespace takt::activity {

void ReactionWatch::attach(const std::string& activity, const net::CompiledNet& net,
                           const std::vector<command::BrakePorts>& brakes) {
  for (const command::BrakePorts& brake : brakes) {
    const Watched watched{.event = net.find<net::Boolean>(brake.event),
                          .rate = net.find<net::Real>(brake.clock.rate),
                          .derivative = net.find<net::Real>(brake.clock.rate_derivative)};
    Reaction reaction{.activity = activity, .event = brake.name, .least = -1, .most = -1};
    for (const auto& line : net.report().reactions) {
      const bool from = std::ranges::find(brake.sources, line.source) != brake.sources.end();
      if (!from || !line.sink.starts_with(brake.fragment + "/") || !line.sink.ends_with(".q")) continue;
      reaction.least = reaction.least < 0 ? line.minimum_cycles : std::min(reaction.least, line.minimum_cycles);
      reaction.most = std::max(reaction.most, line.maximum_cycles);
    }
    if (!watched.event || !watched.rate || !watched.derivative || reaction.least < 0) continue;
    watched_.push_back(watched);
    reactions_.push_back(std::move(reaction));
  }
}

void ReactionWatch::look(std::int64_t cycle) {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (!watched_[i].rate->null) look(cycle, watched_[i], reactions_[i]);  // null: its motion does not run
  }
}

void ReactionWatch::look(std::int64_t cycle, Watched& watched, Reaction& reaction) {
  const bool event = watched.event->null || watched.event->value;
  if (reaction.event_cycle < 0 && event) {
    reaction.event_cycle = cycle;
    watched.compared = watched.steady_before;
  }
  if (watched.compared && reaction.braking_cycle < 0 && watched.rate->value < watched.rate_before)
    reaction.braking_cycle = cycle;
  watched.rate_before = watched.rate->value;
  watched.steady_before = watched.rate->value > 0.0 && !watched.derivative->null && watched.derivative->value == 0.0;
}

}  // namespace takt::activity
