#include "core/rcc/digest.h"

#include <array>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using rcc::Digest;

/// Row D4: the lowest bit of any byte of any block in any cycle counts.
TEST(Digest, D4_AnyBitOfAnyBlockInAnyCycleCounts) {
  constexpr int kCycles = 20, kBlocks = 3;
  constexpr std::array<std::size_t, kBlocks> kSizes = {8, 250, 1000};
  const auto run = [&](int cycle, int block, std::size_t byte) {
    Digest digest;
    Random random(1);
    for (int k = 0; k < kCycles; ++k)
      for (int b = 0; b < kBlocks; ++b) {
        std::vector<std::byte> bytes(kSizes[static_cast<std::size_t>(b)]);
        for (std::byte& one : bytes) one = static_cast<std::byte>(random.bits());
        if (k == cycle && b == block) bytes[byte] ^= std::byte{1};
        digest.take(static_cast<std::uint64_t>(b), bytes);
      }
    return digest.value();
  };
  const auto reference = run(-1, 0, 0);
  EXPECT_EQ(run(-1, 0, 0), reference);
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    const int cycle = static_cast<int>(random.unit() * kCycles), block = static_cast<int>(random.unit() * kBlocks);
    const std::size_t size = kSizes[static_cast<std::size_t>(block)];
    EXPECT_NE(run(cycle, block, static_cast<std::size_t>(random.unit() * static_cast<double>(size))), reference);
  }
}

TEST(Digest, WhereABlockEndsCounts) {
  const std::array<std::byte, 8> bytes{};
  Digest one, two;
  one.take(1, std::span(bytes).first(4));
  one.take(1, std::span(bytes).last(4));
  two.take(1, bytes);
  EXPECT_NE(one.value(), two.value());
}

TEST(Digest, ReadingItDisturbsNothing) {
  const std::array<std::byte, 300> bytes{};
  Digest one, two;
  for (int i = 0; i < 5; ++i) {
    one.take(1, bytes);
    (void)one.value();
    two.take(1, bytes);
  }
  EXPECT_EQ(one.value(), two.value());
  EXPECT_EQ(to_string(one.value()).size(), 32u);
}

class DigestOfTheCore : public CoreTest {};

/// Every value of a device's sample counts, in the one cycle in which it differs, also while nothing reads it.
TEST_F(DigestOfTheCore, D4_EveryValueOfASampleCounts) {
  using Change = void (*)(device::ArmSample&);
  const auto run = [this](Change change) {
    build({});
    const auto ptp = load(ptp_net("ptp", "left", {JointVector::Zero(3), joints(0.5, 0, 0)}));
    core->start(ptp);
    steps(100);
    const auto before = right_backend->state();
    if (change != nullptr) change(right_backend->state());
    guarded_step(*core);
    right_backend->state() = before;
    steps(20);
    return core->digest().value();
  };
  const auto reference = run(nullptr);
  EXPECT_EQ(run(nullptr), reference);
  for (const Change change :
       {Change([](device::ArmSample& s) { s.q[2] = std::nextafter(s.q[2], 1.0); }),
        Change([](device::ArmSample& s) { s.dq[0] = std::nextafter(s.dq[0], 1.0); }),
        Change([](device::ArmSample& s) { s.tau = JointVector::Zero(3); }),
        Change([](device::ArmSample& s) { s.fault ^= 1u; }), Change([](device::ArmSample& s) { s.ready = false; }),
        Change([](device::ArmSample& s) { ++s.sequence; })})
    EXPECT_NE(run(change), reference);
}

/// The values of the blocks say which one differs, cycle by cycle, and change nothing of the digest.
TEST_F(DigestOfTheCore, D4_TheFirstBlockThatDiffersIsNamed) {
  using Cycle = std::vector<Digest::BlockValue>;
  const auto run = [this](double constant, bool keep) {
    build({});
    if (keep) core->digest().keep_blocks(64);
    auto net = ptp_net("motion", "left", {JointVector::Zero(3), joints(0.5, 0, 0)});
    net.add("late", "OnDelay", {{"delay", 0.05}, {"input", true}}).add("extra", "SelectReal", {{"if_false", 0.0}});
    net.add("value", "ConstantReal", {{"value", constant}});
    net.link("late.value", "extra.condition").link("value.value", "extra.if_true");
    core->start(load(net));
    std::vector<Cycle> cycles;
    for (int k = 0; k < 100; ++k) {
      guarded_step(*core);
      const auto blocks = core->digest().blocks();
      cycles.emplace_back(blocks.begin(), blocks.end());
    }
    return std::pair(cycles, core->digest().value());
  };
  const auto [one, digest] = run(1.0, true);
  EXPECT_EQ(run(1.0, true).first, one);
  EXPECT_EQ(run(1.0, false).second, digest);
  EXPECT_TRUE(run(1.0, false).first.back().empty());
  EXPECT_EQ(one.back().size(), 4u) << "the cycle, the net, two arms";
  const auto other = run(std::nextafter(1.0, 2.0), true).first;
  std::set<std::string> differ;
  for (std::size_t k = 0; k < one.size(); ++k)
    for (std::size_t b = 0; b < one[k].size(); ++b)
      if (one[k][b] != other[k][b]) differ.insert(core->block_name(one[k][b].block));
  EXPECT_EQ(differ, (std::set<std::string>{"net 1 'motion'"}));
  std::vector<std::string> names;
  for (const auto& block : one.back()) names.push_back(core->block_name(block.block));
  EXPECT_EQ(names,
            (std::vector<std::string>{"number of the cycle", "net 1 'motion'", "device 'left'", "device 'right'"}));
}

/// Every slot of every net counts: here a value that nothing uses, in one cycle.
TEST_F(DigestOfTheCore, D4_EverySlotCounts) {
  const auto run = [this](double constant) {
    build({});
    auto net = ptp_net("ptp", "left", {JointVector::Zero(3), joints(0.5, 0, 0)});
    net.add("unused", "ConstantReal", {{"value", constant}});
    core->start(load(net));
    steps(3);
    return core->digest().value();
  };
  EXPECT_EQ(run(1.0), run(1.0));
  EXPECT_NE(run(1.0), run(std::nextafter(1.0, 2.0)));
}

}  // namespace
}  // namespace takt::test
