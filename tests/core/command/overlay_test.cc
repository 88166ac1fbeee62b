// A force that is held while a path is followed: on an inclined surface that gives way like a spring.
#include "core/command/actions/overlay_action.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/check.h"
#include "core/kinematics/inverse.h"
#include "core/motion/leg.h"
#include "core/motion/motion_state.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::Reports;

/// Of two lines with a force offset: their speed, m/s, and the range of the offset, m.
struct Corner {
  double speed = 0.03, reach = 0.012, retreat = 0.008;
};

class ForceOffsetTest : public testing::Test {
 protected:
  /// A line of 0.12 m along the base's y, with a force straight down.
  RuntimeCommand polish(ForceOffsetControlParameters wish = {}, double acceleration = 0.8) {
    const Eigen::Isometry3d X_BT = cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT;
    wish.direction_M = X_BT.linear().transpose() * -Eigen::Vector3d::UnitZ();
    wish.force.force = 8.0;
    wish.force.approach_velocity = 0.01;
    wish.force.gain = 1e-3;
    wish.force.acceleration_max = 0.3;
    PlanParameters motion{.acceleration = acceleration, .linear_velocity = 0.03};
    RuntimeCommand command("polish", cell.arm_actuator(),
                           force_offset(lin(cell.moved(0, 0.12, 0), motion), pressing(wish.direction_M), wish));
    command.observe("force", pressing(wish.direction_M));
    command.observe("contact", expression::BooleanSensor(command.action().state("in_contact").node()));
    command.observe("no force", expression::BooleanSensor(command.action().state("no_force").node()));
    return command;
  }
  /// Two such lines with a corner, the force from motion `first` on.
  RuntimeCommand round_the_corner(std::size_t first, const Corner& corner = {}) {
    const Eigen::Isometry3d X_BT = cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT;
    ForceOffsetControlParameters wish{.reach = corner.reach, .retreat = corner.retreat};
    wish.direction_M = X_BT.linear().transpose() * -Eigen::Vector3d::UnitZ();
    wish.force = {.force = 8.0, .approach_velocity = 0.01, .gain = 1e-3, .acceleration_max = 0.3};
    const auto line = [this, &corner](const Eigen::Vector3d& way, double blend) {
      PlanParameters motion{.acceleration = 0.8, .linear_velocity = corner.speed};
      const auto leg = [this, way](const device::JointVector& q) {
        const motion::ArmModel model = expression::planning_model(cell.cell.arms.at("arm"));
        Eigen::Isometry3d X_goal = model.chain.forward(q) * model.X_FM;
        X_goal.translation() += way;
        return motion::lin_leg(model, q, X_goal);
      };
      const auto kind = blend > 0.0 ? motion::Blend::Kind::kDistance : motion::Blend::Kind::kNone;
      return SequencePart{.geometry = leg, .parameters = motion, .blend = {kind, blend}};
    };
    RuntimeCommand command("polish", cell.arm_actuator(),
                           force_offset(sequence({line({0, 0.08, 0}, 0.015), line({-0.08, 0, 0}, 0.0)}),
                                        pressing(wish.direction_M), wish, first));
    command.observe("force", pressing(wish.direction_M));
    command.observe("no force", expression::BooleanSensor(command.action().state("no_force").node()));
    return command;
  }
  /// The largest reach for which the joints stay inside of a fifth of their accelerations and jerks, and of the
  /// velocity that is left, from the second motion on; by differences over the path that share nothing with the check.
  double room_for_offset(const ActionModel& action) const {
    const auto path = action.planned_path();
    const motion::ArmModel model = expression::planning_model(cell.cell.arms.at("arm"), path.X_FM);
    const Eigen::Isometry3d X_BT = model.chain.forward(cell.q()) * model.X_FM;
    const Eigen::Vector3d direction = X_BT.linear().transpose() * -Eigen::Vector3d::UnitZ();
    const auto joints = [&](double t) {
      const auto sample = motion::joints_at(model, *path.motion, t);
      kinematics::Vector6 V = kinematics::Vector6::Zero();
      V.head<3>() = (model.chain.forward(sample->q) * model.X_FM).linear() * direction;
      device::JointVector rates = sample->q;
      const device::JointVector held =
          device::JointVector::Zero(static_cast<Eigen::Index>(model.inverse->held_joints().size()));
      EXPECT_EQ(model.inverse->rates(sample->q, V, held, rates), kinematics::IkStatus::kOk);
      return rates;
    };
    constexpr double h = 2e-4, kShare = 0.2, kMargin = 1.1, kVelocity = 0.02, kAcceleration = 0.3;
    double least = 1e9;
    for (double t = path.handed_over.front(); t + h < path.motion->duration(); t += 1e-3) {
      const device::JointVector before = joints(t - h), now = joints(t), after = joints(t + h);
      const device::JointVector ds = (after - before) / (2.0 * h), dds = (after - 2.0 * now + before) / (h * h);
      const auto sample = motion::joints_at(model, *path.motion, t);
      for (Eigen::Index i = 0; i < now.size(); ++i) {
        const double by_velocity = model.limits.velocity[i] - std::abs(sample->dq[i]);
        least = std::min(least, (by_velocity / kMargin - std::abs(now[i]) * kVelocity) / std::abs(ds[i]));
        const double rest = std::abs(now[i]) * kAcceleration + 2.0 * std::abs(ds[i]) * kVelocity;
        least = std::min(least, (kShare * model.limits.acceleration[i] / kMargin - rest) / std::abs(dds[i]));
      }
    }
    return least;
  }
  expression::RealSensor pressing(const Eigen::Vector3d& direction_M) const {
    return pressing_along(cell.cell, "wrist", direction_M, cell.cell.arms.at("arm").X_FT, {{"wrist", cell.bias}});
  }
  LoadedCommand begin(const Command& command) {
    from = tool();
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    handle->start();
    return handle.value();
  }
  Eigen::Vector3d tool() const { return (cell.X_WB.inverse() * cell.tool_in_world(cell.q())).translation(); }
  double along() const { return tool().y() - from.y(); }
  double offset() const { return from.z() - tool().z(); }

  /// One cycle on a surface that lies `below` the beginning and falls by `slope` along the line.
  void step(double below, double slope) {
    const Eigen::Vector3d normal_B = Eigen::Vector3d(0, slope, 1).normalized();
    const Eigen::Vector3d at = from - Eigen::Vector3d(0, 0, below);
    const double depth = std::max(0.0, -normal_B.dot(tool() - at));
    const auto X_WS = cell.X_WB * cell.arm->chain->forward(cell.q()) * cell.cell.sensors.at("wrist").X_FS;
    cell.extra.force = X_WS.linear().transpose() * (cell.X_WB.linear() * normal_B * kStiffness * depth);
    cell.runtime.step();
  }
  static constexpr double kStiffness = 5000.0;  ///< N/m

  test::CommandCell cell;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
};

TEST_F(ForceOffsetTest, TheForceStaysInItsBandOnAnInclinedSurface) {
  for (const double slope : {0.05, -0.05}) {
    LoadedCommand handle = begin(polish({.reach = 0.012, .retreat = 0.008}));
    double least = 1e9, most = 0.0, worst_side = 0.0;
    for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) {
      step(0.002, slope);
      worst_side = std::max(worst_side, std::abs(tool().x() - from.x()));
      if (i < 2000) continue;
      const double force = handle.value<net::Real>("force").value_or(0.0);
      least = std::min(least, force);
      most = std::max(most, force);
    }
    EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
    EXPECT_GT(least, 6.5) << slope;
    EXPECT_LT(most, 9.5) << slope;
    EXPECT_LT(worst_side, 1e-9) << "it stays in the plane of path and direction";
    EXPECT_NEAR(along(), 0.12, 1e-9) << "the path is driven to its end";
    EXPECT_NEAR(offset(), 0.002 + slope * 0.12 + 8.0 / kStiffness, 3e-4) << "the path lies where the surface is";
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
    // Back, for the next slope.
    ASSERT_TRUE(cell.runtime.execute(RuntimeCommand("back", cell.arm_actuator(), ptp(cell.arm->home))).succeeded());
  }
}

TEST_F(ForceOffsetTest, OneForceIsHeldRoundACorner) {
  LoadedCommand handle = begin(round_the_corner(0));
  double least = 1e9, most = 0.0, slowest = 1e9;
  for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) {
    const Eigen::Vector3d before = tool();
    step(0.002, 0.03);
    const bool corner = (before - from - Eigen::Vector3d(0, 0.08, 0)).head<2>().norm() < 0.02;
    if (corner) slowest = std::min(slowest, (tool() - before).head<2>().norm() / 1e-3);
    if (i < 2000) continue;
    least = std::min(least, handle.value<net::Real>("force").value_or(0.0));
    most = std::max(most, handle.value<net::Real>("force").value_or(0.0));
  }
  EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
  EXPECT_GT(slowest, 0.8 * 0.03) << "it does not stop there";
  EXPECT_GT(least, 6.5);
  EXPECT_LT(most, 9.5);
  EXPECT_LT((tool() - from - Eigen::Vector3d(-0.08, 0.08, 0)).head<2>().norm(), 1e-6);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ForceOffsetTest, ItBeginsInTheMiddleOfABlendAndNobodyNeedsTheForceBefore) {
  LoadedCommand handle = begin(round_the_corner(1));
  double before_corner = 0.0, force = 0.0;
  for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) {
    if (i == 200) cell.sensor->silent = true;
    if (along() > 0.05 && cell.sensor->silent) {
      cell.sensor->silent = false;
      cell.sensor->sample.sequence += i - 200;  // its clock has gone on
    }
    step(0.002, 0.0);
    if (tool().x() > from.x() - 1e-9) before_corner = std::max(before_corner, std::abs(offset()));
    if (tool().x() < from.x() - 0.02) force = handle.value<net::Real>("force").value_or(force);
  }
  EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
  EXPECT_LT(before_corner, 1e-9);
  EXPECT_NEAR(force, 8.0, 1.0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ForceOffsetTest, TheRangeIsNeverLeft) {
  // Nothing below: the tool goes as far as it may. Then a surface that pushes back further than it may.
  for (const double below : {1.0, -0.02}) {
    LoadedCommand handle = begin(polish({.reach = 0.004, .retreat = 0.003}));
    double lowest = 0.0, highest = 0.0;
    for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) {
      step(below, 0.0);
      lowest = std::min(lowest, offset());
      highest = std::max(highest, offset());
    }
    EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
    EXPECT_LE(highest, 0.004 + 1e-9);
    EXPECT_GE(lowest, -0.003 - 1e-9);
    EXPECT_GT(highest - lowest, below > 0 ? 0.0039 : 0.0029) << "it is used";
    EXPECT_LE(cell.worst_limit_share(), 1.0);
    ASSERT_TRUE(cell.runtime.execute(RuntimeCommand("back", cell.arm_actuator(), ptp(cell.arm->home))).succeeded());
  }
}

TEST_F(ForceOffsetTest, P2_APausedPathStillHoldsTheForce) {
  LoadedCommand handle = begin(polish({.reach = 0.012}));
  for (int i = 0; i < 2500; ++i) step(0.002, 0.03);
  (void)cell.speed->write(0.0);
  for (int i = 0; i < 500; ++i) step(0.002, 0.03);
  const double there = along();
  double least = 1e9, most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    step(0.002 + 0.001 * std::sin(0.003 * i), 0.03);  // the surface moves meanwhile
    least = std::min(least, *handle.value<net::Real>("force"));
    most = std::max(most, *handle.value<net::Real>("force"));
  }
  EXPECT_NEAR(along(), there, 1e-12) << "it stands on its path";
  EXPECT_GT(least, 4.0);
  EXPECT_LT(most, 12.0);
  (void)cell.speed->write(1.0);
  for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) step(0.002, 0.03);
  EXPECT_TRUE(handle.status().succeeded());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ForceOffsetTest, N3_WithoutTheForceItStandsOnItsPathAndStays) {
  LoadedCommand handle = begin(polish({.reach = 0.012}));
  for (int i = 0; i < 2000; ++i) step(0.002, 0.05);
  EXPECT_EQ(handle.value<bool>("no force"), false);
  cell.sensor->silent = true;
  const Eigen::Vector3d before = tool();
  for (int i = 0; i < 1000; ++i) step(0.002, 0.05);
  EXPECT_EQ(handle.value<bool>("no force"), true);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_FALSE(handle.status().ended());
  EXPECT_LT((tool() - before).norm(), 0.01) << "it has braked, on its path";
  EXPECT_NEAR(tool().x(), from.x(), 1e-9);
  cell.sensor->silent = false;
  cell.sensor->sample.sequence += 1000;  // its clock has gone on
  for (int i = 0; i < 20'000 && !handle.status().ended(); ++i) step(0.002, 0.05);
  EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
  EXPECT_NEAR(along(), 0.12, 1e-9);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ForceOffsetTest, L6_ACancelAtAnyTimeComesToRestInItsBound) {
  for (const int after : {1, 40, 300, 700, 1500, 2600, 3900}) {
    SCOPED_TRACE(after);
    LoadedCommand handle = begin(polish({.reach = 0.012}));
    for (int i = 0; i < after; ++i) step(0.002, 0.05);
    handle.cancel();
    for (int i = 0; i < 1500 && !handle.status().ended(); ++i) step(0.002, 0.05);
    EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
    ASSERT_TRUE(cell.runtime.execute(RuntimeCommand("back", cell.arm_actuator(), ptp(cell.arm->home))).succeeded());
  }
}

// The joints already move, and turn, where the offset begins.
TEST_F(ForceOffsetTest, RoomForAnOffsetThatBeginsInMotionIsWhatTheJointsLeave) {
  constexpr double kSpeed = 0.4, kLeast = 1e-3, kMost = 1.0;
  const auto fits = [&](double reach, double* expected) {
    RuntimeCommand command = round_the_corner(1, {.speed = kSpeed, .reach = reach, .retreat = 0.0});
    EXPECT_TRUE(plan(command).empty());
    if (expected != nullptr) *expected = room_for_offset(command.node()->model());
    return !check(command).has_errors();
  };
  double expected = 0.0, low = kLeast, high = kMost;
  ASSERT_TRUE(fits(low, &expected));
  ASSERT_FALSE(fits(high, nullptr));
  while (high / low > 1.01) (fits(std::sqrt(low * high), nullptr) ? low : high) = std::sqrt(low * high);
  EXPECT_NEAR(low, expected, 0.05 * expected);
}

TEST_F(ForceOffsetTest, WhatTheLimitsHaveNoRoomForIsRefused) {
  EXPECT_THAT(cell.runtime.load(polish({}, 1.0)).error(), Reports(Code::kLimitExceeded, "/polish"));
  ForceOffsetControlParameters wild{};
  wild.jerk_max = 500.0;
  EXPECT_THAT(cell.runtime.load(polish(wild)).error(), Reports(Code::kLimitExceeded, "/polish"));
  ForceOffsetControlParameters fast{};
  fast.force.velocity_max = 50.0;
  EXPECT_THAT(cell.runtime.load(polish(fast)).error(), Reports(Code::kLimitExceeded, "/polish"));
  EXPECT_THAT(cell.runtime.load(polish({.reach = 0.0, .retreat = 0.0})).error(),
              Reports(Code::kOutOfRange, "/polish", {"0"}));
  RuntimeCommand joints("joints", cell.arm_actuator(),
                        force_offset(ptp(cell.joints(0.1)), pressing(Eigen::Vector3d::UnitZ())));
  EXPECT_THAT(cell.runtime.load(joints).error(), Reports(Code::kConflict, "/joints", {"C8"}));
}

}  // namespace
}  // namespace takt::command
