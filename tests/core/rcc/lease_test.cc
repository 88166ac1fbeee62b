// Who commands from outside, and what becomes of its nets when it falls silent.
#include "core/rcc/lease.h"

#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using rcc::NetState;

class LeaseTest : public CoreTest {
 protected:
  void cycles(rcc::Lease& lease, int count) {
    for (int i = 0; i < count; ++i) {
      guarded_step(*core);
      lease.after_cycle();
    }
  }
  rcc::NetId motion(const std::string& arm) {
    const PlannedLine plan(JointVector::Zero(kFakeJoints), joints(0.5, 0.3, -0.2));
    return load(ptp_net("move " + arm, arm, plan));
  }
};

TEST_F(LeaseTest, ASilentHoldersNetsComeToRestOnTheirPaths) {
  rcc::Lease lease(*core);
  const auto fence = lease.grant(50);
  const rcc::NetId net = motion("left");
  ASSERT_TRUE(lease.add(net, fence));
  ASSERT_NE(core->start(net), 0u);
  for (int i = 0; i < 4; ++i) {
    cycles(lease, 40);
    EXPECT_TRUE(lease.renew(fence)) << "a word every 40 cycles is enough";
  }
  EXPECT_EQ(core->state(net), NetState::kRunning);
  cycles(lease, 53);
  EXPECT_EQ(core->state(net), NetState::kCanceling);
  EXPECT_EQ(lease.holder(), 0u);
  EXPECT_FALSE(lease.renew(fence)) << "it is over for good";
  cycles(lease, 2000);
  EXPECT_EQ(core->state(net), NetState::kTerminated);
  EXPECT_EQ(core->status(net).cause.code, net::Cause::Code::kCancelled);
  expect_limits_kept(*left_backend);
}

TEST_F(LeaseTest, NothingThatStillWaitsStarts) {
  rcc::Lease lease(*core);
  const auto fence = lease.grant(20);
  const rcc::NetId first = motion("left"), second = motion("right");
  ASSERT_TRUE(lease.add(first, fence) && lease.add(second, fence));
  ASSERT_NE(core->start(first), 0u);
  const rcc::Rule then{.condition = {rcc::Term::state(first, {NetState::kTerminated})},
                       .action = {.abort = {}, .cancel = {}, .start = {second}}};
  ASSERT_NE(core->post(then), 0u);
  cycles(lease, 3000);
  EXPECT_EQ(core->state(first), NetState::kTerminated);
  EXPECT_FALSE(core->knows(second));
  EXPECT_EQ(right_backend->sent.back().q, JointVector::Zero(kFakeJoints));
}

TEST_F(LeaseTest, AStartThatWasUnderWayIsCancelledAfterTheEnd) {
  rcc::Lease lease(*core);
  const auto fence = lease.grant(5);
  const rcc::NetId net = motion("left");
  ASSERT_TRUE(lease.add(net, fence));
  ASSERT_NE(core->start(net), 0u);
  EXPECT_TRUE(lease.release(fence));
  cycles(lease, 3000);
  EXPECT_EQ(core->state(net), NetState::kTerminated);
  EXPECT_EQ(core->status(net).cause.code, net::Cause::Code::kCancelled);
}

TEST_F(LeaseTest, ANewHolderEndsWhatTheOldOneHadAndKeepsItsOwn) {
  rcc::Lease lease(*core);
  const auto old = lease.grant(1000);
  const rcc::NetId left = motion("left"), right = motion("right");
  ASSERT_TRUE(lease.add(left, old));
  ASSERT_NE(core->start(left), 0u);
  cycles(lease, 20);
  const auto fence = lease.grant(1000);
  EXPECT_GT(fence, old);
  EXPECT_FALSE(lease.renew(old));
  EXPECT_FALSE(lease.release(old));
  ASSERT_TRUE(lease.add(right, fence));
  ASSERT_NE(core->start(right), 0u);
  cycles(lease, 100);
  EXPECT_NE(core->state(left), NetState::kRunning);
  EXPECT_EQ(core->state(right), NetState::kRunning);
}

TEST_F(LeaseTest, HoldersBesideEachOtherEndOneByOne) {
  rcc::Lease lease(*core);
  const auto one = lease.grant_beside(50), other = lease.grant_beside(5000);
  EXPECT_GT(other, one);
  const rcc::NetId left = motion("left"), right = motion("right");
  ASSERT_TRUE(lease.add(left, one) && lease.add(right, other));
  EXPECT_EQ(lease.owner(left), one);
  EXPECT_EQ(lease.owner(right), other);
  ASSERT_NE(core->start(left), 0u);
  ASSERT_NE(core->start(right), 0u);
  cycles(lease, 100);
  EXPECT_FALSE(lease.holds(one)) << "it was silent";
  EXPECT_TRUE(lease.holds(other));
  EXPECT_NE(core->state(left), NetState::kRunning);
  EXPECT_EQ(core->state(right), NetState::kRunning);
  lease.release_all();
  EXPECT_EQ(lease.holder(), 0u);
  cycles(lease, 3);
  EXPECT_NE(core->state(right), NetState::kRunning);
}

TEST_F(LeaseTest, ThereIsRoomForSoManyHolders) {
  rcc::Lease lease(*core);
  std::vector<std::uint32_t> fences;
  for (std::size_t i = 0; i < rcc::Lease::kHolders; ++i) fences.push_back(lease.grant_beside(0));
  EXPECT_EQ(std::ranges::count(fences, 0u), 0);
  EXPECT_EQ(lease.grant_beside(0), 0u);
  ASSERT_TRUE(lease.release(fences[3]));
  EXPECT_GT(lease.grant_beside(0), fences.back());
}

TEST_F(LeaseTest, WithoutALimitSilenceIsAllowed) {
  rcc::Lease lease(*core);
  const auto fence = lease.grant(0);
  cycles(lease, 5000);
  EXPECT_TRUE(lease.renew(fence));
}

TEST_F(LeaseTest, NetsThatHaveEndedMakeRoom) {
  rcc::Lease lease(*core);
  const auto fence = lease.grant(0);
  net::NetDescription brief;
  brief.name = "brief";
  brief.add("end", "Termination", {{"condition", true}});
  std::vector<rcc::NetId> nets;
  for (std::size_t i = 0; i < rcc::Lease::kNets; ++i) {
    nets.push_back(load(brief));
    ASSERT_TRUE(lease.add(nets.back(), fence));
  }
  const rcc::NetId more = load(brief);
  EXPECT_FALSE(lease.add(more, fence));
  ASSERT_NE(core->start(nets.front()), 0u);
  cycles(lease, 3);
  EXPECT_TRUE(lease.add(more, fence));
}

}  // namespace
}  // namespace takt::test
