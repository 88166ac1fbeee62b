// Hand-over from net to net: the seam is checked when it is agreed and when it happens (row L3); bounds (row L6).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/motion/path_clock.h"
#include "core/net/stop_bound.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using device::Seam;
using net::Cause;
using rcc::Event;
using rcc::NetState;

class SeamTest : public CoreTest {
 protected:
  static Seam rest_at(const JointVector& q) {
    Seam seam;
    seam.q = q;
    seam.dq = seam.ddq = JointVector::Zero(q.size());
    return seam;
  }
  static rcc::LoadOptions from_to(const std::string& arm, const JointVector& from, const JointVector& to) {
    return {.begins = {{arm, rest_at(from)}}, .ends = {{arm, rest_at(to)}}};
  }
  /// A motion with both ends declared, as they are or as a test claims them to be.
  rcc::NetId load_ptp(const JointVector& from, const JointVector& to) {
    return load(ptp_net("ptp", "left", {from, to}), from_to("left", from, to));
  }
  /// The net of a motion that ends in the middle, moving, after so many cycles.
  NetDescription broken_off(const JointVector& from, const JointVector& to, int cycles) {
    NetDescription net = ptp_net("broken", "left", {from, to});
    net.add("late", "OnDelay", {{"delay", 1e-3 * cycles}, {"input", true}}).add("stop", "Termination");
    net.link("late.value", "stop.condition");
    return net;
  }
  const Event* of(rcc::RequestId request) {
    for (const Event& one : core->events())
      if (one.request == request) return &one;
    return nullptr;
  }
  /// Steps until the request has its answer.
  std::optional<Event> answer(rcc::RequestId request, int most = 5'000) {
    for (int i = 0; i < most; ++i) {
      guarded_step(*core);
      if (const Event* found = of(request)) return *found;
    }
    return std::nullopt;
  }
  double sent_q(int joint) const { return left_backend->sent.back().q[joint]; }

  const JointVector a = joints(0, 0, 0), b = joints(0.2, 0.1, 0), c = joints(0.1, 0.3, 0.1);
};

TEST_F(SeamTest, L3_SuccessorFollowsInTheNextCycle) {
  const rcc::NetId first = load_ptp(a, b), second = load_ptp(b, c);
  core->start(first);
  const auto request = core->schedule_after(first, second);
  ASSERT_TRUE(request) << request.error().to_string();
  ASSERT_TRUE(run_to_end(second));
  EXPECT_EQ(core->status(second).first_cycle, core->status(first).last_cycle + 1);
  EXPECT_EQ(core->status(second).cause.code, Cause::Code::kTerminated);
  EXPECT_EQ(sent_q(1), 0.3);
  expect_limits_kept(*left_backend);
}

TEST_F(SeamTest, L3_AtAcceptanceADeclaredMisfitIsRefusedWithAxisAndNumber) {
  const rcc::NetId first = load_ptp(a, b), second = load_ptp(joints(0.2, 0.15, 0), c);
  const auto request = core->schedule_after(first, second);
  ASSERT_FALSE(request);
  EXPECT_THAT(request.error(), Reports(Code::kNotPossibleNow, "", {"2", "1", "0.15", "0.1"}));
  EXPECT_THAT(core->schedule_after(first, 77).error(), Reports(Code::kUnknownName, "", {"77"}));
  core->start(first);
  steps(2);
  EXPECT_THAT(core->schedule_after(second, first).error(), Reports(Code::kNotPossibleNow, "", {"1"}));
}

TEST_F(SeamTest, L3_AStartIsCheckedAgainstTheLastSetPoint) {
  const rcc::NetId elsewhere = load_ptp(joints(0, 0, 0.004), c);  // inside the tolerance of a measured start
  const auto before = left_backend->sent.back().q;
  const auto refused = answer(core->start(elsewhere));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, Event::Kind::kRefused);
  EXPECT_EQ(refused->cause.text.view(), "joint a3: begins at 0.004, not at 0 rad");
  EXPECT_EQ(core->state(elsewhere), NetState::kReady);
  EXPECT_EQ(left_backend->sent.back().q, before);
}

TEST_F(SeamTest, L3_InTheCycleOfTheSwitchWhatWasSentCountsAndTheArmStopsIfNothingFits) {
  // The predecessor ends earlier than it says, and moves: nobody could know when it was agreed.
  const rcc::NetId first = load(broken_off(a, b, 200), from_to("left", a, b)), second = load_ptp(b, c);
  core->start(first);
  const auto request = core->schedule_after(first, second);
  ASSERT_TRUE(request);
  const auto refused = answer(*request);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, Event::Kind::kRefused);
  EXPECT_THAT(std::string(refused->cause.text.view()), takt::test::Names("a1", "0.2"));
  steps(1'000);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  EXPECT_LT(sent_q(0), 0.2);
  EXPECT_EQ(core->state(second), NetState::kReady) << "nothing starts by itself later";
  expect_limits_kept(*left_backend);
}

TEST_F(SeamTest, L3_TheOtherNetTakesOverFromRest) {
  const rcc::NetId first = load(broken_off(a, b, 200), from_to("left", a, b)), second = load_ptp(b, c);
  NetDescription still;  // from wherever the arm comes to rest: it holds it there
  still.name = "still";
  still.add("state", "ArmState", {{"device", "left"}});
  still.add("zero_v", "ConstantJoints", {{"value", {0.0, 0.0, 0.0}}});
  still.add("zero_a", "ConstantJoints", {{"value", {0.0, 0.0, 0.0}}});
  still.add("arm", "ArmCommand", {{"device", "left"}}).add("end", "Termination", {{"condition", false}});
  still.link("state.set_point_q", "arm.q").link("zero_v.value", "arm.dq").link("zero_a.value", "arm.ddq");
  const rcc::NetId from_rest = load(still);
  core->start(first);
  const auto request = core->schedule_after(first, second, from_rest);
  ASSERT_TRUE(request);
  const auto done = answer(*request);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->kind, Event::Kind::kDone);
  EXPECT_THAT(std::string(done->cause.text.view()), takt::test::Names("a1", "0.2")) << "why it is the other one";
  EXPECT_EQ(core->state(from_rest), NetState::kRunning);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  EXPECT_GT(core->status(from_rest).first_cycle, core->status(first).last_cycle + 1) << "it waited for rest";
  steps(10);
  EXPECT_EQ(core->state(from_rest), NetState::kRunning);
  expect_limits_kept(*left_backend);
}

TEST_F(SeamTest, L3_TheOtherNetIsRefusedTooIfItDoesNotFit) {
  const rcc::NetId first = load(broken_off(a, b, 200), from_to("left", a, b)), second = load_ptp(b, c);
  const rcc::NetId from_rest = load_ptp(b, c);  // the arm rests elsewhere
  core->start(first);
  const auto request = core->schedule_after(first, second, from_rest);
  ASSERT_TRUE(request);
  const auto refused = answer(*request);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, Event::Kind::kRefused);
  EXPECT_EQ(refused->net, from_rest);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
}

TEST_F(SeamTest, L3_ModeAndToolAreCheckedInTheCycleOfTheSwitch) {
  rcc::LoadOptions options = from_to("left", a, b);
  options.begins[0].seam.tool = device::ToolSetting{};
  options.begins[0].seam.tool->payload.mass = 1.5;
  const rcc::NetId with_load = load(ptp_net("ptp", "left", {a, b}), options);
  const auto refused = answer(core->start(with_load));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->cause.text.view(), "begins with a load of 1.5, not 0 kg");
  core->find_arm("left")->set_tool(*options.begins[0].seam.tool);
  core->start(with_load);
  steps(2);
  EXPECT_EQ(core->state(with_load), NetState::kRunning);
}

TEST_F(SeamTest, SeamsOfDevicesThatTheNetDoesNotDriveAreRejected) {
  const auto id = core->load(
      ptp_net("ptp", "left", {a, b}),
      {.begins = {{"right", rest_at(a)}, {"left", rest_at(JointVector::Zero(2))}}, .ends = {{"lfet", rest_at(b)}}});
  ASSERT_FALSE(id);
  const Diagnostics text = id.error();
  EXPECT_THAT(text, Reports(Code::kUnknownName, "/begins/0/device", {"right"}));
  EXPECT_THAT(text, Reports(Code::kNotPossibleNow, "/begins/1", {"2", "3"}));
  EXPECT_THAT(text, Reports(Code::kUnknownName, "/ends/0/device", {"lfet"}));
}

TEST_F(SeamTest, NothingIsAllocatedInTheSwitch) {
  const rcc::NetId first = load(broken_off(a, b, 50), from_to("left", a, b)), second = load_ptp(b, c);
  const rcc::NetId from_rest = load_ptp(b, c);
  left_backend->keep = right_backend->keep = false;
  core->start(first);
  ASSERT_TRUE(core->schedule_after(first, second, from_rest));
  const AllocationGuard guard;
  steps(1'000);
  EXPECT_EQ(guard.count(), 0u);
}

TEST_F(SeamTest, L6_TheBoundOfANetFollowsFromItsClock) {
  const PlannedLine plan{a, b};
  const rcc::NetId id = load(ptp_net("ptp", "left", plan));
  const double stop_s = motion::PathClock(plan.bounds, plan.law.duration(), false).stop_time_bound();
  const auto bound = core->status(id).cancel_bound_cycles;
  EXPECT_EQ(bound, static_cast<std::int64_t>(std::ceil(stop_s * 1e3)) + 2);
  // And it holds: cancelled at any cycle, the net ends in order within it.
  for (int cancelled_after = 2; cancelled_after < 400; cancelled_after += 37) {
    build({});
    const rcc::NetId tried = load(ptp_net("ptp", "left", plan));
    core->start(tried);
    steps(cancelled_after);
    core->cancel(tried);
    guarded_step(*core);
    int cycles = 0;
    while (core->state(tried) == NetState::kCanceling && ++cycles < 10'000) guarded_step(*core);
    EXPECT_EQ(core->status(tried).cause.code, Cause::Code::kCancelled) << cancelled_after;
    EXPECT_LE(cycles, bound) << cancelled_after;
  }
}

TEST_F(SeamTest, L6_WhatTheNetDeclaresGoesBeforeAndWhatTheLoaderSaysBeforeThat) {
  NetDescription net = ptp_net("ptp", "left", {a, b});
  net.primitives.front().parameters["bound"] = 0.25;  // "cancel"
  EXPECT_EQ(core->status(load(net)).cancel_bound_cycles, 250);
  EXPECT_EQ(core->status(load(net, {.cancel_bound_cycles = 7})).cancel_bound_cycles, 7);
}

TEST_F(SeamTest, L6_ANetWithoutAWayFromCancelToTheEndGetsTheDefault) {
  NetDescription deaf;
  deaf.name = "deaf";
  deaf.add("end", "Termination", {{"condition", false}});
  EXPECT_EQ(core->status(load(deaf)).cancel_bound_cycles, rcc::LoadOptions::kDefaultCancelBound);
  NetDescription slow = deaf;  // it waits for a time: the way depends on data
  slow.add("cancel", "Cancel").add("wait", "OnDelay", {{"delay", 0.1}}).add("over", "Termination");
  slow.link("cancel.requested", "wait.input").link("wait.value", "over.condition");
  EXPECT_EQ(core->status(load(slow)).cancel_bound_cycles, rcc::LoadOptions::kDefaultCancelBound);
  NetDescription quick = deaf;
  quick.add("cancel", "Cancel").add("over", "Termination");
  quick.link_delayed("cancel.requested", "over.condition", false);
  EXPECT_EQ(core->status(load(quick)).cancel_bound_cycles, 3);
}

}  // namespace
}  // namespace takt::test
