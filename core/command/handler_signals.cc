#include "core/command/handler_signals.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/command_signals.h"

namespace takt::command {

Signal HandlerSignals::occurrence(const CommandTree::Handler& h) {
  const EventHandler& handler = *h.handler;
  const Signal armed = this->armed(h);
  const Signal state = context_.writer.signal_of(handler.state.node());
  context_.trace(h.path, state);
  if (handler.entered) return context_.writer.both(context_.id(h.owner, "event"), state, armed);
  const Signal gone = context_.writer.both(context_.id(h.owner, "gone"), held(h), context_.writer.opposite(state));
  return context_.writer.both(context_.id(h.owner, "event"), gone, armed);
}

Signal HandlerSignals::held(const CommandTree::Handler& h) {
  const Signal state = context_.writer.signal_of(h.handler->state.node());
  const Signal holds = context_.writer.both(context_.id(h.owner, "event"), state, armed(h));
  return context_.writer.latch(context_.id(h.owner, "held"), holds, acts_on_null(h.handler->effect.kind));
}

/// A formula that speaks of the life of its owner counts after the owner has ended too.
Signal HandlerSignals::armed(const CommandTree::Handler& h) {
  return speaks_of(*h.handler, h.owner) ? commands_.started(h.owner) : commands_.active(h.owner);
}

bool HandlerSignals::speaks_of(const EventHandler& handler, int i) const {
  const auto subjects = subjects_of(handler.state.node());
  return std::ranges::find(subjects, context_.node(i).subject) != subjects.end();
}

Signal HandlerSignals::delayed(const CommandTree::Handler& h) {
  const auto found = delayed_.find(h.handler);
  if (found != delayed_.end()) return found->second;
  Signal signal = occurrence(h);
  if (h.handler->trigger.delay > 0.0) {
    const Signal begun =
        context_.writer.latch(context_.id(h.owner, "due"), signal, acts_on_null(h.handler->effect.kind));
    const std::string timer = context_.writer.unique(context_.id(h.owner, "delay"));
    context_.writer.add(timer, "OnDelay", {{"delay", h.handler->trigger.delay}});
    context_.writer.feed(begun, timer + ".input");
    begun_[h.handler] = begun;
    signal = Signal::at(timer + ".value");
  }
  return delayed_[h.handler] = signal;
}

Signal HandlerSignals::pending(const CommandTree::Handler& h) {
  const Signal fired = delayed(h);
  const Signal waits =
      context_.writer.both(context_.id(h.owner, "waits"), begun_[h.handler], context_.writer.opposite(fired));
  return context_.writer.both(context_.id(h.owner, "pending"), waits, context_.writer.opposite(called_off(h)));
}

Signal HandlerSignals::called_off(const CommandTree::Handler& h) {
  const int around = context_.tree.at(context_.tree.find(h.handler->effect.target)).parent;
  if (around < 0 || context_.node(around).cancel_policy.kind != CancelPolicy::Kind::kForward)
    return Signal::always(false);
  const Signal goes_on = clears(h);
  if (goes_on.is(true)) return Signal::always(false);
  return context_.writer.both(context_.id(h.owner, "called_off"), commands_.cancel(around),
                              context_.writer.opposite(goes_on));
}

Signal HandlerSignals::clears(const CommandTree::Handler& h) {
  if (context_.scope.waits_for_cancel(h)) return Signal::always(true);
  std::vector<Signal> cleaners;
  for (const int i : context_.scope.cleaners_of(h)) cleaners.push_back(commands_.cleans_up(i));
  return context_.writer.any(context_.id(h.owner, "clears"), cleaners);
}

}  // namespace takt::command
