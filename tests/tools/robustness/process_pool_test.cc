#include "tools/robustness/process_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>

namespace takt::tools {
namespace {

std::vector<std::string> shell(const std::string& script) { return {"/bin/sh", "-c", script}; }

TEST(ProcessPool, GivesEveryEndInTheOrderOfTheCommands) {
  const auto ends = run_processes({shell("sleep 0.2; echo slow"),
                                   shell("echo quick; echo why >&2; exit 3"),
                                   shell("kill -9 $$"),
                                   {"/nonexistent/program"}},
                                  {.jobs = 4});
  EXPECT_FALSE(ends) << "a program that is not there";
  const auto three = run_processes(
      {shell("sleep 0.2; echo slow"), shell("echo quick; echo why >&2; exit 3"), shell("kill -9 $$")}, {.jobs = 3});
  ASSERT_TRUE(three);
  EXPECT_EQ((*three)[0].output, "slow\n");
  EXPECT_EQ((*three)[0].status, 0);
  EXPECT_GE((*three)[0].wall_s, 0.2);
  EXPECT_EQ((*three)[1].output, "quick\n");
  EXPECT_EQ((*three)[1].errors, "why\n");
  EXPECT_EQ((*three)[1].status, 3);
  EXPECT_EQ((*three)[2].signal, SIGKILL);
  EXPECT_EQ((*three)[2].status, -1);
}

/// Each process notes how many are there: never more than asked for.
TEST(ProcessPool, RunsNoMoreThanItMayAtATime) {
  const auto folder = TemporaryFolder::create();
  ASSERT_TRUE(folder);
  const std::string script =
      "cd '" + folder->path().string() + "'; touch here.$$; ls here.* | wc -l; sleep 0.1; rm here.$$";
  const auto ends = run_processes(std::vector(6, shell(script)), {.jobs = 2});
  ASSERT_TRUE(ends);
  int most = 0;
  for (const ProcessEnd& end : *ends) most = std::max(most, std::stoi(end.output));
  EXPECT_EQ(most, 2);
}

TEST(ProcessPool, AnInterruptIsPassedOnAndStartsNoMore) {
  std::atomic<int> interrupt = 0;
  PoolOptions options{.jobs = 2, .interrupt = &interrupt};
  options.ended = [&](std::size_t, const ProcessEnd&) {
    interrupt = 1;
    return true;
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto ends =
      run_processes({shell("sleep 0.5"), shell("trap 'exit 7' INT; sleep 60 & wait"), shell("exit 0")}, options);
  ASSERT_TRUE(ends);
  EXPECT_EQ((*ends)[0].status, 0);
  EXPECT_EQ((*ends)[1].status, 7) << "asked to end";
  EXPECT_EQ((*ends)[2].status, -1) << "not started";
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

}  // namespace
}  // namespace takt::tools
