#include "core/base/processors.h"

#include <pthread.h>
#include <sched.h>

#include <thread>

#include <gtest/gtest.h>

namespace takt {
namespace {

cpu_set_t allowed() {
  cpu_set_t set;
  EXPECT_EQ(pthread_getaffinity_np(pthread_self(), sizeof set, &set), 0);
  return set;
}

/// The lowest that this process may use.
int first_processor() {
  const cpu_set_t set = allowed();
  for (int i = 0; i < CPU_SETSIZE; ++i)
    if (CPU_ISSET(static_cast<std::size_t>(i), &set)) return i;
  return -1;
}

TEST(Processors, OneThatIsNotThereIsRefusedAndNothingChanges) {
  const cpu_set_t before = allowed();
  for (const int missing : {-1, CPU_SETSIZE - 1, CPU_SETSIZE}) {
    EXPECT_FALSE(has_processor(missing)) << missing;
    EXPECT_FALSE(run_on_processor(missing)) << missing;
  }
  EXPECT_FALSE(keep_off_processor(-1));
  EXPECT_TRUE(has_processor(first_processor()));
  const cpu_set_t after = allowed();
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

TEST(Processors, AThreadRunsOnlyWhereItIsToldTo) {
  const int first = first_processor();
  std::jthread([first] {
    ASSERT_TRUE(run_on_processor(first));
    EXPECT_EQ(sched_getcpu(), first);
    EXPECT_FALSE(keep_off_processor(first)) << "it is the only one";
    EXPECT_EQ(sched_getcpu(), first);
  }).join();
}

TEST(Processors, WhoKeepsOffOneStartsThreadsThatDoTheSame) {
  const int first = first_processor();
  const cpu_set_t before = allowed();
  std::jthread([first, one = CPU_COUNT(&before) < 2] {
    ASSERT_EQ(keep_off_processor(first), !one);
    if (one) return;
    EXPECT_TRUE(keep_off_processor(first)) << "it has left it already";
    std::jthread([first] {
      const cpu_set_t inherited = allowed();
      EXPECT_FALSE(CPU_ISSET(static_cast<std::size_t>(first), &inherited));
      EXPECT_TRUE(run_on_processor(first)) << "a thread of its own may come back";
    }).join();
  }).join();
}

}  // namespace
}  // namespace takt
