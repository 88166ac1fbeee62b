// Whether there is time for a net (row T5).
#include "core/rcc/admission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using rcc::Event;
using rcc::NetState;
using testing::HasSubstr;

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
    EXPECT_THAT(std::string(event.cause.text.view()), HasSubstr("us a cycle with it, but the budget is"));
  }
  EXPECT_TRUE(refused);

  const auto fourth = core.load(adders(1'000));
  ASSERT_FALSE(fourth);
  EXPECT_THAT(fourth.error().to_string(), HasSubstr("and those that run"));
  EXPECT_THAT(fourth.error().to_string(), HasSubstr("the budget is"));
  const auto small = core.load(adders(10));
  EXPECT_TRUE(small) << small.error().to_string();

  core.abort(first);
  guarded_step(core);
  core.start(third);
  guarded_step(core);
  EXPECT_EQ(core.state(third), NetState::kRunning) << "what ended makes room";
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
