// schema: what the tables of the process say of scenario files, plug-ins included (docs/tables.md).
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/faults/faults.h"
#include "cell/judge/expectations.h"
#include "core/operations/table/operation.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using operations::Operation;
using operations::ParameterInfo;

Json reference(std::string_view definition) { return {{"$ref", fmt::format("#/definitions/{}", definition)}}; }

/// One operation without what concerns several keys at once.
Json schema_of_operation(const Operation& operation) {
  Json properties{{"do", true}, {"name", true}}, required = Json::array();
  if (operation.read_command != nullptr) {
    properties["start"] = reference("starts");
    properties["on"] = reference("handlers");
  }
  for (const ParameterInfo& one : operation.parameters()) {
    if (one.refused) continue;
    properties[one.key] = schema_of(one);
    if (one.required) required.push_back(one.key);
  }
  Json schema{{"description", operation.doc}};
  if (!required.empty()) schema["required"] = required;
  schema["additionalProperties"] = false;
  schema["patternProperties"] = {{R"(^(\$.*|comment)$)", true}};
  schema["properties"] = properties;
  return schema;
}

/// One definition per operation, which of them are steps and which are commands, and which definition holds for which
/// value of "do".
Json operation_definitions() {
  Json definitions = Json::object(), steps = Json::array(), commands = Json::array(), chosen = Json::array();
  for (const Operation& operation : operations::Operations::global().all()) {
    definitions[std::string(operation.name)] = schema_of_operation(operation);
    if (operation.read_step != nullptr) steps.push_back(operation.name);
    if (operation.read_command != nullptr) commands.push_back(operation.name);
    chosen.push_back(
        {{"if", {{"properties", {{"do", {{"const", operation.name}}}}}}}, {"then", reference(operation.name)}});
  }
  definitions["step_operations"] = {{"enum", steps}};
  definitions["command_operations"] = {{"enum", commands}};
  definitions["operation_parameters"] = {{"allOf", chosen}};
  return definitions;
}

int schema() {
  Json definitions = operation_definitions();
  definitions["expectation"] = cell::expectation_schema();
  definitions["fault"] = cell::fault_schema();
  fmt::print("{}\n", Json{{"definitions", definitions}}.dump(2));
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_schema(CLI::App& app, Common&) {
  return {app.add_subcommand("schema", "Print the definitions of the schema of scenario files that tables describe"),
          schema};
}

}  // namespace takt::tools
