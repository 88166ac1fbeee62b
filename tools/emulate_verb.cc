// takt emulate: the controllers of a cell, for drivers in other processes.
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/run/emulation_run.h"
#include "tools/cli.h"
#include "tools/typed_lines.h"

namespace takt::tools {
namespace {

/// What is recorded and filmed is a run, with its program and its verdict; here are the machines alone.
void check_products(const app::RunArguments& arguments, Diagnostics& diagnostics) {
  const auto refuse = [&](const std::string& value, const char* option) {
    if (value.empty()) return;
    diagnostics.error(
        Code::kNotPossibleNow, option,
        "emulate runs the machines and no program, so there is no run to record or to film",
        fmt::format("Give {} to the process with the program: takt run FILE --backend NAME=KIND:ADDR {} {}", option,
                    option, value));
  };
  refuse(arguments.record, "--record");
  refuse(arguments.video, "--video");
}

int emulate(const std::string& file, const app::RunArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  check_products(arguments, diagnostics);
  if (diagnostics.has_errors()) return report(diagnostics, common);
  app::RunArguments on_wire = arguments;
  on_wire.realtime = true;  // the wire has the wall clock's time, asked for or not
  const auto parsed = app::parse(on_wire, {file}, diagnostics);
  auto description = cell::read_description(file, parsed.open.overrides, parsed.open.seed, diagnostics);
  if (diagnostics.has_errors() || !description) return report(diagnostics, common);
  description->site = parsed.open.site;
  const device::ModelLibrary library = common.library();
  auto run = cell::EmulationRun::create(std::move(*description), library);
  if (!run) return report(run.error(), common);
  for (const auto& one : (*run)->served())
    fmt::print(stderr, "EMULATED: {} as {} at {}\n", one.device, one.kind, one.address);
  fmt::print(stderr, "Ctrl-C ends. Type 'stop ARM' or 'reset ARM' for what a person does at an arm.\n");
  TypedLines typed;
  const auto ended = (*run)->run({.realtime = arguments.realtime,
                                  .interrupt = &app::catch_interrupts(),
                                  .tell = [](const std::string& line) { fmt::print(stderr, "{}\n", line); },
                                  .next_command = [&typed] { return typed.next(); }});
  fmt::print(stderr, "{}", ended.diagnostics.to_string());
  if (common.json) {
    print({{"result", ended.diagnostics.has_errors() ? "error" : "ended"},
           {"sim_time", ended.sim_time},
           {"overruns", ended.overruns},
           {"diagnostics", to_json(ended.diagnostics)}});
  }
  return ended.diagnostics.has_errors() ? kFault : kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_emulate(CLI::App& parser, Common& common) {
  auto arguments = std::make_shared<app::RunArguments>();
  auto file = std::make_shared<std::string>();
  CLI::App* verb = parser.add_subcommand(
      "emulate", "Run the controllers of a scenario's arms, for drivers in other processes, until Ctrl-C");
  verb->add_option("FILE", *file, "Scenario file")->required();
  verb->add_option("--site", arguments->site, "Site file: back ends of the devices")->type_name("FILE");
  verb->add_option("--backend", arguments->backends, "Driver for which an arm is emulated, over the site file")
      ->type_name("NAME=KIND[:ADDR]")
      ->allow_extra_args(false);
  verb->add_flag("--realtime", arguments->realtime, "Real-time scheduling and locked memory, where permitted");
  verb->add_option("--seed", arguments->seed, "Seed in place of the file's")->type_name("N");
  verb->add_option("--set", arguments->sets, "Change one value of the file; several times")
      ->type_name("JSON_POINTER=VALUE")
      ->allow_extra_args(false);
  // Not in the help: somebody who knows `run` gives them, and is told where they belong.
  verb->add_option("--record", arguments->record)->group("");
  verb->add_option("--video", arguments->video)->group("");
  return {verb, [file, arguments, &common] { return emulate(*file, *arguments, common); }};
}

}  // namespace takt::tools
