#include "core/command/handler_signals.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/command_signals.h"

namespace takt::command {

expression::Signal HandlerSignals::occurrence(const CommandTree::Handler& h) {
  const EventHandler& handler = *h.handler;
  const expression::Signal armed = this->armed(h);
  const expression::Signal state = context_.writer.signal_of(handler.state.node());
  context_.trace(h.path, state);
  if (handler.entered) return context_.writer.both(context_.id(h.owner, "event"), state, armed);
  const expression::Signal gone =
      context_.writer.both(context_.id(h.owner, "gone"), held(h), context_.writer.opposite(state));
  return context_.writer.both(context_.id(h.owner, "event"), gone, armed);
}

expression::Signal HandlerSignals::held(const CommandTree::Handler& h) {
  const expression::Signal state = context_.writer.signal_of(h.handler->state.node());
  const expression::Signal holds = context_.writer.both(context_.id(h.owner, "event"), state, armed(h));
  return context_.writer.latch(context_.id(h.owner, "held"), holds, acts_on_null(h.handler->effect.kind));
}

/// A formula that speaks of the life of its owner counts after the owner has ended too.
expression::Signal HandlerSignals::armed(const CommandTree::Handler& h) {
  return speaks_of(*h.handler, h.owner) ? commands_.started(h.owner) : commands_.active(h.owner);
}

bool HandlerSignals::speaks_of(const EventHandler& handler, int i) const {
  const auto subjects = expression::subjects_of(handler.state.node());
  return std::ranges::find(subjects, context_.node(i).subject) != subjects.end();
}

expression::Signal HandlerSignals::delayed(const CommandTree::Handler& h) {
  const auto found = delayed_.find(h.handler);
  if (found != delayed_.end()) return found->second;
  expression::Signal signal = occurrence(h);
  if (h.handler->trigger.delay > 0.0) {
    const expression::Signal begun =
        context_.writer.latch(context_.id(h.owner, "due"), signal, acts_on_null(h.handler->effect.kind));
    const std::string timer = context_.writer.unique(context_.id(h.owner, "delay"));
    context_.writer.add(timer, "OnDelay", {{"delay", h.handler->trigger.delay}});
    context_.writer.feed(begun, timer + ".input");
    begun_[h.handler] = begun;
    signal = expression::Signal::at(timer + ".value");
  }
  return delayed_[h.handler] = signal;
}

expression::Signal HandlerSignals::pending(const CommandTree::Handler& h) {
  const expression::Signal fired = delayed(h);
  const expression::Signal waits =
      context_.writer.both(context_.id(h.owner, "waits"), begun_[h.handler], context_.writer.opposite(fired));
  return context_.writer.both(context_.id(h.owner, "pending"), waits, context_.writer.opposite(called_off(h)));
}

expression::Signal HandlerSignals::called_off(const CommandTree::Handler& h) {
  const int around = context_.tree.at(context_.tree.find(h.handler->effect.target)).parent;
  if (around < 0 || context_.node(around).cancel_policy.kind != CancelPolicy::Kind::kForward)
    return expression::Signal::always(false);
  const expression::Signal goes_on = clears(h);
  if (goes_on.is(true)) return expression::Signal::always(false);
  return context_.writer.both(context_.id(h.owner, "called_off"), commands_.cancel(around),
                              context_.writer.opposite(goes_on));
}

expression::Signal HandlerSignals::clears(const CommandTree::Handler& h) {
  if (context_.scope.waits_for_cancel(h)) return expression::Signal::always(true);
  std::vector<expression::Signal> cleaners;
  for (const int i : context_.scope.cleaners_of(h)) cleaners.push_back(commands_.cleans_up(i));
  return context_.writer.any(context_.id(h.owner, "clears"), cleaners);
}

}  // namespace takt::command
