#include "core/operations/command_request.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/base/read_parts.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using Kind = command::Effect::Kind;

// -- Event handlers --------------------------------------------------------------------------------------------------

/// One name, or several.
void read_effects(ObjectReader& reader, const char* key, Kind kind, HandlerRequest& handler) {
  const Json* given = reader.child(key);
  if (given == nullptr) return;
  const Json& json = *given;
  const std::string pointer = reader.at(key);
  if (json.is_string()) return handler.effects.push_back({kind, json.get<std::string>(), pointer});
  if (!json.is_array() || json.empty() || kind == Kind::kExternal) {
    return reader.diagnostics().error(Code::kWrongType, pointer, "unexpected value " + short_dump(json),
                                      kind == Kind::kExternal ? "a text" : "a name, or several as an array");
  }
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string place = pointer + pointer_segment(i);
    if (json[i].is_string()) {
      handler.effects.push_back({kind, json[i].get<std::string>(), place});
    } else {
      reader.diagnostics().error(Code::kWrongType, place, "unexpected value " + short_dump(json[i]), "a name");
    }
  }
}

HandlerRequest read_handler(const Json& json, const std::string& pointer, const command::Cell& cell,
                            Diagnostics& diagnostics) {
  HandlerRequest handler;
  handler.pointer = pointer;
  ObjectReader reader(json, pointer, diagnostics);
  if (!json.is_object()) return handler;
  if (reader.has("entered") == reader.has("left")) {
    diagnostics.error(Code::kMissing, pointer, "exactly one event is needed", "'entered' or 'left' with a state");
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
                      "at least one of start, stop, cancel, raise, tell");
  }
  handler.trigger.delay = reader.number("after_s", 0.0, {.low = 0.0, .high = 3600.0});
  handler.trigger.first_only = reader.boolean("first_only", false);
  reader.finish();
  return handler;
}

std::vector<HandlerRequest> read_handlers(const Json& json, const std::string& pointer, const command::Cell& cell,
                                          Diagnostics& diagnostics) {
  std::vector<HandlerRequest> handlers;
  if (!json.is_array()) {
    diagnostics.error(Code::kWrongType, pointer, "unexpected value " + short_dump(json), "an array of event handlers");
    return handlers;
  }
  for (std::size_t i = 0; i < json.size(); ++i)
    handlers.push_back(read_handler(json[i], pointer + pointer_segment(i), cell, diagnostics));
  return handlers;
}

// -- Commands --------------------------------------------------------------------------------------------------------

/// Only its form counts: it stands for a command that could not be read, and such a program is never run.
class Unread final : public CommandRequest {
 public:
  [[nodiscard]] MadeCommand make(const BuildContext&, const std::string&) const override {
    return {command::WaitCommand(name, 0.0)};
  }
};

/// What does not belong to its kind is taken out before the kind reads it.
std::unique_ptr<CommandRequest> read_one(const Json& json, const std::string& pointer, const command::Cell& cell,
                                         Diagnostics& diagnostics) {
  Diagnostics unheard;
  ObjectReader reader(json, pointer, json.is_object() ? unheard : diagnostics);
  if (!json.is_object()) return std::make_unique<Unread>();
  const std::string word = reader.text("do", "");
  const auto kind = std::ranges::find(command_kinds(), word, &CommandKind::name);
  if (kind == command_kinds().end()) {
    std::vector<std::string> names;
    for (const CommandKind& one : command_kinds()) names.emplace_back(one.name);
    diagnostics.error(Code::kUnknownName, pointer + "/do",
                      word.empty() ? "'do' is missing" : fmt::format("there is no command '{}'", word),
                      nearest_choice(word, names, 20));
    return std::make_unique<Unread>();
  }
  Json own = json;
  for (const char* key : {"start", "on"}) own.erase(key);
  auto request = kind->read(own, pointer, cell, diagnostics);
  request->pointer = pointer;
  request->name = word;
  if (json.contains("on")) request->handlers = read_handlers(json.at("on"), pointer + "/on", cell, diagnostics);
  return request;
}

std::unique_ptr<CommandRequest> read_part(const std::string& name, const Json& json, const std::string& pointer,
                                          const command::Cell& cell, Diagnostics& diagnostics) {
  auto request = read_one(json, pointer, cell, diagnostics);
  request->name = name;
  if (name.empty() || name.find('/') != std::string::npos) {
    diagnostics.error(Code::kInvalidName, pointer, fmt::format("a command named '{}'", name),
                      "a name that is not empty and has no '/'");
  }
  if (!json.is_object()) return request;
  if (json.contains("name")) {
    diagnostics.error(Code::kDuplicate, pointer + "/name",
                      fmt::format("a second name: {}", short_dump(json.at("name"))),
                      fmt::format("'{}' is its name", name));
  }
  Diagnostics unheard;
  ObjectReader reader(json, pointer, json.contains("start") ? diagnostics : unheard);
  request->starts = reader.boolean("start", false);
  return request;
}

/// A transaction is made by who makes the tree (command_builder.h).
class Transaction final : public CommandRequest {
 public:
  Transaction() { transaction_ = std::make_unique<TransactionRequest>(); }
  [[nodiscard]] MadeCommand make(const BuildContext&, const std::string&) const override {
    return {command::TransactionCommand(name)};
  }
  TransactionRequest& own() { return *transaction_; }
  std::vector<std::unique_ptr<CommandRequest>>& own_parts() { return parts_; }
};

void read_captures(ObjectReader& reader, const command::Cell& cell, TransactionRequest& transaction) {
  const Json* json = reader.object("capture", false);
  if (!json) return;
  for (const auto& [name, capture] : json->items()) {
    const std::string pointer = reader.at("capture") + pointer_segment(name);
    ObjectReader one(capture, pointer, reader.diagnostics());
    if (!capture.is_object()) continue;
    CaptureRequest request{.name = name, .pointer = pointer, .value = {}, .when = {}};
    if (const Json* value = one.object("value"))
      request.value = read_value(*value, one.at("value"), cell, reader.diagnostics());
    if (const Json* when = one.object("when", false))
      request.when = read_state(*when, one.at("when"), cell, reader.diagnostics());
    one.finish();
    transaction.captures.push_back(std::move(request));
  }
}

void read_on_cancel(ObjectReader& reader, TransactionRequest& transaction) {
  const Json* json = reader.child("on_cancel");
  if (json != nullptr && json->is_array()) {
    transaction.on_cancel = TransactionRequest::OnCancel::kForwardTo;
    transaction.forward_to = reader.texts("on_cancel");
  } else if (reader.choice("on_cancel", {"forward", "ignore"}, "forward") == "ignore") {
    transaction.on_cancel = TransactionRequest::OnCancel::kIgnore;
  }
}

// -- Names -----------------------------------------------------------------------------------------------------------

/// What names mean: all of them are known once the whole tree is read.
class NameCheck {
 public:
  NameCheck(const CommandRequest& root, Diagnostics& diagnostics) : root_(root), diagnostics_(diagnostics) {}

  void run() {
    for (const CommandRequest* command : root_.all()) {
      for (const HandlerRequest& handler : command->handlers) check_handler(*command, handler);
      if (!command->follows().empty())
        check_command(*command, command->follows(), command->pointer + "/value/progress");
      if (command->transaction() == nullptr) continue;
      for (const CaptureRequest& capture : command->transaction()->captures) {
        if (capture.value.kind == ValueRequest::Kind::kProgress)
          check_command(*command, capture.value.of, capture.pointer + "/value/progress");
        if (capture.when) check_state(*command, *capture.when);
      }
      for (std::size_t i = 0; i < command->transaction()->forward_to.size(); ++i) {
        check_command(*command, command->transaction()->forward_to[i],
                      command->pointer + "/on_cancel" + pointer_segment(i));
      }
    }
  }

 private:
  void check_handler(const CommandRequest& owner, const HandlerRequest& handler) {
    check_state(owner, handler.state);
    for (const HandlerRequest::Effect& effect : handler.effects) {
      if (effect.kind == Kind::kExternal) {
        if (effect.name.empty()) diagnostics_.error(Code::kMissing, effect.pointer, "an empty text", "what is told");
      } else if (effect.kind == Kind::kRaise) {
        check_raised(owner, effect.name, effect.pointer);
      } else {
        check_command(owner, effect.name, effect.pointer);
      }
    }
  }

  void check_state(const CommandRequest& owner, const StateRequest& state) {
    for (const StateRequest& operand : state.operands) check_state(owner, operand);
    if (state.kind == StateRequest::Kind::kRaised) check_raised(owner, state.of, state.pointer + "/raised");
    if (state.kind == StateRequest::Kind::kCommand) check_command(owner, state.of, state.pointer + "/" + state.is);
    if (state.kind == StateRequest::Kind::kAction) check_command(owner, state.of, state.pointer + "/action");
  }

  void check_command(const CommandRequest& owner, const std::string& name, const std::string& pointer) {
    if (owner.find(name) != nullptr) return;
    std::vector<std::string> names;
    for (const CommandRequest* command : root_.all()) names.push_back(command->name);
    diagnostics_.error(Code::kUnknownName, pointer,
                       fmt::format("C6: there is no command '{}' in '{}'", name, root_.name),
                       nearest_choice(name, names));
  }

  void check_raised(const CommandRequest& owner, const std::string& name, const std::string& pointer) {
    if (owner.find_raised(name) != nullptr) return;
    std::vector<std::string> names;
    for (const CommandRequest* command : root_.all()) {
      if (command->transaction() == nullptr) continue;
      names.insert(names.end(), command->transaction()->raised.begin(), command->transaction()->raised.end());
    }
    const std::string nearest = names.empty() ? "" : nearest_choice(name, names) + "; ";
    diagnostics_.error(Code::kUnknownName, pointer, fmt::format("C10: no transaction has the raised state '{}'", name),
                       nearest + "'raised' of a transaction around this place");
  }

  const CommandRequest& root_;
  Diagnostics& diagnostics_;
};

}  // namespace

const std::vector<CommandKind>& command_kinds() {
  static const std::vector<CommandKind> kinds{
      {"circ", read_circ_command},       {"follow", read_follow_command},   {"grip", read_grip_command},
      {"hold", read_hold_command},       {"jog", read_jog_command},         {"lin", read_lin_command},
      {"motions", read_motions_command}, {"press", read_press_command},     {"ptp", read_ptp_command},
      {"release", read_release_command}, {"search", read_search_command},   {"set", read_set_command},
      {"spline", read_spline_command},   {"transaction", read_transaction}, {"wait", read_wait_command}};
  return kinds;
}

const std::vector<ParameterInfo>& transaction_parameter_list() {
  using Type = ParameterInfo::Type;
  static const auto list = [] {
    const auto row = [](const char* key, Type type, const char* definition, const char* doc) {
      ParameterInfo info{.key = key, .type = type, .definition = definition};
      info.doc = doc;
      return info;
    };
    std::vector<ParameterInfo> rows{
        row("commands", Type::kObject, "commands", "Commands by name: operations with 'start' and 'on'."),
        row("on", Type::kObject, "handlers", "Handlers of the transaction itself."),
        row("raised", Type::kTexts, "", "States that handlers may raise."),
        row("capture", Type::kObject, "captured", "Values that are kept under a name."),
        row("on_cancel", Type::kObject, "on_cancel",
            "Whom a cancel reaches: forward (all), ignore, or names of commands.")};
    rows.front().required = true;
    rows.back().fallback = "forward";
    return rows;
  }();
  return list;
}

std::unique_ptr<CommandRequest> read_transaction(const Json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics) {
  auto request = std::make_unique<Transaction>();
  ObjectReader reader(json, pointer, diagnostics);
  (void)reader.text("do");
  (void)read_name(reader, "");
  const Json* commands = reader.object("commands");
  if (commands != nullptr) {
    for (const auto& [name, command] : commands->items()) {
      auto part = read_part(name, command, reader.at("commands") + pointer_segment(name), cell, diagnostics);
      part->parent_ = request.get();
      request->own_parts().push_back(std::move(part));
    }
  }
  request->own().raised = reader.texts("raised", std::vector<std::string>{});
  read_captures(reader, cell, request->own());
  read_on_cancel(reader, request->own());
  reader.finish();
  return request;
}

std::unique_ptr<CommandRequest> read_command_step(const Json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics) {
  auto request = read_one(json, pointer, cell, diagnostics);
  if (!json.is_object()) return request;
  Diagnostics unheard;
  ObjectReader reader(json, pointer, unheard);
  request->name = read_name(reader, request->name);
  if (json.contains("start")) {
    diagnostics.error(Code::kConflict, pointer + "/start", "a step of its own has no 'start'",
                      "a command inside of a transaction");
  }
  NameCheck(*request, diagnostics).run();
  return request;
}

const CommandRequest* CommandRequest::find(std::string_view wanted) const {
  const auto slash = wanted.find('/');
  const std::string_view first = wanted.substr(0, slash);
  const CommandRequest* found = nullptr;
  for (const CommandRequest* at = this; at != nullptr && found == nullptr; at = at->parent_) {
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

const CommandRequest* CommandRequest::find_raised(const std::string& state) const {
  const auto has = [&](const CommandRequest& command) {
    return command.transaction_ &&
           std::ranges::find(command.transaction_->raised, state) != command.transaction_->raised.end();
  };
  const CommandRequest* root = this;
  for (const CommandRequest* at = this; at != nullptr; at = at->parent_) {
    if (has(*at)) return at;
    root = at;
  }
  for (const CommandRequest* command : root->all()) {
    if (has(*command)) return command;
  }
  return nullptr;
}

std::vector<const CommandRequest*> CommandRequest::all() const {
  std::vector<const CommandRequest*> commands{this};
  for (std::size_t i = 0; i < commands.size(); ++i) {
    for (const auto& part : commands[i]->parts_) commands.push_back(part.get());
  }
  return commands;
}

}  // namespace takt::activity
