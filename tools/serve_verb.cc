// takt serve: the core of a cell by network, without a program.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "serve/hosted_cell.h"
#include "serve/server.h"
#include "tools/cli.h"
#include "tools/panel.h"

namespace takt::tools {
namespace {

struct ServeArguments {
  std::string file, address = "127.0.0.1", tokens, recordings;
  int port = 8700;
  bool lockstep = false;
  std::vector<std::string> names, origins;
  app::RunArguments run;
};

int serve_cell(const ServeArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  app::RunArguments wanted = arguments.run;
  wanted.realtime = !arguments.lockstep;
  const auto parsed = app::parse(wanted, {arguments.file}, diagnostics);
  serve::Server::Options options{
      .http = {.address = arguments.address, .port = static_cast<unsigned short>(arguments.port)},
      .tokens = {},
      .names = arguments.names,
      .origins = arguments.origins,
      .page = serve::PanelFiles::read(panel_folder(common)),
      .log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); }};
  if (!arguments.tokens.empty()) {
    auto tokens = serve::read_tokens(arguments.tokens);
    if (tokens) {
      options.tokens = std::move(*tokens);
    } else {
      diagnostics.append(tokens.error());
    }
  }
  if (arguments.tokens.empty() || !options.tokens.empty()) diagnostics.append(serve::Server::check(options));
  if (!arguments.recordings.empty() && !std::filesystem::is_directory(arguments.recordings))
    diagnostics.error(Code::kNotFound, "--recordings", fmt::format("there is no folder '{}'", arguments.recordings),
                      "Make it first");
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const device::ModelLibrary library = common.library();
  serve::HostedCell::Options hosting{.open = parsed.open, .run = parsed.run, .recordings = arguments.recordings};
  hosting.run.interrupt = &app::catch_interrupts();
  hosting.run.realtime = !arguments.lockstep;
  auto cell = serve::HostedCell::open(arguments.file, library, hosting);
  if (!cell) return report(cell.error(), common);
  auto server = serve::Server::open(**cell, options);
  if (!server) return report(server.error(), common);
  fmt::print(stderr, "{}", (*cell)->warnings().to_string());
  fmt::print(stderr, "{} at {} ({}); Ctrl-C ends\n", (*cell)->description().title, (*server)->url(),
             arguments.lockstep ? "lock-step" : "real time");
  tell_page((*server)->url(), options.page);
  if (!serve::is_loopback(arguments.address))
    fmt::print(stderr, "Warning: other machines can reach this server, and nothing on the way is encrypted\n");
  const cell::RunReport ended = (*cell)->run();
  server->reset();
  fmt::print(stderr, "{}", ended.diagnostics.to_string());
  if (common.json) {
    print({{"result", ended.diagnostics.has_errors() ? "error" : "ended"},
           {"sim_time", ended.sim_time},
           {"cycles", ended.cycles},
           {"digest", ended.digest},
           {"overruns", ended.overruns},
           {"diagnostics", to_json(ended.diagnostics)}});
  }
  return ended.diagnostics.has_errors() ? kFault : kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_serve(CLI::App& parser, Common& common) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* verb = parser.add_subcommand(
      "serve",
      "The control core of a scenario's cell by HTTP, with a page for browsers, without its program, until Ctrl-C");
  verb->add_option("FILE", arguments->file, "Scenario file, or a cell without a program")->required();
  verb->add_option("--port", arguments->port, "Port; 0: any that is free")->check(CLI::Range(0, 65535));
  verb->add_option("--address", arguments->address, "Address to listen at; beyond loopback only with --tokens");
  verb->add_option("--tokens", arguments->tokens, "Lines ROLE NAME TOKEN, mode 0600: who may look or command")
      ->type_name("FILE");
  verb->add_option("--host", arguments->names, "Further name of this machine that clients may use; several times")
      ->type_name("NAME")
      ->allow_extra_args(false);
  verb->add_option("--origin", arguments->origins, "Page elsewhere that may use the server, https://a.b; several times")
      ->type_name("ORIGIN")
      ->allow_extra_args(false);
  verb->add_option("--recordings", arguments->recordings, "Folder of recordings that clients begin; without it: none")
      ->type_name("FOLDER");
  auto* realtime = verb->add_flag("--realtime", arguments->run.realtime, "At the wall clock's pace (the default)");
  verb->add_flag("--lockstep", arguments->lockstep, "Time goes on only when a client says so")->excludes(realtime);
  verb->add_option("--site", arguments->run.site, "Site file: back ends of the devices")->type_name("FILE");
  verb->add_option("--backend", arguments->run.backends, "Driver of a device, over the site file")
      ->type_name("NAME=KIND[:ADDR]")
      ->allow_extra_args(false);
  verb->add_option("--seed", arguments->run.seed, "Seed in place of the file's")->type_name("N");
  verb->add_option("--set", arguments->run.sets, "Change one value of the file; several times")
      ->type_name("JSON_POINTER=VALUE")
      ->allow_extra_args(false);
  return {verb, [arguments, &common] { return serve_cell(*arguments, common); }};
}

}  // namespace takt::tools
