#include "cell/build/site_devices.h"
#include "core/base/text_location.h"
#include "tools/cli.h"
#include "tools/panel.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/file/data_folder.h"
#include "cell/file/robot_programs.h"
#include "cell/replay/resimulation.h"
#include "core/base/output_file.h"
#include "core/base/processors.h"
#include "record/compare.h"

namespace takt::tools {
namespace {

struct RunVerbArguments : app::RunArguments {
  cell::RobotProgram program;
  std::string file, from, image, resim, report;
  bool dry_run = false, step = false, panel = false;
  int port = 0;        // of the page
  int processor = -1;  // that the cycle has for itself; -1: any
};

/// Whatever thread the process starts from now on leaves it to the cycle.
void reserve_processor(const RunVerbArguments& arguments, Diagnostics& diagnostics) {
  if (arguments.processor < 0) return;
  if (!arguments.realtime) {
    diagnostics.error(Code::kRequires, "--processor", "only a cycle in real time has a thread of its own",
                      "Add --realtime");
  } else if (!has_processor(arguments.processor) || !keep_off_processor(arguments.processor)) {
    diagnostics.error(Code::kOutOfRange, "--processor",
                      fmt::format("processor {} cannot be kept for the cycle alone", arguments.processor),
                      "Choose one of two or more that are online");
  }
}

int dry_run(const cell::Session& session, const Common& common) {
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

/// What cannot be together with --resim.
void check_resim(const RunVerbArguments& arguments, Diagnostics& diagnostics) {
  const auto conflict = [&](bool given, const char* option, const char* why) {
    if (given) diagnostics.error(Code::kConflict, option, why, fmt::format("Give --resim or {}", option));
  };
  conflict(!arguments.file.empty(), "FILE", "a recording carries its scenario");
  conflict(arguments.step, "--step", "commands are carried out again, no steps");
  conflict(!arguments.from.empty(), "--from", "commands are carried out again from the first cycle on");
  conflict(arguments.dry_run, "--dry-run", "there is no rehearsal of recorded commands");
  conflict(!arguments.program.file.empty(), "--program", "commands are carried out again, no program");
  conflict(arguments.realtime, "--realtime", "recorded commands are carried out in simulated time");
}

/// Points of a curve in the report.
constexpr std::size_t kResimPoints = 500;

std::size_t equal_columns(const record::Comparison& comparison) {
  return static_cast<std::size_t>(std::ranges::count_if(comparison.columns, [](const auto& column) {
    return column.samples_outside == 0 && column.max_difference == 0.0;
  }));
}

int tell_resim(const record::Comparison& comparison, const cell::RunReport& report, const Common& common) {
  const std::size_t equal = equal_columns(comparison);
  if (common.json) {
    print({{"result", comparison.passed ? "passed" : "failed"},
           {"cycles", report.cycles},
           {"sim_time", report.sim_time},
           {"wall_time", report.wall_time},
           {"columns", comparison.columns.size()},
           {"columns_equal", equal},
           {"comparison", record::to_json(comparison)},
           {"products", report.products},
           {"diagnostics", to_json(report.diagnostics)}});
  } else {
    fmt::print("{}", record::to_text(comparison));
    fmt::print("  {} cycles of commands carried out again in {:.1f} s; {} of {} columns are equal to the bit\n",
               report.cycles, report.wall_time, equal, comparison.columns.size());
  }
  return comparison.passed ? kHeld : kNotHeld;
}

/// Carries out the commands of a recording again, in a simulated cell, and holds what comes of it against its states.
int resim(const RunVerbArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  auto [opening, options] = app::parse(arguments, {arguments.resim}, diagnostics);
  check_resim(arguments, diagnostics);
  if (!arguments.report.empty()) diagnostics.append(check_output(arguments.report, {arguments.resim}, "--report"));
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const auto recording = record::Recording::open(arguments.resim);
  if (!recording) return report(recording.error(), common);
  const auto cycles = cell::whole_cycles(*recording);
  if (!cycles) return report(cycles.error(), common);
  cell::ReopenedRun::Options reopening{.overrides = opening.overrides, .seed = opening.seed, .site = {}};
  if (!arguments.site.empty() || !arguments.backends.empty()) reopening.site = opening.site;
  auto again = cell::ReopenedRun::open(*recording, common.library(), reopening);
  if (!again) return report(again.error(), common);
  const auto temporary = TemporaryFile::create(".mcap");
  if (!temporary) return report(temporary.error(), common);
  if (options.record.empty()) options.record = temporary->path();
  options.interrupt = &app::catch_interrupts();
  const cell::RunReport run = again->session().run_commands(*recording, *cycles, options);
  fmt::print(stderr, "{}", to_located_text(run.diagnostics));
  if (run.verdict != cell::Verdict::kPassed) return exit_status(run.verdict);
  record::CompareOptions comparing = cell::states_only();
  comparing.plot_points = kResimPoints;
  auto comparison = record::compare_recordings(options.record, arguments.resim, comparing);
  if (!comparison) return report(comparison.error(), common);
  comparison->name_a = "the commands, carried out again";
  if (!arguments.report.empty()) {
    const auto written = record::write_report(*comparison, arguments.report);
    if (!written) return report(written.error(), common);
  }
  return tell_resim(*comparison, run, common);
}

/// A station, a file with a layout for the page beside it, is driven by people where there is a page: what its operator
/// would do by script is left out.
void leave_to_people(const RunVerbArguments& arguments, cell::OpenOptions& opening) {
  std::error_code error;
  std::filesystem::path layout = arguments.file;
  layout.replace_extension(".layout");
  if (arguments.panel && std::filesystem::exists(layout, error))
    opening.overrides.push_back({.pointer = "/operator", .value = "[]"});
}

/// What cannot be together with --panel.
void check_panel(const RunVerbArguments& arguments, Diagnostics& diagnostics) {
  if (!arguments.panel) return;
  if (arguments.step)
    diagnostics.error(Code::kConflict, "--step", "steps are begun in the page", "Give --panel or --step");
  if (arguments.dry_run)
    diagnostics.error(Code::kConflict, "--dry-run", "a rehearsal has nothing to look at", "Give --panel or --dry-run");
}

/// A program in a robot's language takes the place of the scenario's.
void take_program(const cell::RobotProgram& program, cell::OpenOptions& opening, Diagnostics& diagnostics) {
  if (program.file.empty()) return;
  if (auto change = cell::to_override(program)) {
    opening.overrides.insert(opening.overrides.begin(), std::move(*change));
  } else {
    diagnostics.append(change.error());
  }
}

int run(const RunVerbArguments& arguments, const Common& common) {
  if (!arguments.resim.empty()) return resim(arguments, common);
  Diagnostics diagnostics;
  auto [opening, options] = app::parse(arguments, {arguments.file}, diagnostics);
  if (arguments.step && arguments.realtime) {
    diagnostics.error(Code::kConflict, "--step",
                      "simulated time stops while a step waits, so it cannot follow the wall clock",
                      "Give --step or --realtime");
  }
  if (!arguments.image.empty() && !arguments.dry_run)
    diagnostics.error(Code::kRequires, "--image", "a picture of the rehearsal without a rehearsal alone",
                      "Add --dry-run");
  opening.image = arguments.image;
  check_panel(arguments, diagnostics);
  take_program(arguments.program, opening, diagnostics);
  reserve_processor(arguments, diagnostics);
  options.processor = arguments.processor;
  if (diagnostics.has_errors()) return report(diagnostics, common);
  leave_to_people(arguments, opening);
  const device::ModelLibrary library = common.library();
  auto session = cell::Session::open(arguments.file, library, opening);
  if (!session) return report(session.error(), common);
  const auto tell_warnings = [&] { fmt::print(stderr, "{}", to_located_text((*session)->warnings())); };
  if (arguments.dry_run) {
    tell_warnings();
    return dry_run(**session, common);
  }
  options.begun = tell_warnings;

  options.from = arguments.from;
  options.interrupt = &app::catch_interrupts();
  const cell::SiteDevices& site = *(*session)->built().site;
  if (site.has_drivers()) fmt::print(stderr, "devices: {}\n", cell::to_text(site.realities()));
  if (site.speed_override() < 1.0)
    fmt::print(stderr, "speed: {:g} of what is planned; --speed-override 1 for all of it\n", site.speed_override());
  app::log_on_stderr(arguments.log, options);
  if (arguments.step) {
    options.before_step = app::ask_on_terminal;
  } else if (!arguments.panel) {
    app::show_progress_of(options);
  }
  std::unique_ptr<RunPanel> panel;
  if (arguments.panel) {
    auto opened = RunPanel::open(**session, options, static_cast<unsigned short>(arguments.port), common);
    if (!opened) return tools::report(opened.error(), common);
    panel = std::move(*opened);
  }
  const cell::RunReport report = (*session)->run(options);
  app::clear_progress();
  fmt::print(stderr, "{}", to_located_text(report.diagnostics));
  if (common.json) {
    print(to_json(report));
  } else if (report.verdict != cell::Verdict::kRefused) {
    fmt::print("{}", to_text(report, (*session)->description().title));
  }
  std::fflush(stdout);
  if (panel) panel->ended(report, options);
  return exit_status(report.verdict);
}

}  // namespace

std::pair<CLI::App*, Verb> add_run(CLI::App& parser, Common& common) {
  auto arguments = std::make_shared<RunVerbArguments>();
  CLI::App* verb =
      parser.add_subcommand("run", "Run a scenario file: a verdict, and a film and a recording if asked for");
  auto* file = verb->add_option("FILE", arguments->file, "Scenario file, or the name of an installed one");
  app::add_run_options(*verb, *arguments);
  verb->add_option("--from", arguments->from, "Begin at the step of this name")->type_name("NAME");
  auto* program = verb->add_option("--program", arguments->program.file,
                                   "A program in KRL, NAME.src with NAME.dat, or in URScript, NAME.script, instead of "
                                   "the scenario's program")
                      ->type_name("FILE");
  verb->add_option("--arm", arguments->program.arm, "With --program: the arm that it moves")
      ->type_name("NAME")
      ->needs(program);
  verb->add_option("--map", arguments->program.map,
                   "With --program: what its signals, tools, bases and calls are in the cell; default NAME.map.json")
      ->type_name("FILE")
      ->needs(program);
  auto* resim =
      verb->add_option("--resim", arguments->resim,
                       "Instead of a scenario: carry out the commands of a recording again, in simulation, and "
                       "hold what comes of it against its states")
          ->type_name("RECORDING");
  verb->add_option("--report", arguments->report, "With --resim: page with the curves of both")
      ->type_name("OUT.html")
      ->needs(resim);
  verb->parse_complete_callback([file, resim] {
    if (file->count() == 0 && resim->count() == 0) throw CLI::RequiredError("FILE");
  });
  verb->add_flag("--step", arguments->step,
                 "Wait before each step: Enter begins it, c continues without stops, q or the end of input cancels");
  auto* panel = verb->add_flag("--panel", arguments->panel,
                               "With a page for browsers, at the pace of the wall clock: see, start, pause, go step by "
                               "step, change the speed, stop");
  verb->add_option("--port", arguments->port, "With --panel: port of the page; 0, the default: any that is free")
      ->type_name("N")
      ->check(CLI::Range(0, 65535))
      ->needs(panel);
  verb->add_option("--processor", arguments->processor,
                   "With --realtime: the processor that the cycle has for itself in this process")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  verb->add_flag("--dry-run", arguments->dry_run, "Check, build, plan; move nothing");
  verb->add_option("--image", arguments->image,
                   "With --dry-run: draw the posture of the first collision with both bodies marked; without a "
                   "collision the cell at its start")
      ->type_name("OUT.png");
  return {verb, [arguments, &common] {
            arguments->file = cell::find_scenario(arguments->file);
            return run(*arguments, common);
          }};
}

}  // namespace takt::tools
