#include "core/operations/command/command_builder.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"

namespace takt::operations {
namespace {

using command::Command;
using expression::State;
using Kind = command::Effect::Kind;

State command_state(const Command& command, const std::string& which) {
  if (which == "started") return command.started();
  if (which == "active") return command.active();
  if (which == "stopped") return command.stopped();
  if (which == "cancelled") return command.cancelled();
  if (which == "failed") return command.failed();
  if (which == "paused") return command.paused();
  if (which == "timed_out") return State(expression::leaf(net::ValueType::kBoolean, command.subject(), "timed_out"));
  return command.completed();
}

command::Actuator actuator_of(const expression::Cell& cell, const std::string& name) {
  if (cell.arms.contains(name)) return command::arm(cell, name);
  if (cell.grippers.contains(name)) return command::gripper(cell, name);
  return command::output(cell, name);
}

State actuator_state(const command::Actuator& actuator, const std::string& which) {
  if (which == "completed") return actuator.completed();
  if (which == "emergency_stop") return actuator.emergency_stop();
  return actuator.invalid_set_point();
}

expression::RealSensor progress_of(const CommandBuilder::Part& part) {
  if (part.made.action) return part.made.action->progress();
  return expression::RealSensor(expression::broken(Code::kInvalidValue, net::ValueType::kReal,
                                                   fmt::format("C8: '{}' is not a motion", part.request->name),
                                                   "Name a motion"));
}

/// What the command layer calls its own functions is something else in a file.
std::string in_words_of_files(std::string text) {
  static constexpr std::array<std::pair<const char*, const char*>, 3> kWords = {
      {{"add() in place of add_started()", "no \"start\": true"},
       {"add_started()", "\"start\": true"},
       {"TransactionCommand::raised()", "'raised'"}}};
  for (const auto& [theirs, ours] : kWords) {
    const auto at = text.find(theirs);
    if (at != std::string::npos) text.replace(at, std::string_view(theirs).size(), ours);
  }
  return text;
}

}  // namespace

CommandBuilder::CommandBuilder(const OperationCommand& root, const BuildContext& build) {
  add(root, -1);
  // What follows another command comes after it.
  for (const bool follows : {false, true}) {
    for (Part& part : parts_) {
      if (part.request->follows().empty() != follows) make(part, build);
    }
  }
  for (Part& part : parts_) {
    if (part.request->transaction() != nullptr) set_up(part);
  }
  for (const Part& part : parts_) {
    add_handlers(part, build);
    if (part.request->transaction() == nullptr) continue;
    set_cancel_policy(part);
    add_captures(part, build);
  }
  // The longest path that fits is the right one.
  std::ranges::stable_sort(places_, [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
}

/// An entry for a command before what is inside of it.
void CommandBuilder::add(const OperationCommand& request, int parent) {
  const int own = static_cast<int>(parts_.size());
  const std::string around = parent < 0 ? std::string() : parts_[static_cast<std::size_t>(parent)].key;
  indices_[&request] = own;
  parts_.push_back({.request = &request,
                    .parent = parent,
                    .key = around + pointer_segment(request.name),
                    .made = {command::WaitCommand(request.name, 0.0)}});
  for (const auto& part : request.parts()) add(*part, own);
}

void CommandBuilder::make(Part& part, BuildContext build) {
  const OperationCommand& request = *part.request;
  if (!request.follows().empty()) {
    build.progress = progress_of(named(part, request.follows()));
    build.followed = named(part, request.follows()).made.action;
  }
  part.made = request.made(build, part.key);
  places_.emplace_back(part.key, request.pointer);
  for (const auto& [theirs, ours] : part.made.places) places_.emplace_back(part.key + theirs, request.pointer + ours);
  for (std::size_t i = 0; i < part.made.handler_places.size(); ++i) {
    places_.emplace_back(part.key + "/handlers" + pointer_segment(i), request.pointer + part.made.handler_places[i]);
  }
}

/// Children and raised states.
void CommandBuilder::set_up(Part& part) {
  const TransactionParameters& transaction = *part.request->transaction();
  command::CommandNode& node = *part.made.command.node();
  for (const auto& child : part.request->parts()) {
    node.children.push_back(part_of(*child).made.command.node());
    node.started_with.push_back(child->starts);
  }
  for (const std::string& name : transaction.raised) {
    node.raised.emplace_back(name);
    part.raised.emplace(name, node.raised.back());
  }
}

/// Its targets may be anywhere in the tree: whether they may is a rule (C4).
void CommandBuilder::set_cancel_policy(const Part& part) {
  const TransactionParameters& transaction = *part.request->transaction();
  command::CommandNode& node = *part.made.command.node();
  using enum command::CancelPolicy::Kind;
  if (transaction.on_cancel == TransactionParameters::OnCancel::kIgnore) node.cancel_policy.kind = kIgnore;
  if (transaction.on_cancel != TransactionParameters::OnCancel::kForwardTo) return;
  node.cancel_policy.kind = kForwardTo;
  for (const std::string& name : transaction.forward_to)
    node.cancel_policy.targets.push_back(named(part, name).made.command.subject());
}

const CommandBuilder::Part& CommandBuilder::part_of(const OperationCommand& request) const {
  return parts_[static_cast<std::size_t>(indices_.at(&request))];
}

const CommandBuilder::Part& CommandBuilder::named(const Part& from, const std::string& name) const {
  return part_of(*from.request->find(name));
}

command::RaisedState CommandBuilder::raised(const Part& from, const std::string& name) const {
  return part_of(*from.request->find_raised(name)).raised.find(name)->second;
}

// -- Events ----------------------------------------------------------------------------------------------------------

void CommandBuilder::add_handlers(const Part& part, const BuildContext& build) {
  Command command = part.made.command;
  for (const HandlerParameters& handler : part.request->handlers) {
    const State state = state_of(part, handler.state, build);
    for (const HandlerParameters::Effect& effect : handler.effects) {
      places_.emplace_back(part.key + "/handlers" + pointer_segment(command.node()->handlers.size()), handler.pointer);
      if (handler.entered) {
        command.on_entered(state, effect_of(part, effect, build), handler.trigger);
      } else {
        command.on_left(state, effect_of(part, effect, build), handler.trigger);
      }
    }
  }
}

command::Effect CommandBuilder::effect_of(const Part& owner, const HandlerParameters::Effect& effect,
                                          const BuildContext& build) const {
  switch (effect.kind) {
    case Kind::kStart:
      return start(named(owner, effect.name).made.command);
    case Kind::kStop:
      return stop(named(owner, effect.name).made.command);
    case Kind::kCancel:
      return cancel(named(owner, effect.name).made.command);
    case Kind::kRaise:
      return raise(raised(owner, effect.name));
    default:
      return command::external(effect.name, build.tell);
  }
}

State CommandBuilder::state_of(const Part& owner, const StateParameters& state, const BuildContext& build) const {
  const State formula = formula_of(owner, state, build);
  return state.held_for ? formula.held_for(*state.held_for) : formula;
}

/// Recursion is bounded by the depth of the file.
State CommandBuilder::formula_of(const Part& owner, const StateParameters& state, const BuildContext& build) const {
  switch (state.kind) {
    case StateParameters::Kind::kCondition:
      return expression::state_of(state.condition, build.cell, build.biases);
    case StateParameters::Kind::kCommand:
      return command_state(named(owner, state.of).made.command, state.is);
    case StateParameters::Kind::kAction:
      return action_state(owner, state);
    case StateParameters::Kind::kActuator:
      return actuator_state(actuator_of(build.cell, state.of), state.is);
    case StateParameters::Kind::kRaised:
      return raised(owner, state.of).state();
    case StateParameters::Kind::kNot:
      return !state_of(owner, state.operands.front(), build);
    default:
      break;
  }
  State result = state_of(owner, state.operands.front(), build);
  for (std::size_t i = 1; i < state.operands.size(); ++i) {
    const State operand = state_of(owner, state.operands[i], build);
    result = state.kind == StateParameters::Kind::kAll ? (result && operand) : (result || operand);
  }
  return result;
}

State CommandBuilder::action_state(const Part& owner, const StateParameters& state) const {
  const Part& part = named(owner, state.of);
  if (!part.made.action) {
    return State(
        expression::broken(Code::kInvalidValue, net::ValueType::kBoolean,
                           fmt::format("C8: '{}' is not an action, so it has no state '{}'", state.of, state.is),
                           "Use started, active, completed, stopped, cancelled of a command"));
  }
  if (state.is == "at_path") return part.made.action->at_path(state.share);
  if (state.is == "via_passed") return part.made.action->via_passed(state.index);
  return part.made.action->state(state.is);
}

// -- Captures --------------------------------------------------------------------------------------------------------

void CommandBuilder::add_captures(const Part& part, const BuildContext& build) {
  Command command = part.made.command;
  for (const CaptureParameters& capture : part.request->transaction()->captures) {
    const std::string name = capture_name(part.key, capture.name);
    places_.emplace_back(part.key + "/observations" + pointer_segment(name), capture.pointer);
    const auto keep = [&](const auto& sensor) {
      if (capture.when) {
        command.capture(name, sensor, state_of(part, *capture.when, build));
      } else {
        command.observe(name, sensor);
      }
    };
    const ValueParameters& value = capture.value;
    if (value.kind == ValueParameters::Kind::kProgress) {
      keep(progress_of(named(part, value.of)));
    } else if (is_boolean(value, build.cell)) {
      keep(expression::BooleanSensor(boolean_of(value, build.cell).node()));
    } else {
      keep(number_of(value, build.cell, build.biases));
    }
  }
}

Diagnostics CommandBuilder::in_file(const Diagnostics& diagnostics) const {
  Diagnostics result;
  for (Diagnostic diagnostic : diagnostics.list()) {
    diagnostic.hint = in_words_of_files(std::move(diagnostic.hint));
    for (const auto& [path, pointer] : places_) {
      const bool below = diagnostic.pointer.starts_with(path + "/");
      if (diagnostic.pointer != path && !below) continue;
      diagnostic.pointer = pointer + diagnostic.pointer.substr(path.size());
      break;
    }
    result.add(std::move(diagnostic));
  }
  return result;
}

}  // namespace takt::operations
