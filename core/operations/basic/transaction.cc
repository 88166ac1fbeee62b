#include "core/operations/basic/transaction.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/base/read_parts.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;

std::unique_ptr<OperationCommand> read_part(const std::string& name, const OperationSource& source) {
  auto part = read_any_command(source);
  part->name = name;
  if (name.empty() || name.find('/') != std::string::npos) {
    source.diagnostics.error(Code::kInvalidName, source.pointer, fmt::format("a command named '{}'", name),
                             "Choose a name that is not empty and has no '/'");
  }
  if (!source.json.is_object()) return part;
  if (source.json.contains("name")) {
    source.diagnostics.error(Code::kDuplicate, source.pointer + "/name",
                             fmt::format("a second name: {}", short_dump(source.json.at("name"))),
                             fmt::format("Remove it: '{}' is its name", name));
  }
  Diagnostics ignored;
  ObjectReader reader(source.json, source.pointer, source.json.contains("start") ? source.diagnostics : ignored);
  part->starts = reader.boolean("start", false);
  return part;
}

/// A transaction is made by who makes the tree (command_builder.h).
class Transaction final : public OperationCommand {
 public:
  Transaction() { transaction_ = std::make_unique<TransactionParameters>(); }
  [[nodiscard]] MadeCommand make(const BuildContext&, const std::string&) const override {
    return {command::TransactionCommand(name)};
  }
  TransactionParameters& own() { return *transaction_; }
  void add(std::unique_ptr<OperationCommand> part) { adopt(std::move(part)); }
};

void read_captures(ObjectReader& reader, const expression::Cell& cell, TransactionParameters& transaction) {
  const Json* json = reader.object("capture", false);
  if (!json) return;
  for (const auto& [name, capture] : json->items()) {
    const std::string pointer = reader.at("capture") + pointer_segment(name);
    ObjectReader one(capture, pointer, reader.diagnostics());
    if (!capture.is_object()) continue;
    CaptureParameters captured{.name = name, .pointer = pointer, .value = {}, .when = {}, .rate = {}};
    if (const Json* value = one.object("value"))
      captured.value = read_value(*value, one.at("value"), cell, reader.diagnostics());
    if (const Json* when = one.object("when", false))
      captured.when = read_state(*when, one.at("when"), cell, reader.diagnostics());
    if (one.has("rate_Hz")) captured.rate = one.number("rate_Hz", {}, {.low = 0.0, .high = 1000.0, .low_open = true});
    if (captured.rate && captured.when)
      reader.diagnostics().error(Code::kConflict, one.at("rate_Hz"), "a rate for a value that is captured once",
                                 "Give 'rate_Hz', or 'when'");
    one.finish();
    transaction.captures.push_back(std::move(captured));
  }
}

void read_on_cancel(ObjectReader& reader, TransactionParameters& transaction) {
  const Json* json = reader.child("on_cancel");
  if (json != nullptr && json->is_array()) {
    transaction.on_cancel = TransactionParameters::OnCancel::kForwardTo;
    transaction.forward_to = reader.texts("on_cancel");
  } else if (reader.choice("on_cancel", {"forward", "ignore"}, "forward") == "ignore") {
    transaction.on_cancel = TransactionParameters::OnCancel::kIgnore;
  }
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
        row("capture", Type::kObject, "captures", "Values that are kept under a name."),
        row("on_cancel", Type::kObject, "on_cancel",
            "Whom a cancel reaches: forward (all), ignore, or names of commands.")};
    rows.front().required = true;
    rows.back().fallback = "forward";
    return rows;
  }();
  return list;
}

std::unique_ptr<OperationCommand> read_transaction(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  auto transaction = std::make_unique<Transaction>();
  ObjectReader reader(json, pointer, diagnostics);
  (void)reader.text("do");
  (void)read_name(reader, "");
  const Json* commands = reader.object("commands");
  if (commands != nullptr) {
    for (const auto& [name, command] : commands->items()) {
      const std::string place = reader.at("commands") + pointer_segment(name);
      transaction->add(read_part(name, {command, place, cell, diagnostics}));
    }
  }
  transaction->own().raised = reader.texts("raised", std::vector<std::string>{});
  read_captures(reader, cell, transaction->own());
  read_on_cancel(reader, transaction->own());
  reader.finish();
  return transaction;
}

}  // namespace

Operation transaction_operation() {
  return {.name = "transaction",
          .doc = "Runs commands in one real-time context, with handlers for events.",
          .parameters = transaction_parameter_list,
          .read_step = step_of_command,
          .read_command = read_transaction};
}

}  // namespace takt::operations
