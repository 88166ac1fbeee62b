#pragma once

#include <chrono>
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

/// Which cases of a long test this process tries, so that several can run side by side.
///   TAKT_SHARE=k/n  the k-th of n shares, k from 1 on; else all of them
struct Share {
  long which = 1, of = 1;

  Share() {
    const char* share = std::getenv("TAKT_SHARE");
    if (share == nullptr) return;
    if (std::sscanf(share, "%ld/%ld", &which, &of) == 2 && which >= 1 && which <= of) return;
    std::fprintf(stderr, "TAKT_SHARE is '%s', must be k/n with 1 <= k <= n\n", share);
    std::exit(2);
  }
  [[nodiscard]] bool has(std::int64_t number) const { return number % of == which - 1; }
};

/// Says on stderr now and then how far a long test has come.
class Progress {
 public:
  /// @param text  called only if it is time to say something again
  template <typename Text>
  void tell(const Text& text) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(20)) return;
    last_ = now;
    std::fprintf(stderr, "  %s\n", std::string(text()).c_str());
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace takt::test
