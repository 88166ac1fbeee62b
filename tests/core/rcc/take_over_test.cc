// A net takes over from another one that is in motion: the transaction's set `end` (row L8).
#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using device::Seam;
using net::Cause;
using rcc::Event;
using rcc::NetId;
using rcc::NetState;

/// A motion along a line, from rest or in the middle of another motion.
struct Leg {
  PlannedLine plan;
  std::string arm = "left";

  [[nodiscard]] JointVector way() const { return plan.line.q_goal - plan.line.q_start; }
  [[nodiscard]] Seam seam_at(double tau) const {
    const motion::LawPoint at = plan.law.at(tau);
    const JointVector way = this->way();
    Seam seam;
    seam.q = plan.line.q_start + at.s * way;
    seam.dq = at.ds * way;
    seam.ddq = at.dds * way;
    return seam;
  }
  /// The rest of it, from tau on.
  [[nodiscard]] Leg rest_from(double tau) const {
    Leg rest = *this;
    rest.plan.line.q_start = seam_at(tau).q;
    rest.plan.law = plan.law.rest_from(tau);
    return rest;
  }
  /// Ends with a Boolean "blend.value" that is true in the cycle in which the motion is at tau.
  [[nodiscard]] NetDescription net(double tau) const {
    NetDescription net = ptp_net("leg", arm, plan);
    net.add("blend", "InRange", {{"lower", tau - 5e-4}, {"upper", tau + 5e-4}});
    net.link("clock.time", "blend.input");
    return net;
  }
};

class TakeOverTest : public CoreTest {
 protected:
  NetId load_leg(const Leg& one, double blend_at = 0.1) {
    return load(one.net(blend_at), {.begins = {{one.arm, one.seam_at(0.0)}}});
  }
  /// At the blend point of `before` the other one takes over; else `otherwise` begins from rest.
  rcc::RequestId take_over(NetId before, NetId after, NetId otherwise = 0) {
    rcc::Rule rule{.condition = {rcc::Term::output(before, core->net(before)->find<net::Boolean>("blend.value"))},
                   .action = {.start = {after}, .end = {before}}};
    if (otherwise != 0) rule.otherwise.start = {otherwise};
    return core->post(rule);
  }
  std::optional<Event> answer(rcc::RequestId request, int most = 20'000) {
    while (most-- > 0) {
      steps(1);
      for (const Event& one : core->events())
        if (one.request == request && one.kind != Event::Kind::kState) return one;
    }
    return std::nullopt;
  }

  const JointVector a = joints(0, 0, 0), b = joints(0.4, 0.2, 0), c = joints(0.1, 0.3, 0.1);
  const Leg leg{PlannedLine(a, b)};
};

TEST_F(TakeOverTest, L8_TheSuccessorGoesOnInTheNextCycleWhileTheArmMoves) {
  const NetId first = load_leg(leg), second = load_leg(leg.rest_from(0.1));
  const auto request = take_over(first, second);
  core->start(first);
  const auto done = answer(request);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->kind, Event::Kind::kDone) << done->cause.text.view();
  EXPECT_GT(left_backend->sent.back().dq.norm(), 0.05) << "it moves";
  EXPECT_EQ(core->status(first).state, NetState::kTerminated);
  EXPECT_EQ(core->status(first).cause.code, Cause::Code::kTakenOver);
  EXPECT_EQ(net::name_of(core->status(first).cause.code), "taken over");
  EXPECT_EQ(core->status(second).first_cycle, core->status(first).last_cycle + 1);
  const std::size_t cycles = left_backend->sent.size();
  ASSERT_TRUE(run_to_end(second));
  EXPECT_GT(left_backend->sent.size(), cycles + 100);
  EXPECT_EQ(core->status(second).cause.code, Cause::Code::kTerminated);
  EXPECT_EQ(left_backend->sent.back().q, b);
  expect_limits_kept(*left_backend);
}

TEST_F(TakeOverTest, L8_TheWholeMotionIsAsIfNobodyHadTakenOver) {
  core->start(load_leg(leg));
  for (int i = 0; i < 2'000; ++i) core->step();
  const auto alone = left_backend->sent;
  build({});
  const NetId first = load_leg(leg, 0.2), second = load_leg(leg.rest_from(0.2), 0.1);
  take_over(first, second);
  take_over(second, load_leg(leg.rest_from(0.3)));
  core->start(first);
  for (int i = 0; i < 2'000; ++i) core->step();
  ASSERT_EQ(left_backend->sent.size(), alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k)
    ASSERT_LT((left_backend->sent[k].q - alone[k].q).cwiseAbs().maxCoeff(), 1e-13) << k;
}

TEST_F(TakeOverTest, L8_WhatTheSuccessorDoesNotTakeMustStand) {
  // The predecessor moves both arms; the successor wants one of them.
  NetDescription both = leg.net(0.1);
  NetDescription other = ptp_net("", "right", leg.plan);
  both.add("right_arm", "ArmCommand", {{"device", "right"}});
  for (const char* port : {"q", "dq", "ddq"}) both.link(std::string("line.") + port, std::string("right_arm.") + port);
  const NetId first = load(both), second = load_leg(leg.rest_from(0.1));
  const auto request = take_over(first, second);
  core->start(first);
  const auto refused = answer(request);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, Event::Kind::kRefused);
  EXPECT_EQ(refused->cause.text.view(), "right would move on, and no net takes it over");
  EXPECT_EQ(core->state(first), NetState::kRunning) << "wholly or not at all";
  ASSERT_TRUE(run_to_end(first));
  EXPECT_EQ(left_backend->sent.back().q, b);
  EXPECT_EQ(right_backend->sent.back().q, b);
}

TEST_F(TakeOverTest, L8_ASeamThatDoesNotFitLeavesThePredecessorAloneAndTheOtherWayFollowsItsEnd) {
  Leg wrong = leg.rest_from(0.1);
  wrong.plan.line.q_start[1] += 0.002;
  const NetId first = load_leg(leg), second = load_leg(wrong), from_rest = load_leg(Leg{PlannedLine(b, c)});
  const auto request = take_over(first, second, from_rest);
  core->start(first);
  const auto done = answer(request);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->kind, Event::Kind::kDone);
  EXPECT_THAT(std::string(done->cause.text.view()), takt::test::Names("a2"));
  EXPECT_EQ(core->status(first).cause.code, Cause::Code::kTerminated);
  EXPECT_EQ(core->state(second), NetState::kReady);
  EXPECT_EQ(core->status(first).last_cycle, core->cycle() - 1) << "from rest follows without an empty cycle";
  ASSERT_TRUE(run_to_end(from_rest));
  EXPECT_EQ(core->status(from_rest).first_cycle, core->status(first).last_cycle + 1);
  EXPECT_EQ(left_backend->sent.back().q, c);
  expect_limits_kept(*left_backend);
}

TEST_F(TakeOverTest, L8_ANetThatKnowsBothWaysIsStartedInEither) {
  // As an activity's net: it names both ways to begin, and is its own `otherwise`.
  const Leg blended = leg.rest_from(0.1);
  Leg from_rest{PlannedLine(b, c)};
  for (const bool late : {false, true}) {
    build({});
    const NetId first = load_leg(leg, late ? 99.0 : 0.1);
    const Leg& taken = late ? from_rest : blended;
    const NetId second =
        load(taken.net(0.1), {.begins = {{"left", blended.seam_at(0.0)}, {"left", from_rest.seam_at(0.0)}}});
    const auto request = take_over(first, second, second);
    core->start(first);
    const auto done = answer(request);
    ASSERT_TRUE(done);
    EXPECT_EQ(done->kind, Event::Kind::kDone) << done->cause.text.view();
    EXPECT_EQ(done->cause.text.view(), late ? "its condition can never hold" : "");
    ASSERT_TRUE(run_to_end(second));
    EXPECT_EQ(core->status(second).first_cycle, core->status(first).last_cycle + 1);
    EXPECT_EQ(left_backend->sent.back().q, late ? c : b);
    expect_limits_kept(*left_backend);
  }
}

TEST_F(TakeOverTest, L8_AStoppedPredecessorIsNotTakenOverAndTheOtherWaysSeamDecides) {
  for (const bool cancel : {true, false}) {
    build({});
    const NetId first = load_leg(leg, 0.3), second = load_leg(leg.rest_from(0.3));
    const NetId from_rest = load_leg(Leg{PlannedLine(b, c)});
    const auto request = take_over(first, second, from_rest);
    core->start(first);
    steps(150);
    if (cancel)
      core->cancel(first);
    else
      core->abort(first);
    const auto refused = answer(request);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->kind, Event::Kind::kRefused) << "the arm rests elsewhere";
    EXPECT_EQ(refused->net, from_rest);
    EXPECT_TRUE(core->find_arm("left")->at_rest());
    expect_limits_kept(*left_backend);
  }
}

TEST_F(TakeOverTest, L8_ItIsPatientAsLongAsThePredecessorRuns) {
  Leg slow = leg;  // longer than the patience for rest
  slow.plan.law = leg.plan.law.stretched(1.2e-3 * rcc::Rule::kAnswerTimeout / leg.plan.law.duration());
  Leg wrong = leg.rest_from(0.1);
  const NetId first = load_leg(slow, 0.1), from_rest = load_leg(Leg{PlannedLine(b, c)});
  const auto request = take_over(first, load_leg(wrong), from_rest);
  core->start(first);
  const auto done = answer(request);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->kind, Event::Kind::kDone) << done->cause.text.view();
  EXPECT_GT(core->cycle(), rcc::Rule::kAnswerTimeout);
  EXPECT_EQ(core->state(from_rest), NetState::kRunning);
}

TEST_F(TakeOverTest, L8_NetsThatDoNotRunCannotBeEnded) {
  const NetId ready = load_leg(leg), second = load_leg(leg.rest_from(0.1));
  const auto refused = answer(core->post(rcc::Transaction{.start = {second}, .end = {ready}}));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->cause.text.view(), "net 1 is not running, it is Ready");
  EXPECT_THAT(std::string(answer(core->post(rcc::Transaction{.end = {77}}))->cause.text.view()),
              "net 77 is not loaded");
  // A net that has ended is ended already; one that stands may be ended with nobody after it.
  NetDescription still;
  still.add("sum", "ConstantReal", {{"value", 1.0}}).add("end", "Termination", {{"condition", false}});
  const NetId idle = load(still);
  core->start(idle);
  steps(2);
  EXPECT_EQ(answer(core->post(rcc::Transaction{.end = {idle}}))->kind, Event::Kind::kDone);
  EXPECT_EQ(core->status(idle).cause.code, Cause::Code::kTakenOver);
  EXPECT_EQ(answer(core->post(rcc::Transaction{.end = {idle}}))->kind, Event::Kind::kDone);
}

TEST_F(TakeOverTest, L8_AConditionMayBeARangeOfAPort) {
  const NetId first = load_leg(leg), second = load_leg(leg.rest_from(0.1));
  const auto* time = core->net(first)->find<net::Real>("clock.time");
  const auto request = core->post(rcc::Rule{.condition = {rcc::Term::in_range(first, time, 0.0996, 0.1004)},
                                            .action = {.start = {second}, .end = {first}}});
  core->start(first);
  EXPECT_EQ(answer(request)->kind, Event::Kind::kDone);
  EXPECT_EQ(core->status(first).last_cycle - core->status(first).first_cycle, 99);
  ASSERT_TRUE(run_to_end(second));
  EXPECT_EQ(left_backend->sent.back().q, b);
}

/// Chains of motions that take each other over at random places, with seams that do not fit, cancels and aborts.
class RandomChain {
 public:
  RandomChain(rcc::ControlCore& core, Random& random) : core_(core), random_(random) {}

  /// Posts the next switch, or starts anew where everything has come to rest.
  void act() {
    const bool rests = core_.find_arm("left")->phase() == device::Arm::Phase::kFrozen;
    if (rests && (now_ == 0 || core_.state(now_) == NetState::kTerminated)) return begin();
    const bool running = now_ != 0 && core_.state(now_) == NetState::kRunning;
    if (running && next_ == 0 && random_.unit() < 0.2) follow();
    if (running && random_.unit() < 0.0004) core_.cancel(now_);
    if (running && random_.unit() < 0.0002) core_.abort(now_);
  }

  void look() {
    for (const Event& event : core_.events()) {
      if (event.request != request_ || event.request == 0 || event.kind == Event::Kind::kState) continue;
      if (event.kind == Event::Kind::kRefused) ++refused;
      next_ = 0;
    }
    for (const NetId id : {second_, otherwise_}) {
      if (id == 0 || core_.state(id) != NetState::kRunning || id == now_) continue;
      const auto before = core_.status(now_);
      EXPECT_EQ(core_.status(id).first_cycle, before.last_cycle + 1) << "an empty cycle";
      (before.cause.code == Cause::Code::kTakenOver ? taken_over : from_rest) += 1;
      leg_ = id == second_ ? second_leg_ : otherwise_leg_;
      now_ = id;
    }
  }

  long taken_over = 0, from_rest = 0, refused = 0;

 private:
  static constexpr double kBlend_s = 0.02;

  NetId load(const Leg& leg) {
    const auto id = core_.load(leg.net(kBlend_s), {.begins = {{leg.arm, leg.seam_at(0.0)}}});
    EXPECT_TRUE(id) << id.error().to_string();
    return id.value_or(0);
  }
  JointVector any_goal() {
    JointVector goal(kFakeJoints);
    for (double& q : goal) q = random_.uniform(-1.0, 1.0);
    return goal;
  }
  void begin() {
    leg_ = Leg{PlannedLine(core_.find_arm("left")->set_point().q, any_goal())};
    now_ = load(leg_);
    next_ = second_ = otherwise_ = 0;
    core_.start(now_);
  }
  void follow() {
    second_leg_ = leg_.rest_from(kBlend_s);
    if (second_leg_.plan.law.duration() < 2 * kBlend_s) return;
    if (random_.unit() < 0.015) second_leg_.plan.line.q_start[2] += 0.01;
    if (random_.unit() < 0.015) second_leg_.plan.law = second_leg_.plan.law.stretched(1.3);
    otherwise_leg_ = Leg{PlannedLine(leg_.plan.line.q_goal, any_goal())};
    next_ = second_ = load(second_leg_);
    otherwise_ = load(otherwise_leg_);
    rcc::Rule rule{.condition = {rcc::Term::output(now_, core_.net(now_)->find<net::Boolean>("blend.value"))},
                   .action = {.start = {second_}, .end = {now_}},
                   .otherwise = {.start = {otherwise_}}};
    request_ = core_.post(rule);
  }

  rcc::ControlCore& core_;
  Random& random_;
  Leg leg_{PlannedLine(JointVector::Zero(kFakeJoints), JointVector::Ones(kFakeJoints))}, second_leg_ = leg_,
                                                                                         otherwise_leg_ = leg_;
  NetId now_ = 0, next_ = 0, second_ = 0, otherwise_ = 0;
  rcc::RequestId request_ = 0;
};

TEST_F(TakeOverTest, L8_ThousandsOfRandomTakeOversLeaveNoGapAndNoLimit) {
  Random random(8, "take over");
  build({.digest = false, .net_capacity = 1 << 15});
  RandomChain chain(*core, random);
  left_backend->keep = right_backend->keep = true;
  std::int64_t from = core->cycle();
  while (chain.taken_over < 1'500 && core->cycle() < 120'000) {
    chain.act();
    steps(1);
    chain.look();
    ASSERT_EQ(left_backend->last_written_cycle, core->cycle() - 1) << "an empty cycle";
  }
  EXPECT_EQ(left_backend->sent.size(), static_cast<std::size_t>(core->cycle() - from + 1));
  EXPECT_GE(chain.taken_over, 1'000);
  EXPECT_GT(chain.from_rest, 15);
  EXPECT_GT(chain.refused, 10);
  expect_limits_kept(*left_backend);
}

}  // namespace
}  // namespace takt::test
