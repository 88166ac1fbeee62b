// Arms that give way: their springs in figures, changes of mode, what they feel, and their own stops.
#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

using device::Compliance;
using device::ControlMode;
using device::StopCategory;

/// An arm of the models folder with all that its device file says, alone in a world, and a hand that pushes it.
class Bench {
 public:
  explicit Bench(const std::string& name, const std::function<void(WorldDescription&)>& change = {}) {
    description_ = *device::read_arm("models/" + name);
    WorldDescription cell;
    cell.robots.push_back(arm_body("arm", *description_, {}));
    cell.arms.push_back(simulated_arm("arm", "arm", *description_));
    if (change) change(cell);
    world_ = std::make_unique<World>(make(cell));
    q = description_->home;
    dq = ddq = JointVector::Zero(q.size());
    set(ControlMode::kPosition);
  }

  [[nodiscard]] const device::ArmDescription& model() const { return *description_; }
  [[nodiscard]] SimArm& arm() { return *world_->arm("arm"); }
  [[nodiscard]] device::ArmSample sample() { return test::sample(*world_); }
  [[nodiscard]] Pose flange() const { return world_->body_pose(world_->body("arm/" + description_->flange_link)); }
  [[nodiscard]] World& world() { return *world_; }

  /// What the surroundings exert at the flange from now on, in the world's axes, N.
  void push(const Eigen::Vector3d& force) { force_ = force; }
  void set(ControlMode mode) { compliance = description_->impedance.standard(mode); }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) {
      if (compliance.mode != ControlMode::kPosition) arm().write_compliance(compliance);
      arm().write(set_point(q, dq, ddq));
      apply_push();
      ASSERT_TRUE(world_->step());
      // A sensor would see these steps as blows.
      const JointVector torque = arm().motor_torque();
      if (torque_.size() > 0) torque_step = std::max(torque_step, (torque - torque_).cwiseAbs().maxCoeff());
      torque_ = torque;
    }
  }
  /// Goes into a mode from standstill.
  void enter(ControlMode mode) {
    arm().change_mode(mode);
    cycles(600);
    ASSERT_EQ(sample().mode, mode);
    set(mode);
    cycles(300);
  }

  JointVector q, dq, ddq;
  Compliance compliance;
  double torque_step = 0.0;  ///< largest of a motor from cycle to cycle, Nm

 private:
  void apply_push() {
    const auto* data = world_->physics_data();
    const int body = world_->body("arm/" + description_->flange_link);
    const Eigen::Vector3d p = flange().translation();
    const Eigen::Vector3d com = Eigen::Map<const Eigen::Vector3d>(data->xipos + 3 * body);
    world_->push(body, force_, (p - com).cross(force_));
  }

  std::shared_ptr<const device::ArmDescription> description_;
  std::unique_ptr<World> world_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
  JointVector torque_;
};

TEST(ArmImpedance, TwentyNewtonsAtTwoThousandPerMetreAreTenMillimetres) {
  for (int axis = 0; axis < 3; ++axis) {
    Bench bench("lwr4plus");
    bench.cycles(100);
    bench.enter(ControlMode::kCartesianImpedance);
    EXPECT_EQ(bench.compliance.stiffness[axis], 2000.0);
    const Pose before = bench.flange();
    bench.push(20.0 * Eigen::Vector3d::Unit(axis));
    bench.cycles(4000);
    const Eigen::Vector3d way = bench.flange().translation() - before.translation();
    RecordProperty("displacement_mm_" + std::to_string(axis), std::to_string(1e3 * way[axis]));
    EXPECT_NEAR(way[axis], 0.010, 0.0005) << "axis " << axis;
    EXPECT_LT((way - way[axis] * Eigen::Vector3d::Unit(axis)).norm(), 0.0005) << "and nowhere else";
    EXPECT_LT(Eigen::AngleAxisd(bench.flange().linear() * before.linear().transpose()).angle(), 0.005);
    bench.push(Eigen::Vector3d::Zero());
    bench.cycles(4000);
    EXPECT_LT((bench.flange().translation() - before.translation()).norm(), 0.0003) << "it comes back";
  }
}

TEST(ArmImpedance, ItActsAtTheToolInTheAxesThatWereChosen) {
  Bench bench("lwr4plus");
  device::ToolSetting tool;
  tool.X_FT.translation().z() = 0.1;
  bench.arm().set_tool(tool);
  bench.cycles(100);
  bench.enter(ControlMode::kCartesianImpedance);
  bench.compliance.in_tool_axes = true;
  // Soft along the tool's z only. The flange looks down, so that is the world's -z.
  for (int i = 0; i < 500; ++i) {
    bench.compliance.stiffness[2] = 2000.0 - 3.0 * i;
    bench.cycles(1);
  }
  const Pose before = bench.flange();
  bench.push(Eigen::Vector3d(0, 0, 10.0));
  bench.cycles(4000);
  const Eigen::Vector3d way = bench.flange().translation() - before.translation();
  EXPECT_NEAR(way.z(), 10.0 / bench.compliance.stiffness[2], 0.05 * 10.0 / bench.compliance.stiffness[2]);
}

TEST(ArmImpedance, AWrenchThatTheToolExertsMovesItTheOtherWay) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.enter(ControlMode::kCartesianImpedance);
  const Pose before = bench.flange();
  for (int i = 1; i <= 200; ++i) {
    bench.compliance.feed_forward[0] = 0.1 * i;
    bench.cycles(1);
  }
  bench.cycles(4000);
  const Eigen::Vector3d way = bench.flange().translation() - before.translation();
  EXPECT_NEAR(way.x(), 0.010, 0.0005) << "20 N from inside as 20 N from outside";
}

TEST(ArmImpedance, JointSpringsGiveWayAsTheJacobianSays) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.enter(ControlMode::kJointImpedance);
  const Pose before = bench.flange();
  const Eigen::Vector3d force(0, 20.0, 0);
  bench.push(force);
  bench.cycles(4000);
  kinematics::Jacobian J;
  Pose X;
  bench.model().chain->jacobian(bench.sample().q, X, J);
  kinematics::Vector6 wrench = kinematics::Vector6::Zero();
  wrench.head<3>() = force;
  const JointVector bent = (J.transpose() * wrench).cwiseQuotient(bench.compliance.stiffness);
  EXPECT_LT((bench.sample().q - bench.q - bent).norm(), 0.05 * bent.norm());
  const double predicted = (J * bent)[1];
  EXPECT_NEAR((bench.flange().translation() - before.translation()).y(), predicted, 0.05 * predicted);
  EXPECT_GT(predicted, 0.003);
}

TEST(ArmImpedance, TheElbowComesBackByItsOwnSpring) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.enter(ControlMode::kCartesianImpedance);
  const Pose before = bench.flange();
  // Another posture for the same pose: what the tool does not feel.
  JointVector turned = bench.q;
  kinematics::Jacobian J;
  Pose X;
  bench.model().chain->jacobian(turned, X, J);
  const Eigen::MatrixXd null = Eigen::MatrixXd(J).fullPivLu().kernel();
  const JointVector way = 0.05 * null.col(0).normalized();
  for (int i = 1; i <= 1000; ++i) {
    bench.q = turned + 1e-3 * i * way;
    bench.cycles(1);
  }
  bench.cycles(6000);
  EXPECT_LT((bench.sample().q - bench.q).norm(), 0.2 * way.norm()) << "the posture follows";
  EXPECT_LT((bench.flange().translation() - before.translation()).norm(), 0.002) << "the tool does not feel it";
}

TEST(ArmImpedance, L4_NoTorqueJumpsWhenTheModeChanges) {
  Bench bench("lwr4plus");
  bench.cycles(200);
  bench.push(Eigen::Vector3d(15, -10, 5));
  bench.cycles(2000);
  bench.torque_step = 0.0;
  bench.cycles(200);
  const double quiet = bench.torque_step;
  for (const ControlMode mode :
       {ControlMode::kJointImpedance, ControlMode::kCartesianImpedance, ControlMode::kPosition,
        ControlMode::kCartesianImpedance, ControlMode::kJointImpedance, ControlMode::kPosition}) {
    bench.arm().change_mode(mode);
    for (int i = 0; i < 2500; ++i) {
      if (bench.sample().mode == mode && bench.compliance.mode != mode) {
        bench.set(mode);
        if (mode == ControlMode::kPosition) bench.q = bench.sample().q;  // as the core does
      }
      bench.cycles(1);
    }
    ASSERT_EQ(bench.sample().mode, mode);
  }
  EXPECT_LT(bench.torque_step, quiet + 1.0) << "Nm from cycle to cycle";
  EXPECT_EQ(bench.sample().fault, 0u);
}

TEST(ArmImpedance, PositionBeginsWhereTheArmWasPushedTo) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.enter(ControlMode::kCartesianImpedance);
  bench.push(Eigen::Vector3d(20, 0, 0));
  bench.cycles(3000);
  const Pose pushed = bench.flange();
  bench.arm().change_mode(ControlMode::kPosition);
  for (int i = 0; i < 1500; ++i) {
    if (bench.sample().mode == ControlMode::kPosition && bench.compliance.mode != ControlMode::kPosition) {
      bench.set(ControlMode::kPosition);
      bench.q = bench.sample().q;
    }
    bench.cycles(1);
    EXPECT_LT((bench.flange().translation() - pushed.translation()).norm(), 0.001);
  }
  EXPECT_EQ(bench.sample().mode, ControlMode::kPosition);
}

TEST(ArmImpedance, L4_TheDeviceKeepsTheClassesByItself) {
  Bench stiff("ur5");
  stiff.arm().change_mode(ControlMode::kCartesianImpedance);
  stiff.cycles(1000);
  EXPECT_EQ(stiff.sample().mode, ControlMode::kPosition) << "it has no such mode";

  Bench bench("lwr4plus");
  bench.cycles(10);
  for (int i = 0; i < 300; ++i) {  // in motion
    bench.dq = JointVector::Constant(7, 0.05);
    bench.q += 1e-3 * bench.dq;
    if (i == 150) bench.arm().change_mode(ControlMode::kJointImpedance);
    bench.cycles(1);
  }
  bench.dq.setZero();
  bench.cycles(1000);
  EXPECT_EQ(bench.sample().mode, ControlMode::kPosition) << "asked for in motion";
  bench.arm().change_mode(ControlMode::kJointImpedance);
  bench.cycles(499);
  EXPECT_TRUE(bench.sample().changing_mode) << "500 ms are declared";
  bench.cycles(2);
  EXPECT_EQ(bench.sample().mode, ControlMode::kJointImpedance);
  bench.set(ControlMode::kJointImpedance);
  bench.compliance.stiffness[0] = 1e5;
  bench.cycles(1);
  EXPECT_TRUE(bench.sample().braked) << "beyond what it allows";
  EXPECT_NE(bench.arm().fault_text(bench.sample().fault).find("stiffness"), std::string::npos);
}

/// Wrench at the flange in the base's axes that explains the external torques best.
Eigen::Vector3d felt(Bench& bench) {
  kinematics::Jacobian J;
  Pose X;
  const auto sample = bench.sample();
  bench.model().chain->jacobian(sample.q, X, J);
  const kinematics::Vector6 w = (J * J.transpose()).ldlt().solve(J * sample.tau_external);
  return w.head<3>();
}

TEST(ExternalTorque, JointSensorsFeelTwentyNewtonsBetterThanMotorCurrents) {
  const auto error = [](const std::string& name) {
    Bench bench(name);
    bench.cycles(1000);
    const Eigen::Vector3d before = felt(bench);  // the bias of the sensors
    const Eigen::Vector3d force(12, -10, 12);
    bench.push(force);
    bench.cycles(1000);
    return (felt(bench) - before - force).norm();
  };
  EXPECT_LT(error("lwr4plus"), 1.0);
  EXPECT_LT(error("ur5"), 8.0);
  EXPECT_GT(error("tx90"), error("lwr4plus"));
}

TEST(ExternalTorque, AMovingArmFeelsNothingThatIsNotThere) {
  Bench bench("lwr4plus");
  bench.cycles(1000);
  const JointVector bias = bench.sample().tau_external;
  const JointVector from = bench.q;
  double worst = 0.0;
  for (int k = 0; k < 1500; ++k) {
    const double s = std::min(1.0, k / 1000.0), h = 1e-3;
    const double p = s * s * s * (10 - 15 * s + 6 * s * s);
    const JointVector last = bench.q, last_dq = bench.dq;
    bench.q = from + JointVector::Constant(7, 0.4 * p);
    bench.dq = (bench.q - last) / h;
    bench.ddq = (bench.dq - last_dq) / h;
    bench.cycles(1);
    worst = std::max(worst, (bench.sample().tau_external - bias).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 3.0) << "Nm; the motion itself takes some tens";
}

TEST(ExternalTorque, BrakesLeaveNoEstimate) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  EXPECT_EQ(bench.sample().tau_external.size(), 7);
  bench.arm().brake();
  bench.cycles(10);
  EXPECT_EQ(bench.sample().tau_external.size(), 0);
}

/// Moves fast, lets the arm stop by itself and tells how that went.
struct Stop {
  double angle = 0.0;  ///< rad, of the first joint until it stands
  double peak = 0.0;   ///< rad/s^2, largest deceleration
  bool braked = false, ready = true;
  std::uint32_t fault = 0;
  double moved_after = 0.0;  ///< rad, in the second after it stood
};
Stop stop_at_speed(StopCategory category) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  for (int k = 0; k < 500; ++k) {
    const double rate = std::min(1.0, k / 200.0);
    bench.ddq = JointVector::Unit(7, 0) * (k < 200 ? 1.2 / 0.2 : 0.0);
    bench.dq = JointVector::Unit(7, 0) * (1.2 * rate);
    bench.q += 1e-3 * bench.dq;
    bench.cycles(1);
  }
  bench.ddq.setZero();
  const double begin = bench.sample().q[0];
  bench.arm().stop(category);
  Stop stop;
  stop.ready = bench.sample().ready;
  stop.fault = bench.sample().fault;
  double last = bench.sample().dq[0];
  for (int k = 0; k < 1500; ++k) {
    bench.q += 1e-3 * bench.dq;
    bench.cycles(1);  // the core goes on; nobody listens
    stop.peak = std::max(stop.peak, (last - bench.sample().dq[0]) / 1e-3);
    last = bench.sample().dq[0];
  }
  stop.angle = bench.sample().q[0] - begin;
  stop.braked = bench.sample().braked;
  const double stands = bench.sample().q[0];
  bench.cycles(1000);
  stop.moved_after = std::abs(bench.sample().q[0] - stands);
  return stop;
}

TEST(StopCategories, S3_EachStopsInItsOwnWay) {
  const Stop zero = stop_at_speed(StopCategory::kBrakes), one = stop_at_speed(StopCategory::kStopThenBrakes),
             two = stop_at_speed(StopCategory::kStopAndHold);
  for (const Stop& stop : {zero, one, two}) {
    EXPECT_FALSE(stop.ready);
    EXPECT_LT(stop.moved_after, 1e-3);
  }
  EXPECT_TRUE(zero.braked);
  EXPECT_TRUE(one.braked);
  EXPECT_FALSE(two.braked) << "the drives hold it";
  EXPECT_NEAR(one.angle, two.angle, 1e-3) << "the same ramp";
  EXPECT_LT(zero.angle, 0.7 * one.angle) << "brakes need less way";
  EXPECT_GT(zero.peak, 2.0 * one.peak) << "and are harder";
  EXPECT_LT(one.peak, 1.5 * 8.0) << "the limit of the joint is 8 rad/s^2";
  EXPECT_EQ(zero.fault + 1, one.fault);
  EXPECT_EQ(zero.fault + 2, two.fault);
}

TEST(StopCategories, AWorseOneMayFollowAndNothingResumesByItself) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.arm().stop(StopCategory::kStopAndHold);
  bench.cycles(10);
  bench.arm().stop(StopCategory::kStopThenBrakes);
  bench.cycles(10);
  EXPECT_TRUE(bench.sample().braked);
  bench.cycles(500);
  EXPECT_FALSE(bench.sample().ready);
  bench.arm().release_brakes();
  bench.cycles(1);
  EXPECT_TRUE(bench.sample().ready);
  EXPECT_FALSE(bench.sample().braked);
}

TEST(ArmMeasurement, IsSeenLateAndThinnedAsDeclared) {
  Bench bench("lwr4plus", [](WorldDescription& cell) {
    cell.arms[0].measurement.delay = 5 * kMillisecond;
    cell.arms[0].measurement.period = 4 * kMillisecond;
  });
  EXPECT_EQ(bench.arm().timing().sample_age, 8 * kMillisecond);
  Nanoseconds oldest = 0, youngest = kSecond;
  std::uint64_t seen = 0, last = 0;
  for (int k = 0; k < 400; ++k) {
    bench.cycles(1);
    if (k < 20) continue;
    const auto sample = bench.sample();
    const Nanoseconds age = bench.world().time() - sample.stamp;
    oldest = std::max(oldest, age);
    youngest = std::min(youngest, age);
    if (sample.sequence != last) ++seen;
    last = sample.sequence;
  }
  EXPECT_EQ(youngest, 5 * kMillisecond);
  EXPECT_EQ(oldest, 8 * kMillisecond);
  EXPECT_EQ(seen, 95u) << "one of four";
}

TEST(ArmModes, TheCycleDoesNotAllocate) {
  for (const ControlMode mode : {ControlMode::kJointImpedance, ControlMode::kCartesianImpedance}) {
    Bench bench("lwr4plus");
    bench.cycles(10);
    bench.enter(mode);
    const takt::test::AllocationGuard guard;
    bench.cycles(50);
    EXPECT_EQ(guard.count(), 0u) << name_of(mode);
  }
}

TEST(ArmModes, D3_GoOnBitForBitFromASnapshot) {
  Bench bench("lwr4plus");
  bench.cycles(100);
  bench.arm().change_mode(ControlMode::kCartesianImpedance);
  bench.cycles(250);  // in the middle of a change
  bench.push(Eigen::Vector3d(10, 0, 0));
  const Snapshot snapshot = bench.world().save();
  const auto run = [&bench] {
    bench.set(ControlMode::kPosition);
    bench.cycles(300);
    bench.set(ControlMode::kCartesianImpedance);
    bench.cycles(200);
    bench.arm().stop(StopCategory::kStopAndHold);
    bench.cycles(20);
    return std::vector<double>(bench.world().positions().begin(), bench.world().positions().end());
  };
  const auto first = run();
  ASSERT_TRUE(bench.world().restore(snapshot));
  EXPECT_EQ(run(), first);
}

}  // namespace
}  // namespace takt::sim::test
