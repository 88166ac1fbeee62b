#include "core/command/command.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace takt::command {

RaisedState::RaisedState(std::string name)
    : subject_(std::make_shared<const expression::Subject>(
          expression::Subject{expression::Subject::Kind::kRaised, std::move(name)})) {}
expression::State RaisedState::state() const {
  return expression::State(expression::leaf(net::ValueType::kBoolean, subject_, "raised"));
}

Effect start(const Command& command) { return {.kind = Effect::Kind::kStart, .target = command.subject()}; }
Effect stop(const Command& command) { return {.kind = Effect::Kind::kStop, .target = command.subject()}; }
Effect cancel(const Command& command) { return {.kind = Effect::Kind::kCancel, .target = command.subject()}; }
Effect raise(const RaisedState& state) { return {.kind = Effect::Kind::kRaise, .target = state.subject()}; }
Effect external(std::string name, ExternalHandler handler) {
  return {.kind = Effect::Kind::kExternal, .target = nullptr, .name = std::move(name), .external = std::move(handler)};
}

Command::Command(std::string name) : node_(std::make_shared<CommandNode>()) {
  node_->subject =
      std::make_shared<const expression::Subject>(expression::Subject{expression::Subject::Kind::kCommand, name});
  node_->name = std::move(name);
}

Command& Command::on_entered(expression::State state, Effect effect, Trigger trigger) {
  node_->handlers.push_back({std::move(state), true, std::move(effect), trigger});
  return *this;
}

Command& Command::on_left(expression::State state, Effect effect, Trigger trigger) {
  node_->handlers.push_back({std::move(state), false, std::move(effect), trigger});
  return *this;
}

std::string scoped_name(const std::string& part, const std::string& observation) {
  return part.empty() || observation.starts_with('/') ? part + observation : part + " " + observation;
}

Command& Command::fails_if(const expression::State& state) {
  node_->fails_if = node_->fails_if ? *node_->fails_if || state : state;
  return *this;
}

Command& Command::observe_node(std::string name, expression::ExpressionPtr value, expression::ExpressionPtr when) {
  node_->observations.push_back({std::move(name), std::move(value), std::move(when)});
  return *this;
}

namespace {

/// Of several actuators as one the only part that takes what the action gives.
Actuator part_for(const Actuator& actuator, const ActionModel& action) {
  const std::vector<Actuator> parts = actuator.model().parts();
  if (parts.empty()) return actuator;
  std::vector<std::string> takers;
  std::optional<Actuator> taker;
  for (const Actuator& part : parts) {
    const auto takes = part.model().takes();
    if (std::ranges::find(takes, action.gives(part.model())) == takes.end()) continue;
    takers.push_back(part.name());
    taker = part;
  }
  if (takers.size() == 1) return *taker;
  return missing(
      actuator.name(),
      takers.empty()
          ? expression::fault_of(Code::kUnsupported,
                                 fmt::format("no part of '{}' accepts {}", actuator.name(), action.name()),
                                 "Give an action for one of its parts")
          : expression::fault_of(Code::kConflict,
                                 fmt::format("{} parts of '{}' take {}", takers.size(), actuator.name(), action.name()),
                                 fmt::format("Name one of {}", fmt::join(takers, ", "))));
}

/// Whether `inner` is `outer` or inside of it.
bool is_inside(const CommandNode& inner, const CommandNode& outer) {
  return &inner == &outer ||
         std::ranges::any_of(outer.children, [&](const auto& child) { return is_inside(inner, *child); });
}

}  // namespace

namespace {

/// Nothing: it moves no arm whose motions people can hold.
std::optional<expression::State> paused_of(const CommandNode& node) {
  if (node.is_runtime()) {
    const auto speed = node.actuator->model().speed();
    if (!speed) return std::nullopt;
    return expression::State(expression::leaf(net::ValueType::kBoolean, node.subject, "active")) &&
           (expression::is_null(*speed) || !expression::is_greater(*speed, 0.0));
  }
  std::optional<expression::State> any;
  for (const auto& child : node.children) {
    const auto one = paused_of(*child);
    if (one) any = any ? *any || *one : *one;
  }
  return any;
}

}  // namespace

expression::State Command::paused() const {
  if (auto state = paused_of(*node_)) return *state;
  return expression::State(expression::broken(Code::kInvalidValue, net::ValueType::kBoolean,
                                              fmt::format("C8: '{}' moves no arm, so it is never paused", name()),
                                              "Watch a command that moves an arm whose speed has a channel"));
}

RuntimeCommand::RuntimeCommand(std::string name, Actuator actuator, Action action) : Command(std::move(name)) {
  node()->actuator = part_for(actuator, action.model());
  node()->action = std::move(action);
}

WaitCommand::WaitCommand(std::string name, double seconds) : Command(std::move(name)) { node()->seconds = seconds; }
WaitCommand::WaitCommand(std::string name, expression::State until, std::optional<double> timeout)
    : Command(std::move(name)) {
  node()->until = std::move(until);
  node()->seconds = timeout;
}

TransactionCommand& TransactionCommand::add(const Command& command) { return add_child(command, false); }

TransactionCommand& TransactionCommand::add_started(const Command& command) { return add_child(command, true); }

TransactionCommand& TransactionCommand::add_child(const Command& command, bool started) {
  if (is_inside(*node(), *command.node())) {
    node()->circular.push_back(command.name());
    return *this;
  }
  node()->children.push_back(command.node());
  node()->started_with.push_back(started);
  return *this;
}

RaisedState TransactionCommand::raised(std::string name) { return node()->raised.emplace_back(std::move(name)); }

TransactionCommand& TransactionCommand::on_cancel_forward() {
  node()->cancel_policy = {};
  return *this;
}

TransactionCommand& TransactionCommand::on_cancel_forward_to(const std::vector<Command>& commands) {
  node()->cancel_policy = {.kind = CancelPolicy::Kind::kForwardTo, .targets = {}};
  for (const Command& command : commands) node()->cancel_policy.targets.push_back(command.subject());
  return *this;
}

TransactionCommand& TransactionCommand::on_cancel_ignore() {
  node()->cancel_policy = {.kind = CancelPolicy::Kind::kIgnore, .targets = {}};
  return *this;
}

}  // namespace takt::command
