#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace takt::test {

/// How many random cases a test tries and from which seed on; printed, so that every run can be repeated.
///   TAKT_SEED=n    the first seed in place of 1
///   TAKT_RUNS=x    x times as many cases (0.01 for a glance, 1000 for a night)
struct RandomRuns {
  std::uint64_t first_seed = 1;
  long count;

  explicit RandomRuns(long usual_count) : count(usual_count) {
    if (const char* seed = std::getenv("TAKT_SEED")) first_seed = std::strtoull(seed, nullptr, 10);
    if (const char* runs = std::getenv("TAKT_RUNS")) {
      count = static_cast<long>(static_cast<double>(usual_count) * std::strtod(runs, nullptr));
    }
    if (count < 1) count = 1;
    std::printf("%ld random cases from seed %llu on (TAKT_SEED, TAKT_RUNS change that)\n", count,
                static_cast<unsigned long long>(first_seed));
  }
};

}  // namespace takt::test
