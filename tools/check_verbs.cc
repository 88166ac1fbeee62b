// validate, verify, list: whole files and folders of them.
#include <algorithm>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "app/run_arguments.h"
#include "cell/build/device_kind_registry.h"
#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/base/output_file.h"
#include "core/base/text_location.h"
#include "core/kinematics/robot_model.h"
#include "record/golden.h"
#include "sim/film/render_shapes.h"
#include "tools/cli.h"
#include "tools/failure_film.h"
#include "tools/interruption_tries.h"
#include "tools/junit.h"
#include "tools/model_trial.h"
#include "tools/net_file.h"
#include "tools/verify_seeds.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

/// What a JSON file is, by the keys it has.
enum class FileKind { kScenario, kNet, kModel, kSite };

FileKind kind_of(const Json& document) {
  if (document.is_object() && document.contains("primitives")) return FileKind::kNet;
  if (document.is_object() && document.contains("urdf") && document.contains("kind")) return FileKind::kModel;
  if (document.is_object() && document.contains("devices") && !document.contains("program")) return FileKind::kSite;
  return FileKind::kScenario;
}

/// All diagnostics of a file, warnings included.
Diagnostics check_scenario(const std::filesystem::path& file, const std::vector<cell::Override>& overrides,
                           const Common& common) {
  const device::ModelLibrary library = common.library();
  cell::OpenOptions options;
  options.overrides = overrides;
  const auto session = cell::Session::open(file, library, options);
  if (!session) return session.error();
  Diagnostics diagnostics = (*session)->warnings();
  if (const int triangles = (*session)->built().triangles; triangles > sim::kTriangleBudget) {
    diagnostics.warning(
        Code::kTooLarge, "", fmt::format("{} triangles in the scene", triangles),
        fmt::format("Keep it to {} at most, or the film is drawn slower than its time passes", sim::kTriangleBudget));
    diagnostics.set_file(file.string());
  }
  return diagnostics;
}

/// Devices are those of a cell, so a net that names some is checked with `takt net FILE --scenario SCENARIO`.
Diagnostics check_net_file(const std::filesystem::path& file) {
  rcc::ControlCore no_devices({});
  const auto net = load_net_file(file, no_devices.environment());
  return net ? (*net)->report().notes : net.error();
}

/// @param overrides  of a scenario's values
Diagnostics check_file(const std::filesystem::path& file, const std::vector<cell::Override>& overrides,
                       const Common& common) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return check_model(file);
  const auto document = read_json(file);
  if (!document) return document.error();
  switch (kind_of(*document)) {
    case FileKind::kModel:
      return check_model(file.parent_path().empty() ? "." : file.parent_path());
    case FileKind::kNet:
      return check_net_file(file);
    case FileKind::kSite: {
      const auto site = cell::read_site(file);
      return site ? Diagnostics{} : site.error();
    }
    case FileKind::kScenario:
      break;
  }
  return check_scenario(file, overrides, common);
}

int validate(const std::vector<std::string>& files, const std::vector<std::string>& sets, const Common& common) {
  Diagnostics diagnostics;
  const auto overrides = app::parse_sets(sets, diagnostics);
  for (const std::string& file : files) diagnostics.append(check_file(file, overrides, common));
  fmt::print(stderr, "{}", to_located_text(diagnostics));
  const bool valid = !diagnostics.has_errors();
  if (common.json) {
    print({{"result", valid ? "valid" : "error"}, {"diagnostics", to_json(diagnostics)}});
  } else if (valid) {
    fmt::print("{} {} valid\n", files.size(), files.size() == 1 ? "file is" : "files are");
  }
  return valid ? kHeld : kBadInput;
}

/// A folder that cannot be read is a diagnostic: what is in it would not be verified, and nobody would know.
void add_scenarios_below(const std::filesystem::path& folder, std::vector<std::filesystem::path>& files,
                         Diagnostics& diagnostics) {
  std::error_code error;
  std::filesystem::recursive_directory_iterator at(folder, error);
  for (; !error && at != std::filesystem::end(at); at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.ends_with(".json") || name.ends_with(".golden.json") || name.ends_with(".map.json")) continue;
    const auto document = read_json(at->path());
    if (document && kind_of(*document) == FileKind::kScenario) files.push_back(at->path());
  }
  if (error)
    diagnostics.add(
        {Severity::kError, Code::kFileNotReadable, folder.string(), {}, "cannot be searched: " + error.message(), {}});
}

/// Scenario files below the given files and folders, sorted; goldens and maps of robot programs are no scenarios.
std::vector<std::filesystem::path> scenario_files(const std::vector<std::string>& paths, Diagnostics& diagnostics) {
  std::vector<std::filesystem::path> files;
  for (const std::string& path : paths) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
      const std::string why = status.type() == std::filesystem::file_type::none ? error.message() : "";
      diagnostics.add(
          {Severity::kError, Code::kNotFound, path, {}, why.empty() ? "there is no such file or folder" : why, {}});
    } else if (!std::filesystem::is_directory(status)) {
      files.emplace_back(path);
    } else {
      add_scenarios_below(path, files, diagnostics);
    }
  }
  std::ranges::sort(files);
  return files;
}

std::filesystem::path golden_of(const std::filesystem::path& file) {
  return file.parent_path() / (file.stem().string() + ".golden.json");
}

struct VerifyArguments {
  std::vector<std::string> paths;
  std::string junit;
  InterruptionArguments interruptions;
  FailureFilmArguments films;
};

/// A scenario's run against its expectations and its golden, and what came of interruptions.
struct Verified {
  std::filesystem::path file;
  cell::RunReport run;
  std::optional<record::Comparison> golden;
  std::optional<InterruptionTries> tries;
  std::string film;  ///< of the seconds around its failure
  Diagnostics diagnostics;
  int status = kFault;
};

Verified verify_one(const std::filesystem::path& file, const Common& common) {
  Verified verified;
  verified.file = file;
  const device::ModelLibrary library = common.library();
  auto session = cell::Session::open(file, library, {.overrides = {}, .seed = {}, .measure_times = true});
  if (!session) {
    verified.diagnostics = session.error();
    verified.status = kBadInput;
    return verified;
  }
  cell::RunOptions options;
  options.interrupt = &app::catch_interrupts();
  std::error_code ignored;
  const bool has_golden = std::filesystem::exists(golden_of(file), ignored);
  const auto recording = TemporaryFile::create(".mcap");
  if (has_golden && !recording) {
    verified.diagnostics = recording.error();
    return verified;
  }
  if (has_golden) options.record = recording->path();
  verified.run = (*session)->run(options);
  verified.status = cell::exit_status(verified.run.verdict);
  if (has_golden && verified.status == kHeld) {
    auto comparison = record::verify(recording->path(), golden_of(file));
    if (comparison) {
      verified.golden = std::move(*comparison);
      if (!verified.golden->passed) verified.status = kNotHeld;
    } else {
      verified.diagnostics = comparison.error();
      verified.status = kBadInput;
    }
  }
  verified.run.products.clear();
  return verified;
}

void interrupt(const InterruptionArguments& arguments, const Common& common, Verified& verified) {
  if (!arguments.any() || verified.status != kHeld) return;
  verified.tries = try_interruptions(verified.file, arguments, common);
  verified.diagnostics.append(verified.tries->diagnostics);
  if (!verified.tries->held()) verified.status = kNotHeld;
}

/// When it failed: where it left its golden first, else at its end.
FailureMoment moment_of(const Verified& verified) {
  FailureMoment moment{.time = verified.run.sim_time, .at_end = true};
  if (!verified.golden || !verified.golden->departure) return moment;
  const double left = to_seconds(verified.golden->departure->time);
  if (left < moment.time) moment = {.time = left, .at_end = false};
  return moment;
}

/// @return the film; empty: there is none, and a note says why
std::string film_moment(const FailureMoment& moment, const FailureFilmArguments& arguments, const Common& common,
                        Verified& verified) {
  const auto made = film_failure(verified.file, moment, arguments, common);
  if (made) return made->string();
  verified.diagnostics.note("", "the failure was not filmed: " + made.error().to_string());
  return {};
}

/// Of each way of interrupting the first that failed.
void film_interruptions(const FailureFilmArguments& arguments, const Common& common, Verified& verified) {
  std::set<cell::Interruptions::Way> filmed;
  for (const cell::Interruptions::Case& failed : verified.tries->failed) {
    if (!filmed.insert(failed.way).second) continue;
    const FailureMoment moment{.time = 0.0, .at_end = true, .interruption = failed};
    std::string film = film_moment(moment, arguments, common, verified);
    if (!film.empty()) verified.tries->films.push_back(std::move(film));
  }
}

void film(const FailureFilmArguments& arguments, const Common& common, Verified& verified) {
  const bool failed = verified.status == kNotHeld || verified.status == kFault;
  if (arguments.off || !failed || verified.run.cycles == 0) return;
  if (verified.tries && !verified.tries->held()) return film_interruptions(arguments, common, verified);
  verified.film = film_moment(moment_of(verified), arguments, common, verified);
}

/// One scenario that fails in an unforeseen manner does not keep the others from being verified.
Verified verify_guarded(const std::filesystem::path& file, const VerifyArguments& arguments, const Common& common) {
  try {
    Verified verified = verify_one(file, common);
    interrupt(arguments.interruptions, common, verified);
    film(arguments.films, common, verified);
    return verified;
  } catch (const std::exception& error) {
    Verified verified;
    verified.file = file;
    verified.diagnostics.add(
        {Severity::kError, Code::kInternal, file.string(), {}, fmt::format("internal: {}", error.what()), {}});
    return verified;
  }
}

Json describe(const Verified& verified) {
  Json json{{"file", verified.file.string()}, {"status", verified.status}, {"run", to_json(verified.run)}};
  if (verified.golden) json["golden"] = record::to_json(*verified.golden);
  if (verified.tries) json["interruptions"] = to_json(*verified.tries);
  if (!verified.film.empty()) json["film"] = verified.film;
  json["diagnostics"] = to_json(verified.diagnostics);
  return json;
}

/// Why a run whose expectations hold is no success all the same.
std::string failure_of(const Verified& verified) {
  if (verified.golden && !verified.golden->passed) return "failed: the run differs from its golden";
  if (verified.tries && !verified.tries->held()) return "failed: an interruption leaves something behind";
  return "error: the golden cannot be compared";
}

/// The verdict of all that was judged comes first: what follows "passed" takes nothing back.
std::string text_of(const Verified& verified) {
  const std::string file = verified.file.string();
  std::string text = to_text(verified.run, file);
  const std::string golden = verified.golden ? record::to_text(*verified.golden) : std::string();
  const bool took_back = verified.run.verdict == cell::Verdict::kPassed && verified.status != kHeld;
  if (!took_back) return text + golden;
  const std::string rest = text.substr(text.find('\n') + 1);
  const bool left = verified.golden && !verified.golden->passed;
  return fmt::format("{}: {}\n{}", file, failure_of(verified), left ? golden + rest : rest + golden);
}

std::string errors_of(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& diagnostic : diagnostics.list())
    if (diagnostic.severity == Severity::kError) text += (text.empty() ? "" : "\n") + to_string(diagnostic);
  return text;
}

/// A case for the run itself, for each expectation, the golden and the interruptions.
JunitSuite suite_of(const Verified& verified) {
  const double seconds = verified.run.wall_time;
  JunitSuite suite{.name = verified.file.string(), .seconds = seconds, .cases = {}};
  Diagnostics wrong = verified.run.diagnostics;
  wrong.append(verified.diagnostics);
  const bool interrupted = verified.status == kInterrupted;
  suite.cases.push_back({.name = "run", .error = interrupted ? "interrupted" : errors_of(wrong), .seconds = seconds});
  for (const auto& one : verified.run.expectations)
    suite.cases.push_back({.name = one.name,
                           .failure = one.passed || !one.judged || interrupted ? "" : one.measured,
                           .skipped = interrupted || !one.judged ? "not judged" : "",
                           .output = one.measured});
  if (verified.golden)
    suite.cases.push_back(
        {.name = "golden", .failure = verified.golden->passed ? "" : record::to_text(*verified.golden)});
  if (verified.tries)
    suite.cases.push_back({.name = "interruptions", .failure = verified.tries->held() ? "" : to_text(*verified.tries)});
  return suite;
}

/// Of a scenario that did not get its turn, as somebody has interrupted the ones before.
JunitSuite suite_not_run(const std::filesystem::path& file) {
  return {.name = file.string(), .cases = {{.name = "run", .skipped = "interrupted before it was run"}}};
}

/// How many ended how; of a single one its own line says it.
std::string sum_of(const std::vector<int>& statuses, std::size_t files) {
  if (files < 2) return {};
  const auto count = [&](int status) { return std::ranges::count(statuses, status); };
  std::string text = fmt::format("{} of {} scenarios passed", count(kHeld), files);
  const std::pair<int, const char*> rows[] = {
      {kNotHeld, "failed"}, {kBadInput, "refused"}, {kFault, "ended by an error"}, {kInterrupted, "interrupted"}};
  for (const auto& [status, what] : rows)
    if (count(status) > 0) text += fmt::format(", {} {}", count(status), what);
  if (files > statuses.size()) text += fmt::format(", {} not run", files - statuses.size());
  return text + "\n";
}

std::string result_of(int status) {
  return status == kHeld ? "passed" : status == kInterrupted ? "interrupted" : "failed";
}

int verify(const VerifyArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  const auto files = scenario_files(arguments.paths, diagnostics);
  if (!arguments.junit.empty()) diagnostics.append(check_output(arguments.junit, files, "--junit"));
  if (files.empty() && !diagnostics.has_errors())
    diagnostics.error(Code::kNotFound, "", "no scenario file is there", "Name a folder with scenario files, *.json");
  if (diagnostics.has_errors()) return report(diagnostics, common);
  int status = kHeld;
  Json results = Json::array();
  std::vector<JunitSuite> suites;
  std::vector<int> statuses;
  for (const auto& file : files) {
    if (status == kInterrupted) {
      suites.push_back(suite_not_run(file));
      continue;
    }
    const Verified verified = verify_guarded(file, arguments, common);
    status = std::max(status, verified.status);
    statuses.push_back(verified.status);
    results.push_back(describe(verified));
    suites.push_back(suite_of(verified));
    fmt::print(stderr, "{}{}", to_located_text(verified.run.diagnostics), to_located_text(verified.diagnostics));
    if (common.json) continue;
    fmt::print("{}", text_of(verified));
    if (verified.tries) fmt::print("{}", to_text(*verified.tries));
    if (!verified.film.empty()) fmt::print("  film {}\n", verified.film);
  }
  if (!common.json) fmt::print("{}", sum_of(statuses, files.size()));
  if (!arguments.junit.empty()) {
    diagnostics = write_file(arguments.junit, junit_xml(suites), "--junit");
    fmt::print(stderr, "{}", to_located_text(diagnostics));
    if (diagnostics.has_errors()) status = std::max<int>(status, kFault);
  }
  if (common.json) print({{"result", result_of(status)}, {"scenarios", std::move(results)}});
  return status;
}

int list(const Common& common) {
  Diagnostics ignored;
  Json scenarios = Json::array(), models = Json::array();
  for (const auto& file : scenario_files({(common.root / "scenarios").string()}, ignored)) {
    const auto description = cell::read_description(file);
    const std::string title = description ? description->title : "(not valid)";
    scenarios.push_back({{"file", file.lexically_relative(common.root).string()}, {"title", title}});
  }
  for (const std::string& name : common.library().names()) models.push_back(name);
  if (common.json) {
    print({{"scenarios", scenarios}, {"models", models}});
    return kHeld;
  }
  for (const Json& one : scenarios) {
    fmt::print("scenario {:<28} {}\n", one["file"].get<std::string>(), one["title"].get<std::string>());
  }
  for (const Json& one : models) fmt::print("model    {}\n", one.get<std::string>());
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_validate(CLI::App& app, Common& common) {
  auto files = std::make_shared<std::vector<std::string>>();
  CLI::App* verb = app.add_subcommand("validate", "Check scenario, net and model files completely; move nothing");
  verb->add_option("FILE", *files, "Files, or folders of models")->required();
  auto sets = std::make_shared<std::vector<std::string>>();
  verb->add_option("--set", *sets, "Change one value of the scenario files; several times")
      ->type_name("JSON_POINTER=VALUE")
      ->allow_extra_args(false);
  return {verb, [files, sets, &common] { return validate(*files, *sets, common); }};
}

std::pair<CLI::App*, Verb> add_verify(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<VerifyArguments>();
  auto seeds = std::make_shared<SeedArguments>();
  CLI::App* verb = app.add_subcommand(
      "verify", "Run scenarios against their expectations and goldens, or one of them with many seeds");
  verb->add_option("PATH", arguments->paths, "Scenario files, or folders of them")->required();
  verb->add_option("--junit", arguments->junit, "Report for continuous integration (JUnit XML)")->type_name("OUT.xml");
  add_interruption_options(*verb, arguments->interruptions);
  add_failure_film_options(*verb, arguments->films);
  add_seed_options(*verb, *seeds);
  return {verb, [arguments, seeds, &common] {
            Diagnostics diagnostics = check_seed_arguments(*seeds, arguments->paths);
            if (seeds->seeds > 0 && (!arguments->junit.empty() || arguments->interruptions.any()))
              diagnostics.error(Code::kConflict, "--seeds", "seeds are tried without interruptions and without JUnit",
                                "Give one of them at a time");
            if (diagnostics.has_errors()) return report(diagnostics, common);
            return seeds->seeds > 0 ? verify_seeds(arguments->paths.front(), *seeds, common)
                                    : verify(*arguments, common);
          }};
}

std::pair<CLI::App*, Verb> add_list(CLI::App& app, Common& common) {
  CLI::App* verb = app.add_subcommand("list", "List the project's scenarios and models");
  return {verb, [&common] { return list(common); }};
}

}  // namespace takt::tools
