// Whole runs of scenarios/touch.json, without film and recording: how many times real time, and where the time goes.
// Run from the root of the repository.
#include <algorithm>
#include <vector>

#include <benchmark/benchmark.h>

#include "cell/run/session.h"

namespace takt {
namespace {

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

std::unique_ptr<cell::Session> prepare(benchmark::State& state, bool measure) {
  auto description = cell::read_description("scenarios/touch.json");
  if (!description) {
    state.SkipWithError(description.error().to_string().c_str());
    return nullptr;
  }
  description->expectations.clear();  // "repeats" would run everything twice
  auto session = cell::Session::create(std::move(*description), models(), measure);
  if (!session) {
    state.SkipWithError(session.error().to_string().c_str());
    return nullptr;
  }
  return std::move(*session);
}

void BM_TouchRun(benchmark::State& state) {
  const bool measure = state.range(0) != 0;
  cell::RunOptions options;
  options.measure_times = measure;
  std::vector<double> factors;
  cell::RunReport report;
  for (auto _ : state) {
    state.PauseTiming();
    auto session = prepare(state, measure);
    if (!session) return;
    state.ResumeTiming();
    report = session->run(options);
    factors.push_back(report.sim_time / report.wall_time);
  }
  std::ranges::sort(factors);
  state.counters["times_real_time_median"] = factors[factors.size() / 2];
  state.counters["times_real_time_worst"] = factors.front();
  if (!measure) return;
  const double per_cycle = 1e6 / static_cast<double>(report.cycles);
  state.counters["physics_us_per_cycle"] = report.timing.physics * per_cycle;
  state.counters["controller_us_per_cycle"] = report.timing.controller * per_cycle;
  state.counters["core_us_per_cycle"] = report.timing.core * per_cycle;
  state.counters["digest_us_per_cycle"] = report.timing.digest * per_cycle;
  state.counters["program_us_per_cycle"] = report.timing.program * per_cycle;
}
BENCHMARK(BM_TouchRun)->ArgName("measured")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->MinTime(2.0);

/// From the file to a session that could run: reading, models, simulation, rehearsal.
void BM_TouchPrepare(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(prepare(state, false));
}
BENCHMARK(BM_TouchPrepare)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace takt

BENCHMARK_MAIN();
