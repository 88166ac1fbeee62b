#include "tools/robustness/variations.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

constexpr int kRefused = 2, kInterruptedRun = 130;  // exit statuses of `takt run`
constexpr double kFilmedSeconds = 6.0;              // before the end of a run that failed

Words run_command(const VariationPlan& plan, std::uint64_t seed) {
  Words words{"run", plan.file.string(), "--seed", std::to_string(seed)};
  std::ranges::copy(plan.more, std::back_inserter(words));
  return words;
}

/// As a process needs it: with the program in front, and the report on stdout.
Words process_of(const VariationPlan& plan, const Words& command) {
  Words words{plan.program.string()};
  std::ranges::copy(command, std::back_inserter(words));
  words.emplace_back("--json");
  return words;
}

std::string text_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<double> number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

JudgedExpectation read_judged(const Json& json) {
  const auto passed = json.find("passed");
  return {.name = text_at(json, "name"),
          .kind = text_at(json, "kind"),
          .measured = text_at(json, "measured"),
          .unit = text_at(json, "unit"),
          .passed = passed != json.end() && passed->is_boolean() && passed->get<bool>(),
          .judged = json.value("judged", true),
          .value = number_at(json, "value"),
          .lower = number_at(json, "lower"),
          .upper = number_at(json, "upper")};
}

std::string first_error(const Json& diagnostics) {
  for (const Json& one : diagnostics) {
    if (text_at(one, "severity") != "error") continue;
    const std::string pointer = text_at(one, "pointer"), message = text_at(one, "message");
    return pointer.empty() ? message : fmt::format("{}: {}", pointer, message);
  }
  return {};
}

std::optional<RunSummary> read_report(const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || text_at(json, "result").empty()) return std::nullopt;
  RunSummary summary{.digest = text_at(json, "digest"),
                     .sim_time = number_at(json, "sim_time").value_or(0.0),
                     .wall_time = number_at(json, "wall_time").value_or(0.0)};
  for (const Json& one : json.value("expectations", Json::array())) summary.expectations.push_back(read_judged(one));
  summary.error = first_error(json.value("diagnostics", Json::array()));
  return summary;
}

std::string unmet(const std::vector<JudgedExpectation>& expectations) {
  std::string text;
  for (const JudgedExpectation& one : expectations)
    if (!one.passed && one.judged) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", one.name, one.measured);
  return text;
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of('\n');
  if (end == std::string::npos) return "nothing was said";
  const std::size_t break_before = text.rfind('\n', end);
  const std::size_t begin = break_before == std::string::npos ? 0 : break_before + 1;
  return text.substr(begin, end + 1 - begin);
}

std::string read_whole(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

bool Variation::interrupted() const { return end.status == kInterruptedRun; }

double Variation::sim_time() const { return report ? report->sim_time : 0.0; }

std::string Variation::message() const {
  if (passed()) return {};
  if (interrupted()) return "interrupted";
  if (report) return report->error.empty() ? unmet(report->expectations) : report->error;
  const std::string how = end.signal != 0 ? fmt::format("by signal {}", end.signal) : "without a report";
  return fmt::format("the process ended {}: {}", how, last_line(end.errors));
}

Result<std::vector<Variation>> run_variations(const VariationPlan& plan, const std::atomic<int>* interrupt,
                                              const std::function<void(const Variation&)>& ended) {
  std::vector<Variation> variations;
  std::vector<Words> commands;
  for (int i = 0; i < plan.seeds; ++i) {
    const std::uint64_t seed = plan.first_seed + static_cast<std::uint64_t>(i);
    variations.push_back({.seed = seed, .command = run_command(plan, seed), .end = {}});
    commands.push_back(process_of(plan, variations.back().command));
  }
  std::vector<bool> over(variations.size(), false);
  PoolOptions options{.jobs = plan.jobs, .interrupt = interrupt};
  options.ended = [&](std::size_t index, const ProcessEnd& end) {
    Variation& variation = variations[index];
    variation.end = end;
    variation.report = read_report(end.output);
    over[index] = true;
    if (ended) ended(variation);
    return end.status != kRefused;
  };
  if (auto ends = run_processes(commands, options); !ends) return std::unexpected(std::move(ends.error()));
  std::vector<Variation> run;
  for (std::size_t i = 0; i < variations.size(); ++i)
    if (over[i]) run.push_back(std::move(variations[i]));
  return run;
}

void film_failures(const VariationPlan& plan, const std::atomic<int>* interrupt, std::vector<Variation>& variations) {
  std::vector<Variation*> filmed;
  std::vector<TemporaryFile> films;
  std::vector<Words> commands;
  for (Variation& variation : variations) {
    if (variation.passed() || !variation.ended_in_order() || variation.interrupted()) continue;
    if (filmed.size() == static_cast<std::size_t>(plan.films)) break;
    auto film = TemporaryFile::create(".mp4");
    if (!film) return;
    Words words = process_of(plan, variation.command);
    const double begin = std::max(0.0, variation.sim_time() - kFilmedSeconds);
    for (const char* word : {"--size", "640x360", "--video-from"}) words.emplace_back(word);
    words.push_back(fmt::format("{:.3f}", begin));
    words.emplace_back("--video");
    words.push_back(film->path().string());
    filmed.push_back(&variation);
    films.push_back(std::move(*film));
    commands.push_back(std::move(words));
  }
  const auto ends = run_processes(commands, {.jobs = plan.jobs, .interrupt = interrupt});
  if (!ends) return;
  for (std::size_t i = 0; i < filmed.size(); ++i) {
    // The same run ends in the same manner; one that does not is not what the film is to show.
    if ((*ends)[i].status == filmed[i]->end.status) filmed[i]->film = read_whole(films[i].path());
  }
}

}  // namespace takt::tools
