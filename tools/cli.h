#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cell/judge/run_report.h"
#include "core/base/diagnostics.h"
#include "core/device/device_file.h"

namespace CLI {
class App;
}

namespace takt::tools {

/// Exit status of every verb.
enum ExitStatus { kHeld = 0, kNotHeld = 1, kBadInput = 2, kFault = 3, kInterrupted = 130 };

/// What all verbs share.
struct Common {
  bool json = false;
  std::vector<std::string> models;   ///< folders to search for models before the project's own
  std::vector<std::string> plugins;  ///< shared objects to load before the verb runs
  std::filesystem::path root;        ///< of the project: where models/ and scenarios/ lie

  [[nodiscard]] device::ModelLibrary library() const;
};

/// A verb: adds its sub-command to the app; the callback runs it and gives the exit status.
using Verb = std::function<int()>;
using AddVerb = std::pair<CLI::App*, Verb> (*)(CLI::App& app, Common& common);

std::pair<CLI::App*, Verb> add_run(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_validate(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_verify(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_compare(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_bless(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_render(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_net(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_operations(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_primitives(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_model(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_new(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_list(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_emulate(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_doctor(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_events(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_export(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_replay(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_serve(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_recover(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_schema(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_chart(CLI::App& app, Common& common);
std::pair<CLI::App*, Verb> add_sweep(CLI::App& app, Common& common);

/// Prints diagnostics on stderr, a line each; with --json also {"result": "error", "diagnostics": [...]} on stdout.
/// @return kBadInput
int report(const Diagnostics& diagnostics, const Common& common);
using cell::to_json;
/// One JSON object on stdout.
void print(const nlohmann::ordered_json& json);

/// The whole program: parses the command line, runs the verb. @return the exit status.
int run_command_line(int argc, char** argv);

}  // namespace takt::tools
