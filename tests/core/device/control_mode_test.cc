#include "core/device/control_mode.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/device/control_mode_file.h"
#include "core/device/device_file.h"
#include "tests/support/fake_arm.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;

TEST(ControlMode, NamesGoThereAndBack) {
  for (const ControlMode mode : all_control_modes()) EXPECT_EQ(control_mode_of(name_of(mode)), mode);
  EXPECT_FALSE(control_mode_of("torque"));
  EXPECT_FALSE(control_mode_of(""));
}

class ComplianceTest : public testing::Test {
 protected:
  ComplianceRange range = test::compliant_arm_description(3).impedance.joint;
  static constexpr double kCycleShare = 0.002;  // a period of 1 ms, a ramp of 0.5 s
};

TEST_F(ComplianceTest, WhatStaysAsItIsPasses) {
  EXPECT_FALSE(find_fault(range.standard, range.standard, range, kCycleShare));
}

TEST_F(ComplianceTest, ValuesOutsideTheirRangesAreFoundWithAxisAndNumbers) {
  Compliance next = range.standard;
  next.stiffness[1] = 2100.0;
  const auto stiff = find_fault(next, next, range, kCycleShare);
  ASSERT_TRUE(stiff);
  EXPECT_EQ(stiff->view(), "stiffness of axis 2: 2100 outside [0, 2000]");
  next = range.standard;
  next.damping_ratio[0] = 0.05;
  EXPECT_TRUE(find_fault(next, next, range, kCycleShare));
  next = range.standard;
  next.feed_forward[2] = -51.0;
  EXPECT_TRUE(find_fault(next, next, range, kCycleShare));
  next.feed_forward[2] = std::nan("");
  EXPECT_EQ(find_fault(next, next, range, kCycleShare)->view(), "feed-forward of axis 3 is not finite");
  next = range.standard;
  next.stiffness.conservativeResize(2);
  EXPECT_TRUE(find_fault(next, range.standard, range, kCycleShare)) << "a wrong number of axes";
}

TEST_F(ComplianceTest, StepsBeyondTheRateAreFound) {
  Compliance next = range.standard;
  next.stiffness[0] += 3.9;  // 2000 in 0.5 s are 4 a cycle
  EXPECT_FALSE(find_fault(next, range.standard, range, kCycleShare));
  next.stiffness[0] += 0.3;
  EXPECT_TRUE(find_fault(next, range.standard, range, kCycleShare));
}

TEST_F(ComplianceTest, ApproachKeepsTheRateAndArrives) {
  Compliance goal = range.standard;
  goal.stiffness.setZero();
  goal.feed_forward.setConstant(20.0);
  Compliance now = range.standard;
  int cycles = 0;
  while (!(now == goal) && cycles < 1000) {
    const Compliance next = approach(now, goal, range, kCycleShare);
    ASSERT_FALSE(find_fault(next, now, range, kCycleShare)) << "in cycle " << cycles;
    now = next;
    ++cycles;
  }
  EXPECT_EQ(cycles, 250) << "half of the range of the stiffness in half of the ramp";
}

TEST_F(ComplianceTest, L5_AStopTakesTheFeedForwardAwayAndStiffensWhereDeclared) {
  Compliance pushing = range.standard;
  pushing.feed_forward.setConstant(10.0);
  EXPECT_FALSE(pushing.neutral());
  EXPECT_EQ(stopped(pushing, range), range.standard);
  range.stiff_on_stop = true;
  EXPECT_EQ(stopped(pushing, range).stiffness, range.upper.stiffness);
}

TEST(ControlModeFile, FindsAllThatIsWrongAtOnce) {
  const Json json = Json::parse(R"({
    "modes": ["position", "soft", "joint_impedance"],
    "mode_changes": [{"from": "position", "to": "joint_impedance", "class": "at_standstill", "duration_ms": 100},
                     {"from": "position", "to": "joint_impedance", "class": "seamless"},
                     {"from": "position", "to": "cartesian_impedance", "class": "at_once"},
                     {"from": "joint_impedance", "to": "position", "class": "seamless", "duration_ms": 5}],
    "impedance": {"joint_impedance": {"stiffness_max_Nm_rad": [100, 100], "stiffness_Nm_rad": [200, 50],
                                      "torque_max_Nm": [1, -1], "damping_ratio_range": [0.2, 1], "damping_ratio": 2,
                                      "on_stop": "limp"}}})");
  Diagnostics diagnostics;
  ObjectReader reader(json, "/control", diagnostics);
  ControlModes modes;
  ImpedanceDescription impedance;
  read_control_modes(reader, 2, modes, impedance);
  const std::string text = diagnostics.to_string();
  for (const char* expected :
       {"/control/modes/1", "unknown control mode 'soft'", "/control/mode_changes/1", "again",
        "/control/mode_changes/2/class", "/control/mode_changes/2", "it has no mode 'cartesian_impedance'",
        "/control/mode_changes/3/duration_ms", "/control/impedance/joint_impedance/torque_max_Nm/1",
        "/control/impedance/joint_impedance/stiffness_Nm_rad", "200 is above the largest",
        "/control/impedance/joint_impedance/damping_ratio", "/control/impedance/joint_impedance/on_stop"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << "\n" << text;
}

TEST(ControlModeFile, AModeOfImpedanceNeedsItsRanges) {
  const Json json = Json::parse(R"({"modes": ["position", "cartesian_impedance"]})");
  Diagnostics diagnostics;
  ObjectReader reader(json, "/control", diagnostics);
  ControlModes modes;
  ImpedanceDescription impedance;
  read_control_modes(reader, 6, modes, impedance);
  EXPECT_NE(diagnostics.to_string().find("impedance"), std::string::npos) << diagnostics.to_string();
}

TEST(ControlModeFile, TheArmsSayWhatTheyCanDo) {
  const auto model = [](const char* name) { return std::filesystem::path("models") / name; };
  const auto lwr = read_arm(model("lwr4plus"));
  ASSERT_TRUE(lwr) << lwr.error().to_string();
  EXPECT_EQ((*lwr)->modes.list(), "position, joint_impedance, cartesian_impedance");
  EXPECT_EQ((*lwr)->modes.find(ControlMode::kPosition, ControlMode::kCartesianImpedance)->change,
            ChangeClass::kOutsideNet);
  EXPECT_EQ((*lwr)->impedance.range(ControlMode::kCartesianImpedance).upper.stiffness[0], 5000.0);
  for (const char* stiff : {"ur5", "tx90"}) {
    const auto arm = read_arm(model(stiff));
    ASSERT_TRUE(arm) << arm.error().to_string();
    EXPECT_EQ((*arm)->modes.list(), "position");
    EXPECT_EQ((*arm)->modes.find(ControlMode::kPosition, ControlMode::kJointImpedance), nullptr);
  }
}

}  // namespace
}  // namespace takt::device
