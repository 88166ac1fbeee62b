// Weaves over sequences of motions: where they lie on the path clock, and that nothing that is sent is beyond a limit
// of a joint or of the tool.
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/command/actions/overlay_action.h"
#include "core/motion/leg.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"
#include "tests/support/tool_oracle.h"

namespace takt::command {
namespace {

using device::JointVector;
using motion::Blend;
using takt::test::Reports;
using testing::SizeIs;

class WeaveTest : public testing::Test {
 protected:
  /// A line of the tool by this way in the axes of the base, with 80 % of the accelerations.
  SequencePart line(const Eigen::Vector3d& way, double blend_m, double velocity = 0.05) {
    const auto leg = [this, way](const JointVector& q) {
      const motion::ArmModel model = expression::planning_model(cell.cell.arms.at("arm"));
      Eigen::Isometry3d X_BT = model.chain.forward(q) * model.X_FM;
      X_BT.translation() += way;
      return motion::lin_leg(model, q, X_BT);
    };
    PlanParameters wish{.acceleration = kShareWithOverlay, .linear_velocity = velocity};
    return {.geometry = leg,
            .parameters = wish,
            .blend = {blend_m > 0 ? Blend::Kind::kDistance : Blend::Kind::kNone, blend_m}};
  }
  SequencePart joints(double a1, double blend_fraction) {
    const auto leg = [this, a1](const JointVector& q) {
      JointVector goal = q;
      goal[0] += a1;
      return motion::ptp_leg(expression::planning_model(cell.cell.arms.at("arm")), q, goal);
    };
    PlanParameters wish{.velocity = 0.3};
    const auto kind = blend_fraction > 0 ? Blend::Kind::kFraction : Blend::Kind::kNone;
    return {.geometry = leg, .parameters = wish, .blend = {kind, blend_fraction}};
  }
  /// Up and down, beside lines in a plane.
  WeaveParameters upright(double amplitude = 0.003, double frequency = 2.0) const {
    const Eigen::Matrix3d R = (cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT).linear();
    return {.amplitude = amplitude, .frequency = frequency, .direction_M = R.transpose() * Eigen::Vector3d::UnitZ()};
  }
  RuntimeCommand command(const std::vector<SequencePart>& parts, const Weaves& wishes) {
    return {"seam", cell.arm_actuator(), weave_each(sequence(parts), wishes)};
  }
  /// @return why it was refused; empty: it has come to its end
  Diagnostics run(const Command& seam) {
    cell.backend->sent.clear();
    auto handle = cell.runtime.load(seam);
    if (!handle) return handle.error();
    handle->start();
    EXPECT_TRUE(cell.run(*handle).succeeded()) << handle->status().to_string();
    EXPECT_LE(cell.worst_limit_share(), 1.0);
    return {};
  }
  /// The weaves of a planned sequence; `path` gets how it is planned.
  Result<WeavePlan> plan_of(const std::vector<SequencePart>& parts, const Weaves& wishes,
                            ActionModel::PlannedPath& path) {
    const Actuator arm = cell.arm_actuator();
    auto planned = sequence(parts).model().plan(arm.model(), {{"arm", cell.q()}});
    if (!planned) return std::unexpected(planned.error());
    kept_ = *planned;
    path = kept_->planned_path();
    return plan_weaves(*arm.model().arm(), path, wishes);
  }

  Eigen::Vector3d tool_at(std::size_t i) const {
    return (cell.arm->chain->forward(cell.backend->sent[i].q) * cell.cell.arms.at("arm").X_FT).translation();
  }
  std::size_t count() const { return cell.backend->sent.size(); }

  test::CommandCell cell;

 private:
  std::shared_ptr<const ActionModel> kept_;
};

TEST_F(WeaveTest, NeighboursWithTheSameOneGoOnThroughTheirBlend) {
  const WeaveParameters wish = upright();
  const double plane = cell.moved(0, 0, 0).translation().z();
  const Eigen::Vector3d corner = cell.moved(0, 0.08, 0).translation();
  EXPECT_EQ(run(command({line({0, 0.08, 0}, 0.015), line({0.08, 0, 0}, 0)}, {wish, wish})).to_string(), "");
  double slowest = 1e9, in_corner = 0.0;
  std::vector<std::size_t> crossings;
  for (std::size_t i = 500; i + 500 < count(); ++i) {
    const Eigen::Vector3d before = tool_at(i - 1), now = tool_at(i);
    slowest = std::min(slowest, (now - before).head<2>().norm() / 1e-3);
    if ((before.z() - plane) * (now.z() - plane) < 0.0) crossings.push_back(i);
    if ((now - corner).head<2>().norm() < 0.012) in_corner = std::max(in_corner, std::abs(now.z() - plane));
  }
  EXPECT_GT(slowest, 0.8 * 0.05) << "it never stops at the corner";
  EXPECT_NEAR(in_corner, wish.amplitude, 1e-4) << "and weaves there as everywhere";
  ASSERT_GT(crossings.size(), 5u);
  for (std::size_t k = 1; k < crossings.size(); ++k)
    EXPECT_NEAR(static_cast<double>(crossings[k] - crossings[k - 1]), 250.0, 2.0) << "one sine over the whole";
  EXPECT_LE(test::worst_tool_share(cell), 1.0);
}

TEST_F(WeaveTest, OneEndsAndTheNextBeginsInTheMiddleOfTheirBlend) {
  const std::vector<SequencePart> parts{line({0, 0.06, 0}, 0.01), line({0.06, 0, 0}, 0.01), line({0, -0.06, 0}, 0)};
  const WeaveParameters first = upright(), last = upright(0.002, 3.0);
  ActionModel::PlannedPath path;
  const auto apart = plan_of(parts, {first, std::nullopt, last}, path);
  ASSERT_TRUE(apart) << apart.error().to_string();
  ASSERT_THAT(apart->windows, SizeIs(2));
  EXPECT_EQ(apart->windows[0].begin, 0.0);
  EXPECT_NEAR(apart->windows[0].end, path.handed_over[0], 1e-12);
  EXPECT_NEAR(apart->windows[1].begin, path.handed_over[1], 1e-12);
  EXPECT_NEAR(apart->windows[1].end, path.motion->duration(), 1e-12);
  EXPECT_EQ(apart->windows[1].motion, 2u);
  const auto next = plan_of(parts, {first, last, last}, path);
  ASSERT_TRUE(next) << next.error().to_string();
  ASSERT_THAT(next->windows, SizeIs(2));
  EXPECT_EQ(next->windows[0].end, next->windows[1].begin);

  const double plane = cell.moved(0, 0, 0).translation().z();
  EXPECT_EQ(run(command(parts, {first, std::nullopt, last})).to_string(), "");
  std::array<double, 3> most{};
  double slowest = 1e9;
  for (std::size_t i = 1; i < count(); ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    const bool in_first = t<path.handed_over[0] - 0.01, in_last = t> path.handed_over[1] + 0.01;
    const bool in_middle = t > path.handed_over[0] + 0.01 && t < path.handed_over[1] - 0.01;
    const double off = std::abs(tool_at(i).z() - plane);
    if (in_first) most[0] = std::max(most[0], off);
    if (in_middle) most[1] = std::max(most[1], off);
    if (in_last) most[2] = std::max(most[2], off);
    if (i > 300 && i + 300 < count())
      slowest = std::min(slowest, (tool_at(i) - tool_at(i - 1)).head<2>().norm() / 1e-3);
  }
  EXPECT_NEAR(most[0], 0.003, 2e-4);
  EXPECT_LT(most[1], 1e-9) << "nothing over the one between";
  EXPECT_NEAR(most[2], 0.002, 2e-4);
  EXPECT_GT(slowest, 0.8 * 0.05);
  EXPECT_LE(test::worst_tool_share(cell), 1.0);
}

TEST_F(WeaveTest, BlendsIntoMotionsOfJointsHaveNone) {
  const std::vector<SequencePart> parts{joints(0.2, 0.3), line({0, 0, 0.06}, 0.02), joints(-0.2, 0)};
  const WeaveParameters wish{.amplitude = 0.002, .frequency = 2.0, .direction_M = Eigen::Vector3d::UnitY()};
  ActionModel::PlannedPath path;
  const auto plan = plan_of(parts, {std::nullopt, wish, std::nullopt}, path);
  ASSERT_TRUE(plan) << plan.error().to_string();
  ASSERT_THAT(plan->windows, SizeIs(1));
  EXPECT_GT(plan->windows[0].begin, path.handed_over[0] + 0.01) << "the blend before is one of joints";
  EXPECT_LT(plan->windows[0].end, path.handed_over[1] - 0.01);
  EXPECT_EQ(run(command(parts, {std::nullopt, wish, std::nullopt})).to_string(), "");
  const auto refused = plan_of(parts, {wish, wish, std::nullopt}, path);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), Reports(Code::kConflict, "/0", {"C8"}));
}

TEST_F(WeaveTest, WhatIsWrongIsToldWithTheNumberOfTheMotion) {
  const std::vector<SequencePart> parts{line({0, 0.06, 0}, 0.01), line({0.06, 0, 0}, 0)};
  WeaveParameters steep = upright();
  steep.ramp = 0.02;
  EXPECT_THAT(run(command(parts, {upright(), steep})), Reports(Code::kLimitExceeded, "/seam/1/ramp"));
  EXPECT_THAT(run(command(parts, {upright(), upright(0.1, 5.0)})), Reports(Code::kOutOfRange, "/seam/1"));
  EXPECT_THAT(run(command(parts, {upright(), upright(), upright()})), Reports(Code::kWrongSize, "/seam", {"3", "2"}));
}

// The weave alone and the path alone keep the limit, both together do not.
TEST_F(WeaveTest, ItsSpeedIsJudgedTogetherWithThatOfThePath) {
  auto slow = std::make_shared<device::ArmDescription>(*cell.arm);
  slow->cartesian.linear_velocity = 0.3;
  device::Arm device("slow", slow, cell.backend, cell.core.period());
  expression::MountedArm arm = cell.cell.arms.at("arm");
  arm.device = &device;
  const motion::ArmModel model = expression::planning_model(arm);
  const WeaveParameters wish = upright(0.004, 2.0);
  const double swing = 2.0 * std::numbers::pi * wish.frequency * wish.amplitude;
  const auto weaves_at = [&](double velocity) -> Result<WeavePlan> {
    const auto line =
        motion::plan_lin(model.chain, *model.inverse, model.limits, model.cartesian, cell.q(), cell.moved(0, 0.2, 0),
                         {}, {.acceleration = 0.8, .linear_velocity = velocity, .X_FM = model.X_FM});
    if (!line) return std::unexpected(line.error());
    return plan_weaves(arm, {.motion = &*line, .X_FM = model.X_FM}, {wish});
  };
  const auto fast = weaves_at(0.3);
  ASSERT_FALSE(fast);
  const Diagnostics& refused = fast.error();
  EXPECT_THAT(refused, Reports(Code::kLimitExceeded, "/0", {"0.3"}));
  const double allowed = takt::test::first_number(refused.list().front().hint);
  EXPECT_NEAR(allowed, std::sqrt(0.3 * 0.3 - swing * swing), 2e-3) << "at right angles";
  EXPECT_TRUE(weaves_at(allowed));
  EXPECT_FALSE(weaves_at(1.02 * allowed));
}

/// Any motions with any weaves.
struct Wild {
  std::vector<SequencePart> parts;
  Weaves wishes;
};

class WildWeaves : public WeaveTest, public testing::WithParamInterface<int> {
 protected:
  Wild wild(Random& random) {
    Wild wild;
    const int motions = 1 + static_cast<int>(3 * random.unit());
    for (int i = 0; i < motions; ++i) {
      SequencePart part = geometry(random);
      part.parameters = {.acceleration = random.unit() < 0.3 ? 1.0 : kShareWithOverlay,
                         .linear_velocity = std::exp(random.uniform(std::log(0.03), std::log(1.5)))};
      if (i + 1 < motions) part.blend = {Blend::Kind::kFraction, random.uniform(0.1, 0.5)};
      const bool as_before = i > 0 && random.unit() < 0.4;
      wild.wishes.push_back(as_before ? wild.wishes.back() : weave(random));
      wild.parts.push_back(std::move(part));
    }
    return wild;
  }

 private:
  static Eigen::Vector3d vector(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
  }
  static std::optional<WeaveParameters> weave(Random& random) {
    if (random.unit() < 0.2) return std::nullopt;
    const double frequency = std::exp(random.uniform(std::log(0.5), std::log(6.0)));
    const double omega = 2.0 * std::numbers::pi * frequency;
    // Up to what a tool may have at all, and a little beyond.
    const double amplitude =
        std::min(0.03, random.uniform(0.1, 1.1) * std::min(1.0 / pow(omega, 2), 15.0 / pow(omega, 3)));
    return WeaveParameters{.amplitude = amplitude,
                           .frequency = frequency,
                           .direction_M = vector(random, 1.0).normalized(),
                           .ramp = random.uniform(0.3, 1.5)};
  }
  SequencePart geometry(Random& random) {
    const int kind = static_cast<int>(3 * random.unit());
    const Eigen::Vector3d way = vector(random, 0.12), bulge = vector(random, 0.06);
    return {.geometry = [this, kind, way, bulge](const JointVector& q) -> Result<motion::Leg> {
      const motion::ArmModel model = expression::planning_model(cell.cell.arms.at("arm"));
      const Eigen::Isometry3d X_BT = model.chain.forward(q) * model.X_FM;
      Eigen::Isometry3d X_goal = X_BT, X_via = X_BT;
      X_goal.translation() += way;
      X_via.translation() += 0.5 * way + bulge;
      if (kind == 0) return motion::lin_leg(model, q, X_goal);
      if (kind == 1)
        return motion::circ_leg(model, q, motion::ArcThrough{.p_via = X_via.translation(), .X_BM_goal = X_goal});
      return motion::spline_leg(model, q, std::vector<Eigen::Isometry3d>{X_via, X_goal});
    }};
  }
};

// Rows P1, P2: at any override, pause and cancel.
TEST_P(WildWeaves, P1_P2_NothingThatIsSentIsBeyondALimit) {
  constexpr int kSeeds = 8;
  int driven = 0;
  double most = 0.0;
  const JointVector home = cell.arm->home;
  for (int seed = kSeeds * GetParam(); seed < kSeeds * (GetParam() + 1); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed), "weaves");
    const Wild some = wild(random);
    cell.backend->sent.clear();
    auto handle = cell.runtime.load(command(some.parts, some.wishes));
    if (!handle) continue;  // too much
    ++driven;
    handle->start();
    const int cancel_at = random.unit() < 0.3 ? static_cast<int>(random.uniform(10, 3000)) : -1;
    for (int i = 0; i < 60'000 && !handle->status().ended(); ++i) {
      if (random.unit() < 0.004) (void)cell.speed->write(random.unit() < 0.3 ? 0.0 : random.uniform(0.1, 1.0));
      if (random.unit() < 0.004) (void)cell.speed->write(1.0);
      if (i == cancel_at) handle->cancel();
      cell.runtime.step();
    }
    (void)cell.speed->write(1.0);
    ASSERT_TRUE(handle->status().succeeded()) << handle->status().to_string();
    const double of_tool = test::worst_tool_share(cell), of_joints = cell.worst_limit_share();
    ASSERT_LE(of_tool, 1.0);
    ASSERT_LE(of_joints, 1.0);
    most = std::max({most, of_tool, of_joints});
    ASSERT_TRUE(cell.runtime.execute(RuntimeCommand("home", cell.arm_actuator(), ptp(home))).succeeded());
  }
  RecordProperty("driven", driven);
  EXPECT_GE(driven, 2);
  EXPECT_GT(most, 0.7) << "the limits were near";
}
INSTANTIATE_TEST_SUITE_P(Seeds, WildWeaves, testing::Range(0, 12));

}  // namespace
}  // namespace takt::command
