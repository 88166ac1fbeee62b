#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "core/device/gripper.h"

/// What every back end of a gripper owes the canonical gripper, whatever machine is behind it (docs/devices.md,
/// "Gripper"). Instantiate with INSTANTIATE_TEST_SUITE_P(Name, GripperConformance, Values(...), name_of_gripper).
namespace takt::test {

/// A gripper with its surroundings: a part of known width that can be put between the open fingers.
class GripperRig {
 public:
  virtual ~GripperRig() = default;
  /// The machine lives on for one cycle of 1 ms.
  virtual void advance() = 0;
  std::shared_ptr<const device::GripperDescription> description;
  std::shared_ptr<device::GripperBackend> backend;
  double part_width = 0.0;  ///< m; 0: there is none
};

struct GripperUnderTest {
  std::string name;
  std::function<std::unique_ptr<GripperRig>(bool with_part)> make;
};

inline std::string name_of_gripper(const testing::TestParamInfo<GripperUnderTest>& one) { return one.param.name; }

class GripperConformance : public testing::TestWithParam<GripperUnderTest> {
 protected:
  void build(bool with_part) {
    rig = GetParam().make(with_part);
    ASSERT_TRUE(rig && rig->backend && rig->description);
    gripper = std::make_unique<device::Gripper>("gripper", rig->description, rig->backend);
    for (int i = 0; i < 50 && !gripper->ready(); ++i) cycle();
    ASSERT_TRUE(gripper->ready());
    gripper->hold();
  }
  /// One cycle as the core runs it. @return why the guard tripped, or an empty text
  std::string cycle(std::optional<device::GripperSetPoint> wanted = {}) {
    gripper->begin_cycle(k, k * kMillisecond);
    ++k;
    if (wanted) gripper->propose(wanted->width, wanted->speed, wanted->force);
    const auto trip = gripper->check();
    gripper->hand_over();
    rig->advance();
    return trip ? std::string(trip->view()) : "";
  }
  /// Commands until the fingers stand. @return cycles that took
  int go(const device::GripperSetPoint& wanted) {
    int cycles = 0;
    do {
      EXPECT_EQ(cycle(wanted), "");
    } while (++cycles < 5000 && (cycles < 3 || !gripper->at_rest()));
    cycle();
    return cycles;
  }
  [[nodiscard]] device::GripperSetPoint to(double width, double speed = 0.1) const {
    return {.sequence = 0, .width = width, .speed = speed, .force = 0.5 * rig->description->force_max};
  }
  [[nodiscard]] device::GripperState state() const { return gripper->sample().state; }

  std::unique_ptr<GripperRig> rig;
  std::unique_ptr<device::Gripper> gripper;
  std::int64_t k = 0;
};

TEST_P(GripperConformance, GoesToAWidthAndSaysSo) {
  build(false);
  const double goal = 0.5 * rig->description->stroke;
  const double way = std::abs(gripper->sample().width - goal);
  const int cycles = go(to(goal));
  EXPECT_EQ(state(), device::GripperState::kIdle);
  EXPECT_NEAR(gripper->sample().width, goal, 1e-3);
  EXPECT_GE(cycles * 1e-3, way / 0.1) << "not faster than it was told";
  EXPECT_TRUE(gripper->answered());
}

TEST_P(GripperConformance, SamplesCarryTimeAndNumber) {
  build(false);
  const auto first = gripper->sample();
  for (int i = 0; i < 100; ++i) cycle();
  const auto later = gripper->sample();
  EXPECT_GT(later.sequence, first.sequence);
  EXPECT_GT(later.stamp, first.stamp);
  EXPECT_LE(gripper->sample_age(), rig->description->sample_age_max);
  EXPECT_GE(gripper->sample_age(), 0);
}

TEST_P(GripperConformance, HoldsWhatItMeetsAndKeepsItWhenItsNetEnds) {
  build(true);
  go(to(0.0));
  EXPECT_EQ(state(), device::GripperState::kHolding);
  EXPECT_NEAR(gripper->sample().width, rig->part_width, 2e-3);
  EXPECT_NEAR(gripper->sample().force, 0.5 * rig->description->force_max, 2.0);
  const auto sent = gripper->set_point().sequence;
  gripper->release();
  for (int i = 0; i < 500; ++i) cycle();
  EXPECT_EQ(state(), device::GripperState::kHolding);
  EXPECT_EQ(gripper->set_point().sequence, sent);
}

TEST_P(GripperConformance, KeepsTheGripThroughAStop) {
  build(true);
  go(to(0.0));
  cycle(to(rig->description->stroke));  // has hardly begun to open when it is stopped
  gripper->stop();
  for (int i = 0; i < 500; ++i) cycle();
  EXPECT_EQ(state(), device::GripperState::kHolding);
}

TEST_P(GripperConformance, StandsStillSoonAfterAStopOnItsWay) {
  build(false);
  for (int i = 0; i < 100; ++i) cycle(to(0.0, 0.05));
  gripper->stop();
  for (int i = 0; i < 300; ++i) cycle();
  const double width = gripper->sample().width;
  EXPECT_GT(width, 0.1 * rig->description->stroke) << "it did not go on to its goal";
  for (int i = 0; i < 300; ++i) cycle();
  EXPECT_NEAR(gripper->sample().width, width, 1e-4);
  EXPECT_TRUE(gripper->at_rest());
}

TEST_P(GripperConformance, TheSameCommandAgainChangesNothing) {
  build(false);
  const double goal = 0.3 * rig->description->stroke;
  go(to(goal));
  const auto sent = gripper->set_point().sequence;
  for (int i = 0; i < 200; ++i) {
    cycle(to(goal));
    EXPECT_EQ(state(), device::GripperState::kIdle);
  }
  EXPECT_EQ(gripper->set_point().sequence, sent);
}

TEST_P(GripperConformance, OpensAgain) {
  build(true);
  go(to(0.0));
  go(to(rig->description->stroke));
  EXPECT_EQ(state(), device::GripperState::kIdle);
  EXPECT_NEAR(gripper->sample().width, rig->description->stroke, 1e-3);
}

}  // namespace takt::test
