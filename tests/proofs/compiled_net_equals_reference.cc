// The compiled form of a net against the plain reading of the same description, bit for bit (rows N1, N5, O1, O2, O3).
#include <gtest/gtest.h>

#include "tests/core/net/net_support.h"
#include "tests/core/net/random_net.h"
#include "tests/core/net/side_by_side.h"
#include "tests/support/random_runs.h"

namespace takt::net {
namespace {

constexpr int kCycles = 30;

/// Frames carry no names in random nets, so every one of them must be accepted.
TEST(CompiledNet, RowsN1N5O1O2O3EqualsReferenceOnRandomNets) {
  const test::RandomRuns runs(10'000);
  std::int64_t fragments = 0, delays = 0, nulls = 0, values = 0;
  for (long i = 0; i < runs.count; ++i) {
    const std::uint64_t seed = runs.first_seed + static_cast<std::uint64_t>(i);
    Random random(seed, "nets");
    const NetDescription description = random_net(random, 3 + static_cast<int>(seed % 40));
    const auto net = make_net(description);
    ASSERT_NE(net, nullptr) << "seed " << seed << "\n" << net_to_json(description).dump(1);
    ReferenceNet reference(description);
    SideBySide both(*net, reference);
    const std::string difference = both.first_difference(kCycles);
    ASSERT_EQ(difference, "") << "seed " << seed << "\n" << net_to_json(description).dump(1);
    fragments += static_cast<std::int64_t>(description.fragments.size());
    delays += static_cast<std::int64_t>(net->ports().size() - reference.output_slots().size());
    nulls += both.nulls;
    values += both.values;
  }
  std::printf("%ld nets of %d cycles: %lld fragments, %lld delayed links, %lld values and %lld nulls compared\n",
              runs.count, kCycles, static_cast<long long>(fragments), static_cast<long long>(delays),
              static_cast<long long>(values), static_cast<long long>(nulls));
  // The generator must not have gone stale.
  EXPECT_GT(fragments, runs.count / 4);
  EXPECT_GT(delays, runs.count);
  EXPECT_GT(nulls, runs.count * kCycles);
  EXPECT_GT(values, runs.count * kCycles);
}

}  // namespace
}  // namespace takt::net
