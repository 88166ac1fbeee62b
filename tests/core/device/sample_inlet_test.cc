// Samples out of order, lost, repeated (row T2).
#include <vector>

#include <gtest/gtest.h>

#include "core/device/sample_inlet.h"

namespace takt::device {
namespace {

InletCounts counts(const std::vector<std::uint64_t>& sequences, std::vector<bool> accepted = {}) {
  SampleInlet inlet;
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    const bool taken = inlet.accept(sequences[i]);
    if (i < accepted.size()) {
      EXPECT_EQ(taken, accepted[i]) << "sample " << i;
    }
  }
  return inlet.counts();
}

TEST(SampleInlet, T2_OnlyWhatIsNewerIsAccepted) {
  const auto c = counts({5, 6, 6, 9, 8, 7, 7, 10}, {true, true, false, true, false, false, false, true});
  EXPECT_EQ(c.accepted, 4u);
  EXPECT_EQ(c.repeated, 2u);
  EXPECT_EQ(c.reordered, 2u);
  EXPECT_EQ(c.lost, 0u) << "7 and 8 came after all";
}

TEST(SampleInlet, WhatNeverCameIsLost) { EXPECT_EQ(counts({1, 2, 5, 6, 16}).lost, 11u); }

TEST(SampleInlet, WhatHasComeIsKnown) {
  SampleInlet inlet;
  for (const std::uint64_t n : {1, 2, 5}) inlet.accept(n);
  EXPECT_TRUE(inlet.seen(2));
  EXPECT_FALSE(inlet.seen(3));
  EXPECT_FALSE(inlet.seen(6));
  for (std::uint64_t n = 6; n <= 100; ++n) inlet.accept(n);
  EXPECT_FALSE(inlet.seen(5)) << "too long ago to be known";
}

}  // namespace
}  // namespace takt::device
