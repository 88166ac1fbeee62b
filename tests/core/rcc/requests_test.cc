// Requests to the core: what may be refused for lack of room, and what never is (row L2).
#include <array>
#include <atomic>
#include <thread>
#include <type_traits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rcc/net_bits.h"
#include "core/rcc/request_queue.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Notes;
using takt::test::Reports;

using net::Cause;
using rcc::Event;
using rcc::NetState;

TEST(RequestQueue, GivesBackInOrderAndRefusesWhatItHasNoRoomFor) {
  rcc::RequestQueue<int, 8> queue;
  int value = -1;
  EXPECT_FALSE(queue.pop(value));
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 8; ++i) EXPECT_TRUE(queue.push(10 * round + i));
    EXPECT_FALSE(queue.push(99));
    for (int i = 0; i < 8; ++i) {
      ASSERT_TRUE(queue.pop(value));
      EXPECT_EQ(value, 10 * round + i);
    }
    EXPECT_FALSE(queue.pop(value));
  }
}

/// Values of several words, so that a torn one is seen; each thread's come in its order and none is lost.
TEST(RequestQueue, ManyThreadsWriteAndNothingIsTornOrLost) {
  struct Value {
    std::size_t thread = 0;
    std::int64_t number = 0, again = 0;
  };
  constexpr std::size_t kThreads = 3;
  constexpr std::int64_t kEach = 3'000;
  rcc::RequestQueue<Value, 16> queue;
  std::vector<std::jthread> writers;
  for (std::size_t thread = 0; thread < kThreads; ++thread) {
    writers.emplace_back([&queue, thread] {
      for (std::int64_t i = 0; i < kEach;) {
        if (queue.push({.thread = thread, .number = i, .again = -i})) {
          ++i;
        } else {
          std::this_thread::yield();
        }
      }
    });
  }
  std::array<std::int64_t, kThreads> next{};
  Value value;
  for (std::int64_t taken = 0; taken < std::int64_t{kThreads} * kEach;) {
    if (!queue.pop(value)) {
      std::this_thread::yield();
      continue;
    }
    ++taken;
    ASSERT_EQ(value.number, next.at(value.thread)++);
    ASSERT_EQ(value.again, -value.number);
  }
}

TEST(NetBits, EachBitIsTakenOnceHoweverOftenItWasSet) {
  rcc::NetBits bits(130);
  for (const std::size_t slot : {0u, 63u, 64u, 129u, 64u}) bits.set(slot);
  std::vector<std::size_t> taken;
  const auto take = [&] { bits.take([&](std::size_t slot) { taken.push_back(slot); }); };
  take();
  EXPECT_THAT(taken, testing::ElementsAre(0u, 63u, 64u, 129u));
  take();
  EXPECT_EQ(taken.size(), 4u);
}

/// A set or a condition that is too large is an error of the compiler, or a result that must be looked at.
TEST(Rules, NothingIsDroppedInSilence) {
  rcc::NetSet set;
  for (int i = 0; i < rcc::NetSet::kCapacity; ++i) EXPECT_TRUE(set.add(1));
  EXPECT_FALSE(set.add(1));
  rcc::Condition condition;
  for (int i = 0; i < rcc::Condition::kCapacity; ++i) EXPECT_TRUE(condition.add({}));
  EXPECT_FALSE(condition.add({}));
  EXPECT_EQ(condition.size, rcc::Condition::kCapacity);
  static_assert(std::is_constructible_v<rcc::NetSet, rcc::NetId, rcc::NetId>);
  static_assert(rcc::Condition::kCapacity >= 2 * rcc::NetSet::kCapacity, "a blend out of each net of a set");
}

class Requests : public CoreTest {
 protected:
  rcc::NetId moving(const std::string& arm = "left") {
    const rcc::NetId net = load(ptp_net("ptp", arm, {JointVector::Zero(3), joints(0.6, 0, 0)}));
    EXPECT_NE(core->start(net), 0u);
    steps(300);
    return net;
  }
  /// Rules that wait for the end of a net that runs, as many as there is room for.
  void fill_rules(rcc::NetId running) {
    const rcc::Rule waits{.condition = {rcc::Term::state(running, {NetState::kTerminated})}, .action = {}};
    for (int i = 0; i < 256; ++i) ASSERT_NE(core->post(waits), 0u);
    guarded_step(*core);
    const rcc::RequestId more = core->post(waits);
    guarded_step(*core);
    ASSERT_EQ(answer(more), "256 rules wait, and there is no room for more");
  }
  /// Cancels of a net that has not begun: each is refused, none does anything.
  void fill_queue(rcc::NetId ready) {
    int taken = 0;
    while (core->cancel(ready) != 0) ++taken;
    EXPECT_EQ(taken, 512);
  }
  /// Why a request was refused in the last step; "done", or "no answer".
  std::string answer(rcc::RequestId request) const {
    for (const Event& event : core->events()) {
      if (event.request != request) continue;
      return event.kind == Event::Kind::kDone ? "done" : std::string(event.cause.text.view());
    }
    return "no answer";
  }
  rcc::NetId idle() { return load(ptp_net("idle", "right", {JointVector::Zero(3), joints(0.1, 0, 0)})); }
};

TEST_F(Requests, L6_AnAbortIsNeverRefusedBehindRulesThatWait) {
  const rcc::NetId net = moving();
  fill_rules(net);
  const rcc::RequestId request = core->abort(net);
  guarded_step(*core);
  EXPECT_EQ(core->state(net), NetState::kTerminated);
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kAborted);
  EXPECT_EQ(answer(request), "done");
}

TEST_F(Requests, L6_AnAbortIsNeverRefusedOnAFullQueue) {
  const rcc::NetId net = moving(), ready = idle();
  fill_queue(ready);
  EXPECT_EQ(core->abort(net), 0u) << "only the answer finds no room";
  guarded_step(*core);
  EXPECT_EQ(core->state(net), NetState::kTerminated);
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kAborted);
  steps(1500);
  expect_limits_kept(*left_backend);
}

TEST_F(Requests, L6_AStopOfAllIsNeverRefusedOnAFullQueueAndComesFromAnyThread) {
  const rcc::NetId left = moving(), ready = idle();
  EXPECT_NE(core->start(ready), 0u);
  guarded_step(*core);
  fill_rules(left);
  fill_queue(left);
  std::jthread([this] { core->stop_all(Cause::Code::kAborted, "the operator"); }).join();
  core->stop_all(Cause::Code::kOverrun, "and the clock");
  guarded_step(*core);
  for (const rcc::NetId net : {left, ready}) {
    EXPECT_EQ(core->state(net), NetState::kTerminated);
    EXPECT_EQ(core->status(net).cause.text.view(), "the operator") << "who asked first";
  }
}

TEST_F(Requests, L6_WhatIsAbortedBeforeItBeginsDoesNotBegin) {
  const rcc::NetId net = idle();
  const rcc::RequestId start = core->start(net), abort = core->abort(net);
  guarded_step(*core);
  EXPECT_EQ(core->state(net), NetState::kReady);
  EXPECT_EQ(answer(start), fmt::format("an abort of net {} was asked for", net));
  EXPECT_EQ(answer(abort), fmt::format("net {} is not running, it is Ready", net));
  const rcc::RequestId later = core->start(net);
  guarded_step(*core);
  EXPECT_EQ(answer(later), "done");
  EXPECT_EQ(answer(core->abort(4711)), "no answer");
  guarded_step(*core);
}

TEST_F(Requests, L6_AnAbortDoesNotMeetTheNextNetOfItsSlot) {
  core = std::make_unique<rcc::ControlCore>(rcc::ControlCore::Options{.net_capacity = 2});
  left_backend = add_arm("left");
  guarded_step(*core);
  const auto one = [this] { return load(ptp_net("ptp", "left", {JointVector::Zero(3), joints(0.1, 0, 0)})); };
  const rcc::NetId first = one();
  core->abort(first);
  ASSERT_TRUE(core->unload(first));
  guarded_step(*core);
  const rcc::NetId other = one(), second = one();
  EXPECT_EQ(second % 2, first % 2) << "the same slot";
  EXPECT_NE(other, second);
  EXPECT_NE(core->start(second), 0u);
  steps(5);
  EXPECT_EQ(core->state(second), NetState::kRunning);
  core->abort(first);
  steps(2);
  EXPECT_EQ(core->state(second), NetState::kRunning) << "net " << first << " is long gone";
}

TEST_F(Requests, StartsAndCancelsFindRoomBehindRulesThatWait) {
  const rcc::NetId net = moving(), ready = idle();
  fill_rules(net);
  const rcc::RequestId start = core->start(ready);
  guarded_step(*core);
  EXPECT_EQ(answer(start), "done");
  const rcc::RequestId cancel = core->cancel(net);
  guarded_step(*core);
  EXPECT_EQ(answer(cancel), "done");
}

TEST_F(Requests, UnloadAndUnwatchNeedNoRoom) {
  const rcc::NetId net = moving(), ready = idle(), also_ready = idle();
  const auto watch = core->watch(net, "clock.time");
  ASSERT_TRUE(watch);
  steps(2);
  fill_queue(ready);
  const auto refused = core->watch(net, "clock.time");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), Reports(Code::kNotPossibleNow, "", {"512"}));
  core->unwatch(*watch);
  EXPECT_TRUE(core->unload(also_ready));
  guarded_step(*core);
  EXPECT_TRUE((*watch)->ended());
  EXPECT_FALSE(core->knows(also_ready));
  EXPECT_TRUE(core->knows(ready));
}

/// Both cannot be; before, the answer was "done" and the net was aborted, or ran on as before.
TEST_F(Requests, L2_ANetIsNotStartedAndEndedInOneTransaction) {
  const rcc::NetId net = moving(), ready = idle();
  const auto refused = [&](const rcc::Transaction& transaction) {
    const rcc::RequestId request = core->post(transaction);
    guarded_step(*core);
    return answer(request);
  };
  EXPECT_EQ(refused({.abort = {net}, .start = {net}}), "net 1 is to be started and aborted at once");
  EXPECT_EQ(refused({.cancel = {net}, .start = {net}}), "net 1 is to be started and cancelled at once");
  EXPECT_EQ(refused({.start = {net}, .end = {net}}), "net 1 is to be started and ended at once");
  EXPECT_EQ(refused({.cancel = {net}, .start = {ready, net}}), "net 1 is to be started and cancelled at once");
  EXPECT_EQ(core->state(net), NetState::kRunning) << "wholly or not at all";
  EXPECT_EQ(core->state(ready), NetState::kReady);
  EXPECT_EQ(refused({.cancel = {net}, .start = {ready}}), "done");
}

/// As a rule needs it that takes five arms over from their blends: two terms each.
TEST_F(Requests, L8_ARuleOfTenTermsWaitsForTheLastOne) {
  const rcc::NetId net = moving(), ready = idle();
  const rcc::Term runs = rcc::Term::state(net, {NetState::kRunning});
  rcc::Rule rule{.condition = {runs, runs, runs, runs, runs, runs, runs, runs, runs,
                               rcc::Term::state(net, {NetState::kTerminated})},
                 .action = {.start = {ready}}};
  ASSERT_EQ(rule.condition.size, 10);
  const rcc::RequestId waits = core->post(rule);
  steps(5);
  EXPECT_EQ(core->state(ready), NetState::kReady) << "its last term does not hold";
  rule.condition.terms[9] = runs;
  const rcc::RequestId fires = core->post(rule);
  guarded_step(*core);
  EXPECT_EQ(answer(fires), "done");
  EXPECT_NE(waits, fires);
}

TEST_F(Requests, AHandleKeepsANetThatWasUnloaded) {
  core = std::make_unique<rcc::ControlCore>(rcc::ControlCore::Options{.net_capacity = 2});
  left_backend = add_arm("left");
  guarded_step(*core);
  const auto one = [this](const char* name) {
    return core->load(ptp_net(name, "left", {JointVector::Zero(3), joints(0.1, 0, 0)}));
  };
  const rcc::NetId first = one("first").value();
  rcc::NetHandle handle = core->net(first);
  const std::weak_ptr<const net::CompiledNet> watched = handle;
  ASSERT_TRUE(core->unload(first));
  guarded_step(*core);
  EXPECT_EQ(core->net(first), nullptr) << "it is not found any more";
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(one("next")) << "its slot is free again";
  EXPECT_FALSE(one("too many"));
  EXPECT_EQ(handle->name(), "first");
  EXPECT_NE(handle->find<net::Real>("clock.time"), nullptr);
  handle.reset();
  EXPECT_TRUE(watched.expired());
}

/// A cancel that nothing in the net hears only begins the time after which it is aborted.
TEST_F(Requests, L6_LoadSaysThatANetWithoutCancelCanOnlyBeAborted) {
  auto net = ptp_net("with", "left", {JointVector::Zero(3), joints(0.6, 0, 0)});
  const auto notes = [&] { return core->net(load(net))->report().notes; };
  EXPECT_THAT(notes(), testing::Not(Notes("/primitives", {"Cancel"})));
  std::erase_if(net.links, [](const auto& link) { return link.from == "cancel.requested"; });
  net.primitives.erase(net.primitives.begin());
  for (auto& primitive : net.primitives) {
    if (primitive.id == "target") primitive.parameters["condition"] = false;
    if (primitive.id == "stopped") primitive.parameters["a"] = false;
  }
  EXPECT_THAT(notes(), Notes("/primitives", {"Cancel"}));
  EXPECT_EQ(core->status(load(net)).cancel_bound_cycles, rcc::LoadOptions::kDefaultCancelBound);
}

/// Whoever looks at nets is never in the way of those who load and unload them, and never sees freed memory. Under TSan
/// and ASan this is the proof; without them it shows that the answers are whole.
TEST_F(Requests, ReadersBesideLoadAndUnload) {
  constexpr int kLoads = 150;
  left_backend->keep = right_backend->keep = false;
  std::atomic<rcc::NetId> newest = 0;
  std::atomic<int> loading = 2;
  std::jthread cycle([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) guarded_step(*core);
  });
  const auto load_and_unload = [&](bool on_worker) {
    const NetDescription net = ptp_net("seen", "left", {JointVector::Zero(3), joints(0.1, 0, 0)});
    NetDescription wrong;
    wrong.add("x", "NoSuchPrimitive");
    for (int i = 0; i < kLoads; ++i) {
      const rcc::NetId id = on_worker ? core->load_async(i % 5 == 0 ? wrong : net) : core->load(net).value();
      newest = id;
      while (core->state(id) == NetState::kLoading) std::this_thread::yield();
      if (i % 4 == 0) (void)core->start(id);
      if (i % 8 == 0) (void)core->cancel(id);
      if (i % 4 == 0) core->abort(id);
      if (i % 3 == 0) {
        EXPECT_FALSE(core->load(wrong));
      }
      while (core->knows(id) && !core->unload(id)) {
        core->abort(id);
        std::this_thread::yield();
      }
    }
    --loading;
  };
  std::jthread one(load_and_unload, false), other(load_and_unload, true);
  std::array<std::atomic<int>, 2> seen{};
  const auto read = [&](std::size_t reader) {
    while (loading > 0) {
      for (rcc::NetId id = newest, least = id > 4 ? id - 4 : 0; id > least; --id) {
        const rcc::NetStatus status = core->status(id);
        if (status.state == NetState::kTerminated) {
          EXPECT_NE(status.cause.code, Cause::Code::kNone);
        }
        (void)core->diagnostics(id);
        if (const rcc::NetHandle net = core->net(id)) {
          EXPECT_EQ(net->name(), "seen");
          ++seen.at(reader);
        }
        if (const auto watch = core->watch(id, "clock.time", {.capacity = 4})) {
          (void)(*watch)->newest();
          core->unwatch(*watch);
        }
        (void)core->schedule_after(id, id + 1);
      }
      std::this_thread::yield();
    }
  };
  { std::jthread first(read, 0u), second(read, 1u); }
  EXPECT_GT(seen[0] + seen[1], 0);
}

}  // namespace
}  // namespace takt::test
