#include "cell/judge/run_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/reports.h"

namespace takt::cell::run_log_test {
namespace {

using takt::test::Names;
using testing::ElementsAre;

std::vector<std::uint64_t> cycles(const RunLog& log) {
  std::vector<std::uint64_t> cycles;
  for (const LogEntry& entry : log.entries()) cycles.push_back(entry.cycle);
  return cycles;
}

TEST(RunLog, KeepsTheFirstAndTheLast) {
  RunLog log(5);
  for (std::uint64_t cycle = 1; cycle <= 5; ++cycle) log.add({.cycle = cycle});
  EXPECT_THAT(cycles(log), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(log.omitted(), 0);
  for (std::uint64_t cycle = 6; cycle <= 1000; ++cycle) log.add({.cycle = cycle});
  EXPECT_THAT(cycles(log), ElementsAre(1, 2, 998, 999, 1000));
  EXPECT_EQ(log.omitted(), 995);
}

TEST(RunLog, LevelsHaveNames) {
  for (const std::string& name : log_level_names()) EXPECT_EQ(name_of(*log_level_named(name)), name);
  EXPECT_FALSE(log_level_named("loud"));
  EXPECT_EQ(level_of("program", "begin"), LogLevel::kDebug);
  EXPECT_EQ(level_of("program", "log"), LogLevel::kInfo);
  EXPECT_EQ(level_of("program", "retry"), LogLevel::kWarning);
  EXPECT_EQ(level_of("some arm", "fault"), LogLevel::kError);
  EXPECT_EQ(level_of("fault", "push"), LogLevel::kWarning) << "what the scenario does to the machines";
  EXPECT_EQ(level_of("contact", "contact"), LogLevel::kInfo);
}

TEST(RunLog, ALineHasTimeLevelSourceStepAndText) {
  const LogEntry entry{.time = 3500 * kMillisecond,
                       .cycle = 3500,
                       .level = LogLevel::kWarning,
                       .source = "program",
                       .name = "retry",
                       .step = "measure / touch",
                       .text = "1 of 3"};
  EXPECT_THAT(to_text(entry), Names("3.500", "warning", "program", "retry", "measure", "touch", "1", "3"));
  EXPECT_EQ(to_json(entry).dump(), R"({"time_s":3.5,"cycle":3500,"level":"warning","source":"program","name":"retry",)"
                                   R"("step":"measure / touch","text":"1 of 3"})");
}

TEST(RunLog, AnEventThatIsNamedLikeItsSourceIsNamedOnce) {
  const LogEntry entry{.time = 0, .cycle = 1, .level = LogLevel::kInfo, .source = "contact", .name = "contact"};
  EXPECT_EQ(to_text(entry), "    0.000 s  contact");
}

}  // namespace
}  // namespace takt::cell::run_log_test
