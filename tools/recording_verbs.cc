// compare, bless, render: what is done with recordings.
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/judge/signal_reader.h"
#include "cell/replay/recorded_run.h"
#include "cell/replay/replay.h"
#include "cell/replay/state_dump.h"
#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/base/output_file.h"
#include "core/base/text_location.h"
#include "record/compare.h"
#include "record/golden.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

struct CompareArguments {
  std::string a, b, html;
  bool quick = false, films = false;
};

bool is_golden(const std::string& file) { return file.ends_with(".json"); }

/// Runs both again to say which bit differs first; if that cannot be, a note says why.
void name_bit(const CompareArguments& arguments, const Common& common, record::Comparison& comparison) {
  const auto a = record::Recording::open(arguments.a);
  const auto b = record::Recording::open(arguments.b);
  if (!a || !b) return;
  const auto bit = cell::find_bit(*a, *b, comparison.first_difference->cycle, common.library());
  if (!bit) {
    for (const Diagnostic& diagnostic : bit.error().list()) comparison.notes.push_back(to_string(diagnostic));
  } else if (*bit) {
    comparison.first_difference->bit = cell::to_string(**bit);
  }
}

/// The tolerances that the scenario of a recording asks for.
std::vector<record::ToleranceRule> recorded_rules(const std::string& file) {
  const auto recording = record::Recording::open(file);
  if (!recording) return {};
  const auto description = cell::recorded_scenario(*recording);
  return description ? description->tolerances : std::vector<record::ToleranceRule>();
}

/// Of a curve in the report: two for each column of pixels of a small screen.
constexpr std::size_t kReportPoints = 500;

/// A small film of a recording, for the report; what is wrong becomes a note.
std::string film_of(const std::string& recording, const Common& common, record::Comparison& comparison) {
  const auto file = TemporaryFile::create(".mp4");
  if (!file) return {};
  cell::ReplayOptions options;
  options.video = file->path();
  options.width = 320;
  options.height = 180;
  options.fps = 5;
  const auto frames = cell::render_recording(recording, common.library(), options);
  constexpr std::size_t kMost = std::size_t{16} << 20;
  auto film = frames ? read_file(file->path(), kMost) : Result<std::string>(std::unexpected(frames.error()));
  if (film) return std::move(*film);
  for (const Diagnostic& diagnostic : film.error().list()) comparison.notes.push_back(to_string(diagnostic));
  return {};
}

int compare(const CompareArguments& arguments, const Common& common) {
  if (is_golden(arguments.a)) {
    Diagnostics diagnostics;
    diagnostics.add(
        {Severity::kError, Code::kUsage, arguments.a, {}, "the first file is a golden", "compare RECORDING GOLDEN"});
    return report(diagnostics, common);
  }
  if (arguments.films && arguments.html.empty()) {
    Diagnostics diagnostics;
    diagnostics.error(Code::kRequires, "--films", "films are parts of the report", "Add --report OUT.html");
    return report(diagnostics, common);
  }
  if (!arguments.html.empty()) {
    const Diagnostics diagnostics = check_output(arguments.html, {arguments.a, arguments.b}, "--report");
    if (diagnostics.has_errors()) return report(diagnostics, common);
  }
  auto comparison = is_golden(arguments.b) ? record::verify(arguments.a, arguments.b)
                                           : record::compare_recordings(
                                                 arguments.a, arguments.b,
                                                 {.rules = recorded_rules(arguments.b), .plot_points = kReportPoints});
  if (!comparison) return report(comparison.error(), common);
  if (comparison->first_difference && !arguments.quick) name_bit(arguments, common, *comparison);
  if (arguments.films) {
    comparison->film_a = film_of(arguments.a, common, *comparison);
    if (!is_golden(arguments.b)) comparison->film_b = film_of(arguments.b, common, *comparison);
  }
  if (!arguments.html.empty()) {
    const auto written = record::write_report(*comparison, arguments.html);
    if (!written) return report(written.error(), common);
  }
  if (common.json) {
    print(record::to_json(*comparison));
  } else {
    fmt::print("{}", record::to_text(*comparison));
  }
  return comparison->passed ? kHeld : kNotHeld;
}

struct BlessArguments {
  std::string scenario, reason;
};

/// A reason that says nothing is none.
Diagnostics check_reason(const std::string& reason) {
  Diagnostics diagnostics;
  if (reason.find_first_not_of(" \t\r\n") == std::string::npos)
    diagnostics.error(Code::kMissing, "--reason", "the reason is empty", "Say in words why this run is right");
  return diagnostics;
}

int bless(const BlessArguments& arguments, const Common& common) {
  if (const Diagnostics diagnostics = check_reason(arguments.reason); diagnostics.has_errors())
    return report(diagnostics, common);
  const device::ModelLibrary library = common.library();
  auto session = cell::Session::open(arguments.scenario, library);
  if (!session) return report(session.error(), common);
  const std::filesystem::path file = arguments.scenario;
  const auto recording = TemporaryFile::create(".mcap");
  if (!recording) return report(recording.error(), common);
  cell::RunOptions options;
  options.record = recording->path();
  options.interrupt = &app::catch_interrupts();
  const cell::RunReport run = (*session)->run(options);
  if (run.verdict != cell::Verdict::kPassed) {
    fmt::print(stderr, "{}{}", to_text(run, arguments.scenario), to_located_text(run.diagnostics));
    Diagnostics diagnostics;
    diagnostics.add({Severity::kError,
                     Code::kConditionNotMet,
                     arguments.scenario,
                     {},
                     "this run failed, so it is not blessed",
                     {}});
    (void)report(diagnostics, common);
    return cell::exit_status(run.verdict);
  }
  const auto golden_file = file.parent_path() / (file.stem().string() + ".golden.json");
  record::BlessOptions blessing;
  blessing.scenario = file.filename().string();
  blessing.reason = arguments.reason;
  blessing.topics = {"/*/set_point", "/*/joint_states", "/*/wrench", "/*/gripper", "/signals", "/objects", "/program"};
  blessing.rules = (*session)->description().tolerances;
  // What is measured by an analog input is mostly noise, and noise does not thin.
  for (const cell::NamedSignal& signal : cell::signals_of((*session)->built().cell))
    if (!signal.digital)
      blessing.rules.push_back({"/signals", signal.name, {.kind = record::ToleranceKind::kReportOnly}});
  // Measured torques are noise on top of what the positions already say.
  blessing.rules.push_back({.column = "*.effort", .tolerance = {.kind = record::ToleranceKind::kReportOnly}});
  const auto golden = record::bless(recording->path(), golden_file, blessing);
  if (!golden) return report(golden.error(), common);
  if (common.json) {
    print({{"result", "blessed"}, {"golden", golden_file.string()}, {"columns", golden->columns.size()}});
  } else {
    fmt::print("{}: {} curves, {} events\n", golden_file.string(), golden->columns.size(), golden->events.size());
  }
  return kHeld;
}

struct RenderArguments {
  std::string recording;
  cell::ReplayOptions options;
  std::optional<double> to;
  app::FilmViewArguments view;
  std::string size = "1280x720";
};

int render(RenderArguments& arguments, const Common& common) {
  Diagnostics diagnostics = check_output(arguments.options.video, {arguments.recording}, "--video");
  if (!app::parse_size(arguments.size, arguments.options.width, arguments.options.height)) {
    diagnostics.error(Code::kInvalidValue, "--size", fmt::format("'{}' is not a size", arguments.size),
                      "Write WIDTHxHEIGHT, e.g. 1280x720");
  }
  arguments.options.view = app::parse_view(arguments.view, diagnostics);
  arguments.options.show = arguments.view.show;
  if (arguments.to) arguments.options.to = *arguments.to;
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const device::ModelLibrary library = common.library();
  const auto frames = cell::render_recording(arguments.recording, library, arguments.options);
  if (!frames) return report(frames.error(), common);
  if (common.json) {
    print({{"result", "rendered"}, {"frames", *frames}, {"video", arguments.options.video.string()}});
  } else {
    fmt::print("{}: {} frames\n", arguments.options.video.string(), *frames);
  }
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_compare(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* verb = app.add_subcommand("compare", "Compare a recording with another one, or with a golden");
  verb->add_option("A", arguments->a, "Recording (MCAP)")->required();
  verb->add_option("B", arguments->b, "Recording (MCAP) or golden (JSON)")->required();
  verb->add_option("--report", arguments->html, "Page with the curves")->type_name("OUT.html");
  verb->add_flag("--films", arguments->films, "The report has small films of both, side by side");
  verb->add_flag("--quick", arguments->quick, "Do not run both again to name the first bit that differs");
  return {verb, [arguments, &common] { return compare(*arguments, common); }};
}

std::pair<CLI::App*, Verb> add_bless(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<BlessArguments>();
  CLI::App* verb = app.add_subcommand("bless", "Run a scenario and keep its curves as the golden beside it");
  verb->add_option("SCENARIO", arguments->scenario, "Scenario file")->required();
  verb->add_option("--reason", arguments->reason, "Why this run is right")->required()->type_name("TEXT");
  return {verb, [arguments, &common] { return bless(*arguments, common); }};
}

std::pair<CLI::App*, Verb> add_render(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* verb = app.add_subcommand("render", "Make a film from a recording");
  verb->add_option("RECORDING", arguments->recording, "Recording (MCAP)")->required();
  verb->add_option("--video", arguments->options.video, "Film (MP4, H.264)")->required()->type_name("OUT.mp4");
  verb->add_option("--from", arguments->options.from, "The film begins at this simulated time, s")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  verb->add_option("--to", arguments->to, "The film ends at this simulated time, s")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  verb->add_option("--camera", arguments->options.camera,
                   "Camera; without it the scenario's cuts; fit: one that fits the cell")
      ->type_name("NAME");
  app::add_film_view_options(*verb, arguments->view);
  verb->add_option("--jobs", arguments->options.jobs, "Pictures that are drawn at a time")
      ->type_name("N")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  verb->add_option("--size", arguments->size, "Size of the film")->type_name("WxH")->capture_default_str();
  verb->add_option("--fps", arguments->options.fps, "Pictures per second")->capture_default_str();
  return {verb, [arguments, &common] { return render(*arguments, common); }};
}

}  // namespace takt::tools
