#include "app/run.h"

#include <algorithm>
#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/cell_setup.h"
#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/run/interruptions.h"
#include "core/base/text_location.h"

namespace takt::app {
namespace {

constexpr int kRefused = 2;

struct Arguments : RunArguments {
  std::string file;
  std::vector<std::string> models;
  std::string core, token;
  bool json = false, step = false;
  std::int64_t try_every = 0;  // cycles; 0: the run is not tried
};

/// What stopped the program; empty if nothing did.
Diagnostics carry_out(Cell& cell, const Program& program) {
  Diagnostics why;
  try {
    program(cell);
  } catch (const activity::ProgramCancelled&) {
    // It was asked for.
  } catch (const activity::ActivityError& error) {
    why = error.diagnostics();
  } catch (const std::exception& error) {
    why.error(Code::kInternal, "", fmt::format("the program threw: {}", error.what()));
  }
  return why;
}

std::string digest_of_second_run(const std::filesystem::path& file, const CellOptions& options,
                                 const cell::OpenOptions& open, const Program& program) {
  CellOptions quiet = options;
  quiet.quiet = true;
  CellSetup setup{.open = open, .run = {}, .core = {}, .token = {}};
  setup.run.measure_times = false;
  try {
    Cell cell(file, quiet, std::move(setup));
    return cell.finish(carry_out(cell, program)).digest;
  } catch (const activity::ActivityError& error) {
    return error.what();
  }
}

/// What `--try-interruptions` cannot be had with: a fork has one thread and no clock. Nor can `--step` follow the wall
/// clock.
Diagnostics check(const Arguments& arguments) {
  Diagnostics diagnostics;
  if (arguments.step && arguments.realtime)
    diagnostics.error(Code::kConflict, "--step",
                      "simulated time stops while a step waits, so it cannot follow the wall clock",
                      "Use --step or --realtime");
  if (!arguments.token.empty() && arguments.core.empty())
    diagnostics.error(Code::kRequires, "--token", "a token is for a server", "Name the server with --core");
  if (arguments.try_every == 0) return diagnostics;
  const std::pair<const char*, bool> others[] = {{"--video", !arguments.video.empty()},
                                                 {"--record", !arguments.record.empty()},
                                                 {"--realtime", arguments.realtime},
                                                 {"--step", arguments.step},
                                                 {"--core", !arguments.core.empty()}};
  for (const auto& [name, given] : others)
    if (given)
      diagnostics.error(Code::kConflict, "--try-interruptions", fmt::format("cannot be together with {}", name),
                        "Give one of both");
  return diagnostics;
}

/// What came of the children, as an expectation of the run.
void tell(const cell::Interruptions& tries, cell::RunReport& report) {
  const auto& failures = tries.failures();
  std::string measured = fmt::format("{} tried", tries.tried());
  for (const std::string& failure : failures) measured += "; " + failure;
  const bool held = failures.empty() && tries.tried() > 0;
  report.expectations.push_back({.name = "interruptions", .kind = "program", .passed = held, .measured = measured});
  if (!held && report.verdict == cell::Verdict::kPassed) report.verdict = cell::Verdict::kFailed;
}

void print(const nlohmann::ordered_json& json) { fmt::print("{}", cell::to_output_text(json)); }

int refuse(const Diagnostics& diagnostics, bool json) {
  fmt::print(stderr, "{}", to_located_text(diagnostics));
  if (json) print({{"result", "error"}, {"diagnostics", cell::to_json(diagnostics)}});
  return kRefused;
}

int run(const Arguments& arguments, const Program& program, const CooperatingArms& cooperating) {
  Diagnostics diagnostics;
  auto [open, options] = parse(arguments, {arguments.file}, diagnostics);
  diagnostics.append(check(arguments));
  diagnostics.append(check_model_folders(arguments.models));
  if (diagnostics.has_errors()) return refuse(diagnostics, arguments.json);
  CellOptions cell_options{.quiet = arguments.json, .cooperating = cooperating};
  cell_options.models.assign(arguments.models.begin(), arguments.models.end());
  CellSetup setup{.open = open, .run = options, .core = arguments.core, .token = arguments.token};
  setup.run.interrupt = &catch_interrupts();
  log_on_stderr(arguments.log, setup.run);
  if (arguments.step) setup.run.before_step = ask_on_terminal;
  if (!arguments.json && !arguments.step) show_progress_of(setup.run);
  cell::Interruptions tries(
      {.every = std::max<std::int64_t>(1, arguments.try_every), .ways = cell::Interruptions::by_program});
  if (arguments.try_every > 0) tries.attach(setup.run);
  std::optional<Cell> cell;
  try {
    cell.emplace(arguments.file, cell_options, setup);
  } catch (const OpenError& error) {
    return refuse(error.diagnostics(), arguments.json);
  }
  fmt::print(stderr, "{}", to_located_text(cell->warnings()));
  const Diagnostics why = carry_out(*cell, program);
  cell::RunReport report = cell->finish(why, [&]() -> std::string {
    return tries.in_child() ? "" : digest_of_second_run(arguments.file, cell_options, open, program);
  });
  if (tries.in_child()) tries.answer_after(cell->model(), cell->core().period(), report);
  if (arguments.try_every > 0) tell(tries, report);
  if (!arguments.json) clear_progress();
  fmt::print(stderr, "{}", to_located_text(report.diagnostics));
  if (arguments.json) {
    print(to_json(report));
  } else {
    fmt::print("{}", to_text(report, cell->title()));
  }
  return exit_status(report.verdict);
}

int run_command_line(int argc, char** argv, const std::filesystem::path& file, const Program& program,
                     const CooperatingArms& cooperating) {
  Arguments arguments;
  arguments.file = file.string();
  CLI::App parser("A program of a cell");
  parser.add_option("FILE", arguments.file, "Scenario or cell file")->capture_default_str();
  add_run_options(parser, arguments);
  parser.add_option("--models", arguments.models, "Folder of models that is searched first; several times")
      ->type_name("DIR")
      ->allow_extra_args(false);
  parser.add_option("--core", arguments.core, "The cell is in takt serve at this URL, and the program in this process")
      ->type_name("URL");
  parser.add_option("--token", arguments.token, "With --core: file with the token of an operator, mode 0600")
      ->type_name("FILE");
  parser.add_flag("--json", arguments.json, "The report as JSON on stdout");
  parser.add_flag(
      "--step", arguments.step,
      "Wait before each activity: Enter begins it, c continues without stops, q or the end of input cancels");
  parser
      .add_option("--try-interruptions", arguments.try_every,
                  "Fork at every N-th cycle, and cancel, pause and abort the program there")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  try {
    parser.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return parser.exit(error);  // --help
    Diagnostics diagnostics;
    diagnostics.error(Code::kUsage, "", error.what(), "See --help");
    return refuse(diagnostics, arguments.json);
  }
  return run(arguments, program, cooperating);
}

}  // namespace

int run(int argc, char** argv, const std::filesystem::path& file, const Program& program,
        const CooperatingArms& cooperating) {
  prepare_process();
  return run_guarded(fmt::format("{}", fmt::join(argv, argv + argc, " ")),
                     [&] { return run_command_line(argc, argv, file, program, cooperating); });
}

}  // namespace takt::app
