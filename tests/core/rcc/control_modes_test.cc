// Control modes of arms: what LOAD says of them, what a START does, and who else may change them (row L4).
#include <map>

#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using device::ControlMode;
using net::Cause;
using rcc::Event;
using rcc::NetState;

/// A net that holds an arm where it is, in a mode; it ends after a cancel.
NetDescription hold_net(const std::string& type, const JointVector& q, const Json& more = Json::object()) {
  NetDescription net;
  net.name = "hold";
  const std::vector<double> zero(static_cast<std::size_t>(q.size()), 0.0), where(q.begin(), q.end());
  Json parameters = {{"device", "left"}};
  parameters.update(more);
  net.add("arm", type, parameters);
  net.add("cancel", "Cancel").add("end", "Termination").link("cancel.requested", "end.condition");
  net.add("q", "ConstantJoints", {{"value", where}}).link("q.value", "arm.q");
  net.add("dq", "ConstantJoints", {{"value", zero}}).link("dq.value", "arm.dq");
  net.add("ddq", "ConstantJoints", {{"value", zero}}).link("ddq.value", "arm.ddq");
  return net;
}

class ControlModesTest : public CoreTest {
 protected:
  ControlModesTest() {
    description = std::make_shared<const device::ArmDescription>(compliant_arm_description(kFakeJoints));
    build({});
    left = core->find_arm("left");
  }

  NetDescription in(ControlMode mode, const JointVector& q = JointVector::Zero(kFakeJoints)) const {
    if (mode == ControlMode::kPosition) return hold_net("ArmCommand", q, {{"mode", "position"}});
    return hold_net(mode == ControlMode::kJointImpedance ? "JointImpedanceCommand" : "CartesianImpedanceCommand", q);
  }

  /// Steps until the request is answered. @return whether it was done; `why` holds the reason if not.
  bool wait_for(rcc::RequestId request, int most = 1000) {
    for (; most > 0; --most) {
      steps(1);
      ++waited;
      for (const Event& one : core->events()) {
        if (one.request != request) continue;
        why = std::string(one.cause.text.view());
        return one.kind == Event::Kind::kDone;
      }
    }
    why = "no answer";
    return false;
  }
  bool change_to(ControlMode mode) { return wait_for(core->change_mode("left", mode)); }

  device::Arm* left = nullptr;
  std::string why;
  int waited = 0;
};

TEST_F(ControlModesTest, L4_LoadNamesTheModesThatThereAre) {
  build({});
  description = std::make_shared<const device::ArmDescription>(fake_arm_description(kFakeJoints));
  build({});
  const auto loaded = core->load(in(ControlMode::kJointImpedance));
  ASSERT_FALSE(loaded);
  const Diagnostics& text = loaded.error();
  EXPECT_THAT(text,
              Reports(Code::kUnknownName, "/primitives/0/parameters/device", {"left", "joint_impedance", "position"}));
  EXPECT_FALSE(core->load(hold_net("ArmCommand", joints(0, 0, 0), {{"mode", "joint_impedance"}})));
}

TEST_F(ControlModesTest, L4_AStartWaitsForAChangeAtStandstillAndItsDeclaredTime) {
  left_backend->change_cycles = 5;
  const auto net = load(in(ControlMode::kJointImpedance));
  ASSERT_TRUE(wait_for(core->start(net))) << why;
  EXPECT_GE(waited, 20) << "declared are 20 ms, though the device was ready sooner";
  EXPECT_LE(waited, 25);
  EXPECT_EQ(left->mode(), ControlMode::kJointImpedance);
  EXPECT_EQ(left_backend->changes, 1);
  steps(5);
  EXPECT_EQ(core->state(net), NetState::kRunning);
  EXPECT_EQ(left_backend->given.back(), description->impedance.joint.standard);
}

TEST_F(ControlModesTest, L2_ACancelTakesBackAStartThatWaitsForTheDevice) {
  const auto net = load(in(ControlMode::kJointImpedance));
  const auto start = core->start(net);
  steps(3);
  EXPECT_EQ(core->state(net), NetState::kReady);
  const auto cancel = core->cancel(net);
  steps(1);
  std::map<rcc::RequestId, rcc::Event::Kind> answers;
  for (const rcc::Event& event : core->events()) answers[event.request] = event.kind;
  EXPECT_EQ(answers.at(start), rcc::Event::Kind::kRefused);
  EXPECT_EQ(answers.at(cancel), rcc::Event::Kind::kDone);
  steps(100);
  EXPECT_EQ(core->state(net), NetState::kReady) << "it never runs";
}

TEST_F(ControlModesTest, L4_AStartIsRefusedWhereTheClassForbidsTheChange) {
  const auto net = load(in(ControlMode::kCartesianImpedance));
  EXPECT_FALSE(wait_for(core->start(net)));
  EXPECT_EQ(why, "left: position to cartesian_impedance is forbidden");
  EXPECT_EQ(core->state(net), NetState::kReady);
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  EXPECT_TRUE(wait_for(core->start(net))) << why;  // seamless from there
  core->abort(net);
  steps(2);
  const auto stiff = load(in(ControlMode::kPosition));
  EXPECT_FALSE(wait_for(core->start(stiff)));
  EXPECT_EQ(why, "left: cartesian_impedance to position only outside a net");
}

TEST_F(ControlModesTest, L4_AMovingArmDoesNotChangeAtStandstill) {
  const auto ptp = load(ptp_net("ptp", "left", {joints(0, 0, 0), joints(0.4, 0.2, 0.1)}));
  core->start(ptp);
  steps(100);
  const auto soft = load(in(ControlMode::kJointImpedance));
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {soft}});
  steps(1);
  ASSERT_NE(event(Event::Kind::kRefused), nullptr);
  EXPECT_EQ(event(Event::Kind::kRefused)->cause.text.view(), "left is held by net 1");
  EXPECT_EQ(left_backend->changes, 0);
}

TEST_F(ControlModesTest, L4_AChangeFromOutsideIsRefusedWhileANetHoldsTheArm) {
  const auto net = load(in(ControlMode::kPosition));
  ASSERT_TRUE(wait_for(core->start(net)));
  EXPECT_FALSE(change_to(ControlMode::kJointImpedance));
  EXPECT_EQ(why, "left: a net holds it");
  core->cancel(net);
  steps(3);
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  ASSERT_TRUE(change_to(ControlMode::kCartesianImpedance)) << why;
  waited = 0;
  ASSERT_TRUE(change_to(ControlMode::kPosition)) << why;
  EXPECT_GE(waited, 50);
  EXPECT_TRUE(change_to(ControlMode::kPosition)) << "it is there";
  EXPECT_EQ(core->change_mode("nobody", ControlMode::kPosition), 0u);
}

TEST_F(ControlModesTest, L4_ADeviceThatDoesNotChangeIsTold) {
  left_backend->ignores_modes = true;
  EXPECT_FALSE(change_to(ControlMode::kJointImpedance));
  EXPECT_EQ(why, "left: did not go into mode joint_impedance");
  EXPECT_EQ(left->mode(), ControlMode::kPosition);
  EXPECT_FALSE(left->refusal()) << "it can be driven as before";
}

TEST_F(ControlModesTest, PositionBeginsWhereTheArmIs) {
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  left_backend->deflection = joints(0.02, -0.01, 0.0);
  left_backend->change_cycles = 25;
  steps(3);
  EXPECT_EQ(left->set_point().q, joints(0, 0, 0)) << "the set point is where the springs rest";
  EXPECT_FALSE(left->refusal()) << "an arm that gives way may be elsewhere";
  ASSERT_TRUE(change_to(ControlMode::kPosition)) << why;
  EXPECT_EQ(left->set_point().q, joints(0.02, -0.01, 0.0));
  EXPECT_EQ(left_backend->sent.back().q, joints(0.02, -0.01, 0.0));
}

TEST_F(ControlModesTest, AnArmThatChangesByItselfIsTakenOverAnew) {
  const auto net = load(in(ControlMode::kPosition));
  ASSERT_TRUE(wait_for(core->start(net)));
  steps(10);
  left_backend->take_mode(ControlMode::kJointImpedance);
  steps(3);
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kDevice);
  EXPECT_EQ(left->mode(), ControlMode::kJointImpedance);
}

TEST_F(ControlModesTest, WhatIsWantedIsApproachedWithTheRatesOfTheDevice) {
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  auto net = in(ControlMode::kJointImpedance);
  net.add("soft", "ConstantJoints", {{"value", {200, 200, 200}}}).link("soft.value", "arm.stiffness");
  const auto id = load(net);
  ASSERT_TRUE(wait_for(core->start(id))) << why;
  const auto* settled = core->net(id)->find<net::Boolean>("arm.settled");
  steps(1);
  EXPECT_NEAR(left_backend->given.back().stiffness[0], 996.0, 1e-9) << "2000 in 0.5 s";
  EXPECT_FALSE(settled->value);
  steps(200);
  EXPECT_EQ(left_backend->given.back().stiffness[0], 200.0);
  EXPECT_TRUE(settled->value);
}

TEST_F(ControlModesTest, S2_TheGuardTripsOnALimitOfTheDeviceAndClampsNothing) {
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  auto net = in(ControlMode::kJointImpedance);
  net.add("stiff", "ConstantJoints", {{"value", {2500, 200, 200}}}).link("stiff.value", "arm.stiffness");
  const auto id = load(net);
  ASSERT_TRUE(wait_for(core->start(id))) << why;
  ASSERT_TRUE(run_to_end(id, 1000));
  EXPECT_EQ(core->status(id).cause.code, Cause::Code::kGuard);
  EXPECT_THAT(core->status(id).cause.text.view(), takt::test::Names("1"));
  for (const auto& given : left_backend->given) EXPECT_LE(given.stiffness.maxCoeff(), 2002.0);
}

TEST_F(ControlModesTest, L5_AStopTakesTorquesToNeutralBeforeTheSetPointIsFrozen) {
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  auto net = in(ControlMode::kJointImpedance);
  net.add("push", "ConstantJoints", {{"value", {10, 0, -10}}}).link("push.value", "arm.torque");
  const auto id = load(net);
  ASSERT_TRUE(wait_for(core->start(id))) << why;
  steps(200);
  EXPECT_EQ(left_backend->given.back().feed_forward, joints(10, 0, -10));
  core->cancel(id);
  ASSERT_TRUE(run_to_end(id, 10));
  EXPECT_EQ(left->phase(), device::Arm::Phase::kBraking) << "at rest, but it pushes";
  double last = 10.0;
  for (int i = 0; i < 200 && left->phase() == device::Arm::Phase::kBraking; ++i) {
    steps(1);
    const double now = left_backend->given.back().feed_forward[0];
    EXPECT_LE(last - now, 0.2 + 1e-9) << "100 Nm in 0.5 s";
    last = now;
  }
  EXPECT_EQ(left->phase(), device::Arm::Phase::kFrozen);
  EXPECT_EQ(last, 0.0);
  EXPECT_EQ(left->set_point().q, joints(0, 0, 0));
}

TEST_F(ControlModesTest, L4_ANetThatChangesTheModeByTurnsNeedsSeamlessChanges) {
  const auto turns = [this](ControlMode one, ControlMode other) {
    NetDescription net;
    net.name = "turns";
    net.add("cancel", "Cancel").add("end", "Termination").link("cancel.requested", "end.condition");
    net.add("yes", "ConstantBoolean", {{"value", true}}).add("late", "OnDelay", {{"delay", 0.01}}).add("early", "Not");
    net.link("yes.value", "late.input").link("late.value", "early.input");
    for (const auto& [id, mode] : {std::pair{"first", one}, std::pair{"second", other}}) {
      net::FragmentDescription part{.id = id, .when_inactive = {}, .net = in(mode), .inputs = {}, .outputs = {}};
      std::erase_if(part.net.primitives, [](const auto& p) { return p.id == "cancel" || p.id == "end"; });
      std::erase_if(part.net.links, [](const auto& link) { return link.to == "end.condition"; });
      net.fragments.push_back(part);
    }
    net.link("early.value", "first.active").link("late.value", "second.active");
    return net;
  };
  const auto wrong = core->load(turns(ControlMode::kPosition, ControlMode::kJointImpedance));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong, takt::test::ReportsAnywhere(Code::kConflict, {"position", "joint_impedance"}));
  const auto right = load(turns(ControlMode::kJointImpedance, ControlMode::kCartesianImpedance));
  ASSERT_TRUE(change_to(ControlMode::kJointImpedance)) << why;
  ASSERT_TRUE(wait_for(core->start(right))) << why;
  steps(5);
  EXPECT_EQ(left->mode(), ControlMode::kJointImpedance);
  steps(15);
  EXPECT_EQ(core->state(right), NetState::kRunning);
  EXPECT_EQ(left->mode(), ControlMode::kCartesianImpedance);
  EXPECT_EQ(left_backend->given.back().stiffness.size(), 6);
}

TEST_F(ControlModesTest, L3_ASeamKnowsTheModes) {
  const auto seam = [](const char* mode) { return device::Seam{.mode = net::Text(mode)}; };
  EXPECT_FALSE(left->seam_mismatch(seam("joint_impedance"), seam("cartesian_impedance")));
  ASSERT_TRUE(left->seam_mismatch(seam("cartesian_impedance"), seam("position")));
  EXPECT_EQ(left->seam_mismatch(seam("cartesian_impedance"), seam("position"))->view(),
            "begins in mode position, not cartesian_impedance");
}

}  // namespace
}  // namespace takt::test
