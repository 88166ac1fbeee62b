// Two arms that move one thing, in the simulation: what is measured of them, through cancels and stops (rows P5, S1).
#include "app/interfaces/two_arms.h"

#include <algorithm>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "cell/faults/faults.h"
#include "core/device/device_file.h"
#include "tests/support/limit_oracle.h"

namespace takt::cell::pair_test {
namespace {

using activity::Activity;
using activity::RunPtr;

constexpr double kWay = 0.2e-3;  ///< m: so far apart two arms may have the thing that they move
constexpr double kAngle = 0.05;  ///< degrees, likewise

/// Two arms of one kind that look at each other, 1.6 m apart.
class PairTest : public testing::TestWithParam<const char*> {
 protected:
  PairTest() {
    const std::string arm = R"({"model": ")" + std::string(GetParam()) + R"(", "at": {"in": "world", )";
    const auto description =
        parse_description(R"({"devices": {"left": )" + arm + R"("position_m": [0, 0, 0.4]}}, "right": )" + arm +
                          R"("position_m": [1.6, 0, 0.4], "rpy_deg": [0, 0, 180]}}},
                          "program": {"do": "wait", "seconds": 1},
                          "faults": [{"at_s": 3600, "do": "emergency_stop"}]})");
    EXPECT_TRUE(description) << description.error().to_string();
    Diagnostics warnings;
    auto cell = build_cell(*description, device::ModelLibrary({"models"}), false, warnings);
    EXPECT_TRUE(cell) << cell.error().to_string();
    built = std::make_unique<BuiltCell>(std::move(*cell));
    EXPECT_TRUE(make_faults(description->faults, *built)) << "they bring the latch";
    program = std::make_unique<activity::Runtime>(*built->core, built->cell, [this] { cycle(); });
    for (int i = 0; i < 5; ++i) cycle();
    built->emergency_stop->set_reset(true);
    cycle();
    built->emergency_stop->set_reset(false);
    const app::Actuator left(*program, "left"), right(*program, "right");
    for (const auto* one : {&left, &right}) one->use<app::PtpInterface>().ptp(ready(one->name())).execute();
    for (int i = 0; i < 500; ++i) cycle();
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.translation() << 0.8, 0.0, flange("left").translation().z();
    pair = std::make_unique<app::TwoArms>(left, right, X_WC);
  }

  void cycle() {
    built->core->step();
    ASSERT_TRUE(built->world->step());
    for (const auto& [name, arm] : built->cell.arms) {
      const auto& q = arm.device->set_point().q;
      sent[name].emplace_back(q.begin(), q.end());
    }
  }

  /// Bent, so that there is room on all sides.
  [[nodiscard]] device::JointVector ready(const std::string& name) const {
    return built->cell.arms.find(name)->second.device->description().home;
  }

  /// In the world, as the plant has it.
  [[nodiscard]] Eigen::Isometry3d flange(const std::string& name) const {
    const device::ArmDescription& arm = built->core->find_arm(name)->description();
    const std::vector<std::string> names = built->world->position_names();
    device::JointVector q(static_cast<Eigen::Index>(arm.joint_names.size()));
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const auto found = std::ranges::find(names, name + "/" + arm.joint_names[static_cast<std::size_t>(i)]);
      q[i] = built->world->positions()[static_cast<std::size_t>(found - names.begin())];
    }
    return *built->cell.frames.pose(name) * arm.chain->forward(q);
  }

  /// How far apart the two arms have the centre, m and degrees.
  struct Apart {
    double way = 0.0, angle = 0.0;
  };
  [[nodiscard]] Apart apart() const {
    const auto& grasp = pair->grasp();
    const Eigen::Isometry3d by_left = flange("left") * grasp.X_HL, by_right = flange("right") * grasp.X_HF;
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(by_left.linear().transpose() * by_right.linear()));
    return {(by_left.translation() - by_right.translation()).norm(), turn.angle() * 180.0 / std::numbers::pi};
  }

  /// Steps until both have stood for a while; the worst on the way.
  Apart follow(const RunPtr& run, const std::function<void(int)>& at_cycle) {
    Apart worst;
    for (int i = 0, standing = 0; standing < 200 && i < 20'000; ++i) {
      if (at_cycle) at_cycle(i);
      program->step();
      standing = run->over() ? standing + 1 : 0;
      const Apart now = apart();
      worst = {std::max(worst.way, now.way), std::max(worst.angle, now.angle)};
    }
    return worst;
  }

  void expect_together(const Apart& worst, const char* name) {
    EXPECT_LT(worst.way, kWay);
    EXPECT_LT(worst.angle, kAngle);
    RecordProperty(std::string(name) + "_um", static_cast<int>(1e6 * worst.way));
    RecordProperty(std::string(name) + "_mdeg", static_cast<int>(1e3 * worst.angle));
    for (const auto& [arm, list] : sent) {
      const motion::JointLimits& l = built->core->find_arm(arm)->description().limits;
      const auto vector = [](const device::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
      takt::test::LimitOracle oracle(
          {vector(l.lower), vector(l.upper), vector(l.velocity), vector(l.acceleration), vector(l.jerk)}, 1e-3, 1e-11);
      for (const auto& q : list)
        if (!q.empty()) oracle.add(q);
      EXPECT_LE(std::max({oracle.velocity.share, oracle.acceleration.share, oracle.jerk.share}), 1.0) << arm;
    }
  }

  RunPtr begin() { return pair->lin_by({0.05, 0.12, 0.1}, {.linear_velocity = 0.25}).schedule(); }

  std::unique_ptr<BuiltCell> built;
  std::map<std::string, std::vector<std::vector<double>>> sent;
  std::unique_ptr<activity::Runtime> program;
  std::unique_ptr<app::TwoArms> pair;
};

TEST_P(PairTest, P5_AMotionKeepsThemTogether) {
  const RunPtr run = begin();
  expect_together(follow(run, {}), "motion");
  EXPECT_EQ(run->state(), activity::RunState::kCompleted) << run->diagnostics().to_string();
}

TEST_P(PairTest, P5_ACancelKeepsThemTogether) {
  const RunPtr run = begin();
  expect_together(follow(run,
                         [&](int i) {
                           if (i == 350) run->cancel();
                         }),
                  "cancel");
  EXPECT_EQ(run->state(), activity::RunState::kCancelled) << run->diagnostics().to_string();
}

TEST_P(PairTest, S1_StopsOfCategory1And2KeepThemTogether) {
  for (const auto category : {device::StopCategory::kStopAndHold, device::StopCategory::kStopThenBrakes}) {
    SCOPED_TRACE(static_cast<int>(category));
    const RunPtr run = begin();
    const auto worst = follow(run, [&](int i) {
      built->emergency_stop->set_category(category);
      if (i == 350) built->emergency_stop->set_healthy(false);
    });
    const bool brakes = category == device::StopCategory::kStopThenBrakes;
    expect_together(worst, brakes ? "category1" : "category2");
    EXPECT_EQ(run->state(), activity::RunState::kFailed);
    for (const char* name : {"left", "right"}) EXPECT_EQ(built->world->arm(name)->braked(), brakes) << name;
    built->emergency_stop->set_healthy(true);
    cycle();
    built->emergency_stop->set_reset(true);
    cycle();
    built->emergency_stop->set_reset(false);
    cycle();
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, PairTest, testing::Values("lwr4plus", "ur5", "tx90"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace takt::cell::pair_test
