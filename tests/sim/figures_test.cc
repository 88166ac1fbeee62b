// What the machines must reach, for every arm of the models folder (docs/benchmarks.md has the figures).
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "core/device/device_file.h"
#include "core/kinematics/inverse.h"
#include "core/motion/motion_state.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

/// An arm with all that its device file says, alone in a world.
class FiguresTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    auto read = device::read_arm(std::string("models/") + GetParam());
    ASSERT_TRUE(read) << read.error().to_string();
    model = *read;
    cell.robots.push_back(arm_body("arm", *model, {}));
    cell.arms.push_back(simulated_arm("arm", "arm", *model));
  }

  [[nodiscard]] Eigen::Vector3d flange(const World& world) const {
    return world.body_pose(world.body("arm/" + model->flange_link)).translation();
  }
  [[nodiscard]] JointVector zero() const { return JointVector::Zero(model->home.size()); }

  /// A straight line of the flange across the reach of the arm, 0.3 m with 250 mm/s, from rest to rest.
  struct Line {
    static constexpr double kSpeed = 0.25, kRamp = 0.3, kLength = 0.3;  // m/s, s, m
    static constexpr double kDuration = kLength / kSpeed + kRamp;

    /// Way and speed after t s: the speed rises and falls with bounded jerk.
    static double speed(double t) {
      const double up = std::clamp(t / kRamp, 0.0, 1.0), down = std::clamp((kDuration - t) / kRamp, 0.0, 1.0);
      const double s = std::min(up, down);
      return kSpeed * s * s * (3.0 - 2.0 * s);
    }
  };

  /// Largest distance of the flange from where it is to be on the line, m, at the best lag in whole cycles.
  double worst_on_line(const WorldDescription& description) {
    World world = make(description);
    const auto& chain = *model->chain;
    JointVector q = model->home, dq = zero();
    std::vector<Eigen::Vector3d> wanted, measured;
    const double h = 1e-3;
    for (int k = 0; k < static_cast<int>(Line::kDuration / h) + 300; ++k) {
      Pose X;
      kinematics::Jacobian J;
      chain.jacobian(q, X, J);
      kinematics::Vector6 twist = kinematics::Vector6::Zero();
      twist[1] = Line::speed(k * h);
      const JointVector next = J.completeOrthogonalDecomposition().solve(twist);
      wanted.push_back(X.translation());
      measured.push_back(flange(world));
      world.arm("arm")->write(set_point(q, next, (next - dq) / h));
      EXPECT_TRUE(world.step());
      q += h * next;
      dq = next;
    }
    EXPECT_NEAR((wanted.back() - wanted.front()).norm(), Line::kLength, 0.01);
    double best = 1.0;
    for (std::size_t lag = 0; lag < 20; ++lag) {
      double worst = 0.0;
      for (std::size_t k = lag; k < wanted.size(); ++k) worst = std::max(worst, (measured[k] - wanted[k - lag]).norm());
      best = std::min(best, worst);
    }
    return best;
  }

  /// A cube of that mass, 80 mm before the face of the flange.
  void hang(double mass) {
    ObjectDescription load = box("load", {0.1, 0.1, 0.1}, {0.0, 0.0, 0.08});
    load.mount.parent = "arm/" + model->flange_link;
    load.mass = mass;
    cell.objects.push_back(load);
  }
  [[nodiscard]] motion::ArmModel planning_model() const {
    return {.chain = *model->chain,
            .inverse = model->inverse.get(),
            .limits = model->limits,
            .cartesian = model->cartesian,
            .X_FM = Pose::Identity(),
            .load = std::nullopt};
  }

  /// Largest share of a motor's torque limit that a motion asks for, in the plant, not in the plan.
  double share_of_torque(const motion::ArmModel& arm, const motion::Motion& motion) {
    cell.robots[0].q.assign(motion.q_start.data(), motion.q_start.data() + motion.q_start.size());
    World world = make(cell);
    double share = 0.0;
    for (double t = 0.0; t < motion.duration() + 0.1; t += 1e-3) {
      const auto at = motion::joints_at(arm, motion, std::min(t, motion.duration()));
      if (!at) {
        ADD_FAILURE() << "the plan cannot be followed";
        return 0.0;
      }
      world.arm("arm")->write(set_point(at->q, at->dq, at->ddq));
      EXPECT_TRUE(world.step());
      const auto used = world.arm("arm")->wanted_torque().cwiseAbs().cwiseQuotient(model->effort);
      share = std::max(share, used.maxCoeff());
    }
    return share;
  }

  std::shared_ptr<const device::ArmDescription> model;
  WorldDescription cell;
};

/// Anywhere in its range, for joints that turn more than once within one turn.
JointVector random_q(Random& random, const motion::JointLimits& limits) {
  JointVector q(limits.lower.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q[i] = random.uniform(std::max(limits.lower[i], -std::numbers::pi), std::min(limits.upper[i], std::numbers::pi));
  }
  return q;
}

TEST_P(FiguresTest, WithItsRatedLoadAndAllItsSpeedNoMotorLacksTorque) {
  hang(model->payload_rated);
  motion::ArmModel aware = planning_model();
  const motion::ArmModel unaware = aware;
  const kinematics::Payload told = make(cell).arm("arm")->payload();
  ASSERT_NEAR(told.mass, model->payload_rated, 1e-9);
  aware.load = motion::DriveLoad{.armature = model->armature, .payload = told};

  Random random(7);
  double worst = 0.0, worst_unaware = 0.0;
  int lin = 0;
  for (int i = 0; i < 12; ++i) {
    const JointVector q0 = random_q(random, model->limits), q1 = random_q(random, model->limits);
    const auto motion = motion::plan_ptp(aware.chain, aware.limits, q0, q1, {.load = aware.load});
    ASSERT_TRUE(motion) << motion.error().to_string();
    const double share = share_of_torque(aware, *motion);
    EXPECT_LE(share, 1.0) << "PTP " << i;
    worst = std::max(worst, share);
    if (i % 5 == 0) {
      worst_unaware =
          std::max(worst_unaware, share_of_torque(unaware, *motion::plan_ptp(aware.chain, aware.limits, q0, q1)));
    }
    Pose goal = aware.chain.forward(q0);
    goal.translation() +=
        0.4 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
    const auto line = motion::plan_lin(aware.chain, *aware.inverse, aware.limits, aware.cartesian, q0, goal, {},
                                       {.load = aware.load});
    if (!line) continue;  // out of reach, or on another branch
    const double on_line = share_of_torque(aware, *line);
    EXPECT_LE(on_line, 1.0) << "LIN " << i;
    worst = std::max(worst, on_line);
    ++lin;
  }
  RecordProperty("worst_percent", std::to_string(100.0 * worst));
  RecordProperty("planned_without_the_load_percent", std::to_string(100.0 * worst_unaware));
  EXPECT_GE(lin, 2);
  EXPECT_GT(worst, 0.5) << "the motions are no trial";
}

TEST_P(FiguresTest, AStepOfTenMillimetresSettlesInAFifthOfASecond) {
  for (int axis = 0; axis < 3; ++axis) {
    World world = make(cell);
    Pose X;
    kinematics::Jacobian J;
    model->chain->jacobian(model->home, X, J);
    const kinematics::Vector6 way = 0.010 * kinematics::Vector6::Unit(axis);
    const JointVector goal = model->home + JointVector(J.completeOrthogonalDecomposition().solve(way));
    const Eigen::Vector3d wanted = model->chain->forward(goal).translation();
    double overshoot = 0.0, late = 0.0;
    for (int k = 0; k < 600; ++k) {
      hold(world, goal, 1);
      const Eigen::Vector3d beyond = flange(world) - wanted;
      overshoot = std::max(overshoot, beyond[axis]);
      if (k >= 200) late = std::max(late, beyond.norm());
    }
    RecordProperty("overshoot_um_axis_" + std::to_string(axis), std::to_string(1e6 * overshoot));
    RecordProperty("after_200_ms_um_axis_" + std::to_string(axis), std::to_string(1e6 * late));
    EXPECT_LT(overshoot, 0.05 * 0.010) << "axis " << axis;
    EXPECT_LT(late, 0.1e-3) << "axis " << axis;
  }
}

TEST_P(FiguresTest, ALineWith250MillimetresPerSecondIsTracked) {
  const double worst = worst_on_line(cell);
  RecordProperty("worst_mm", std::to_string(1e3 * worst));
  EXPECT_LT(worst, 0.5e-3);
}

TEST_P(FiguresTest, D6_APlantOfTenPercentMoreMassTracksDifferently) {
  const double nominal = worst_on_line(cell);
  cell.physics.plant_mass_scale = 1.1;
  const double heavy = worst_on_line(cell);
  RecordProperty("heavier_mm", std::to_string(1e3 * heavy));
  EXPECT_GT(heavy, 1.2 * nominal);
}

TEST_P(FiguresTest, OneKilogramOfWrongPayloadShiftsTheArmAsPredicted) {
  cell.arms[0].payload_mass_error = 1.0;
  // Statics without friction, which holds a part of the load.
  for (auto& joint : cell.robots[0].joints) joint.coulomb = 0.0;
  World world = make(cell);
  hold(world, model->home, 3000);
  const JointVector q = sample(world).q, shift = q - model->home;
  const auto& chain = *model->chain;
  const kinematics::Payload believed = world.arm("arm")->payload();
  kinematics::Payload real = believed;
  real.mass -= 1.0;
  const Eigen::Vector3d gravity(0, 0, -9.81);
  const JointVector surplus = chain.inverse_dynamics(q, zero(), zero(), gravity, believed) -
                              chain.inverse_dynamics(q, zero(), zero(), gravity, real);
  kinematics::JointMatrix M = chain.mass_matrix(q, believed);
  M.diagonal() += model->armature;
  const JointVector w2 = model->natural_frequency.cwiseProduct(model->natural_frequency);
  const JointVector predicted = JointVector(M.ldlt().solve(surplus)).cwiseQuotient(w2);
  EXPECT_LT((shift - predicted).norm(), 0.03 * predicted.norm() + 2.0 * model->position_resolution);
  EXPECT_GT(chain.forward(q).translation().z(), chain.forward(model->home).translation().z())
      << "who believes in a load that is not there lifts the arm";
}

TEST_P(FiguresTest, WithoutDampingTheEnergyStays) {
  WorldDescription free;
  free.robots.push_back(arm_body("arm", *model, {}));
  for (auto& joint : free.robots[0].joints) {
    joint.coulomb = joint.viscous = 0.0;
    joint.armature = std::min(joint.armature, 0.1);
  }
  free.robots[0].stop_margin = 100.0;  // stops take energy
  free.physics.integrator = Integrator::kRungeKutta4;
  free.physics.gravity *= 0.1;  // a slow swing of some rad
  World world = make(free);
  const double begin = world.energy();
  double fastest = 0.0;
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_TRUE(world.step());
    fastest = std::max(fastest, std::abs(world.physics_data()->qvel[1]));
  }
  RecordProperty("drift_J", std::to_string(std::abs(world.energy() - begin)));
  EXPECT_GT(fastest, 0.05) << "rad/s: the test needs motion";
  EXPECT_LT(std::abs(world.energy() - begin), 1e-3);
}

std::string name_of_arm(const testing::TestParamInfo<const char*>& arm) { return arm.param; }

INSTANTIATE_TEST_SUITE_P(Arms, FiguresTest, testing::Values("lwr4plus", "ur5", "tx90"), name_of_arm);

}  // namespace
}  // namespace takt::sim::test
