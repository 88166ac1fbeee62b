#include "sim/film/shadow_ranges.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace takt::sim {
namespace {

/// As the header says it: every texel of the block and kShadowReach around it; beyond the map there is nothing.
ShadowRange looked_up(const std::vector<std::uint16_t>& depth, int size, int column, int row) {
  int least = 65535, greatest = 0;
  for (int y = row * kShadowBlock - kShadowReach; y < (row + 1) * kShadowBlock + kShadowReach; ++y) {
    for (int x = column * kShadowBlock - kShadowReach; x < (column + 1) * kShadowBlock + kShadowReach; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < size && y < size;
      const int here = inside ? depth[static_cast<std::size_t>(y * size + x)] : 65535;
      least = std::min(least, here);
      greatest = std::max(greatest, here);
    }
  }
  return {.least = least == 65535 ? kNoCaster : static_cast<float>(least) / 65535,
          .greatest = greatest == 65535 ? kNoCaster : static_cast<float>(greatest) / 65535};
}

TEST(ShadowRanges, HoldEveryDepthThatAFilterCanMeet) {
  std::mt19937 random(3);
  ShadowRanges ranges;
  for (const int size : {16, 64, 132}) {
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(size * size), 65535);
    for (int i = 0; i < size; ++i) depth[random() % depth.size()] = static_cast<std::uint16_t>(random() % 65536);
    for (int y = 8; y < size; ++y)
      for (int x = 0; x < size / 2; ++x) depth[static_cast<std::size_t>(y * size + x)] = 30'000;
    const auto found = ranges.of(depth, size, 0.1f);
    const int blocks = size / kShadowBlock;
    ASSERT_EQ(found.size(), static_cast<std::size_t>(blocks * blocks));
    for (int row = 0; row < blocks; ++row) {
      for (int column = 0; column < blocks; ++column) {
        const ShadowRange one = found[static_cast<std::size_t>(row * blocks + column)];
        const ShadowRange wanted = looked_up(depth, size, column, row);
        EXPECT_LE(one.least, wanted.least);
        EXPECT_GE(one.greatest, wanted.greatest);
        EXPECT_NEAR(one.least, wanted.least, 2e-5);
        EXPECT_NEAR(one.greatest, wanted.greatest, 2e-5);
        EXPECT_EQ(one.edge > 0, one.greatest - one.least > 0.1f);
      }
    }
  }
}

TEST(ShadowRanges, AnEmptyMapShadesNothing) {
  ShadowRanges ranges;
  for (const ShadowRange& one : ranges.of(std::vector<std::uint16_t>(32 * 32, 65535), 32, 0.1f)) {
    EXPECT_EQ(one.least, kNoCaster);
    EXPECT_EQ(one.edge, 0);
  }
}

}  // namespace
}  // namespace takt::sim
