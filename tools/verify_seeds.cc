#include "tools/verify_seeds.h"

#include <algorithm>
#include <filesystem>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/process.h"
#include "cell/file/description.h"
#include "cell/run/stopwatch.h"
#include "core/base/output_file.h"
#include "core/base/text_location.h"
#include "tools/robustness/robustness.h"

namespace takt::tools {
namespace {

constexpr int kMostSeeds = 100'000, kMostJobs = 1024;

VariationPlan variation_plan(const std::string& file, const SeedArguments& arguments, const Common& common) {
  // This program as it runs, also where its file is replaced meanwhile.
  VariationPlan plan{.program = "/proc/self/exe", .file = file};
  const auto add = [&plan](const char* option, const std::vector<std::string>& values) {
    for (const std::string& value : values) {
      plan.more.emplace_back(option);
      plan.more.push_back(value);
    }
  };
  add("--set", arguments.sets);
  add("--models", common.models);
  add("--plugin", common.plugins);
  plan.first_seed = arguments.first_seed;
  plan.seeds = arguments.seeds;
  plan.jobs = arguments.jobs > 0 ? arguments.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  plan.films = arguments.films;
  return plan;
}

void show_progress(const Variation& variation) {
  fmt::print(stderr, "seed {}: {}, {:.1f} s simulated in {:.1f} s{}{}\n", variation.seed,
             variation.passed()        ? "passed"
             : variation.interrupted() ? "interrupted"
                                       : "failed",
             variation.sim_time(), variation.end.wall_s, variation.passed() || variation.interrupted() ? "" : ": ",
             variation.interrupted() ? "" : variation.message());
}

/// A scenario that takt refuses is bad input: its diagnostics are those of one run.
int report_refused(const Variation& variation, const Common& common) {
  fmt::print(stderr, "{}", variation.end.errors);
  if (common.json) {
    auto json = nlohmann::ordered_json::parse(variation.end.output);
    json["seed"] = variation.seed;
    print(json);
  }
  return kBadInput;
}

std::string title_of(const std::string& file) {
  const auto description = cell::read_description(file);
  return description ? description->title : file;
}

int exit_status_of(const Robustness& robustness) {
  if (robustness.holds()) return kHeld;
  return robustness.all_ended_in_order() ? kNotHeld : kFault;
}

}  // namespace

void add_seed_options(CLI::App& verb, SeedArguments& arguments) {
  verb.add_option("--seeds", arguments.seeds, "Run one scenario with so many seeds, each in a process of its own")
      ->type_name("N")
      ->check(CLI::Range(1, kMostSeeds));
  verb.add_option("--first-seed", arguments.first_seed, "With --seeds: the first of them")
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--jobs", arguments.jobs, "With --seeds: runs at a time; default: as many as there are processors")
      ->type_name("N")
      ->check(CLI::Range(1, kMostJobs));
  verb.add_option("--at-least", arguments.at_least, "With --seeds: so many have to pass; default: all")
      ->type_name("N")
      ->check(CLI::Range(0, kMostSeeds));
  verb.add_option("--report", arguments.report,
                  "With --seeds: one page with success, times, forces, and films of the last seconds of failures")
      ->type_name("OUT.html");
  verb.add_option("--films", arguments.films, "With --report: of so many failures there is a film, at most")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(0, 100));
  verb.add_option("--set", arguments.sets, "With --seeds: change one value of the file; several times")
      ->type_name("JSON_POINTER=VALUE")
      ->allow_extra_args(false);
}

Diagnostics check_seed_arguments(const SeedArguments& arguments, const std::vector<std::string>& paths) {
  Diagnostics diagnostics;
  const auto needs_seeds = [&](const char* option, bool given) {
    if (given && arguments.seeds == 0)
      diagnostics.error(Code::kRequires, option, "it counts for many seeds of one scenario", "Add --seeds N");
  };
  needs_seeds("--jobs", arguments.jobs > 0);
  needs_seeds("--at-least", arguments.at_least.has_value());
  needs_seeds("--report", !arguments.report.empty());
  needs_seeds("--set", !arguments.sets.empty());
  if (arguments.seeds == 0) return diagnostics;
  std::error_code ignored;
  if (paths.size() != 1 || std::filesystem::is_directory(paths.front(), ignored))
    diagnostics.error(Code::kConflict, "--seeds", "the variations are those of one scenario", "Give one scenario file");
  if (arguments.at_least.value_or(0) > arguments.seeds)
    diagnostics.error(Code::kOutOfRange, "--at-least",
                      fmt::format("{} of {} seeds cannot pass", *arguments.at_least, arguments.seeds),
                      fmt::format("Keep it to at most {}", arguments.seeds));
  if (!arguments.report.empty())
    diagnostics.append(check_output(arguments.report, {paths.begin(), paths.end()}, "--report"));
  return diagnostics;
}

int verify_seeds(const std::string& file, const SeedArguments& arguments, const Common& common) {
  const VariationPlan plan = variation_plan(file, arguments, common);
  const std::atomic<int>& interrupt = app::catch_interrupts();
  const auto begin = cell::Stopwatch::Clock::now();
  auto variations = run_variations(plan, &interrupt, show_progress);
  if (!variations) return report(variations.error(), common);
  const auto refused =
      std::ranges::find_if(*variations, [](const Variation& one) { return one.end.status == kBadInput && one.report; });
  if (refused != variations->end()) return report_refused(*refused, common);

  Robustness robustness{.file = file, .title = title_of(file), .variations = std::move(*variations), .jobs = plan.jobs};
  robustness.needed = static_cast<std::size_t>(arguments.at_least.value_or(arguments.seeds));
  robustness.wall_s = cell::Stopwatch::seconds_since(begin);
  int status = interrupt.load() > 0 ? static_cast<int>(kInterrupted) : exit_status_of(robustness);
  auto json = to_json(robustness);
  if (!arguments.report.empty() && interrupt.load() == 0) {
    film_failures(plan, &interrupt, robustness.variations);
    const Diagnostics written = write_file(arguments.report, to_html(robustness), "--report");
    fmt::print(stderr, "{}", to_located_text(written));
    if (written.has_errors()) status = kFault;
    json = to_json(robustness);
    json["report"] = arguments.report;
  }
  if (common.json) {
    print(json);
  } else {
    fmt::print("{}", to_text(robustness));
    if (json.contains("report")) fmt::print("  wrote {}\n", arguments.report);
  }
  return status;
}

}  // namespace takt::tools
