#include "core/rcc/control_core.h"

#include <algorithm>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using net::Cause;
using rcc::Event;
using rcc::NetState;

class ControlCoreTest : public CoreTest {
 protected:
  rcc::NetId load_ptp(const std::string& arm, const JointVector& from, const JointVector& to,
                      const rcc::LoadOptions& options = {}) {
    return load(ptp_net("ptp_" + arm, arm, {from, to}), options);
  }
  JointVector zero = JointVector::Zero(3);
  JointVector goal = joints(0.6, -0.4, 0.2);
};

TEST_F(ControlCoreTest, P1_PtpArrivesExactlyInsideTheLimits) {
  const auto ptp = load_ptp("left", zero, goal);
  EXPECT_EQ(core->state(ptp), NetState::kReady);
  core->start(ptp);
  ASSERT_TRUE(run_to_end(ptp));
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kTerminated);
  EXPECT_EQ(left_backend->sent.back().q, goal);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  expect_limits_kept(*left_backend);
}

TEST_F(ControlCoreTest, L2_StartedInOneCycleRunsFirstInTheNext) {
  const auto ptp = load_ptp("left", zero, goal);
  const std::int64_t k = core->cycle();
  core->start(ptp);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kRunning);
  EXPECT_EQ(core->status(ptp).first_cycle, k + 1);
  EXPECT_EQ(core->net(ptp)->cycles(), 0);
  guarded_step(*core);
  EXPECT_EQ(core->net(ptp)->cycles(), 1);
}

TEST_F(ControlCoreTest, L5_FrozenBitForBitAfterTheEnd) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  ASSERT_TRUE(run_to_end(ptp));
  const auto frozen = left_backend->sent.back();
  left_backend->state().q[0] += 0.001;  // the real arm sags; the set point does not follow
  for (int i = 0; i < 50; ++i) {
    guarded_step(*core);
    EXPECT_EQ(left_backend->sent.back().q, frozen.q);
    EXPECT_EQ(left_backend->last_written_cycle, core->cycle() - 1);
  }
}

TEST_F(ControlCoreTest, L6_CancelBrakesOnThePath) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  steps(300);
  core->cancel(ptp);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kCanceling);
  ASSERT_TRUE(run_to_end(ptp, 2000));
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kCancelled);
  const JointVector end = left_backend->sent.back().q;
  const double share = end[0] / goal[0];
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.95);
  EXPECT_LT((end - share * goal).norm(), 1e-12);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  expect_limits_kept(*left_backend);
}

TEST_F(ControlCoreTest, L6_ANetThatIgnoresItsCancelIsAborted) {
  auto net = ptp_net("stubborn", "left", {zero, goal});
  std::erase_if(net.links, [](const auto& link) { return link.from == "cancel.requested"; });
  net.primitives.erase(net.primitives.begin());
  for (auto& primitive : net.primitives) {
    if (primitive.id == "target") primitive.parameters["condition"] = false;
    if (primitive.id == "stopped") primitive.parameters["a"] = false;
  }
  const auto stubborn = load(net, {.cancel_bound_cycles = 20});
  core->start(stubborn);
  steps(200);
  core->cancel(stubborn);
  steps(1 + 20);
  EXPECT_EQ(core->state(stubborn), NetState::kTerminated);
  EXPECT_EQ(core->status(stubborn).cause.code, Cause::Code::kAborted);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kBraking);
}

TEST_F(ControlCoreTest, L6_TheBoundOfACancelCountsFromTheLastThatGoesOn) {
  NetDescription net;
  net.name = "cleans up";
  net.add("timer", "OnDelay", {{"input", true}, {"delay", 0.05}}).add("busy", "Not").add("end", "Termination");
  net.add("cancel", "Cancel").link("timer.value", "busy.input");
  net.primitives[2].parameters["condition"] = false;
  const auto stubborn = load(net, {.cancel_bound_cycles = 10, .goes_on = "busy.value"});
  core->start(stubborn);
  steps(5);
  core->cancel(stubborn);
  steps(50);
  EXPECT_EQ(core->state(stubborn), NetState::kCanceling);
  steps(10);
  EXPECT_EQ(core->state(stubborn), NetState::kTerminated);
  EXPECT_EQ(core->status(stubborn).cause.code, Cause::Code::kAborted);
  const auto unknown = core->load(net, {.goes_on = "bisy.value"});
  EXPECT_THAT(unknown, Reports(Code::kUnknownName, "/goes_on", {"bisy.value"}));
}

TEST_F(ControlCoreTest, L2_ACancelPostedAfterAStartFindsTheNetInItsFirstCycle) {
  const auto ptp = load_ptp("left", zero, goal);
  const auto start = core->start(ptp), cancel = core->cancel(ptp);
  steps(1);
  EXPECT_EQ(core->state(ptp), NetState::kCanceling);
  for (const auto& event : core->events()) EXPECT_NE(event.kind, rcc::Event::Kind::kRefused);
  EXPECT_NE(start, cancel);
  ASSERT_TRUE(run_to_end(ptp, 10));
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kCancelled);
  EXPECT_LT(left_backend->sent.back().q.norm(), 1e-12) << "nothing has moved";

  const auto early = load_ptp("left", zero, goal);
  const auto refused = core->cancel(early);
  (void)core->start(early);
  steps(1);
  EXPECT_EQ(core->state(early), NetState::kRunning) << "it was not there yet when it was to be cancelled";
  EXPECT_TRUE(std::ranges::any_of(core->events(), [&](const rcc::Event& event) {
    return event.kind == rcc::Event::Kind::kRefused && event.request == refused;
  }));
}

TEST_F(ControlCoreTest, S3_AnArmThatItsBrakesHaveStoppedIsAtRest) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  steps(300);
  const device::Arm& left = *core->find_arm("left");
  EXPECT_FALSE(left.at_rest());
  left_backend->brake();
  left_backend->state().braked = true;
  steps(5);
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kDevice);
  EXPECT_TRUE(left.lost());
  EXPECT_TRUE(left.at_rest()) << "its last set point moved, but it does not";
}

TEST_F(ControlCoreTest, L2_AbortBrakesAtOnceWithinTheLimits) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  steps(300);
  core->abort(ptp);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kTerminated);
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kAborted);
  ASSERT_NE(event(Event::Kind::kStopped), nullptr);
  EXPECT_THAT(std::string(event(Event::Kind::kStopped)->cause.text.view()), takt::test::Names("left"));
  steps(1500);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kFrozen);
  expect_limits_kept(*left_backend);
}

TEST_F(ControlCoreTest, SecondStartOnAHeldArmIsRefusedAndTheFirstIsUntouched) {
  const auto run = [this](bool disturb) {
    build({});
    const auto first = load_ptp("left", zero, goal);
    const auto second = load_ptp("left", zero, joints(-0.5, 0, 0));
    core->start(first);
    steps(100);
    if (disturb) {
      const auto request = core->start(second);
      guarded_step(*core);
      const Event* refused = event(Event::Kind::kRefused);
      EXPECT_NE(refused, nullptr);
      if (refused != nullptr) {
        EXPECT_EQ(refused->request, request);
        EXPECT_EQ(refused->net, second);
        EXPECT_THAT(std::string(refused->cause.text.view()), takt::test::Names("left"));
      }
      EXPECT_EQ(core->state(second), NetState::kReady);
    } else {
      guarded_step(*core);
    }
    EXPECT_TRUE(run_to_end(first));
    return core->digest().value();
  };
  EXPECT_EQ(run(true), run(false));
}

TEST_F(ControlCoreTest, S5_ANetThatStartsElsewhereMovesNothing) {
  const auto ptp = load_ptp("left", joints(0.1, 0, 0), goal);
  core->start(ptp);
  steps(2);
  EXPECT_EQ(core->state(ptp), NetState::kTerminated);
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kGuard);
  EXPECT_EQ(core->status(ptp).cause.text.view(), "joint a1: net starts at 0.1, arm is at 0 rad");
  for (const auto& set_point : left_backend->sent) EXPECT_EQ(set_point.q, zero);
}

TEST_F(ControlCoreTest, S5_AnArmThatWasPushedAwayIsRefused) {
  const auto ptp = load_ptp("left", zero, goal);
  left_backend->state().q[1] = 0.02;
  guarded_step(*core);
  left_backend->state().q[1] = 0.02;
  core->start(ptp);
  guarded_step(*core);
  ASSERT_NE(event(Event::Kind::kRefused), nullptr);
  EXPECT_EQ(event(Event::Kind::kRefused)->cause.text.view(), "left: is not where it was sent");
}

TEST_F(ControlCoreTest, L1_RequestsAreIdempotentOrRefusedWithAReason) {
  const auto ptp = load_ptp("left", zero, goal);
  const auto expect = [this](Event::Kind kind, std::string_view text) {
    guarded_step(*core);
    const Event* found = event(kind);
    ASSERT_NE(found, nullptr) << text;
    EXPECT_EQ(found->cause.text.view(), text);
  };
  core->cancel(ptp);
  expect(Event::Kind::kRefused, "net 1 is not running, it is Ready");
  core->start(77);
  expect(Event::Kind::kRefused, "net 77 is not loaded");
  core->start(ptp);
  expect(Event::Kind::kDone, "");
  core->start(ptp);
  expect(Event::Kind::kDone, "");
  core->abort(ptp);
  expect(Event::Kind::kDone, "");
  core->abort(ptp);
  expect(Event::Kind::kDone, "");
  core->start(ptp);
  expect(Event::Kind::kRefused, "net 1 is not Ready, it is Terminated");
}

TEST_F(ControlCoreTest, L1_RejectedNetsSayWhy) {
  NetDescription net;
  net.add("x", "NoSuchPrimitive");
  const auto rejected = core->load(net);
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error(), Reports(Code::kUnknownName, "/primitives/0/type", {"NoSuchPrimitive"}));

  auto absent = ptp_net("absent", "lefft", {zero, goal});
  const auto no_device = core->load(absent);
  ASSERT_FALSE(no_device);
  EXPECT_THAT(no_device.error(), Reports(Code::kUnknownName, "/primitives/5/parameters/device", {"left"}));
}

TEST_F(ControlCoreTest, L1_LoadingOnAWorker) {
  const auto good = core->load_async(ptp_net("good", "left", {zero, goal}));
  NetDescription broken;
  broken.add("x", "NoSuchPrimitive");
  const auto bad = core->load_async(broken);
  while (core->state(good) == NetState::kLoading || core->state(bad) == NetState::kLoading) guarded_step(*core);
  EXPECT_EQ(core->state(good), NetState::kReady);
  EXPECT_EQ(core->state(bad), NetState::kRejected);
  EXPECT_THAT(core->diagnostics(bad), Reports(Code::kUnknownName, "/primitives/0/type", {"NoSuchPrimitive"}));
  core->start(good);
  EXPECT_TRUE(run_to_end(good));
}

TEST_F(ControlCoreTest, PhaseLockedStartOfTwoArms) {
  const auto left = load_ptp("left", zero, goal), right = load_ptp("right", zero, goal);
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
  ASSERT_TRUE(run_to_end(left));
  EXPECT_EQ(core->state(right), NetState::kTerminated);
  ASSERT_EQ(left_backend->sent.size(), right_backend->sent.size());
  for (std::size_t i = 0; i < left_backend->sent.size(); ++i)
    ASSERT_EQ(left_backend->sent[i].q, right_backend->sent[i].q);
}

TEST_F(ControlCoreTest, L2_ATransactionIsDoneWhollyOrNotAtAll) {
  const auto holder = load_ptp("right", zero, goal);
  core->start(holder);
  guarded_step(*core);
  const auto left = load_ptp("left", zero, goal), right = load_ptp("right", zero, goal);
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
  guarded_step(*core);
  ASSERT_NE(event(Event::Kind::kRefused), nullptr);
  EXPECT_EQ(event(Event::Kind::kRefused)->net, right);
  EXPECT_EQ(core->state(left), NetState::kReady);
  EXPECT_EQ(core->state(right), NetState::kReady);
}

/// scheduleAfter: the successor's first cycle follows the predecessor's last without a gap (row L3).
TEST_F(ControlCoreTest, L3_SuccessorFollowsWithoutAnEmptyCycle) {
  const auto first = load_ptp("left", zero, goal), second = load_ptp("left", goal, zero);
  core->start(first);
  (void)core->post(rcc::Rule{.condition = {rcc::Term::state(first, {NetState::kTerminated})},
                             .action = {.abort = {}, .cancel = {}, .start = {second}}});
  ASSERT_TRUE(run_to_end(second));
  EXPECT_EQ(core->status(second).first_cycle, core->status(first).last_cycle + 1);
  EXPECT_EQ(core->status(second).cause.code, Cause::Code::kTerminated);
  EXPECT_EQ(left_backend->sent.back().q, zero);
  expect_limits_kept(*left_backend);
}

TEST_F(ControlCoreTest, L2_RuleOnAnOutputOfANet) {
  const auto ptp = load_ptp("left", zero, goal);
  auto watcher = load_ptp("right", zero, goal);
  core->start(ptp);
  core->start(watcher);
  const auto* at_end = core->net(ptp)->find<net::Boolean>("clock.at_end");
  ASSERT_NE(at_end, nullptr);
  // `watcher` has the same law, so both reach the end in the same cycle; abort wins nothing then. Cancel it before.
  (void)core->post(rcc::Rule{.condition = {rcc::Term::output(ptp, at_end)},
                             .action = {.abort = {}, .cancel = {watcher}, .start = {}}});
  steps(100);
  core->cancel(ptp);
  ASSERT_TRUE(run_to_end(watcher));
  EXPECT_EQ(core->status(watcher).cause.code, Cause::Code::kTerminated);
}

/// Otherwise they would wait for ever, and in the end there would be no room for others.
TEST_F(ControlCoreTest, L2_ARuleThatCanNeverHoldIsDroppedAndSaysSo) {
  const auto ptp = load_ptp("left", zero, goal), other = load_ptp("right", zero, goal);
  core->start(ptp);
  guarded_step(*core);
  const auto* at_end = core->net(ptp)->find<net::Boolean>("clock.at_end");
  const auto waits = core->post(rcc::Rule{.condition = {rcc::Term::output(ptp, at_end)},
                                          .action = {.abort = {}, .cancel = {}, .start = {other}}});
  steps(100);
  EXPECT_EQ(event(Event::Kind::kRefused), nullptr);
  core->abort(ptp);
  steps(2);
  ASSERT_NE(event(Event::Kind::kRefused), nullptr);
  EXPECT_EQ(event(Event::Kind::kRefused)->request, waits);
  EXPECT_EQ(event(Event::Kind::kRefused)->net, ptp);
  EXPECT_EQ(event(Event::Kind::kRefused)->cause.text.view(), "its condition can never hold");
  EXPECT_EQ(core->state(other), NetState::kReady);
  for (int i = 0; i < 1000; ++i) {
    (void)core->post(rcc::Rule{.condition = {rcc::Term::state(ptp, {NetState::kRunning})},
                               .action = {.abort = {}, .cancel = {}, .start = {other}}});
    guarded_step(*core);
    ASSERT_EQ(event(Event::Kind::kRefused)->cause.text.view(), "its condition can never hold");
  }
}

TEST_F(ControlCoreTest, D4_EqualRunsHaveEqualDigestsAndAnAddedBitCounts) {
  std::array<std::uint64_t, 4> outside{};
  const auto run = [&](int flip_at) {
    build({});
    outside.fill(7);
    core->digest().add_block("outside", std::as_bytes(std::span(outside)));
    const auto ptp = load_ptp("left", zero, goal);
    core->start(ptp);
    for (int i = 0; i < 100; ++i) {
      outside[2] ^= i == flip_at ? 1u : 0u;
      guarded_step(*core);
      outside[2] = 7;
    }
    return core->digest().value();
  };
  const auto reference = run(-1);
  EXPECT_EQ(run(-1), reference);
  for (const int cycle : {0, 50, 99}) EXPECT_NE(run(cycle), reference);
}

TEST_F(ControlCoreTest, NothingIsAllocatedInTheCycle) {
  left_backend->keep = right_backend->keep = false;
  const auto left = load_ptp("left", zero, goal), right = load_ptp("right", zero, goal);
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
  steps(2);
  const AllocationGuard guard;
  steps(100);
  core->cancel(left);
  steps(100);
  core->abort(right);
  core->start(99);
  steps(2000);
  EXPECT_EQ(guard.count(), 0u);
}

TEST_F(ControlCoreTest, UnloadForgetsWhatIsNotActive) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  steps(2);
  EXPECT_FALSE(core->unload(ptp));
  core->abort(ptp);
  guarded_step(*core);
  EXPECT_TRUE(core->unload(ptp));
  guarded_step(*core);
  EXPECT_FALSE(core->knows(ptp));
  EXPECT_FALSE(core->unload(ptp));
}

TEST_F(ControlCoreTest, S1_ADeviceThatFallsOutEndsItsNet) {
  const auto ptp = load_ptp("left", zero, goal);
  core->start(ptp);
  steps(200);
  left_backend->state().ready = false;
  left_backend->state().fault = 3;
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kTerminated);
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kDevice);
  EXPECT_EQ(core->status(ptp).cause.text.view(), "left: not ready, fault 3");
  const auto last = left_backend->last_written_cycle;
  steps(10);
  EXPECT_EQ(left_backend->last_written_cycle, last);  // nothing is sent to an arm that is not ready
}

}  // namespace
}  // namespace takt::test
