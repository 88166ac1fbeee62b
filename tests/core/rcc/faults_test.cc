// What happens when a net does wrong: the guard, null set points, primitives that throw.
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using net::Cause;
using net::Cycle;
using net::In;
using net::JointArray;
using net::Out;
using net::Real;
using net::Setup;
using rcc::Event;
using rcc::NetState;

/// Passes joints on and, from a cycle on, adds a jump to one of them, gives NaN (which a port makes null), or null.
class TestSpoil final : public net::Primitive {
 public:
  explicit TestSpoil(Setup& setup)
      : input_(setup.in<JointArray>("input", {.unit = "rad", .doc = "what is spoilt"})),
        value_(setup.out<JointArray>("value", {.unit = "rad", .doc = "spoilt"})),
        cycle_(setup.parameter<net::Integer>("cycle", {.doc = "from when"})),
        jump_(setup.parameter<Real>("jump", 0.0, {.doc = "how far"})),
        nan_(setup.parameter<net::Boolean>("nan", false, {.doc = "not a number instead"})) {}
  void update(const Cycle& cycle) override {
    if (input_.null()) return value_.set_null();
    JointArray value = *input_;
    if (cycle.index_in_net >= cycle_) {
      value.value[1] += jump_;
      if (nan_) value.value[1] = std::numeric_limits<double>::quiet_NaN();
    }
    value_.set(value);
  }

 private:
  In<JointArray> input_;
  Out<JointArray> value_;
  std::int64_t cycle_;
  double jump_;
  bool nan_;
};
TAKT_PRIMITIVE(TestSpoil, "test", "Spoils joints.");

class TestThrow final : public net::Primitive {
 public:
  explicit TestThrow(Setup& setup)
      : out_(setup.out<Real>("value", {.unit = "1", .doc = "nothing"})),
        cycle_(setup.parameter<net::Integer>("cycle", {.doc = "when"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.index_in_net == cycle_) throw std::runtime_error("bad day");
    out_.set(0.0);
  }

 private:
  Out<Real> out_;
  std::int64_t cycle_;
};
TAKT_PRIMITIVE(TestThrow, "test", "Throws.");

class FaultsTest : public CoreTest {
 protected:
  /// A PTP whose positions are spoilt on their way to the arm.
  NetDescription spoilt(const std::string& arm, const Json& parameters) {
    auto net = ptp_net("spoilt", arm, {zero, goal});
    std::erase_if(net.links, [](const auto& link) { return link.to == "arm.q"; });
    net.add("spoil", "TestSpoil", parameters);
    net.link("line.q", "spoil.input").link("spoil.value", "arm.q");
    return net;
  }
  JointVector zero = JointVector::Zero(3);
  JointVector goal = joints(0.6, -0.4, 0.2);
};

TEST_F(FaultsTest, S2_AJumpTripsTheGuardAndTheArmBrakesWithinItsLimits) {
  const auto net = load(spoilt("left", {{"cycle", 300}, {"jump", 0.3}}));
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  const auto status = core->status(net);
  EXPECT_EQ(status.last_cycle, status.first_cycle + 300);
  EXPECT_EQ(status.cause.code, Cause::Code::kGuard);
  EXPECT_EQ(status.cause.cycle, status.last_cycle);
  EXPECT_THAT(std::string(status.cause.text.view()), testing::StartsWith("joint a2: velocity 29"));
  ASSERT_NE(event(Event::Kind::kStopped), nullptr);
  steps(2000);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kFrozen);
  expect_limits_kept(*left_backend);
}

TEST_F(FaultsTest, S2_TheSmallestJumpTheGuardShouldSee) {
  // 1e-6 rad in 1 ms is a jerk of 1000 rad/s^3, five times the limit.
  const auto net = load(spoilt("left", {{"cycle", 300}, {"jump", 1e-6}}));
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kGuard);
  steps(2000);
  expect_limits_kept(*left_backend);
}

TEST_F(FaultsTest, N4_N5_NanIsNullAndNullStopsTheArm) {
  const auto net = load(spoilt("left", {{"cycle", 300}, {"nan", true}}));
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kNullInput);
  EXPECT_EQ(core->status(net).cause.text.view(), "left: the set point is null");
  steps(2000);
  expect_limits_kept(*left_backend);
}

TEST_F(FaultsTest, N4_ExtrapolationBridgesThenStops) {
  auto text = spoilt("left", {{"cycle", 300}, {"nan", true}});
  for (auto& primitive : text.primitives)
    if (primitive.id == "arm") primitive.on_null["q"] = {{"bridge_cycles", 5}};
  const auto net = load(text);
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  const auto status = core->status(net);
  EXPECT_EQ(status.cause.code, Cause::Code::kNullInput);
  EXPECT_EQ(status.last_cycle, status.first_cycle + 305);
  steps(2000);
  expect_limits_kept(*left_backend);
}

/// A net that trips at one of its arms stops all of them in the same cycle.
TEST_F(FaultsTest, S2_AllArmsOfTheNetStop) {
  auto both = spoilt("left", {{"cycle", 300}, {"jump", 0.3}});
  both.add("right", "ArmCommand", {{"device", "right"}});
  for (const char* port : {"q", "dq", "ddq"}) both.link(std::string("line.") + port, std::string("right.") + port);
  const auto net = load(both);
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kBraking);
  EXPECT_EQ(core->find_arm("right")->phase(), device::Arm::Phase::kBraking);
  steps(2000);
  expect_limits_kept(*left_backend);
  expect_limits_kept(*right_backend);
}

TEST_F(FaultsTest, L7_AThrowingPrimitiveEndsItsNetAndNoOther) {
  const auto run = [this](bool with_thrower) {
    build({});
    right_backend->keep = true;
    auto bystander = load(ptp_net("bystander", "right", {zero, goal}));
    auto text = ptp_net("thrower", "left", {zero, goal});
    if (with_thrower) text.add("thrower", "TestThrow", {{"cycle", 250}});
    const auto net = load(text);
    (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {bystander, net}});
    // Without the allocation guard: what is thrown lies on the heap.
    for (int i = 0; i < 20'000 && core->state(bystander) != NetState::kTerminated; ++i) core->step();
    EXPECT_EQ(core->state(bystander), NetState::kTerminated);
    if (with_thrower) {
      EXPECT_EQ(core->status(net).cause.code, Cause::Code::kException);
      EXPECT_EQ(core->status(net).last_cycle, core->status(net).first_cycle + 250);
      expect_limits_kept(*left_backend);
    }
    std::vector<JointVector> sent;
    for (const auto& set_point : right_backend->sent) sent.push_back(set_point.q);
    return sent;
  };
  EXPECT_EQ(run(true), run(false));
}

TEST_F(FaultsTest, N3_ADeadSensorAtATerminationEndsTheNet) {
  auto text = ptp_net("watched", "left", {zero, goal});
  std::erase_if(text.links, [](const auto& link) { return link.to == "end.condition"; });
  text.add("state", "ArmState", {{"device", "right"}});
  text.add("watch", "GreaterThan", {{"b", 1.0}});
  text.link("state.age", "watch.a").link("watch.value", "end.condition");
  const auto net = load(text);
  core->start(net);
  steps(300);
  EXPECT_EQ(core->state(net), NetState::kRunning);
  right_backend->silent = true;
  guarded_step(*core);
  EXPECT_EQ(core->state(net), NetState::kTerminated);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kBraking);  // row L5: it was not at rest
  steps(2000);
  expect_limits_kept(*left_backend);
}

TEST_F(FaultsTest, ErrorFailsTheNetWithItsText) {
  auto text = ptp_net("failing", "left", {zero, goal});
  text.add("late", "CycleCounter", {{"counted", true}});
  text.add("state", "ArmState", {{"device", "left"}});
  text.add("tired", "OnDelay", {{"delay", 0.1}});
  text.add("error", "Error", {{"text", "had enough"}});
  text.link("state.ready", "tired.input").link("tired.value", "error.condition");
  const auto net = load(text);
  core->start(net);
  ASSERT_TRUE(run_to_end(net));
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kError);
  EXPECT_EQ(core->status(net).cause.text.view(), "had enough");
  EXPECT_EQ(core->status(net).last_cycle, core->status(net).first_cycle + 100);
}

}  // namespace
}  // namespace takt::test
