// Row D2: whatever the program's latency is, every scenario still does what it promises.
#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/base/random.h"
#include "tests/support/random_runs.h"
#include "tests/support/scenario_names.h"

namespace takt::cell::latency_test {
namespace {

/// The expectation that the run repeats would take a second run each, so it is not judged here; other tests hold it.
RunReport run_with(const std::string& file, int latency) {
  static const device::ModelLibrary models({"models"});
  OpenOptions options;
  options.overrides.push_back({"/program_latency_cycles", std::to_string(latency)});
  auto session = Session::open(file, models, options);
  RunReport report;
  if (!session) {
    report.diagnostics = session.error();
    return report;
  }
  RunOptions run;
  run.measure_times = false;
  run.repeat = false;
  return (*session)->run(run);
}

constexpr int kLongest = 50;

/// None and the longest, and some between that the seed chooses; with TAKT_RUNS=20 all of them.
std::set<int> latencies() {
  const takt::test::RandomRuns runs(3);
  std::set<int> chosen{0, kLongest};
  Random random(runs.first_seed, "latency");
  const auto wanted = static_cast<std::size_t>(std::min<long>(runs.count, kLongest + 1));
  while (chosen.size() < wanted) chosen.insert(static_cast<int>(random.unit() * (kLongest + 1)));
  return chosen;
}

class Latency : public testing::TestWithParam<std::string> {};

TEST_P(Latency, RowD2EveryExpectationStillHolds) {
  for (const int latency : latencies()) {
    SCOPED_TRACE(latency);
    const RunReport report = run_with("scenarios/" + GetParam() + ".json", latency);
    EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
    for (const ExpectationResult& result : report.expectations) {
      EXPECT_TRUE(result.passed || !result.judged) << result.name << ": " << result.measured;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Each, Latency, testing::ValuesIn(takt::test::scenario_names()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace takt::cell::latency_test
