// The life of a net (row L1): which transitions there are, and that no request brings about another one.
#include "core/rcc/net_state.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using rcc::Event;
using rcc::NetState;

constexpr std::array kStates = {NetState::kLoading, NetState::kRejected,  NetState::kReady,
                                NetState::kRunning, NetState::kCanceling, NetState::kTerminated};

TEST(NetStates, L1_OnlyTheseTransitionsAreLegal) {
  std::set<std::string> legal;
  for (const NetState from : kStates)
    for (const NetState to : kStates)
      if (is_legal(from, to)) legal.insert(fmt::format("{} -> {}", name_of(from), name_of(to)));
  EXPECT_EQ(legal, (std::set<std::string>{"Loading -> Ready", "Loading -> Rejected", "Ready -> Running",
                                          "Running -> Canceling", "Running -> Terminated", "Canceling -> Terminated"}));
}

class LifeOfNets : public CoreTest {};

/// Starts, cancels and aborts in any order, also of nets that ended, that were forgotten and that never were: every
/// request has one answer, states only change along legal transitions, and nobody holds an arm twice.
TEST_F(LifeOfNets, L1_AnyOrderOfRequestsKeepsToTheTransitionsAndIsAnswered) {
  Random random(20261121);
  left_backend->keep = right_backend->keep = false;
  std::map<rcc::NetId, NetState> states;
  std::set<rcc::RequestId> open;
  std::vector<rcc::NetId> nets{4711};
  const auto here = [this](const char* arm) { return core->find_arm(arm)->set_point().q; };
  for (int k = 0; k < 4'000; ++k) {
    if (k % 40 == 0 && nets.size() < 60) {
      const char* arm = random.unit() < 0.5 ? "left" : "right";
      const JointVector q = here(arm);
      JointVector goal = q;
      goal[0] = q[0] > 0 ? q[0] - 0.1 : q[0] + 0.1;
      nets.push_back(load(ptp_net("ptp", arm, {q, goal})));
      states[nets.back()] = NetState::kReady;
    }
    const auto some = [&] { return nets[static_cast<std::size_t>(random.unit() * static_cast<double>(nets.size()))]; };
    const double dice = random.unit();
    if (dice < 0.10) open.insert(core->start(some()));
    if (dice > 0.97) open.insert(core->cancel(some()));
    if (dice > 0.50 && dice < 0.51) open.insert(core->abort(some()));
    if (dice > 0.20 && dice < 0.22)
      open.insert(core->post(rcc::Transaction{.abort = {some()}, .cancel = {}, .start = {some(), some()}}));
    guarded_step(*core);
    std::map<std::string, int> holders;
    for (const Event& event : core->events()) {
      if (event.kind == Event::Kind::kState) {
        ASSERT_TRUE(is_legal(states[event.net], event.state))
            << "net " << event.net << ": " << name_of(states[event.net]) << " -> " << name_of(event.state);
        states[event.net] = event.state;
      } else if (event.request != 0) {
        ASSERT_EQ(open.erase(event.request), 1u) << "answered twice, or never asked";
      }
    }
    for (const auto& [net, state] : states) {
      ASSERT_EQ(core->state(net), state);
      if (!rcc::is_active(state)) continue;
      for (const std::string& resource : core->net(net)->report().resources) ASSERT_EQ(++holders[resource], 1) << k;
    }
  }
  EXPECT_TRUE(open.empty()) << open.size() << " requests were never answered";
  std::set<NetState> seen;
  for (const auto& [net, state] : states) seen.insert(state);
  EXPECT_TRUE(seen.contains(NetState::kTerminated));
}

/// A start that is repeated, a cancel of what is being cancelled, an abort of what has ended: done, and nothing
/// happens.
TEST_F(LifeOfNets, L1_ARequestThatIsFulfilledDoesNothing) {
  const auto run = [this](int times) {
    build({});
    const rcc::NetId net = load(ptp_net("ptp", "left", {joints(0, 0, 0), joints(0.3, 0, 0)}));
    const auto ask = [&](auto request) {
      for (int i = 0; i < times; ++i) request();
      guarded_step(*core);
      int done = 0;
      for (const Event& event : core->events()) done += event.kind == Event::Kind::kDone;
      EXPECT_EQ(done, times);
    };
    ask([&] { core->start(net); });
    steps(50);
    ask([&] { core->start(net); });
    ask([&] { core->cancel(net); });
    steps(5);
    ask([&] { core->cancel(net); });
    EXPECT_TRUE(run_to_end(net));
    ask([&] { core->cancel(net); });
    ask([&] { core->abort(net); });
    return core->digest().value();
  };
  EXPECT_EQ(run(1), run(3));
}

/// Sixteen nets of one transaction begin in one cycle, or none does.
TEST_F(LifeOfNets, L2_SixteenNetsStartInOneCycleOrNoneDoes) {
  for (const bool one_is_busy : {false, true}) {
    core = std::make_unique<rcc::ControlCore>(rcc::ControlCore::Options{});
    for (int i = 0; i < 16; ++i) add_arm(fmt::format("arm{}", i));
    guarded_step(*core);
    rcc::Transaction all;
    for (int i = 0; i < 16; ++i)
      ASSERT_TRUE(all.start.add(load(ptp_net("ptp", fmt::format("arm{}", i), {joints(0, 0, 0), joints(0.1, 0, 0)}))));
    const rcc::NetId busy = load(ptp_net("busy", "arm9", {joints(0, 0, 0), joints(0.1, 0, 0)}));
    if (one_is_busy) core->start(busy);
    guarded_step(*core);
    (void)core->post(all);
    guarded_step(*core);
    const Event* refused = event(Event::Kind::kRefused);
    ASSERT_EQ(refused != nullptr, one_is_busy);
    if (one_is_busy) {
      EXPECT_EQ(refused->cause.text.view(), fmt::format("arm9 is held by net {}", busy));
    }
    steps(1);
    for (const rcc::NetId net : all.start) {
      EXPECT_EQ(core->state(net), one_is_busy ? NetState::kReady : NetState::kRunning);
      EXPECT_EQ(core->status(net).first_cycle, one_is_busy ? -1 : 3);
    }
  }
}

}  // namespace
}  // namespace takt::test
