#include "core/command/event_latches.h"

#include <nlohmann/json.hpp>

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

expression::Signal EventLatches::add(const std::string& preferred_id, LatchKind kind, const expression::Subject* target,
                                     bool null_sets) {
  const std::string id = writer_.unique(preferred_id);
  writer_.add(id, "SetResetLatch", {{"reset", false}}, null_sets ? Json::object() : Json{{"set", false}});
  latches_.push_back({id + ".set", kind, target});
  return expression::Signal::at(id + ".value");
}

expression::Signal EventLatches::raised(const expression::SubjectPtr& state) {
  auto [entry, is_new] = raised_.try_emplace(state.get());
  if (is_new) entry->second = add(state->name, LatchKind::kRaise, state.get(), false);
  return entry->second;
}

void EventLatches::add_event(LatchKind kind, const expression::Subject* target, const expression::Signal& event) {
  events_.push_back({kind, target, event});
}

void EventLatches::link_events() {
  std::map<std::pair<LatchKind, const expression::Subject*>, std::vector<const Event*>> events;
  for (const Event& event : events_) events[{event.kind, event.target}].push_back(&event);
  std::vector<expression::NetWriter::Feed> feeds;
  using enum LatchKind;
  for (const LatchKind kind : {kStart, kCleanUp, kRaise, kStop, kCancel}) {
    for (const Latch& latch : latches_) {
      if (latch.kind == kind) add_feeds(latch, events[{latch.kind, latch.target}], feeds);
    }
  }
  writer_.feed_without_cycles(feeds);
}

/// A chain of gates before the latch. The last one first: what it feeds is known then.
void EventLatches::add_feeds(const Latch& latch, const std::vector<const Event*>& events,
                             std::vector<expression::NetWriter::Feed>& feeds) {
  std::string to = latch.set;
  for (std::size_t i = events.size(); i-- > 1;) {
    const std::string gate = writer_.unique(expression::NetWriter::node_of(latch.set) + "_by");
    writer_.add(gate, "Or");
    writer_.link(gate + ".value", to);
    feeds.push_back({events[i]->signal, gate + ".b"});
    to = gate + ".a";
  }
  feeds.push_back({events.empty() ? expression::Signal::always(false) : events.front()->signal, to});
}

}  // namespace takt::command
