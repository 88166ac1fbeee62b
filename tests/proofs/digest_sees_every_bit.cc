// Row D4: the lowest bit of any port, device value or block of simulation state, flipped in any one cycle, changes the
// digest of the run.
#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/random_runs.h"

namespace takt::test {
namespace {

constexpr int kCycles = 60, kPorts = 12;
constexpr std::size_t kStateWords = 40;

/// What is disturbed: nothing, a port of a net, a value of an arm's sample, or a word of the simulation's state.
struct Flip {
  enum class Where : std::uint8_t { kNowhere, kPort, kNullFlag, kSample, kState };
  Where where = Where::kNowhere;
  int cycle = -1;
  std::size_t which = 0;
};

double flipped(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  bits ^= 1u;
  std::memcpy(&value, &bits, sizeof(bits));
  return value;
}

/// Gives numbers that nothing reads; in one cycle one of them has its lowest bit flipped, or is null.
class ProofNumbers final : public net::Primitive {
 public:
  explicit ProofNumbers(net::Setup& setup) {
    for (std::size_t i = 0; i < kPorts; ++i)
      out_[i] = setup.out<net::Real>("out" + std::to_string(i), {.unit = "1", .may_be_null = true});
  }
  void update(const net::Cycle& cycle) override {
    for (std::size_t i = 0; i < kPorts; ++i) {
      const double value = std::sin(static_cast<double>(cycle.index_in_net * kPorts) + static_cast<double>(i)) + 2.0;
      const bool hit = flip.cycle == cycle.index_in_net && flip.which == i;
      if (hit && flip.where == Flip::Where::kNullFlag) {
        out_[i].set_null();
      } else {
        out_[i].set(hit && flip.where == Flip::Where::kPort ? flipped(value) : value);
      }
    }
  }
  static inline Flip flip;

 private:
  std::array<net::Out<net::Real>, kPorts> out_;
};
TAKT_PRIMITIVE(ProofNumbers, "test", "Numbers.");

class DigestProof : public CoreTest {
 protected:
  rcc::Digest::Value run(const Flip& flip) {
    build({});
    state_.fill(0.5);
    core->digest().add_block("state", std::as_bytes(std::span(state_)));
    ProofNumbers::flip = flip;
    auto net = ptp_net("ptp", "left", {JointVector::Zero(3), joints(0.5, 0.1, -0.2)});
    net.add("numbers", "ProofNumbers");
    core->start(load(net));
    guarded_step(*core);
    for (int i = 0; i < kCycles; ++i) {
      const device::ArmSample before = right_backend->state();
      const bool now = flip.cycle == i;
      if (now && flip.where == Flip::Where::kSample) disturb(right_backend->state(), flip.which);
      double& word = state_[flip.which % kStateWords];
      if (now && flip.where == Flip::Where::kState) word = flipped(word);
      guarded_step(*core);
      if (now && flip.where == Flip::Where::kState) word = flipped(word);
      if (now && flip.where == Flip::Where::kSample) {
        right_backend->state().q = before.q;
        right_backend->state().dq = before.dq;
      }
    }
    return core->digest().value();
  }
  static void disturb(device::ArmSample& sample, std::size_t which) {
    const auto joint = static_cast<Eigen::Index>(which % kFakeJoints);
    double& value = which % 2 == 0 ? sample.q[joint] : sample.dq[joint];
    value = flipped(value);
  }

 private:
  std::array<double, kStateWords> state_{};
};

TEST_F(DigestProof, RowD4TheLowestBitOfAnythingInAnyCycleChangesTheDigest) {
  const RandomRuns runs(1000);
  const auto reference = run({});
  ASSERT_EQ(run({}), reference);
  Random random(runs.first_seed, "flips");
  std::array<long, 5> tried{};
  for (long i = 0; i < runs.count; ++i) {
    const Flip flip{static_cast<Flip::Where>(1 + random.bits() % 4), static_cast<int>(random.bits() % kCycles),
                    random.bits() % kPorts};
    ASSERT_NE(run(flip), reference) << "where " << static_cast<int>(flip.where) << " cycle " << flip.cycle << " which "
                                    << flip.which;
    ++tried[static_cast<std::size_t>(flip.where)];
  }
  std::printf("each changed the digest: %ld bits of ports, %ld null flags, %ld bits of samples, %ld bits of state\n",
              tried[1], tried[2], tried[3], tried[4]);
}

}  // namespace
}  // namespace takt::test
