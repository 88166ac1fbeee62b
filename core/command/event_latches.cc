#include "core/command/event_latches.h"

#include <nlohmann/json.hpp>

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Effect::Kind;

}  // namespace

Signal EventLatches::add(const std::string& preferred_id, Kind kind, const Subject* target, bool null_sets) {
  const std::string id = writer_.unique(preferred_id);
  writer_.add(id, "SetResetLatch", {{"reset", false}}, null_sets ? Json::object() : Json{{"set", false}});
  latches_.push_back({id + ".set", kind, target});
  return Signal::at(id + ".value");
}

Signal EventLatches::raised(const SubjectPtr& state) {
  auto [entry, is_new] = raised_.try_emplace(state.get());
  if (is_new) entry->second = add(state->name, Kind::kRaise, state.get(), false);
  return entry->second;
}

void EventLatches::add_event(Kind kind, const Subject* target, const Signal& event) {
  events_.push_back({kind, target, event});
}

void EventLatches::link_events() {
  for (const Kind kind : {Kind::kStart, Kind::kRaise, Kind::kStop, Kind::kCancel}) {
    for (const Latch& latch : latches_) {
      if (latch.kind == kind) link_events_of(latch);
    }
  }
}

void EventLatches::link_events_of(const Latch& latch) {
  std::vector<Signal> signals;
  for (const Event& event : events_) {
    if (event.kind == latch.kind && event.target == latch.target) signals.push_back(event.signal);
  }
  // The last gate of the chain first: what it feeds is known then.
  std::string to = latch.set;
  for (std::size_t i = signals.size(); i-- > 1;) {
    const std::string gate = writer_.unique(NetWriter::node_of(latch.set) + "_by");
    writer_.add(gate, "Or");
    writer_.link(gate + ".value", to);
    writer_.feed_without_cycle(signals[i], gate + ".b");
    to = gate + ".a";
  }
  writer_.feed_without_cycle(signals.empty() ? Signal::always(false) : signals.front(), to);
}

}  // namespace takt::command
