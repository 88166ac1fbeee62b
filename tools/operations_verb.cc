// operations: what a program can ask for, from the tables of parameters.
#include <algorithm>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/operations/table/operation.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using operations::Operation;
using operations::ParameterInfo;

/// "required", "default 0.05", or "optional".
std::string default_text(const ParameterInfo& one) {
  if (one.required) return "required";
  return one.fallback.empty() ? "optional" : "default " + one.fallback;
}

void print_parameters(const std::vector<ParameterInfo>& parameters, std::size_t indent) {
  std::size_t width = 0;
  for (const ParameterInfo& one : parameters) width = std::max(width, one.key.size());
  for (const ParameterInfo& one : parameters) {
    if (one.refused) continue;
    fmt::print("{:{}}{:<{}}  {} ({}; {})\n", "", indent, one.key, width, one.doc, describe_type(one),
               default_text(one));
    print_parameters(one.fields, indent + 4);
  }
}

void print_operation(const Operation& operation) {
  fmt::print("{}\n  {}\n\n", operation.name, operation.doc);
  print_parameters(operation.parameters(), 2);
}

void print_list(const std::vector<const Operation*>& operations) {
  std::size_t width = 0;
  for (const Operation* operation : operations) width = std::max(width, operation->name.size());
  for (const Operation* operation : operations) fmt::print("{:<{}}  {}\n", operation->name, width, operation->doc);
}

// -- The page of the documentation ------------------------------------------------------------------------------------

/// What a type is called on the page; objects have a section of their own.
std::string linked_type(const ParameterInfo& one) {
  return one.fields.empty() ? describe_type(one) : fmt::format("[{0}](#{0})", one.definition);
}

void print_table(const std::vector<ParameterInfo>& parameters) {
  fmt::print("\n| key | type | default | meaning |\n|---|---|---|---|\n");
  for (const ParameterInfo& one : parameters) {
    if (!one.refused) fmt::print("| `{}` | {} | {} | {} |\n", one.key, linked_type(one), default_text(one), one.doc);
  }
}

/// Objects that operations have as parameters, each once.
void collect_objects(const std::vector<ParameterInfo>& parameters,
                     std::map<std::string, const std::vector<ParameterInfo>*>& objects) {
  for (const ParameterInfo& one : parameters) {
    if (!one.fields.empty()) objects.try_emplace(one.definition, &one.fields);
    collect_objects(one.fields, objects);
  }
}

void print_page(const std::vector<const Operation*>& operations) {
  fmt::print(
      "# Reference of operations\n\n"
      "This page is printed by `takt operations --markdown` from the tables of parameters "
      "([operations.md](operations.md)); a test keeps it\nup to date. Every operation also has `do` (its name here) "
      "and "
      "`name` (for people).\n");
  std::map<std::string, const std::vector<ParameterInfo>*> objects;
  for (const Operation* operation : operations) {
    fmt::print("\n## {}\n{}\n", operation->name, operation->doc);
    print_table(operation->parameters());
    collect_objects(operation->parameters(), objects);
  }
  fmt::print("\n# Objects\nParameters with parameters of their own.\n");
  for (const auto& [name, fields] : objects) {
    fmt::print("\n## {}\n", name);
    print_table(*fields);
  }
}

// -- For programs -----------------------------------------------------------------------------------------------------

Json describe(const std::vector<ParameterInfo>& parameters) {
  Json list = Json::array();
  for (const ParameterInfo& one : parameters) {
    if (one.refused) continue;
    Json json{{"key", one.key},
              {"type", describe_type(one)},
              {"unit", one.unit},
              {"required", one.required},
              {"default", one.fallback.empty() ? Json() : Json(one.fallback)},
              {"doc", one.doc}};
    if (!one.choices.empty()) json["choices"] = one.choices;
    if (!one.fields.empty()) json["fields"] = describe(one.fields);
    list.push_back(std::move(json));
  }
  return list;
}

struct Arguments {
  std::string name;
  bool markdown = false;
};

int operations(const Arguments& arguments, const Common& common) {
  std::vector<const Operation*> chosen;
  std::vector<std::string> names;
  for (const Operation& operation : operations::Operations::global().all()) {
    names.emplace_back(operation.name);
    if (arguments.name.empty() || arguments.name == operation.name) chosen.push_back(&operation);
  }
  if (chosen.empty()) {
    Diagnostics diagnostics;
    diagnostics.error(Code::kUnknownName, "", fmt::format("there is no operation '{}'", arguments.name),
                      nearest_choice(arguments.name, names, 30));
    return report(diagnostics, common);
  }
  if (common.json) {
    Json list = Json::array();
    for (const Operation* operation : chosen)
      list.push_back(
          {{"name", operation->name}, {"doc", operation->doc}, {"parameters", describe(operation->parameters())}});
    print({{"operations", list}});
  } else if (arguments.markdown) {
    print_page(chosen);
  } else if (arguments.name.empty()) {
    print_list(chosen);
  } else {
    print_operation(*chosen.front());
  }
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_operations(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* verb = app.add_subcommand("operations", "Print the operations of programs with their parameters");
  verb->add_option("NAME", arguments->name, "One operation with its parameters");
  verb->add_flag("--markdown", arguments->markdown, "As a page: docs/operations-reference.md");
  return {verb, [arguments, &common] { return operations(*arguments, common); }};
}

}  // namespace takt::tools
