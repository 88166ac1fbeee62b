// schema: what files may hold, from the tables that read them.
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/table/schema.h"
#include "scenario/schema.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Files by what they hold.
constexpr std::pair<const char*, Json (*)()> kForms[] = {{"scenario", scenario::scenario_schema}};

int schema(const std::string& form, const Common& common) {
  std::vector<std::string> names;
  for (const auto& [name, print] : kForms) {
    names.emplace_back(name);
    if (name != form) continue;
    fmt::print("{}", table::page_of(print()));
    return kHeld;
  }
  Diagnostics diagnostics;
  diagnostics.error(Code::kUnknownName, "", fmt::format("there is no schema '{}'", form),
                    nearest_choice(form, names, 30));
  return report(diagnostics, common);
}

}  // namespace

std::pair<CLI::App*, Verb> add_schema(CLI::App& app, Common& common) {
  auto form = std::make_shared<std::string>("scenario");
  CLI::App* verb = app.add_subcommand("schema", "Print the JSON Schema of a kind of file");
  verb->add_option("FILES", *form, "scenario");
  return {verb, [form, &common] { return schema(*form, common); }};
}

}  // namespace takt::tools
