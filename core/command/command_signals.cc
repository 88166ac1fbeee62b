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
      heard_ends_(AwaitedStarts::heard_ends(context.tree)),
      ports_(static_cast<std::size_t>(context.tree.size())) {
  std::vector<int> order(ranks_.size());
  for (std::size_t i = 0; i < ranks_.size(); ++i) order[static_cast<std::size_t>(ranks_[i])] = static_cast<int>(i);
  for (const int i : order) {
    if (!node(i).is_runtime()) continue;
    for (const std::string& device : node(i).actuator->model().devices()) turns_[device].commands.push_back(i);
  }
}

// -- Start and end ----------------------------------------------------------------------------------------------------

expression::Signal CommandSignals::started(int i) {
  if (at(i).started) return *at(i).started;
  const expression::Signal signal = writer_.either(context_.id(i, "started_at_all"), begun(i), cleans_up(i));
  return *(at(i).started = signal);
}

expression::Signal CommandSignals::begun(int i) {
  if (at(i).begun) return *at(i).begun;
  expression::Signal signal = expression::Signal::always(parent(i) < 0);
  if (parent(i) >= 0 && context_.tree.at(i).with_parent) signal = started(parent(i));
  if (context_.has_event(Kind::kStart, i)) {
    const expression::Signal latch =
        context_.latches.add(context_.id(i, "started"), LatchKind::kStart, node(i).subject.get(), false);
    signal = writer_.either(context_.id(i, "begun"), signal, latch);
  }
  return *(at(i).begun = signal);
}

expression::Signal CommandSignals::cleans_up(int i) {
  if (at(i).cleans_up) return *at(i).cleans_up;
  if (!context_.scope.may_clean_up(i)) return *(at(i).cleans_up = expression::Signal::always(false));
  return *(at(i).cleans_up =
               context_.latches.add(context_.id(i, "cleans_up"), LatchKind::kCleanUp, node(i).subject.get(), false));
}

expression::Signal CommandSignals::running(int i) {
  if (parent(i) < 0 && !heard_ends_.contains(i)) return expression::Signal::always(true);
  return writer_.both(context_.id(i, "running"), started(i), writer_.opposite(ended(i).one_cycle_ago()));
}

expression::Signal CommandSignals::wants(int i) {
  if (moves(i)) return running(i);
  return writer_.both(context_.id(i, "wants"), running(i), writer_.opposite(stop(i)));
}

expression::Signal CommandSignals::active(int i) {
  if (at(i).active) return *at(i).active;
  std::vector<expression::Signal> taken;
  if (node(i).is_runtime()) {
    for (const std::string& device : node(i).actuator->model().devices()) {
      const expression::Signal one = taken_before(i, turns_.at(device));
      const auto same = [&](const expression::Signal& other) {
        return other.constant == one.constant && other.port == one.port;
      };
      if (std::ranges::none_of(taken, same)) taken.push_back(one);
    }
  }
  expression::Signal signal = wants(i);
  for (const expression::Signal& one : taken)
    signal = writer_.both(context_.id(i, "turn"), signal, writer_.opposite(one));
  return *(at(i).active = signal);
}

/// A command before this one has the device. One gate for each command, so that a long chain stays small.
expression::Signal CommandSignals::taken_before(int i, Turns& turns) {
  const auto place = static_cast<std::size_t>(std::ranges::find(turns.commands, i, {}) - turns.commands.begin());
  while (turns.taken.size() <= place) {
    const std::size_t next = turns.taken.size() - 1;
    const int before = turns.commands[next];
    const expression::Signal taken = writer_.either(context_.id(before, "taken"), turns.taken[next], active(before));
    if (turns.taken.size() == next + 1) turns.taken.push_back(taken);
  }
  return turns.taken[place];
}

std::vector<int> CommandSignals::rivals_before(int i) const {
  std::set<int> rivals;
  if (!node(i).is_runtime()) return {};
  for (const std::string& device : node(i).actuator->model().devices()) {
    for (const int other : turns_.at(device).commands) {
      if (rank(other) >= rank(i)) break;
      rivals.insert(other);
    }
  }
  return {rivals.begin(), rivals.end()};
}

expression::Signal CommandSignals::ends(int i, const char* what) {
  if (!brakes_when_stopped(i)) return writer_.either(context_.id(i, what), done(i), stop(i));
  if (moves(i)) return done(i);
  std::vector<expression::Signal> inside;
  for (const int child : context_.tree.at(i).children) inside.push_back(busy(child));
  const expression::Signal rests = writer_.opposite(writer_.any(context_.id(i, "runs_inside"), inside));
  return writer_.either(context_.id(i, what), done(i), writer_.both(context_.id(i, "stops_at_rest"), stop(i), rests));
}

expression::Signal CommandSignals::over() {
  return heard_ends_.contains(0) ? ended(0).one_cycle_ago() : ends(0, "over");
}

expression::Signal CommandSignals::ended(int i) {
  if (at(i).ended) return *at(i).ended;
  const std::string latch = writer_.unique(context_.id(i, "ended"));
  at(i).ended = expression::Signal::at(latch + ".value");
  writer_.add(latch, "SetResetLatch", {{"reset", false}});
  writer_.feed(ends(i), latch + ".set");
  return *at(i).ended;
}

expression::Signal CommandSignals::done(int i) {
  if (at(i).done) return *at(i).done;
  expression::Signal signal = node(i).is_runtime() ? fragments_.done(i)
                              : node(i).is_wait()  ? wait_done(i)
                                                   : transaction_done(i);
  return *(at(i).done = writer_.only_while(context_.id(i, "done"), active(i), signal));
}

expression::Signal CommandSignals::wait_done(int i) {
  std::vector<expression::Signal> ends{cancel(i)};
  if (node(i).until) ends.push_back(writer_.signal_of(node(i).until->node()));
  if (node(i).seconds) {
    const std::string timer = writer_.unique(context_.id(i, "timer"));
    writer_.add(timer, "OnDelay", {{"delay", *node(i).seconds}});
    writer_.feed(active(i), timer + ".input");
    ends.push_back(expression::Signal::at(timer + ".value"));
  }
  return writer_.any(context_.id(i, "over"), ends);
}

/// Nothing inside runs any more, no start is due, and nothing can be started any more (row L9). The pending ones are
/// linked when the handlers are written.
expression::Signal CommandSignals::transaction_done(int i) {
  const CommandTree& tree = context_.tree;
  std::vector<expression::Signal> busy;
  for (const int child : tree.at(i).children) {
    busy.push_back(this->busy(child));
    busy.push_back(awaited_.awaited(child));
    context_.trace(tree.at(child).path + " awaited", busy.back());
  }
  for (const auto& handler : tree.handlers())
    if (is_delayed_start_in(i, *handler.handler)) busy.push_back(handlers_.pending(handler));
  return writer_.opposite(writer_.any(context_.id(i, "busy"), busy));
}

/// It has started, and what there is to hear of its end has been heard.
expression::Signal CommandSignals::busy(int i) {
  const expression::Signal over = heard_ends_.contains(i) ? ended(i).one_cycle_ago() : ended(i);
  return writer_.both(context_.id(i, "busy"), started(i), writer_.opposite(over));
}

bool CommandSignals::is_delayed_start_in(int transaction, const EventHandler& handler) const {
  if (handler.effect.kind != Kind::kStart || handler.trigger.delay <= 0.0) return false;
  const int target = context_.tree.find(handler.effect.target);
  return target >= 0 && parent(target) == transaction;
}

// -- Stop and cancel --------------------------------------------------------------------------------------------------

/// Arms come to rest on their paths before a stop ends what moves them; everything else is released at once.
bool CommandSignals::moves(int i) const { return node(i).is_runtime() && !node(i).actuator->model().arms().empty(); }

/// A stop may reach it, and something in it has to come to rest then.
bool CommandSignals::brakes_when_stopped(int i) const {
  bool may_stop = false;
  for (int around = i; around >= 0; around = parent(around))
    may_stop = may_stop || context_.has_event(Kind::kStop, around);
  for (int inner = i; may_stop && inner < context_.tree.at(i).end; ++inner)
    if (moves(inner)) return true;
  return false;
}

expression::Signal CommandSignals::brake(int i) {
  return moves(i) ? writer_.either(context_.id(i, "brake"), cancel(i), stop(i)) : cancel(i);
}

expression::Signal CommandSignals::stopped(int i) {
  return brakes_when_stopped(i) ? writer_.both(context_.id(i, "stopped_at_rest"), stop(i), ended(i)) : stop(i);
}

expression::Signal CommandSignals::stop(int i) {
  if (at(i).stop) return *at(i).stop;
  const expression::Signal above = parent(i) < 0 ? expression::Signal::always(false) : stop(parent(i));
  if (!context_.has_event(Kind::kStop, i)) return *(at(i).stop = memory(i, "stop", above));
  const expression::Signal latch =
      context_.latches.add(context_.id(i, "stop"), LatchKind::kStop, node(i).subject.get(), true);
  at(i).stop = latch;
  if (!above.is(false)) at(i).stop = writer_.either(context_.id(i, "stopped"), latch, memory(i, "stop_around", above));
  return *at(i).stop;
}

/// Remembers a request that concerns a command only while it runs.
expression::Signal CommandSignals::memory(int i, const char* what, const expression::Signal& request) {
  if (request.constant) return request;
  return writer_.latch(context_.id(i, what), writer_.both(context_.id(i, what) + "_now", request, running(i)), true);
}

expression::Signal CommandSignals::cancel(int i) {
  if (at(i).cancel) return *at(i).cancel;
  expression::Signal signal = parent(i) < 0 ? expression::Signal::at("cancel.requested") : forwarded(i);
  if (context_.has_event(Kind::kCancel, i)) {
    const expression::Signal latch =
        context_.latches.add(context_.id(i, "cancel"), LatchKind::kCancel, node(i).subject.get(), true);
    signal = writer_.either(context_.id(i, "cancel_all"), signal, latch);
  }
  return *(at(i).cancel = signal);
}

/// The cancel of the transaction around it, as far as its policy forwards it; clean-up runs to its end.
expression::Signal CommandSignals::forwarded(int i) {
  if (!context_.scope.is_forwarded(i)) return expression::Signal::always(false);
  return writer_.both(context_.id(i, "cancel_forwarded"), cancel(parent(i)), writer_.opposite(cleans_up(i)));
}

expression::Signal CommandSignals::goes_on() {
  const CommandTree& tree = context_.tree;
  std::vector<expression::Signal> all;
  for (int i = 1; i < tree.size(); ++i) {
    const bool exempt = context_.scope.is_exempt(i);
    const bool may_start = exempt || node(parent(i)).cancel_policy.kind != CancelPolicy::Kind::kForward;
    if (exempt && !node(i).is_transaction())
      all.push_back(writer_.both(context_.id(i, "goes_on"), active(i), writer_.opposite(cancel(i))));
    if (!may_start) continue;
    all.push_back(awaited_.awaited(i));
    for (const int h : tree.acting_on(Kind::kStart, i))
      if (tree.handler(h).handler->trigger.delay > 0.0) all.push_back(handlers_.pending(tree.handler(h)));
  }
  return writer_.any("goes_on", all);
}

expression::Signal CommandSignals::cancelled(int i) {
  if (!at(i).cancelled) at(i).cancelled = parent(i) < 0 ? cancel(i) : memory(i, "cancelled", cancel(i));
  return *at(i).cancelled;
}

// -- How it ended -----------------------------------------------------------------------------------------------------

expression::Signal CommandSignals::ended_in_order(int i) {
  return writer_.both(context_.id(i, "in_order"), ended(i), writer_.opposite(stop(i)));
}

expression::Signal CommandSignals::completed(int i) {
  const expression::Signal in_order = writer_.both(context_.id(i, "completed"), ended(i), writer_.opposite(stop(i)));
  if (!context_.tree.can_fail(i)) return in_order;
  if (has_timeout(i) && !node(i).fails_if) return writer_.both(context_.id(i, "in_time"), in_order, met(i));
  return writer_.both(context_.id(i, "succeeded"), in_order, writer_.opposite(failed(i)));
}

/// Of a transaction: something in it has.
expression::Signal CommandSignals::failed(int i) {
  if (at(i).failed) return *at(i).failed;
  std::vector<expression::Signal> any;
  if (has_timeout(i)) any.push_back(timed_out(i));
  if (node(i).fails_if) any.push_back(failed_itself(i));
  for (const int child : context_.tree.at(i).children)
    if (context_.tree.can_fail(child)) any.push_back(failed(child));
  const expression::Signal one = writer_.any(context_.id(i, "any_failed"), any);
  return *(at(i).failed = writer_.both(context_.id(i, "failed"), ended_in_order(i), one));
}

/// What its last cycle shows is kept.
expression::Signal CommandSignals::failed_itself(int i) {
  const expression::Signal at_end =
      writer_.both(context_.id(i, "fails"), done(i), writer_.signal_of(node(i).fails_if->node()));
  return writer_.latch(context_.id(i, "failure"), at_end, true);
}

/// Of a wait with a timeout: its state has held while it ran, or it was cancelled.
expression::Signal CommandSignals::met(int i) {
  if (at(i).met) return *at(i).met;
  const expression::Signal now =
      writer_.both(context_.id(i, "holds"), writer_.signal_of(node(i).until->node()), active(i));
  const expression::Signal held = writer_.latch(context_.id(i, "held"), now, false);
  return *(at(i).met = writer_.either(context_.id(i, "met"), held, cancelled(i)));
}

expression::Signal CommandSignals::timed_out(int i) {
  return writer_.both(context_.id(i, "timed_out"), ended_in_order(i), writer_.opposite(met(i)));
}

expression::Signal CommandSignals::state(int i, const std::string& name) {
  if (name == "started") return started(i);
  if (name == "active") return active(i);
  if (name == "stopped") return stopped(i);
  if (name == "cancelled") return cancelled(i);
  if (name == "failed") return failed(i);
  if (name == "timed_out") return timed_out(i);
  return completed(i);
}

}  // namespace takt::command
