#include "tools/interruption_tries.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/run/interruptions.h"
#include "cell/run/session.h"

namespace takt::tools {
namespace {

using cell::Interruptions;
using Way = Interruptions::Way;

/// The cycles of all ways are multiples of this.
std::int64_t common_cycles(const InterruptionArguments& arguments) {
  return std::gcd(std::gcd(arguments.cancel_every, arguments.pause_every),
                  std::gcd(arguments.abort_every, arguments.fault_every));
}

std::vector<Way> ways_at(std::int64_t cycle, const InterruptionArguments& arguments, InterruptionTries& tries) {
  std::vector<Way> ways;
  const auto add = [&](Way way, std::int64_t every, int& count) {
    if (every == 0 || cycle % every != 0) return;
    ways.push_back(way);
    ++count;
  };
  add(Way::kCancel, arguments.cancel_every, tries.cancels);
  add(Way::kPause, arguments.pause_every, tries.pauses);
  add(Way::kAbort, arguments.abort_every, tries.aborts);
  add(Way::kFault, arguments.fault_every, tries.faults);
  return ways;
}

}  // namespace

void add_interruption_options(CLI::App& verb, InterruptionArguments& arguments) {
  const auto add = [&](const char* option, std::int64_t& every, const char* what) {
    verb.add_option(option, every, fmt::format("Each scenario once more, {} at every N-th cycle in a fork", what))
        ->type_name("N")
        ->check(CLI::PositiveNumber);
  };
  add("--cancel-every", arguments.cancel_every, "cancelled");
  add("--pause-every", arguments.pause_every, "paused and resumed");
  add("--abort-every", arguments.abort_every, "aborted");
  add("--fault-every", arguments.fault_every, "met by a fault of a device");
}

InterruptionTries try_interruptions(const std::filesystem::path& file, const InterruptionArguments& arguments,
                                    const Common& common) {
  InterruptionTries tries;
  cell::OpenOptions opening;
  opening.all_may_fail = arguments.fault_every > 0;
  auto session = cell::Session::open(file, common.library(), opening);
  if (!session) {
    tries.diagnostics = session.error();
    return tries;
  }
  const std::int64_t every = common_cycles(arguments);
  Interruptions interruptions({.first = every, .every = every, .ways = [&, every](std::int64_t point) {
                                 return ways_at((point + 1) * every, arguments, tries);
                               }});
  cell::RunOptions options;
  options.measure_times = false;
  options.repeat = false;
  interruptions.attach(options);
  const cell::RunReport report = (*session)->run(options);
  if (interruptions.in_child()) {
    const cell::BuiltCell& built = (*session)->built();
    interruptions.come_to_rest(built);
    interruptions.answer_after(built.cell, built.core->period(), report);
  }
  tries.failures = interruptions.failures();
  tries.failed = interruptions.failed();
  return tries;
}

nlohmann::ordered_json to_json(const InterruptionTries& tries) {
  return {{"held", tries.held()},   {"cancels", tries.cancels},
          {"pauses", tries.pauses}, {"aborts", tries.aborts},
          {"faults", tries.faults}, {"failures", tries.failures},
          {"films", tries.films},   {"diagnostics", to_json(tries.diagnostics)}};
}

std::string to_text(const InterruptionTries& tries) {
  std::string counts;
  const std::pair<int, const char*> rows[] = {
      {tries.cancels, "cancels"}, {tries.pauses, "pauses"}, {tries.aborts, "aborts"}, {tries.faults, "faults"}};
  for (const auto& [count, what] : rows)
    if (count > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, what);
  std::string text = fmt::format("  {} {:<28} {}\n", tries.held() ? "ok  " : "FAIL", "interruptions", counts);
  for (const std::string& failure : tries.failures) text += fmt::format("       {}\n", failure);
  for (const std::string& film : tries.films) text += fmt::format("       film {}\n", film);
  return text;
}

}  // namespace takt::tools
