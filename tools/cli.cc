#include "tools/cli.h"

#include <algorithm>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/file/data_folder.h"
#include "core/base/text_location.h"
#include "core/base/version.h"
#include "core/plugin/load.h"
#include "hw/drivers.h"

namespace takt::tools {
namespace {

constexpr AddVerb kVerbs[] = {add_run,     add_validate,   add_verify,     add_compare, add_bless,   add_render,
                              add_net,     add_operations, add_primitives, add_model,   add_new,     add_list,
                              add_emulate, add_doctor,     add_events,     add_export,  add_recover, add_replay,
                              add_schema,  add_serve,      add_chart,      add_sweep};

/// A usage error in the form of every other diagnostic.
int report_usage(const CLI::App& app, const CLI::ParseError& error, const Common& common) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  Diagnostics diagnostics;
  diagnostics.error(Code::kUsage, "", error.what(), "See takt --help, or takt VERB --help");
  return report(diagnostics, common);
}

/// A first word that is no verb, with the nearest one; empty if it is one, or an option.
Diagnostics check_verb(const CLI::App& app, int argc, char** argv) {
  Diagnostics diagnostics;
  if (argc < 2 || argv[1][0] == '-') return diagnostics;
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  if (std::ranges::find(names, argv[1]) != names.end()) return diagnostics;
  diagnostics.error(Code::kUnknownName, "", fmt::format("there is no verb '{}'", argv[1]),
                    nearest_choice(argv[1], names));
  return diagnostics;
}

/// Loads the plug-ins, so that every verb knows what they bring. All that is wrong is said at once.
Diagnostics load_plugins(const Common& common) {
  Diagnostics diagnostics;
  for (const std::string& file : common.plugins) {
    if (const auto loaded = plugin::load(file); !loaded) diagnostics.append(loaded.error());
  }
  return diagnostics;
}

}  // namespace

device::ModelLibrary Common::library() const {
  std::vector<std::filesystem::path> paths(models.begin(), models.end());
  paths.push_back(root / "models");
  return device::ModelLibrary(std::move(paths));
}

void print(const nlohmann::ordered_json& json) { fmt::print("{}", cell::to_output_text(json)); }

int report(const Diagnostics& diagnostics, const Common& common) {
  fmt::print(stderr, "{}", to_located_text(diagnostics));
  if (common.json) print({{"result", "error"}, {"diagnostics", to_json(diagnostics)}});
  return kBadInput;
}

namespace {

int run(int argc, char** argv) {
  Common common;
  common.root = cell::data_folder();
  CLI::App app{
      "takt: robot control core and digital twin of the cell it controls.\n"
      "Exit status: 0 success; 1 an expectation or comparison failed; 2 bad input or usage; 3 device,\n"
      "communication or runtime fault; 130 interrupted."};
  app.name("takt");
  app.set_version_flag("--version", std::string("takt ") + TAKT_VERSION);
  app.require_subcommand(1);
  std::vector<std::pair<CLI::App*, Verb>> verbs;
  for (const AddVerb add : kVerbs) {
    verbs.push_back(add(app, common));
    CLI::App* verb = verbs.back().first;
    verb->add_flag("--json", common.json, "One JSON object on stdout; progress and diagnostics on stderr");
    verb->add_option("--models", common.models, "Folder searched for models before the project's own; several times")
        ->type_name("DIR")
        ->allow_extra_args(false);
    verb->add_option("--plugin", common.plugins, "Plug-ins with primitives and kinds of device; several times")
        ->type_name("FILE.so")
        ->allow_extra_args(false);
  }
  // Known before the parser has read it all: also a usage error is reported as asked for.
  for (int i = 1; i < argc; ++i) common.json = common.json || std::string_view(argv[i]) == "--json";
  if (const Diagnostics diagnostics = check_verb(app, argc, argv); diagnostics.has_errors())
    return report(diagnostics, common);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_usage(app, error, common);
  }
  for (const auto& [verb, run] : verbs) {
    if (!verb->parsed()) continue;
    Diagnostics diagnostics = app::check_model_folders(common.models);
    diagnostics.append(load_plugins(common));
    return diagnostics.has_errors() ? report(diagnostics, common) : run();
  }
  return kBadInput;
}

}  // namespace

int run_command_line(int argc, char** argv) {
  app::prepare_process();
  hw::add_own_drivers();
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  return app::run_guarded(fmt::format("takt {}", fmt::join(words, " ")), [&] { return run(argc, argv); });
}

}  // namespace takt::tools
