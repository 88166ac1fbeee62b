#include "core/command/command_fragments.h"

#include <nlohmann/json.hpp>

#include "core/command/command_signals.h"

namespace takt::command {

CommandFragments::CommandFragments(MappingContext& context, CommandSignals& commands)
    : context_(context), commands_(commands), entries_(static_cast<std::size_t>(context.tree.size())) {}

CommandFragments::Entry& CommandFragments::written(int i) {
  Entry& entry = entries_[static_cast<std::size_t>(i)];
  if (entry.fragment) return entry;
  const expression::Signal brake = commands_.brake(i);
  entry.fragment.emplace(context_.writer, context_.id(i), brake);
  const CommandNode& node = context_.node(i);
  const ActuatorModel& actuator = node.actuator->model();
  entry.contribution = node.model().add_to(*entry.fragment, actuator);
  actuator.add_consumer(*entry.fragment, entry.contribution.set_point);
  const expression::Signal on = commands_.active(i);
  if (!on.is(true)) context_.writer.feed(on, context_.id(i) + ".active");
  return entry;
}

expression::Signal CommandFragments::done(int i) {
  const Entry& entry = written(i);
  expression::Signal signal = entry.contribution.done;
  if (!signal.constant) signal.port = entry.fragment->outer(signal.port);
  return signal;
}

expression::Signal CommandFragments::state(int i, const expression::Expression& leaf) {
  Entry& entry = written(i);
  const nlohmann::ordered_json& parameters = leaf.primitive.parameters;
  auto [state, is_new] = entry.states.try_emplace(leaf.output + parameters.dump());
  if (is_new) {
    const std::string port = context_.node(i).model().add_state(*entry.fragment, leaf.output, parameters);
    state->second = entry.fragment->outer(port);
  }
  const expression::Signal port = expression::Signal::at(state->second);
  if (leaf.type != net::ValueType::kBoolean) return port;
  return context_.writer.only_while(context_.id(i, leaf.output.c_str()), commands_.active(i), port);
}

expression::Signal CommandFragments::invalid(const std::string& actuator) {
  std::vector<expression::Signal> signals;
  for (int i = 0; i < context_.tree.size(); ++i) {
    const CommandNode& node = context_.node(i);
    if (!node.is_runtime() || !drives(*node.actuator, actuator)) continue;
    expression::FragmentWriter& inside = *written(i).fragment;
    const expression::Signal port = expression::Signal::at(inside.outer(node.actuator->model().add_invalid(inside)));
    signals.push_back(context_.writer.only_while(context_.id(i, "invalid"), commands_.active(i), port));
  }
  return context_.writer.any("invalid", signals);
}

std::optional<ClockPorts> CommandFragments::clock(int i) {
  if (!context_.node(i).is_runtime()) return std::nullopt;
  const Entry& entry = written(i);
  if (entry.contribution.path_clock.empty()) return std::nullopt;
  return ClockPorts::of(entry.fragment->outer(entry.contribution.path_clock));
}

void CommandFragments::trace_set_point(int i) {
  const Entry& entry = written(i);
  for (const auto& [name, port] : entry.contribution.set_point.ports)
    context_.trace(context_.tree.at(i).path + " " + name, expression::Signal::at(entry.fragment->outer(port)));
}

}  // namespace takt::command
