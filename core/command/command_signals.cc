#include "core/command/command_signals.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/command_fragments.h"
#include "core/command/handler_signals.h"

namespace takt::command {
namespace {

using Kind = Effect::Kind;

}  // namespace

CommandSignals::CommandSignals(MappingContext& context, CommandFragments& fragments, HandlerSignals& handlers)
    : context_(context),
      writer_(context.writer),
      fragments_(fragments),
      handlers_(handlers),
      awaited_(context.tree, context.writer,
               {.started = [this](int i) { return started(i); },
                .running = [this](int i) { return running(i); },
                .called_off = [this](const CommandTree::Handler& h) { return handlers_.called_off(h); },
                .held = [this](const CommandTree::Handler& h) { return handlers_.held(h); }}),
      ranks_(context.tree.ranks()),
      ports_(static_cast<std::size_t>(context.tree.size())) {}

// -- Start and end ----------------------------------------------------------------------------------------------------

Signal CommandSignals::started(int i) {
  if (at(i).started) return *at(i).started;
  Signal signal = Signal::always(parent(i) < 0);
  if (parent(i) >= 0 && context_.tree.at(i).with_parent) signal = started(parent(i));
  if (context_.has_event(Kind::kStart, i)) {
    const Signal latch = context_.latches.add(context_.id(i, "started"), Kind::kStart, node(i).subject.get(), false);
    signal = writer_.either(context_.id(i, "begun"), signal, latch);
  }
  return *(at(i).started = signal);
}

Signal CommandSignals::running(int i) {
  if (parent(i) < 0) return Signal::always(true);
  return writer_.both(context_.id(i, "running"), started(i), writer_.opposite(ended(i).one_cycle_ago()));
}

Signal CommandSignals::wants(int i) {
  return writer_.both(context_.id(i, "wants"), running(i), writer_.opposite(stop(i)));
}

Signal CommandSignals::active(int i) {
  if (at(i).active) return *at(i).active;
  std::vector<Signal> others;
  for (const int other : rivals_before(i)) others.push_back(active(other));
  Signal signal = wants(i);
  for (const Signal& other : others) signal = writer_.both(context_.id(i, "turn"), signal, writer_.opposite(other));
  return *(at(i).active = signal);
}

std::vector<int> CommandSignals::rivals_before(int i) const {
  std::vector<int> rivals;
  if (!node(i).is_runtime()) return rivals;
  const auto devices = node(i).actuator->model().devices();
  for (int other = 0; other < context_.tree.size(); ++other) {
    if (!node(other).is_runtime() || rank(other) >= rank(i)) continue;
    const auto others = node(other).actuator->model().devices();
    if (std::ranges::find_first_of(devices, others) != devices.end()) rivals.push_back(other);
  }
  return rivals;
}

Signal CommandSignals::ended(int i) {
  if (at(i).ended) return *at(i).ended;
  const std::string latch = writer_.unique(context_.id(i, "ended"));
  at(i).ended = Signal::at(latch + ".value");
  writer_.add(latch, "SetResetLatch", {{"reset", false}});
  writer_.feed(writer_.either(context_.id(i, "ends"), done(i), stop(i)), latch + ".set");
  return *at(i).ended;
}

Signal CommandSignals::done(int i) {
  if (at(i).done) return *at(i).done;
  Signal signal = node(i).is_runtime() ? fragments_.done(i) : node(i).is_wait() ? wait_done(i) : transaction_done(i);
  return *(at(i).done = writer_.only_while(context_.id(i, "done"), active(i), signal));
}

Signal CommandSignals::wait_done(int i) {
  std::vector<Signal> ends{cancel(i)};
  if (node(i).until) ends.push_back(writer_.signal_of(node(i).until->node()));
  if (node(i).seconds) {
    const std::string timer = writer_.unique(context_.id(i, "timer"));
    writer_.add(timer, "OnDelay", {{"delay", *node(i).seconds}});
    writer_.feed(active(i), timer + ".input");
    ends.push_back(Signal::at(timer + ".value"));
  }
  return writer_.any(context_.id(i, "over"), ends);
}

/// Nothing inside runs any more, no start is due, and nothing can be started any more (row L9). The pending ones are
/// linked when the handlers are written.
Signal CommandSignals::transaction_done(int i) {
  const CommandTree& tree = context_.tree;
  std::vector<Signal> busy;
  for (const int child : tree.at(i).children) {
    const Signal over = AwaitedStarts::end_is_heard(tree, child) ? ended(child).one_cycle_ago() : ended(child);
    busy.push_back(writer_.both(context_.id(child, "busy"), started(child), writer_.opposite(over)));
    busy.push_back(awaited_.awaited(child));
    context_.trace(tree.at(child).path + " awaited", busy.back());
  }
  for (const auto& handler : tree.handlers())
    if (is_delayed_start_in(i, *handler.handler)) busy.push_back(handlers_.pending(handler));
  return writer_.opposite(writer_.any(context_.id(i, "busy"), busy));
}

bool CommandSignals::is_delayed_start_in(int transaction, const EventHandler& handler) const {
  if (handler.effect.kind != Kind::kStart || handler.trigger.delay <= 0.0) return false;
  const int target = context_.tree.find(handler.effect.target);
  return target >= 0 && parent(target) == transaction;
}

// -- Stop and cancel --------------------------------------------------------------------------------------------------

Signal CommandSignals::stop(int i) {
  if (at(i).stop) return *at(i).stop;
  const Signal above = parent(i) < 0 ? Signal::always(false) : stop(parent(i));
  if (!context_.has_event(Kind::kStop, i)) return *(at(i).stop = memory(i, "stop", above));
  const Signal latch = context_.latches.add(context_.id(i, "stop"), Kind::kStop, node(i).subject.get(), true);
  at(i).stop = latch;
  if (!above.is(false)) at(i).stop = writer_.either(context_.id(i, "stopped"), latch, memory(i, "stop_around", above));
  return *at(i).stop;
}

/// Remembers a request that concerns a command only while it runs.
Signal CommandSignals::memory(int i, const char* what, const Signal& request) {
  if (request.constant) return request;
  return writer_.latch(context_.id(i, what), writer_.both(context_.id(i, what) + "_now", request, running(i)), true);
}

Signal CommandSignals::cancel(int i) {
  if (at(i).cancel) return *at(i).cancel;
  Signal signal = parent(i) < 0 ? Signal::at("cancel.requested") : forwarded(i);
  if (context_.has_event(Kind::kCancel, i)) {
    const Signal latch = context_.latches.add(context_.id(i, "cancel"), Kind::kCancel, node(i).subject.get(), true);
    signal = writer_.either(context_.id(i, "cancel_all"), signal, latch);
  }
  return *(at(i).cancel = signal);
}

/// The cancel of the transaction around it, as far as its policy forwards it.
Signal CommandSignals::forwarded(int i) {
  const CancelPolicy& policy = node(parent(i)).cancel_policy;
  const bool is_forwarded = policy.kind == CancelPolicy::Kind::kForward ||
                            (policy.kind == CancelPolicy::Kind::kForwardTo &&
                             std::ranges::find(policy.targets, node(i).subject) != policy.targets.end());
  return is_forwarded ? cancel(parent(i)) : Signal::always(false);
}

Signal CommandSignals::cancelled(int i) {
  if (!at(i).cancelled) at(i).cancelled = parent(i) < 0 ? cancel(i) : memory(i, "cancelled", cancel(i));
  return *at(i).cancelled;
}

// -- How it ended -----------------------------------------------------------------------------------------------------

Signal CommandSignals::ended_in_order(int i) {
  return writer_.both(context_.id(i, "in_order"), ended(i), writer_.opposite(stop(i)));
}

Signal CommandSignals::completed(int i) {
  const Signal in_order = writer_.both(context_.id(i, "completed"), ended(i), writer_.opposite(stop(i)));
  if (!context_.tree.can_fail(i)) return in_order;
  if (has_timeout(i) && !node(i).fails_if) return writer_.both(context_.id(i, "in_time"), in_order, met(i));
  return writer_.both(context_.id(i, "succeeded"), in_order, writer_.opposite(failed(i)));
}

/// Of a transaction: something in it has.
Signal CommandSignals::failed(int i) {
  if (at(i).failed) return *at(i).failed;
  std::vector<Signal> any;
  if (has_timeout(i)) any.push_back(timed_out(i));
  if (node(i).fails_if) any.push_back(failed_itself(i));
  for (const int child : context_.tree.at(i).children)
    if (context_.tree.can_fail(child)) any.push_back(failed(child));
  const Signal one = writer_.any(context_.id(i, "any_failed"), any);
  return *(at(i).failed = writer_.both(context_.id(i, "failed"), ended_in_order(i), one));
}

/// What its last cycle shows is kept.
Signal CommandSignals::failed_itself(int i) {
  const Signal at_end = writer_.both(context_.id(i, "fails"), done(i), writer_.signal_of(node(i).fails_if->node()));
  return writer_.latch(context_.id(i, "failure"), at_end, true);
}

/// Of a wait with a timeout: its state has held while it ran, or it was cancelled.
Signal CommandSignals::met(int i) {
  if (at(i).met) return *at(i).met;
  const Signal now = writer_.both(context_.id(i, "holds"), writer_.signal_of(node(i).until->node()), active(i));
  const Signal held = writer_.latch(context_.id(i, "held"), now, false);
  return *(at(i).met = writer_.either(context_.id(i, "met"), held, cancelled(i)));
}

Signal CommandSignals::timed_out(int i) {
  return writer_.both(context_.id(i, "timed_out"), ended_in_order(i), writer_.opposite(met(i)));
}

Signal CommandSignals::state(int i, const std::string& name) {
  if (name == "started") return started(i);
  if (name == "active") return active(i);
  if (name == "stopped") return stop(i);
  if (name == "cancelled") return cancelled(i);
  if (name == "failed") return failed(i);
  if (name == "timed_out") return timed_out(i);
  return completed(i);
}

}  // namespace takt::command
