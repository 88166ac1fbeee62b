#include "core/device/seam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/arm.h"
#include "tests/support/fake_arm.h"

namespace takt::test {
namespace {

using device::Arm;
using device::JointVector;
using device::Seam;

/// What an arm says when a net that ends like `end` is followed by one that begins like `begin`; empty: it fits.
std::string seam_mismatch(const Seam& end, const Seam& begin) {
  const Arm arm("arm", std::make_shared<const device::ArmDescription>(fake_arm_description(3)),
                std::make_shared<FakeArm>(JointVector::Zero(3)), kMillisecond);
  const auto text = arm.seam_mismatch(end, begin);
  return text ? std::string(text->view()) : "";
}

Seam at(double q, double dq = 0.0, double ddq = 0.0) {
  Seam seam;
  seam.q = JointVector::Constant(3, 0.1);
  seam.dq = seam.ddq = JointVector::Zero(3);
  seam.q[1] = q;
  seam.dq[1] = dq;
  seam.ddq[1] = ddq;
  return seam;
}

// Limits of the fake arm: jerk 200 rad/s^3, period 1 ms: 2e-7 rad, 2e-4 rad/s, 0.2 rad/s^2 are one step of jerk.
TEST(SeamOfAnArm, L3_FitsUpToOneStepOfJerkAndNamesAxisAndNumber) {
  EXPECT_EQ(seam_mismatch(at(0.5, 0.2, 1.0), at(0.5, 0.2, 1.0)), "");
  EXPECT_EQ(seam_mismatch(at(0.5), at(0.5 + 1.9e-7)), "");
  EXPECT_EQ(seam_mismatch(at(0.5), at(0.6)), "joint a2: begins at 0.6, not at 0.5 rad");
  EXPECT_EQ(seam_mismatch(at(0.5), at(0.5 + 2.2e-7)).substr(0, 9), "joint a2:");
  EXPECT_EQ(seam_mismatch(at(0.5, 1.9e-4), at(0.5)), "");
  EXPECT_EQ(seam_mismatch(at(0.5, 0.3), at(0.5)), "joint a2: begins at 0, not at 0.3 rad/s");
  EXPECT_EQ(seam_mismatch(at(0.5, 0.3, 1.0), at(0.5, 0.3, 1.1)), "");
  EXPECT_EQ(seam_mismatch(at(0.5, 0.3, 1.0), at(0.5, 0.3, 2.0)), "joint a2: begins at 2, not at 1 rad/s2");
}

TEST(SeamOfAnArm, L3_WhatIsNotSaidIsNotCompared) {
  EXPECT_EQ(seam_mismatch({}, at(0.5)), "");
  EXPECT_EQ(seam_mismatch(at(0.5), {}), "");
  Seam only_q;
  only_q.q = at(0.5).q;
  EXPECT_EQ(seam_mismatch(at(0.5, 1.0, 1.0), only_q), "");
}

TEST(SeamOfAnArm, L3_ModeAndToolBelongToIt) {
  Seam a = at(0.5), b = at(0.5);
  a.mode = net::Text("position");
  b.mode = net::Text("impedance");
  EXPECT_EQ(seam_mismatch(a, b), "begins in mode impedance, not position");
  b.mode = a.mode;
  a.tool = b.tool = device::ToolSetting{};
  EXPECT_EQ(seam_mismatch(a, b), "");
  b.tool->payload.mass = 0.5;
  EXPECT_EQ(seam_mismatch(a, b), "begins with a load of 0.5, not 0 kg");
  b.tool->payload.mass = 0.0;
  b.tool->X_FT.translation().z() = 0.2;
  EXPECT_EQ(seam_mismatch(a, b), "begins with another tool: 0.2 m apart");
}

TEST(SeamOfAnArm, L3_NotFiniteAndOfTheWrongSizeFitsNowhere) {
  Seam broken = at(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(seam_mismatch(at(0.5), broken), "");
  broken.q = JointVector::Zero(2);
  EXPECT_EQ(seam_mismatch(at(0.5), broken), "begins with 2 joints, not 3");
}

}  // namespace
}  // namespace takt::test
