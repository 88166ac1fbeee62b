#include "core/base/text_location.h"
#include "tools/cli.h"

#include <iostream>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"

namespace takt::tools {
namespace {

struct RunVerbArguments : app::RunArguments {
  std::string file, from, image;
  bool dry_run = false, step = false;
};

/// Shows what would begin, and waits for a line of stdin. Whoever goes away (end of input) wants nothing to move on.
scenario::StepAnswer ask(const scenario::NextStep& next) {
  for (const std::string& variable : next.changed) fmt::print(stderr, "            {}\n", variable);
  fmt::print(stderr, "{:9.3f} s  next: {} ({})\n", next.sim_time, next.name, next.pointer);
  std::string line;
  while (std::getline(std::cin, line)) {
    if (line.empty()) return scenario::StepAnswer::kNext;
    if (line == "c") return scenario::StepAnswer::kContinue;
    if (line == "q") return scenario::StepAnswer::kCancel;
    fmt::print(stderr, "Enter: this step; c: go on without stops; q: cancel\n");
  }
  return scenario::StepAnswer::kCancel;
}

int dry_run(const scenario::Session& session, const Common& common) {
  const auto& description = session.description();
  if (common.json) {
    print({{"result", "valid"},
           {"title", description.title},
           {"planned_duration", session.planned_duration()},
           {"steps", session.program().step_count()},
           {"devices", description.devices.size()},
           {"objects", description.objects.size()},
           {"triangles", session.built().triangles},
           {"diagnostics", to_json(session.warnings())}});
    return kHeld;
  }
  fmt::print("{}\n", description.title);
  for (const auto& device : description.devices) fmt::print("  device {:<12} {}\n", device.name, device.model);
  for (const auto& object : description.objects) fmt::print("  object {}\n", object.name);
  fmt::print("  {} steps, about {:.1f} s, {} triangles; nothing was moved\n", session.program().step_count(),
             session.planned_duration(), session.built().triangles);
  return kHeld;
}

int run(const RunVerbArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  auto [opening, options] = app::parse(arguments, {arguments.file}, diagnostics);
  if (arguments.step && arguments.realtime) {
    diagnostics.error(Code::kConflict, "--step",
                      "simulated time stops while a step waits, so it cannot follow the wall clock",
                      "--step or --realtime");
  }
  if (!arguments.image.empty() && !arguments.dry_run)
    diagnostics.error(Code::kRequires, "--image", "a picture of the rehearsal without a rehearsal alone", "--dry-run");
  opening.image = arguments.image;
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const device::ModelLibrary library = common.library();
  auto session = scenario::Session::open(arguments.file, library, opening);
  if (!session) return report(session.error(), common);
  const auto tell_warnings = [&] { fmt::print(stderr, "{}", to_located_text((*session)->warnings())); };
  if (arguments.dry_run) {
    tell_warnings();
    return dry_run(**session, common);
  }
  options.begun = tell_warnings;

  options.from = arguments.from;
  options.interrupt = &app::catch_interrupts();
  const scenario::SiteDevices& site = *(*session)->built().site;
  if (!site.drivers().empty()) fmt::print(stderr, "devices: {}\n", scenario::to_text(site.realities()));
  if (site.speed_override() < 1.0)
    fmt::print(stderr, "speed: {:g} of what is planned; --speed-override 1 for all of it\n", site.speed_override());
  app::log_on_stderr(arguments.log, options);
  if (arguments.step) {
    options.before_step = ask;
  } else {
    app::show_progress_on_terminal(options);
  }
  const scenario::RunReport report = (*session)->run(options);
  app::clear_progress();
  fmt::print(stderr, "{}", to_located_text(report.diagnostics));
  if (common.json) {
    print(to_json(report));
  } else if (report.verdict != scenario::Verdict::kRefused) {
    fmt::print("{}", to_text(report, (*session)->description().title));
  }
  return exit_status(report.verdict);
}

}  // namespace

std::pair<CLI::App*, Verb> add_run(CLI::App& parser, Common& common) {
  auto arguments = std::make_shared<RunVerbArguments>();
  CLI::App* verb =
      parser.add_subcommand("run", "Run a scenario file: a verdict, and a film and a recording if asked for");
  verb->add_option("FILE", arguments->file, "Scenario file")->required();
  app::add_run_options(*verb, *arguments);
  verb->add_option("--from", arguments->from, "Begin at the step of this name")->type_name("NAME");
  verb->add_flag("--step", arguments->step,
                 "Wait before each step: Enter begins it, c continues without stops, q or the end of input cancels");
  verb->add_flag("--dry-run", arguments->dry_run, "Check, build, plan; move nothing");
  verb->add_option("--image", arguments->image,
                   "With --dry-run: draw the posture of the first collision with both bodies marked; without a "
                   "collision the cell at its start")
      ->type_name("OUT.png");
  return {verb, [arguments, &common] { return run(*arguments, common); }};
}

}  // namespace takt::tools
