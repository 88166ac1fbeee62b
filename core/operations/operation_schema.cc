#include "core/operations/operation_schema.h"

#include <nlohmann/json.hpp>

#include "core/operations/operation.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// Keys that every operation has, and those of commands.
std::vector<ParameterInfo> keys_of(const Operation& operation) {
  constexpr auto kAny = ParameterInfo::Type::kAny;
  std::vector<ParameterInfo> keys{table::field("do", kAny, {}), table::field("name", kAny, {})};
  if (operation.read_command != nullptr) {
    for (const char* key : {"start", "on"}) {
      keys.push_back(table::field(key, ParameterInfo::Type::kObject, {}));
      keys.back().definition = key == std::string_view("on") ? "handlers" : "starts";
    }
  }
  keys.insert(keys.end(), operation.parameters().fields.begin(), operation.parameters().fields.end());
  return keys;
}

Json schema_of_operation(const Operation& operation, table::SchemaPrinter& schema) {
  ParameterInfo whole = table::field({}, ParameterInfo::Type::kObject, {});
  whole.fields = keys_of(operation);
  whole.rules = operation.parameters().rules;
  Json body{{"description", operation.doc}};
  body.update(schema.object_of(whole));
  return body;
}

}  // namespace

void define_operations(table::SchemaPrinter& schema) {
  Json steps = Json::array(), commands = Json::array(), chosen = Json::array();
  for (const Operation& operation : Operations::global().all()) {
    const std::string name(operation.name);
    schema.define(name, schema_of_operation(operation, schema));
    if (operation.read_step != nullptr) steps.push_back(name);
    if (operation.read_command != nullptr) commands.push_back(name);
    chosen.push_back({{"if", {{"properties", {{"do", {{"const", name}}}}}}}, {"then", table::reference_to(name)}});
  }
  schema.define("step_operations", {{"enum", std::move(steps)}});
  schema.define("command_operations", {{"enum", std::move(commands)}});
  schema.define("operation_parameters", {{"allOf", std::move(chosen)}});
}

}  // namespace takt::activity
