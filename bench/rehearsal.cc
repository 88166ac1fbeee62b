// What the check of collisions adds to the rehearsal of a PTP of 2 s, in a cell of 50 bodies: one arm, and two arms in
// parallel branches. The same program with the check switched off is measured in the same run. docs/benchmarks.md has
// the figures.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "core/base/random.h"
#include "core/device/device_file.h"
#include "core/program/tree/program.h"

namespace takt::cell {
namespace {

/// Arms with probes that swing by 70 degrees, and boxes below and around what they sweep.
std::string cell_text(int arms, bool checked) {
  std::string devices, objects, branches;
  for (int i = 0; i < arms; ++i) {
    const std::string name = i == 0 ? "left" : "right";
    devices += fmt::format(
        R"({0}"{1}": {{"model": "lwr4plus", "at": {{"in": "world", "position_m": [{2}, 0, 0.75]}}}},
            "{1} probe": {{"model": "probe_ball", "on": "{1}"}})",
        i > 0 ? ", " : "", name, 1.6 * i);
    branches += fmt::format(
        R"({}{{"do": "ptp", "arm": "{}", "to": {{"joints_deg": [70, -22, 9, 98, 9, -52, 9]}}, "speed": 0.36}})",
        i > 0 ? ", " : "", name);
  }
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const double turn = random.uniform(-3.1, 3.1), radius = random.uniform(0.55, 0.9);
    objects += fmt::format(
        R"({}"body {}": {{"shape": "box", "size_m": [0.08, 0.08, 0.08],
                          "at": {{"in": "world", "position_m": [{}, {}, {}]}}}})",
        i > 0 ? ", " : "", i, radius * std::cos(turn), radius * std::sin(turn), random.uniform(0.0, 0.6));
  }
  return fmt::format(
      R"({{"devices": {{{}}}, "objects": {{{}}}, {} "program": {{"do": "parallel", "branches": [{}]}}}})", devices,
      objects, checked ? "" : R"("collisions": {"off": "measured without"},)", branches);
}

void rehearsal(benchmark::State& state) {
  const auto description = parse_description(cell_text(static_cast<int>(state.range(0)), state.range(1) != 0));
  Diagnostics warnings;
  auto built = build_cell(*description, device::ModelLibrary({"models"}), false, warnings);
  if (!built) return state.SkipWithError(built.error().to_string().c_str());
  const auto program = program::Program::parse(description->program, "/program", built->cell, nullptr);
  std::size_t collisions = 0;
  double duration = 0.0;
  for (auto _ : state) {
    const program::Rehearsed rehearsed = program->rehearse(built->cell);
    collisions += rehearsed.collisions.size();
    duration = rehearsed.duration;
  }
  state.counters["motion_s"] = duration;
  state.counters["collisions"] = static_cast<double>(collisions) / static_cast<double>(state.iterations());
}
BENCHMARK(rehearsal)->ArgNames({"arms", "checked"})->ArgsProduct({{1, 2}, {0, 1}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace takt::cell

BENCHMARK_MAIN();
