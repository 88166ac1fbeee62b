// schema: JSON Schemas of files, as the tables of the process say, plug-ins included (docs/tables.md).
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/build/device_kind_registry.h"
#include "cell/faults/faults.h"
#include "cell/file/forms.h"
#include "cell/judge/expectations.h"
#include "core/device/material.h"
#include "core/operations/table/operation.h"
#include "core/program/tree/node.h"
#include "core/program/tree/node_forms.h"
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

Json file_schema(const char* title, const Form& form, Json definitions) {
  SchemaWriter writer(definitions);
  Json schema{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title}};
  schema.update(writer.schema_of(form));
  if (!definitions.empty()) schema["definitions"] = std::move(definitions);
  return schema;
}

/// Steps of programs: nodes and operations.
void add_steps(Json& definitions) {
  SchemaWriter writer(definitions);
  Json nodes = Json::array(), chosen = Json::array();
  for (const program::NodeKind& kind : program::node_kinds()) {
    nodes.push_back(kind.name);
    chosen.push_back(
        {{"if", {{"properties", {{"do", {{"const", kind.name}}}}}}}, {"then", writer.reference_to(kind.form.get())}});
  }
  chosen.push_back(reference("operation_parameters"));
  (void)writer.reference_to(program::sub_program_form());
  const Form step{
      .doc = "",
      .keys = {
          any_key("do", "", "Step type."),
          text_key("name",
                   "Name in the film, in progress and in diagnostics; film/cuts and the expectation 'step' refer to "
                   "it. Names may repeat.")
              .optional("the step type")}};
  Json schema = writer.schema_of(step);
  schema.erase("additionalProperties");  // they depend on "do"
  schema.erase("patternProperties");
  schema["properties"]["do"]["anyOf"] = Json::array({{{"enum", nodes}}, reference("step_operations")});
  schema["allOf"] = chosen;
  definitions["step"] = std::move(schema);
}

Json scenario_schema() {
  Json definitions = operation_definitions();
  add_steps(definitions);
  SchemaWriter writer(definitions);
  (void)writer.reference_to(cell::expectation_form());
  (void)writer.reference_to(cell::fault_form());
  Json settings = Json::array();
  for (const std::string& kind : cell::DeviceKinds::global().names())
    if (const Form& form = cell::DeviceKinds::global().find(kind)->settings(); !form.keys.empty() || form.others)
      settings.push_back(writer.reference_to(form));
  definitions["device_settings"] = {{"description", "As the kind of the device says."}, {"anyOf", settings}};
  return file_schema("takt scenario", cell::scenario_form().form(), std::move(definitions));
}

struct PrintedFile {
  const char* name;
  Json (*schema)();
};
constexpr PrintedFile kFiles[] = {
    {"scenario", scenario_schema},
    {"site", [] { return file_schema("takt site", cell::site_form().form(), Json::object()); }},
    {"materials", [] { return file_schema("takt materials", device::materials_form(), Json::object()); }}};

int schema(const std::string& file) {
  fmt::print("{}\n", std::ranges::find(kFiles, file, &PrintedFile::name)->schema().dump(2));
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_schema(CLI::App& app, Common&) {
  CLI::App* verb = app.add_subcommand("schema", "Print the JSON Schema of a kind of file");
  const auto file = std::make_shared<std::string>("scenario");
  std::vector<std::string> names;
  for (const PrintedFile& kind : kFiles) names.emplace_back(kind.name);
  verb->add_option("FILE", *file, "Kind of file")->check(CLI::IsMember(names))->capture_default_str();
  return {verb, [file] { return schema(*file); }};
}

}  // namespace takt::tools
