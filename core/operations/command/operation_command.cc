#include "core/operations/command/operation_command.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/base/read_parts.h"
#include "core/kinematics/chain.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using Kind = command::Effect::Kind;

// -- Event handlers --------------------------------------------------------------------------------------------------

/// One name, or several.
void read_effects(ObjectReader& reader, const char* key, Kind kind, HandlerParameters& handler) {
  const Json* given = reader.child(key);
  if (given == nullptr) return;
  const Json& json = *given;
  const std::string pointer = reader.at(key);
  if (json.is_string()) return handler.effects.push_back({kind, json.get<std::string>(), pointer});
  if (!json.is_array() || json.empty() || kind == Kind::kExternal) {
    return reader.diagnostics().error(Code::kWrongType, pointer, "unexpected value " + short_dump(json),
                                      kind == Kind::kExternal ? "Give a text" : "Give a name, or several as an array");
  }
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string place = pointer + pointer_segment(i);
    if (json[i].is_string()) {
      handler.effects.push_back({kind, json[i].get<std::string>(), place});
    } else {
      reader.diagnostics().error(Code::kWrongType, place, "unexpected value " + short_dump(json[i]), "Give it a name");
    }
  }
}

HandlerParameters read_handler(const Json& json, const std::string& pointer, const expression::Cell& cell,
                               Diagnostics& diagnostics) {
  HandlerParameters handler;
  handler.pointer = pointer;
  ObjectReader reader(json, pointer, diagnostics);
  if (!json.is_object()) return handler;
  if (reader.has("entered") == reader.has("left")) {
    diagnostics.error(Code::kMissing, pointer, "exactly one event is needed", "Give 'entered' or 'left' with a state");
  }
  handler.entered = !reader.has("left");
  for (const char* key : {"entered", "left"}) {
    if (const Json* state = reader.child(key)) handler.state = read_state(*state, reader.at(key), cell, diagnostics);
  }
  read_effects(reader, "start", Kind::kStart, handler);
  read_effects(reader, "stop", Kind::kStop, handler);
  read_effects(reader, "cancel", Kind::kCancel, handler);
  read_effects(reader, "raise", Kind::kRaise, handler);
  read_effects(reader, "tell", Kind::kExternal, handler);
  if (handler.effects.empty()) {
    diagnostics.error(Code::kMissing, pointer, "the event handler has no effect",
                      "Give at least one of start, stop, cancel, raise, tell");
  }
  handler.trigger.delay = reader.number("after_s", 0.0, {.low = 0.0, .high = 3600.0});
  handler.trigger.first_only = reader.boolean("first_only", false);
  reader.finish();
  return handler;
}

std::vector<HandlerParameters> read_handlers(const Json& json, const std::string& pointer, const expression::Cell& cell,
                                             Diagnostics& diagnostics) {
  std::vector<HandlerParameters> handlers;
  if (!json.is_array()) {
    diagnostics.error(Code::kWrongType, pointer, "unexpected value " + short_dump(json),
                      "Give an array of event handlers");
    return handlers;
  }
  for (std::size_t i = 0; i < json.size(); ++i)
    handlers.push_back(read_handler(json[i], pointer + pointer_segment(i), cell, diagnostics));
  return handlers;
}

/// Only its form counts: it replaces a command that could not be read, and such a program is never run.
class Unread final : public OperationCommand {
 public:
  [[nodiscard]] MadeCommand make(const BuildContext&, const std::string&) const override {
    return {command::WaitCommand(name, 0.0)};
  }
};

}  // namespace

std::unique_ptr<OperationCommand> read_any_command(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  Diagnostics ignored;
  ObjectReader reader(json, pointer, json.is_object() ? ignored : diagnostics);
  if (!json.is_object()) return std::make_unique<Unread>();
  const std::string type = reader.text("do", "");
  const Operation* operation = Operations::global().find(type);
  if (operation == nullptr || operation->read_command == nullptr) {
    diagnostics.error(type.empty() ? Code::kMissing : Code::kUnknownName, pointer + "/do",
                      type.empty() ? "'do' is missing" : fmt::format("there is no command '{}'", type),
                      nearest_choice(type, Operations::global().command_types(), 20));
    return std::make_unique<Unread>();
  }
  Json own = json;  // what every command has is removed before its type reads it
  for (const char* key : {"start", "on"}) own.erase(key);
  auto command = operation->read_command({own, pointer, cell, diagnostics});
  command->pointer = pointer;
  command->name = type;
  if (json.contains("on")) command->handlers = read_handlers(json.at("on"), pointer + "/on", cell, diagnostics);
  return command;
}

nlohmann::ordered_json OperationCommand::left_steps() const { return Json::array(); }

MadeCommand OperationCommand::made(const BuildContext& build, const std::string& key) const {
  MadeCommand made = make(build, key);
  if (!abort_if_) return made;
  activity::add_abort(made.command, expression::state_of(*abort_if_, build.cell, build.biases), key);
  made.handler_places.emplace_back("/abort_if");
  return made;
}

MadeCommand OperationCommand::on_actuator(const command::Actuator& actuator, const command::Action& action) const {
  if (!compliance_)
    return {.command = command::RuntimeCommand(name, actuator, action), .action = action, .actuator = actuator};
  const auto arms = actuator.model().compliant_arms();
  const int joints = arms.empty() ? 0 : arms.front()->device->description().chain->joint_count();
  const command::Action compliant = with_compliance(action, compliance_of(*compliance_, joints));
  return {.command = command::RuntimeCommand(name, actuator, compliant),
          .action = compliant,
          .actuator = actuator,
          .places = places_of(*compliance_)};
}

void OperationCommand::report(const activity::RunView& ended, const std::string& key, bool cancelled,
                              activity::Context& context, Diagnostics& diagnostics) const {
  diagnostics.append(activity::abort_diagnostics(ended, key), pointer);
  finish(ended, key, cancelled, context, diagnostics);
}

const OperationCommand* OperationCommand::find(std::string_view wanted) const {
  const auto slash = wanted.find('/');
  const std::string_view first = wanted.substr(0, slash);
  const OperationCommand* found = nullptr;
  for (const OperationCommand* at = this; at != nullptr && found == nullptr; at = at->parent_) {
    for (const auto& part : at->parts_) {
      if (part->name == first) found = part.get();
    }
    if (found == nullptr && at->name == first) found = at;
  }
  if (found == nullptr || slash == std::string_view::npos) return found;
  // Below a name only what is directly inside counts.
  const std::string_view rest = wanted.substr(slash + 1);
  const std::string_view next = rest.substr(0, rest.find('/'));
  const bool inside = std::ranges::any_of(found->parts_, [&](const auto& part) { return part->name == next; });
  return inside ? found->find(rest) : nullptr;
}

const OperationCommand* OperationCommand::find_raised(const std::string& state) const {
  const auto has = [&](const OperationCommand& command) {
    return command.transaction_ &&
           std::ranges::find(command.transaction_->raised, state) != command.transaction_->raised.end();
  };
  const OperationCommand* root = this;
  for (const OperationCommand* at = this; at != nullptr; at = at->parent_) {
    if (has(*at)) return at;
    root = at;
  }
  for (const OperationCommand* command : root->all()) {
    if (has(*command)) return command;
  }
  return nullptr;
}

std::vector<const OperationCommand*> OperationCommand::all() const {
  std::vector<const OperationCommand*> commands{this};
  for (std::size_t i = 0; i < commands.size(); ++i) {
    for (const auto& part : commands[i]->parts_) commands.push_back(part.get());
  }
  return commands;
}

}  // namespace takt::operations
