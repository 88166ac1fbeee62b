// A scenario file in this process: the run of `takt run`, and its check without one.
#include <filesystem>
#include <optional>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nlohmann/json.hpp>

#include "app/run_arguments.h"
#include "cell/file/data_folder.h"
#include "cell/run/session.h"
#include "core/device/device_file.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/interrupts.h"
#include "python/run_options.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;

std::unique_ptr<cell::Session> open_session(const std::string& file, const RunSettings& settings) {
  if (!settings.core.empty())
    raise_error("OpenError", Code::kUnsupported, "core", "a file's own program runs where its core is",
                "Give a program in Python, or run the file with takt run");
  auto session = cell::Session::open(file, device::ModelLibrary(settings.models), settings.parsed.open);
  if (!session) raise_error("OpenError", session.error());
  return std::move(*session);
}

/// Runs it to its end. @param options  JSON, see run_settings(). @return the report as JSON
std::string run_scenario(const std::string& file, const std::string& options) {
  RunSettings settings = run_settings(file, options);
  Interrupts interrupts;
  Json report;
  {
    const nb::gil_scoped_release unlocked;
    settings.parsed.run.interrupt = &interrupts.count();
    settings.parsed.run.operate = [&interrupts](cell::Operator&) { interrupts.poll(); };
    const auto session = open_session(file, settings);
    const cell::RunReport run = session->run(settings.parsed.run);
    if (run.verdict == cell::Verdict::kRefused) raise_error("OpenError", run.diagnostics);
    report = to_json(run);
    report["title"] = session->description().title;
    report["warnings"] = cell::to_json(session->warnings());
  }
  return cell::to_output_text(std::move(report));
}

/// Reads, builds and rehearses it; nothing moves. @return title, planned duration, steps and warnings as JSON
std::string check_scenario(const std::string& file, const std::string& options) {
  const RunSettings settings = run_settings(file, options);
  const nb::gil_scoped_release unlocked;
  const auto session = open_session(file, settings);
  return cell::to_output_text({{"title", session->description().title},
                               {"planned_duration", session->planned_duration()},
                               {"steps", session->program().step_count()},
                               {"warnings", cell::to_json(session->warnings())}});
}

}  // namespace

RunSettings run_settings(const std::string& file, const std::string& options) {
  const Json json = Json::parse(options);
  app::RunArguments arguments;
  arguments.video = json.value("video", std::string());
  arguments.record = json.value("record", std::string());
  arguments.camera = json.value("camera", std::string());
  arguments.size = json.value("size", arguments.size);
  arguments.fps = json.value("fps", arguments.fps);
  arguments.realtime = json.value("realtime", false);
  arguments.site = json.value("site", std::string());
  if (json.contains("seed")) arguments.seed = json.at("seed").get<std::string>();
  if (json.contains("sets")) arguments.sets = json.at("sets").get<std::vector<std::string>>();
  Diagnostics diagnostics;
  RunSettings settings{.parsed = app::parse(arguments, {file}, diagnostics),
                       .models = {},
                       .core = json.value("core", std::string()),
                       .token = json.value("token", std::string())};
  if (!settings.token.empty() && settings.core.empty())
    diagnostics.error(Code::kRequires, "token", "a token is for a server", "Name the server with core");
  const auto folders = json.value("models", std::vector<std::string>());
  diagnostics.append(app::check_model_folders(folders));
  if (diagnostics.has_errors()) raise_error("OpenError", std::move(diagnostics));
  settings.models.assign(folders.begin(), folders.end());
  settings.models.push_back(cell::data_folder() / "models");
  settings.parsed.run.watchdog = 0;  // it would end the whole process, and whoever uses a debugger stops it
  settings.parsed.run.repeat = json.value("repeat", true);
  settings.parsed.run.measure_times = settings.parsed.open.measure_times = json.value("measure_times", false);
  return settings;
}

void bind_scenarios(nb::module_& module) {
  module.def("run_scenario", run_scenario);
  module.def("check_scenario", check_scenario);
}

}  // namespace takt::python
