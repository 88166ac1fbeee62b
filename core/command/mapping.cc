#include "core/command/mapping.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/check.h"
#include "core/command/command_fragments.h"
#include "core/command/command_signals.h"
#include "core/command/command_tree.h"
#include "core/command/handler_signals.h"
#include "core/command/mapping_context.h"

namespace takt::command {
namespace {

using Kind = Effect::Kind;

/// Writes the net of a tree: the commands, then the handlers, then the links between the two. What each of them is as a
/// signal is written by the parts below; this class says what the net has and what is shown of it.
class Mapper {
 public:
  Mapper(const CommandTree& tree, Nanoseconds period)
      : tree_(tree), writer_(period, [this](const expression::Expression& leaf) { return leaf_signal(leaf); }) {}

  MappedCommand map() {
    writer_.add("cancel", "Cancel");
    writer_.add("end", "Termination");
    writer_.feed(commands_.over(), "end.condition");
    for (int i = 0; i < tree_.size(); ++i) write_command(i);
    for (const auto& handler : tree_.handlers()) write_handler(handler);
    name_signals();
    context_.latches.link_events();
    bound_cancel();
    mapped_.traced = std::move(context_.traced);
    mapped_.net = std::move(writer_.net);
    mapped_.net.name = node(0).name;
    return std::move(mapped_);
  }

 private:
  const CommandNode& node(int i) const { return *tree_.at(i).node; }
  std::string id(int i, const char* what) const { return context_.id(i, what); }

  expression::Signal leaf_signal(const expression::Expression& leaf) {
    switch (leaf.subject->kind) {
      case expression::Subject::Kind::kRaised:
        return context_.latches.raised(leaf.subject);
      case expression::Subject::Kind::kAction:
        return action_signal(tree_.find(leaf.subject), leaf);
      case expression::Subject::Kind::kActuator:
        return fragments_.invalid(leaf.subject->name);
      default:
        return commands_.state(tree_.find(leaf.subject), leaf.output);
    }
  }

  /// An action starts and is completed with the command that carries it out.
  expression::Signal action_signal(int i, const expression::Expression& leaf) {
    const bool is_life = leaf.output == "started" || leaf.output == "completed";
    return is_life ? commands_.state(i, leaf.output) : fragments_.state(i, leaf);
  }

  // -- Commands ------------------------------------------------------------------------------------------------------

  void write_command(int i) {
    (void)commands_.done(i);
    if (node(i).is_runtime()) write_conflicts(i);
    mapped_.commands.push_back({tree_.at(i).path, fragments_.clock(i)});
    for (const Observation& observation : node(i).observations) write_observation(i, observation);
    trace_command(i);
    if (!node(i).is_runtime() || i > 0 || context_.has_event(Kind::kStop, i)) return;
    add_seams(i, node(i).model().begins(), mapped_.options.begins);
    if (!context_.has_event(Kind::kCancel, i)) add_seams(i, node(i).model().ends(), mapped_.options.ends);
  }

  void add_seams(int i, const std::vector<device::Seam>& seams, std::vector<rcc::NetSeam>& all) const {
    const auto devices = node(i).actuator->model().devices();
    for (std::size_t k = 0; k < seams.size(); ++k) all.push_back({devices.at(k), seams[k]});
  }

  /// Two commands want one device, and the one that has it does not end in this cycle.
  void write_conflicts(int i) {
    for (const int other : commands_.rivals_before(i)) {
      if (context_.order.has_ended(other, i)) continue;
      const expression::Signal kept =
          writer_.both(id(other, "kept"), commands_.active(other), writer_.opposite(commands_.done(other)));
      const expression::Signal conflict = writer_.both(id(i, "conflict"), commands_.wants(i), kept);
      if (conflict.is(false)) continue;
      const std::string error = writer_.unique(id(i, "against_") + node(other).name);
      const std::string text = fmt::format("'{}' needs a device of '{}'", node(i).name, node(other).name);
      writer_.add(error, "Error", {{"text", text.substr(0, 63)}, {"cause", "conflict"}}, {{"condition", false}});
      writer_.feed(conflict, error + ".condition");
    }
  }

  void trace_command(int i) {
    context_.trace(tree_.at(i).path + " active", commands_.active(i));
    context_.trace(tree_.at(i).path + " cancel", commands_.cancel(i));
    if (node(i).is_runtime()) fragments_.trace_set_point(i);
  }

  /// What the core reads while the net runs.
  void name_signals() {
    if (const expression::Signal goes_on = commands_.goes_on(); !goes_on.constant)
      mapped_.options.goes_on = goes_on.port;
    if (const expression::Signal stop = commands_.stop(0); !stop.constant) mapped_.options.stopped = stop.port;
  }

  /// Where the net does not know how long a cancel takes: all the times one after the other, and some cycles for each.
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
    const std::string name = tree_.name_of(i, observation);
    std::string port = writer_.port_of(observation.value);
    if (observation.when) {
      const expression::Signal now =
          writer_.both(name + "-now", commands_.active(i), writer_.signal_of(observation.when));
      const std::string snapshot = writer_.unique(name);
      writer_.add(snapshot, "Snapshot" + std::string(net::name_of(observation.value->type)));
      writer_.link(port, snapshot + ".input");
      writer_.feed(writer_.latch(name + "-first", now, false), snapshot + ".trigger");
      port = snapshot + ".value";
    }
    mapped_.observed[name] = std::move(port);
  }

  // -- Handlers ------------------------------------------------------------------------------------------------------

  void write_handler(const CommandTree::Handler& h) {
    const Effect& effect = h.handler->effect;
    if (effect.kind == Kind::kExternal) return write_external(h);
    if (effect.kind == Kind::kStart) return write_start(h);
    const expression::Signal signal = handlers_.delayed(h);
    if (effect.kind == Kind::kRaise) {
      (void)context_.latches.raised(effect.target);
      return context_.latches.add_event(LatchKind::kRaise, effect.target.get(), signal);
    }
    const bool is_stop = effect.kind == Kind::kStop;
    if (!is_stop) note_brake(h);
    context_.latches.add_event(
        is_stop ? LatchKind::kStop : LatchKind::kCancel, effect.target.get(),
        writer_.both(id(h.owner, is_stop ? "stops" : "cancels"), signal, commands_.running(tree_.find(effect.target))));
  }

  /// After a cancel of the transaction only clean-up starts, which the cancel does not concern (rule C4).
  void write_start(const CommandTree::Handler& h) {
    const expression::Subject* target = h.handler->effect.target.get();
    const int i = tree_.find(h.handler->effect.target);
    const expression::Signal due = handlers_.delayed(h);
    expression::Signal start = writer_.both(id(h.owner, "start"), due, writer_.opposite(handlers_.called_off(h)));
    if (context_.scope.may_clean_up(i)) {
      const expression::Signal clears =
          writer_.both(id(h.owner, "clearing"), commands_.cancel(h.owner), handlers_.clears(h));
      start = writer_.both(id(h.owner, "start"), start, writer_.opposite(clears));
      const expression::Signal is_new =
          writer_.both(id(h.owner, "clean_up"), clears, writer_.opposite(commands_.begun(i)));
      context_.latches.add_event(LatchKind::kCleanUp, target, writer_.both(id(h.owner, "clean_up"), due, is_new));
    }
    context_.latches.add_event(LatchKind::kStart, target, start);
  }

  /// The state of the handler, and the clock that it brakes; nothing for events that come from no sensor, or later.
  void note_brake(const CommandTree::Handler& h) {
    const int target = tree_.find(h.handler->effect.target);
    const expression::Signal event = writer_.signal_of(h.handler->state.node());
    const auto clock = fragments_.clock(target);
    if (!clock || event.constant || !h.handler->entered || h.handler->trigger.delay > 0.0) return;
    BrakePorts brake{
        .name = h.path, .event = event.port, .fragment = context_.id(target), .clock = *clock, .sources = {}};
    std::set<const expression::Expression*> seen;
    add_sources(h.handler->state.node(), seen, brake.sources);
    if (!brake.sources.empty()) mapped_.brakes.push_back(std::move(brake));
  }

  /// The primitives of a formula that read a device or a channel, each once.
  void add_sources(const expression::ExpressionPtr& node, std::set<const expression::Expression*>& seen,
                   std::vector<std::string>& sources) {
    if (!seen.insert(node.get()).second) return;
    if (node->resource != nullptr) {
      std::string id = expression::NetWriter::node_of(writer_.port_of(node));
      if (std::ranges::find(sources, id) == sources.end()) sources.push_back(std::move(id));
    }
    for (const auto& [port, input] : node->inputs)
      if (input) add_sources(input, seen, sources);
  }

  /// Counts in the net; the program reads the count.
  void write_external(const CommandTree::Handler& h) {
    const Trigger& trigger = h.handler->trigger;
    expression::Signal signal = handlers_.occurrence(h);
    if (trigger.first_only) signal = writer_.latch(id(h.owner, "first"), signal, false);
    if (trigger.delay > 0.0) {
      const std::string delay = writer_.unique(id(h.owner, "later"));
      const auto cycles = static_cast<std::int64_t>(std::ceil(trigger.delay / to_seconds(writer_.period()) - 1e-9));
      writer_.add(delay, "DelayBoolean", {{"cycles", cycles}});
      writer_.feed(signal, delay + ".input");
      signal = expression::Signal::at(delay + ".value");
    }
    const std::string counter = writer_.unique(h.handler->effect.name);
    writer_.add(counter, "UpDownCounter");
    writer_.feed(signal, counter + ".up");
    mapped_.externals.push_back({h.handler->effect.name, counter + ".count", h.handler->effect.external});
  }

  const CommandTree& tree_;
  expression::NetWriter writer_;
  MappingContext context_{tree_, writer_};
  CommandSignals commands_{context_, fragments_, handlers_};
  CommandFragments fragments_{context_, commands_};
  HandlerSignals handlers_{context_, commands_};
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
