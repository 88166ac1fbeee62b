// Row D2: whatever the program's latency is, every example that is short enough still does what it promises.
#include <string>

#include <gtest/gtest.h>

#include "scenario/session.h"

namespace takt::scenario {
namespace {

/// The expectation that the run repeats would take a second run each; other tests hold it.
RunReport run_with(const std::string& file, int latency) {
  static const device::ModelLibrary models({"models"});
  OpenOptions options;
  options.overrides.push_back({"/program_latency_cycles", std::to_string(latency)});
  auto session = Session::open(file, models, options);
  RunReport report;
  if (!session) {
    report.findings = session.error();
    return report;
  }
  RunOptions run;
  run.measure_times = false;
  run.repeat = false;
  return (*session)->run(run);
}

struct Example {
  const char* file;
  int latency;
};
void PrintTo(const Example& example, std::ostream* out) { *out << example.file << " with " << example.latency; }

class Latency : public testing::TestWithParam<Example> {};

TEST_P(Latency, RowD2EveryExpectationStillHolds) {
  const RunReport report = run_with(GetParam().file, GetParam().latency);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.findings.to_string();
  for (const ExpectationResult& result : report.expectations) {
    EXPECT_TRUE(result.passed) << result.name << ": " << result.measured;
  }
}

// Every latency is tried, every example with the extremes; a run takes some tenths of a second to a few.
constexpr Example kExamples[] = {
    {"scenarios/touch.json", 0},  {"scenarios/touch.json", 1},   {"scenarios/touch.json", 50},
    {"scenarios/can.json", 0},    {"scenarios/can.json", 3},     {"scenarios/can.json", 50},
    {"scenarios/pick.json", 0},   {"scenarios/pick.json", 5},    {"scenarios/pick.json", 50},
    {"scenarios/blend.json", 0},  {"scenarios/blend.json", 2},   {"scenarios/blend.json", 50},
    {"scenarios/wave.json", 0},   {"scenarios/wave.json", 10},   {"scenarios/wave.json", 50},
    {"scenarios/search.json", 0}, {"scenarios/search.json", 50}, {"scenarios/sort.json", 0},
    {"scenarios/sort.json", 20},  {"scenarios/sort.json", 50},
};
INSTANTIATE_TEST_SUITE_P(Each, Latency, testing::ValuesIn(kExamples));

}  // namespace
}  // namespace takt::scenario
