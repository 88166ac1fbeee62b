#include "app/run.h"

#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/cell_setup.h"
#include "app/run_arguments.h"

namespace takt::app {
namespace {

constexpr int kRefused = 2;

struct Arguments : RunArguments {
  std::string file;
  std::vector<std::string> models;
  bool json = false;
};

/// What stopped the program; empty if nothing did.
Findings carry_out(Cell& cell, const Program& program) {
  Findings why;
  try {
    program(cell);
  } catch (const activity::ProgramCancelled&) {
    // It was asked for.
  } catch (const activity::ActivityError& error) {
    why = error.findings();
  } catch (const std::exception& error) {
    why.error("", fmt::format("the program threw: {}", error.what()));
  }
  return why;
}

std::string digest_of_second_run(const std::filesystem::path& file, const CellOptions& options,
                                 const scenario::OpenOptions& open, const Program& program) {
  CellOptions quiet = options;
  quiet.quiet = true;
  Cell::Setup setup{.open = open, .run = {}};
  setup.run.measure_times = false;
  try {
    Cell cell(file, quiet, std::move(setup));
    return cell.finish(carry_out(cell, program)).digest;
  } catch (const activity::ActivityError& error) {
    return error.what();
  }
}

void print(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

int refuse(const Findings& findings, bool json) {
  fmt::print(stderr, "{}", findings.to_string());
  if (json) print({{"result", "error"}, {"findings", scenario::to_json(findings)}});
  return kRefused;
}

int run(const Arguments& arguments, const Program& program) {
  Findings findings;
  auto [open, options] = parse(arguments, findings);
  if (findings.has_errors()) return refuse(findings, arguments.json);
  CellOptions cell_options{.quiet = arguments.json};
  cell_options.models.assign(arguments.models.begin(), arguments.models.end());
  Cell::Setup setup{.open = open, .run = options};
  setup.run.interrupt = &catch_interrupts();
  if (!arguments.json) show_progress_on_terminal(setup.run);
  std::optional<Cell> cell;
  try {
    cell.emplace(arguments.file, cell_options, setup);
  } catch (const OpenError& error) {
    return refuse(error.findings(), arguments.json);
  }
  fmt::print(stderr, "{}", cell->warnings().to_string());
  const Findings why = carry_out(*cell, program);
  const scenario::RunReport report =
      cell->finish(why, [&] { return digest_of_second_run(arguments.file, cell_options, open, program); });
  if (!arguments.json) clear_progress();
  fmt::print(stderr, "{}", report.findings.to_string());
  if (arguments.json) {
    print(to_json(report));
  } else {
    fmt::print("{}", to_text(report, cell->title()));
  }
  return exit_status(report.verdict);
}

}  // namespace

int run(int argc, char** argv, const std::filesystem::path& file, const Program& program) {
  Arguments arguments;
  arguments.file = file.string();
  CLI::App parser("A program of a cell");
  parser.add_option("FILE", arguments.file, "Scenario or cell file")->capture_default_str();
  add_run_options(parser, arguments);
  parser.add_option("--models", arguments.models, "Folder of models that is searched first")->type_name("DIR");
  parser.add_flag("--json", arguments.json, "The report as JSON on stdout");
  try {
    parser.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return parser.exit(error);  // --help
    Findings findings;
    findings.error("", error.what(), "--help");
    return refuse(findings, arguments.json);
  }
  return run(arguments, program);
}

}  // namespace takt::app
