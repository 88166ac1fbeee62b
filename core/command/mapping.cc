#include "core/command/mapping.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/awaited_starts.h"
#include "core/command/check.h"
#include "core/command/command_tree.h"
#include "core/expression/net_writer.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Effect::Kind;

/// A latch whose events are linked when everything else stands.
struct OpenLatch {
  std::string set;  ///< its input
  Kind kind;
  const Subject* target;
};

/// Writes the net of a tree. Each signal of a command is written when it is first asked for; its port has a name before
/// what it depends on is written, so loops through delayed links need no order.
class Mapper {
 public:
  Mapper(const CommandTree& tree, Nanoseconds period)
      : tree_(tree),
        ranks_(tree.ranks()),
        writer_(period, [this](const Expression& leaf) { return leaf_signal(leaf); }),
        awaited_(tree, writer_,
                 {.started = [this](int i) { return started(i); },
                  .running = [this](int i) { return running(i); },
                  .called_off = [this](const CommandTree::Handler& h) { return called_off(h); },
                  .held = [this](const CommandTree::Handler& h) { return held(h); }}),
        ports_(static_cast<std::size_t>(tree.size())) {
    (void)writer_.unique("end");
    (void)writer_.unique("cancel");
    for (int i = 0; i < tree.size(); ++i) at(i).id = writer_.unique(id_wish(i));
  }

  MappedCommand map() {
    writer_.add("cancel", "Cancel");
    writer_.add("end", "Termination");
    writer_.feed(writer_.either("over", done(0), stop(0)), "end.condition");
    for (int i = 0; i < tree_.size(); ++i) write_command(i);
    for (const auto& handler : tree_.handlers()) write_handler(handler);
    close_latches();
    bound_cancel();
    mapped_.net = std::move(writer_.net);
    mapped_.net.name = tree_.at(0).node->name;
    return std::move(mapped_);
  }

 private:
  struct Ports {
    std::string id;
    std::optional<Signal> started, ended, stop, cancel, cancelled, active, done, met;
    std::optional<FragmentWriter> fragment;
    Contribution contribution;
    std::map<std::string, std::string> states;  ///< what was added to the fragment
    std::vector<Signal> pending;                ///< of a transaction: starts that are due
  };
  struct Event {
    Kind kind;
    const Subject* target;
    Signal signal;
  };

  Ports& at(int i) { return ports_[static_cast<std::size_t>(i)]; }
  const CommandNode& node(int i) const { return *tree_.at(i).node; }
  std::string id(int i, const char* what) { return at(i).id + "-" + what; }

  /// Commands inside of others carry the names of what is around them but for the root.
  std::string id_wish(int i) const {
    std::string wish = node(i).name;
    for (int p = tree_.at(i).parent; p > 0; p = tree_.at(p).parent) wish = node(p).name + "-" + wish;
    return wish;
  }

  bool has_event(Kind kind, int i) const {
    return std::ranges::any_of(tree_.handlers(), [&](const CommandTree::Handler& h) {
      return h.handler->effect.kind == kind && tree_.find(h.handler->effect.target) == i;
    });
  }

  Signal open_latch(const std::string& wish, Kind kind, const Subject* target, bool null_sets) {
    const std::string id = writer_.unique(wish);
    writer_.add(id, "SetResetLatch", {{"reset", false}}, null_sets ? Json::object() : Json{{"set", false}});
    open_.push_back({id + ".set", kind, target});
    return Signal::at(id + ".value");
  }

  // -- The life of a command -----------------------------------------------------------------------------------------

  Signal started(int i) {
    if (at(i).started) return *at(i).started;
    const int parent = tree_.at(i).parent;
    Signal signal = Signal::always(parent < 0);
    if (parent >= 0 && tree_.at(i).with_parent) signal = started(parent);
    if (has_event(Kind::kStart, i)) {
      const Signal latch = open_latch(id(i, "started"), Kind::kStart, node(i).subject.get(), false);
      signal = writer_.either(id(i, "begun"), signal, latch);
    }
    return *(at(i).started = signal);
  }

  /// Started, and not ended in a cycle before.
  Signal running(int i) {
    if (tree_.at(i).parent < 0) return Signal::always(true);
    return writer_.both(id(i, "running"), started(i), writer_.opposite(ended(i).one_cycle_ago()));
  }

  Signal stop(int i) {
    if (at(i).stop) return *at(i).stop;
    const int parent = tree_.at(i).parent;
    const Signal above = parent < 0 ? Signal::always(false) : stop(parent);
    const bool own = has_event(Kind::kStop, i);
    if (!own) return *(at(i).stop = memory(i, "stop", above));
    const Signal latch = open_latch(id(i, "stop"), Kind::kStop, node(i).subject.get(), true);
    at(i).stop = latch;
    if (!above.is(false)) at(i).stop = writer_.either(id(i, "stopped"), latch, memory(i, "stop_around", above));
    return *at(i).stop;
  }

  /// Remembers a request that concerns a command only while it runs.
  Signal memory(int i, const char* what, const Signal& request) {
    if (request.constant) return request;
    return writer_.latch(id(i, what), writer_.both(id(i, what) + "_now", request, running(i)), true);
  }

  Signal cancel(int i) {
    if (at(i).cancel) return *at(i).cancel;
    const int parent = tree_.at(i).parent;
    Signal signal = parent < 0 ? Signal::at("cancel.requested") : forwarded(i, parent);
    if (has_event(Kind::kCancel, i)) {
      const Signal latch = open_latch(id(i, "cancel"), Kind::kCancel, node(i).subject.get(), true);
      signal = writer_.either(id(i, "cancel_all"), signal, latch);
    }
    return *(at(i).cancel = signal);
  }

  Signal forwarded(int i, int parent) {
    const CancelPolicy& policy = node(parent).cancel_policy;
    const bool told = policy.kind == CancelPolicy::Kind::kForward ||
                      (policy.kind == CancelPolicy::Kind::kForwardTo &&
                       std::ranges::find(policy.targets, node(i).subject) != policy.targets.end());
    return told ? cancel(parent) : Signal::always(false);
  }

  Signal cancelled(int i) {
    if (!at(i).cancelled) {
      at(i).cancelled = tree_.at(i).parent < 0 ? cancel(i) : memory(i, "cancelled", cancel(i));
    }
    return *at(i).cancelled;
  }

  Signal wants(int i) { return writer_.both(id(i, "wants"), running(i), writer_.opposite(stop(i))); }

  /// It wants to, and no earlier command has its devices.
  Signal active(int i) {
    if (at(i).active) return *at(i).active;
    std::vector<Signal> others;
    for (const int other : rivals_before(i)) others.push_back(active(other));
    Signal signal = wants(i);
    for (const Signal& other : others) signal = writer_.both(id(i, "turn"), signal, writer_.opposite(other));
    return *(at(i).active = signal);
  }

  /// Runtime commands that share a device with this one and come before it.
  std::vector<int> rivals_before(int i) const {
    std::vector<int> rivals;
    if (!node(i).is_runtime()) return rivals;
    const auto devices = node(i).actuator->model().devices();
    for (int other = 0; other < tree_.size(); ++other) {
      if (!node(other).is_runtime() || rank(other) >= rank(i)) continue;
      const auto others = node(other).actuator->model().devices();
      if (std::ranges::find_first_of(devices, others) != devices.end()) rivals.push_back(other);
    }
    return rivals;
  }
  int rank(int i) const { return ranks_[static_cast<std::size_t>(i)]; }

  Signal ended(int i) {
    if (at(i).ended) return *at(i).ended;
    const std::string latch = writer_.unique(id(i, "ended"));
    at(i).ended = Signal::at(latch + ".value");
    writer_.add(latch, "SetResetLatch", {{"reset", false}});
    writer_.feed(writer_.either(id(i, "ends"), done(i), stop(i)), latch + ".set");
    return *at(i).ended;
  }

  Signal completed(int i) {
    const Signal in_order = writer_.both(id(i, "completed"), ended(i), writer_.opposite(stop(i)));
    return has_timeout(i) ? writer_.both(id(i, "in_time"), in_order, met(i)) : in_order;
  }

  bool has_timeout(int i) const { return node(i).until && node(i).seconds; }

  /// Of a wait with a timeout: its state has held while it ran, or it was cancelled.
  Signal met(int i) {
    if (at(i).met) return *at(i).met;
    const Signal now = writer_.both(id(i, "holds"), writer_.signal_of(node(i).until->node()), active(i));
    const Signal held = writer_.latch(id(i, "held"), now, false);
    return *(at(i).met = writer_.either(id(i, "met"), held, cancelled(i)));
  }

  Signal timed_out(int i) {
    const Signal in_order = writer_.both(id(i, "over_in_order"), ended(i), writer_.opposite(stop(i)));
    return writer_.both(id(i, "timed_out"), in_order, writer_.opposite(met(i)));
  }

  Signal done(int i) {
    if (at(i).done) return *at(i).done;
    Signal signal = node(i).is_runtime() ? runtime_done(i) : node(i).is_wait() ? wait_done(i) : transaction_done(i);
    return *(at(i).done = writer_.only_while(id(i, "done"), active(i), signal));
  }

  Signal runtime_done(int i) {
    FragmentWriter& fragment = this->fragment(i);
    Signal signal = at(i).contribution.done;
    if (!signal.constant) signal.port = fragment.outer(signal.port);
    return signal;
  }

  Signal wait_done(int i) {
    std::vector<Signal> ends{cancel(i)};
    if (node(i).until) ends.push_back(writer_.signal_of(node(i).until->node()));
    if (node(i).seconds) {
      const std::string timer = writer_.unique(id(i, "timer"));
      writer_.add(timer, "OnDelay", {{"delay", *node(i).seconds}});
      writer_.feed(active(i), timer + ".input");
      ends.push_back(Signal::at(timer + ".value"));
    }
    return writer_.any(id(i, "over"), ends);
  }

  /// Nothing inside runs any more, no start is due, and nothing can be started any more (row L9). The pending ones are
  /// linked when the handlers are written.
  Signal transaction_done(int i) {
    std::vector<Signal> busy;
    for (const int child : tree_.at(i).children) {
      const Signal over = AwaitedStarts::end_is_heard(tree_, child) ? ended(child).one_cycle_ago() : ended(child);
      busy.push_back(writer_.both(id(child, "busy"), started(child), writer_.opposite(over)));
      busy.push_back(awaited_.awaited(child));
      trace(tree_.at(child).path + " awaited", busy.back());
    }
    for (const auto& handler : tree_.handlers()) {
      if (handler.handler->effect.kind != Kind::kStart || handler.handler->trigger.delay <= 0.0) continue;
      const int target = tree_.find(handler.handler->effect.target);
      if (target >= 0 && tree_.at(target).parent == i) busy.push_back(pending(handler));
    }
    return writer_.opposite(writer_.any(id(i, "busy"), busy));
  }

  // -- Runtime commands ----------------------------------------------------------------------------------------------

  FragmentWriter& fragment(int i) {
    Ports& own = at(i);
    if (own.fragment) return *own.fragment;
    const Signal cancel_signal = cancel(i);
    own.fragment.emplace(writer_, own.id, cancel_signal);
    const ActuatorModel& actuator = node(i).actuator->model();
    own.contribution = node(i).model().add_to(*own.fragment, actuator);
    actuator.add_consumer(*own.fragment, own.contribution.set_point);
    const Signal on = active(i);
    if (!on.is(true)) writer_.feed(on, own.id + ".active");
    return *own.fragment;
  }

  Signal action_signal(int i, const Expression& leaf) {
    if (leaf.output == "started") return started(i);
    if (leaf.output == "completed") return completed(i);
    FragmentWriter& inside = fragment(i);
    const Json& parameters = leaf.primitive.parameters;
    auto [place, is_new] = at(i).states.try_emplace(leaf.output + parameters.dump());
    if (is_new) place->second = inside.outer(node(i).model().add_state(inside, leaf.output, parameters));
    const Signal port = Signal::at(place->second);
    if (leaf.type != net::ValueType::kBoolean) return port;
    return writer_.only_while(id(i, leaf.output.c_str()), active(i), port);
  }

  /// Some command gives the actuator nothing.
  Signal invalid_signal(const std::string& actuator) {
    std::vector<Signal> signals;
    for (int i = 0; i < tree_.size(); ++i) {
      if (!node(i).is_runtime() || !drives(*node(i).actuator, actuator)) continue;
      FragmentWriter& inside = fragment(i);
      const Signal port = Signal::at(inside.outer(node(i).actuator->model().add_invalid(inside)));
      signals.push_back(writer_.only_while(id(i, "invalid"), active(i), port));
    }
    return writer_.any("invalid", signals);
  }

  Signal command_signal(int i, const std::string& state) {
    if (state == "started") return started(i);
    if (state == "active") return active(i);
    if (state == "stopped") return stop(i);
    if (state == "cancelled") return cancelled(i);
    if (state == "timed_out") return timed_out(i);
    return completed(i);
  }

  Signal raised_signal(const SubjectPtr& subject) {
    auto [place, is_new] = raised_.try_emplace(subject.get());
    if (is_new) place->second = open_latch(subject->name, Kind::kRaise, subject.get(), false);
    return place->second;
  }

  Signal leaf_signal(const Expression& leaf) {
    switch (leaf.subject->kind) {
      case Subject::Kind::kRaised:
        return raised_signal(leaf.subject);
      case Subject::Kind::kAction:
        return action_signal(tree_.find(leaf.subject), leaf);
      case Subject::Kind::kActuator:
        return invalid_signal(leaf.subject->name);
      default:
        return command_signal(tree_.find(leaf.subject), leaf.output);
    }
  }

  /// Two commands want one device, and the one that has it does not end in this cycle.
  void write_conflicts(int i) {
    for (const int other : rivals_before(i)) {
      if (follows(i, other)) continue;
      const Signal kept = writer_.both(id(other, "kept"), active(other), writer_.opposite(done(other)));
      const Signal conflict = writer_.both(id(i, "conflict"), wants(i), kept);
      if (conflict.is(false)) continue;
      const std::string error = writer_.unique(id(i, "against_") + node(other).name);
      const std::string text = fmt::format("'{}' wants what '{}' has", node(i).name, node(other).name);
      writer_.add(error, "Error", {{"text", text.substr(0, 63)}, {"cause", "conflict"}}, {{"condition", false}});
      writer_.feed(conflict, error + ".condition");
    }
  }

  /// Whether `i` can only be started by what has ended with `other`.
  bool follows(int i, int other) const {
    if (tree_.at(i).with_parent) return false;
    bool any = false;
    for (const auto& handler : tree_.handlers()) {
      if (handler.handler->effect.kind != Kind::kStart || tree_.find(handler.handler->effect.target) != i) continue;
      if (!handler.handler->entered || !tree_.implies_end(handler.handler->state.node(), other)) return false;
      any = true;
    }
    return any;
  }

  void write_command(int i) {
    (void)done(i);
    if (node(i).is_runtime()) write_conflicts(i);
    mapped_.commands.push_back({tree_.at(i).path, clock_of(i)});
    for (const Observation& observation : node(i).observations) write_observation(i, observation);
    trace_command(i);
    if (!node(i).is_runtime() || !active(i).is(true)) return;
    add_seams(i, node(i).model().begins(), mapped_.options.begins);
    if (!has_event(Kind::kCancel, i)) add_seams(i, node(i).model().ends(), mapped_.options.ends);
  }

  /// Nothing of what is not a planned motion.
  std::optional<ClockPorts> clock_of(int i) {
    if (!node(i).is_runtime() || at(i).contribution.path_clock.empty()) return std::nullopt;
    return ClockPorts::of(fragment(i).outer(at(i).contribution.path_clock));
  }

  void add_seams(int i, const std::vector<device::Seam>& seams, std::vector<rcc::NetSeam>& all) const {
    const auto devices = node(i).actuator->model().devices();
    for (std::size_t k = 0; k < seams.size(); ++k) all.push_back({devices.at(k), seams[k]});
  }

  void trace(const std::string& name, const Signal& signal) {
    const bool known = std::ranges::any_of(mapped_.traced, [&](const auto& t) { return t.port == signal.port; });
    if (!signal.constant && !known) mapped_.traced.push_back({name, signal.port});
  }

  void trace_command(int i) {
    trace(tree_.at(i).path + " active", active(i));
    trace(tree_.at(i).path + " cancel", cancel(i));
    if (!node(i).is_runtime()) return;
    for (const auto& [name, port] : at(i).contribution.set_point.ports) {
      trace(tree_.at(i).path + " " + name, Signal::at(at(i).fragment->outer(port)));
    }
  }

  /// Where the net cannot tell how long a cancel takes: all the times one after the other, and some cycles for each.
  void bound_cancel() {
    bool unknown = false;
    double time = 0.0;
    for (int i = 0; i < tree_.size(); ++i) {
      if (!node(i).is_runtime()) continue;
      unknown = unknown || !node(i).model().net_knows_stop_time();
      time += node(i).model().stop_time(node(i).actuator->model());
    }
    const auto cycles = static_cast<std::int64_t>(std::ceil(time / to_seconds(writer_.period())));
    if (unknown) mapped_.options.cancel_bound_cycles = cycles + 4 * tree_.size() + 4;
  }

  void write_observation(int i, const Observation& observation) {
    std::string port = writer_.port_of(observation.value);
    if (observation.when) {
      const Signal now = writer_.both(observation.name + "-now", active(i), writer_.signal_of(observation.when));
      const std::string snapshot = writer_.unique(observation.name);
      writer_.add(snapshot, "Snapshot" + std::string(net::name_of(observation.value->type)));
      writer_.link(port, snapshot + ".input");
      writer_.feed(writer_.latch(observation.name + "-first", now, false), snapshot + ".trigger");
      port = snapshot + ".value";
    }
    mapped_.observed[observation.name] = std::move(port);
  }

  // -- Events --------------------------------------------------------------------------------------------------------

  /// The formula speaks of the life of its owner, so it counts after the owner has ended too.
  bool speaks_of(const EventHandler& handler, int i) const {
    const auto subjects = subjects_of(handler.state.node());
    return std::ranges::find(subjects, node(i).subject) != subjects.end();
  }

  /// The event, before any delay: true as long as the state is as it shall be.
  Signal occurrence(const CommandTree::Handler& h) {
    const EventHandler& handler = *h.handler;
    const Signal armed = this->armed(h);
    const Signal state = writer_.signal_of(handler.state.node());
    trace(h.path, state);
    if (handler.entered) return writer_.both(id(h.owner, "event"), state, armed);
    const Signal gone = writer_.both(id(h.owner, "gone"), held(h), writer_.opposite(state));
    return writer_.both(id(h.owner, "event"), gone, armed);
  }
  /// Its state has held while the handler was armed.
  Signal held(const CommandTree::Handler& h) {
    const Signal state = writer_.signal_of(h.handler->state.node());
    const Signal holds = writer_.both(id(h.owner, "event"), state, armed(h));
    return writer_.latch(id(h.owner, "held"), holds, acts_on_null(h.handler->effect.kind));
  }
  Signal armed(const CommandTree::Handler& h) {
    return speaks_of(*h.handler, h.owner) ? started(h.owner) : active(h.owner);
  }
  static bool acts_on_null(Kind kind) { return kind == Kind::kStop || kind == Kind::kCancel; }

  /// From the event, after its delay, on.
  Signal delayed(const CommandTree::Handler& h) {
    const auto found = delayed_.find(h.handler);
    if (found != delayed_.end()) return found->second;
    Signal signal = occurrence(h);
    if (h.handler->trigger.delay > 0.0) {
      const Signal begun = writer_.latch(id(h.owner, "due"), signal, acts_on_null(h.handler->effect.kind));
      const std::string timer = writer_.unique(id(h.owner, "delay"));
      writer_.add(timer, "OnDelay", {{"delay", h.handler->trigger.delay}});
      writer_.feed(begun, timer + ".input");
      begun_[h.handler] = begun;
      signal = Signal::at(timer + ".value");
    }
    return delayed_[h.handler] = signal;
  }

  /// A start is due, and nothing has called it off.
  Signal pending(const CommandTree::Handler& h) {
    const Signal fired = delayed(h);
    const Signal waits = writer_.both(id(h.owner, "waits"), begun_[h.handler], writer_.opposite(fired));
    return writer_.both(id(h.owner, "pending"), waits, writer_.opposite(called_off(h)));
  }

  /// The transaction around the target was cancelled, and this handler is not what it does then (rule C4).
  Signal called_off(const CommandTree::Handler& h) {
    const int around = tree_.at(tree_.find(h.handler->effect.target)).parent;
    if (around < 0 || node(around).cancel_policy.kind != CancelPolicy::Kind::kForward) return Signal::always(false);
    if (h.owner == around && speaks_of(*h.handler, around)) return Signal::always(false);
    return cancel(around);
  }

  void write_handler(const CommandTree::Handler& h) {
    const Effect& effect = h.handler->effect;
    if (effect.kind == Kind::kExternal) return write_external(h);
    Signal signal = delayed(h);
    if (effect.kind == Kind::kCancel) note_brake(h);
    if (effect.kind == Kind::kStart) {
      signal = writer_.both(id(h.owner, "start"), signal, writer_.opposite(called_off(h)));
    } else if (acts_on_null(effect.kind)) {
      signal = writer_.both(id(h.owner, effect.kind == Kind::kStop ? "stops" : "cancels"), signal,
                            running(tree_.find(effect.target)));
    } else {
      (void)raised_signal(effect.target);
    }
    events_.push_back({effect.kind, effect.target.get(), signal});
  }

  /// What the handler looks at, and the clock that it brakes; nothing for events that come from no sensor, or later.
  void note_brake(const CommandTree::Handler& h) {
    const int target = tree_.find(h.handler->effect.target);
    const Signal event = writer_.signal_of(h.handler->state.node());
    if (!node(target).is_runtime() || at(target).contribution.path_clock.empty() || event.constant ||
        !h.handler->entered || h.handler->trigger.delay > 0.0)
      return;
    BrakePorts brake{
        .name = h.path, .event = event.port, .fragment = at(target).id, .clock = *clock_of(target), .sources = {}};
    std::set<const Expression*> seen;
    add_sources(h.handler->state.node(), seen, brake.sources);
    if (!brake.sources.empty()) mapped_.brakes.push_back(std::move(brake));
  }

  /// The primitives of a formula that read a device or a channel, each once.
  void add_sources(const ExpressionPtr& node, std::set<const Expression*>& seen, std::vector<std::string>& sources) {
    if (!seen.insert(node.get()).second) return;
    if (node->resource != nullptr) {
      std::string id = NetWriter::node_of(writer_.port_of(node));
      if (std::ranges::find(sources, id) == sources.end()) sources.push_back(std::move(id));
    }
    for (const auto& [port, input] : node->inputs)
      if (input) add_sources(input, seen, sources);
  }

  /// Counts in the net; the program's side looks at the count.
  void write_external(const CommandTree::Handler& h) {
    const Trigger& trigger = h.handler->trigger;
    Signal signal = occurrence(h);
    if (trigger.first_only) signal = writer_.latch(id(h.owner, "first"), signal, false);
    if (trigger.delay > 0.0) {
      const std::string delay = writer_.unique(id(h.owner, "later"));
      const auto cycles = static_cast<std::int64_t>(std::ceil(trigger.delay / to_seconds(writer_.period()) - 1e-9));
      writer_.add(delay, "DelayBoolean", {{"cycles", cycles}});
      writer_.feed(signal, delay + ".input");
      signal = Signal::at(delay + ".value");
    }
    const std::string counter = writer_.unique(h.handler->effect.name);
    writer_.add(counter, "UpDownCounter");
    writer_.feed(signal, counter + ".up");
    mapped_.externals.push_back({h.handler->effect.name, counter + ".count", h.handler->effect.external});
  }

  /// Joins events with what they act on: what closes a cycle is delayed by one cycle (row O7). Starts come first, so
  /// that rather an end is delayed than a beginning.
  void close_latches() {
    for (const Kind kind : {Kind::kStart, Kind::kRaise, Kind::kStop, Kind::kCancel}) {
      for (const OpenLatch& latch : open_) {
        if (latch.kind == kind) close(latch);
      }
    }
  }

  void close(const OpenLatch& latch) {
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

  const CommandTree& tree_;
  std::vector<int> ranks_;
  NetWriter writer_;
  AwaitedStarts awaited_;
  std::vector<Ports> ports_;
  std::map<const Subject*, Signal> raised_;
  std::map<const EventHandler*, Signal> delayed_, begun_;
  std::vector<OpenLatch> open_;
  std::vector<Event> events_;
  MappedCommand mapped_;
};

}  // namespace

Result<MappedCommand> map(const Command& command, Nanoseconds period) {
  Diagnostics diagnostics = check(command);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const CommandTree tree(command);
  return Mapper(tree, period).map();
}

}  // namespace takt::command
