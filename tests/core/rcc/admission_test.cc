// Whether there is time for a net (row T5).
#include "core/rcc/admission.h"

#include <array>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using rcc::Event;
using rcc::NetState;

NetDescription adders(int count) {
  NetDescription net;
  net.name = "adders";
  for (int i = 0; i < count; ++i) net.add("a" + std::to_string(i), "Add", {{"a", 1.0}, {"b", 2.0}});
  net.add("end", "Termination", {{"condition", false}});
  return net;
}

TEST(Admission, TheFactorOfThisMachineIsOneNumber) {
  const double factor = rcc::machine_factor();
  EXPECT_GT(factor, 0.05);
  EXPECT_LT(factor, 50.0);
  EXPECT_EQ(rcc::machine_factor(), factor);
}

TEST(Admission, T5_InRealTimeLoadRefusesWhatDoesNotFitBesideWhatRuns) {
  rcc::ControlCore probe({});
  const double cost = probe.status(probe.load(adders(1'000)).value()).cost_ns;
  ASSERT_GT(cost, 0.0);

  rcc::ControlCore core({.budget = static_cast<Nanoseconds>(2.5 * cost)});
  const auto first = core.load(adders(1'000)).value(), second = core.load(adders(1'000)).value();
  const auto third = core.load(adders(1'000)).value();  // nothing runs yet: each fits
  core.start(first);
  core.start(second);
  const auto request = core.start(third);
  guarded_step(core);
  EXPECT_EQ(core.state(second), NetState::kRunning);
  EXPECT_EQ(core.state(third), NetState::kReady);
  bool refused = false;
  for (const Event& event : core.events()) {
    if (event.request != request) continue;
    refused = event.kind == Event::Kind::kRefused;
    EXPECT_THAT(std::string(event.cause.text.view()), takt::test::Names("us"));
  }
  EXPECT_TRUE(refused);

  const auto fourth = core.load(adders(1'000));
  ASSERT_FALSE(fourth);
  EXPECT_THAT(fourth.error(), Reports(Code::kOverBudget, ""));
  const auto small = core.load(adders(10));
  EXPECT_TRUE(small) << small.error().to_string();

  core.abort(first);
  guarded_step(core);
  core.start(third);
  guarded_step(core);
  EXPECT_EQ(core.state(third), NetState::kRunning) << "what ended makes room";
}

class AdmissionOfTransactions : public testing::Test {
 protected:
  /// A core whose budget is so many times the cost of one of the nets.
  void build(double nets_in_budget) {
    rcc::ControlCore probe({});
    const double cost = probe.status(probe.load(adders(1'000)).value()).cost_ns;
    core = std::make_unique<rcc::ControlCore>(
        rcc::ControlCore::Options{.budget = static_cast<Nanoseconds>(nets_in_budget * cost)});
    for (rcc::NetId& net : nets) net = core->load(adders(1'000)).value();
  }
  /// The answer to a transaction in the next cycle.
  Event answer(const rcc::Transaction& transaction) {
    const rcc::RequestId request = core->post(transaction);
    guarded_step(*core);
    for (const Event& event : core->events())
      if (event.request == request) return event;
    ADD_FAILURE() << "no answer";
    return {};
  }

  std::unique_ptr<rcc::ControlCore> core;
  std::array<rcc::NetId, 3> nets{};
};

TEST_F(AdmissionOfTransactions, T5_NetsThatFitOnlyAloneAreNotStartedTogether) {
  build(1.5);
  const Event both = answer({.start = {nets[0], nets[1]}});
  EXPECT_EQ(both.kind, Event::Kind::kRefused);
  EXPECT_EQ(both.net, nets[1]) << "the one that is too much";
  EXPECT_THAT(std::string(both.cause.text.view()), takt::test::Names("us"));
  EXPECT_EQ(core->state(nets[0]), NetState::kReady) << "wholly or not at all";
  EXPECT_EQ(answer({.start = {nets[0], nets[0]}}).kind, Event::Kind::kDone) << "it is one net";
  EXPECT_EQ(answer({.start = {nets[0], nets[1]}}).kind, Event::Kind::kRefused) << "one of them runs already";
}

TEST_F(AdmissionOfTransactions, T5_WhatARuleAbortsOrEndsMakesRoomForWhatItStarts) {
  build(1.5);
  ASSERT_EQ(answer({.start = {nets[0]}}).kind, Event::Kind::kDone);
  EXPECT_EQ(answer({.start = {nets[1]}}).kind, Event::Kind::kRefused);
  EXPECT_EQ(answer({.cancel = {nets[0]}, .start = {nets[1]}}).kind, Event::Kind::kRefused) << "it may run on";
  EXPECT_EQ(answer({.abort = {nets[0]}, .start = {nets[1]}}).kind, Event::Kind::kDone);
  EXPECT_EQ(core->state(nets[1]), NetState::kRunning);
  EXPECT_EQ(answer({.start = {nets[2]}, .end = {nets[1]}}).kind, Event::Kind::kDone);
  EXPECT_EQ(core->state(nets[2]), NetState::kRunning);
}

TEST_F(AdmissionOfTransactions, T5_ANetIsNotSubtractedTwice) {
  build(1.5);
  ASSERT_EQ(answer({.start = {nets[0]}}).kind, Event::Kind::kDone);
  EXPECT_EQ(answer({.abort = {nets[0]}, .start = {nets[1], nets[2]}, .end = {nets[0]}}).kind, Event::Kind::kRefused);
}

TEST(Admission, T5_InLockStepCostIsOnlyReported) {
  rcc::ControlCore core({});
  const auto id = core.load(adders(20'000));
  ASSERT_TRUE(id);
  EXPECT_GT(core.status(*id).cost_ns, 10'000.0);
  core.start(*id);
  guarded_step(core);
  EXPECT_EQ(core.state(*id), NetState::kRunning);
}

}  // namespace
}  // namespace takt::test
