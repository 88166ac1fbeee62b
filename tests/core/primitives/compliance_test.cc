// Impedance, admittance, force control and differential kinematics: laws against their equations, limits by
// differencing.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Frame;
using net::JointArray;
using net::Real;
using net::Twist;
using net::Vector;
using net::Wrench;
using Json = nlohmann::ordered_json;
constexpr double kPeriod = 1e-3;

TEST(Force, ImpedanceIsASpringAndADamper) {
  PrimitiveHarness law("ImpedanceLaw", {{"stiffness", {100, 200, 300}},
                                        {"rotational_stiffness", {10, 20, 30}},
                                        {"damping", {1, 2, 3}},
                                        {"rotational_damping", {0.1, 0.2, 0.3}}});
  law.set("error", Twist{Vector(0.01, 0.02, -0.01), Vector(0.1, 0, 0)})
      .set("twist_error", Twist{Vector(1, 0, -1), Vector(0, 1, 0)});
  const Wrench w = *law.set_null("feed_forward").step().get<Wrench>("wrench");
  EXPECT_LT((w.force - Vector(2, 4, -6)).norm(), 1e-12);
  EXPECT_LT((w.torque - Vector(1, 0.2, 0)).norm(), 1e-12);
  const Wrench more = *law.set("feed_forward", Wrench{Vector(1, 1, 1), Vector(0, 0, 2)}).step().get<Wrench>("wrench");
  EXPECT_LT((more.force - Vector(3, 5, -5)).norm() + (more.torque - Vector(1, 0.2, 2)).norm(), 1e-12);
}

Json admittance(double mass, double damping, double stiffness) {
  const auto all = [](double x) { return Json{x, x, x}; };
  return {{"mass", all(mass)},           {"inertia", all(mass)},
          {"damping", all(damping)},     {"rotational_damping", all(damping)},
          {"stiffness", all(stiffness)}, {"rotational_stiffness", all(stiffness)}};
}

/// The step response of m x'' + d x' + k x = f in closed form (underdamped); the discrete one is right to first order.
TEST(Force, AdmittanceFollowsItsDifferentialEquation) {
  const double m = 2.0, d = 20.0, k = 800.0, f = 10.0;
  PrimitiveHarness law("AdmittanceLaw", admittance(m, d, k));
  law.set("reset", false).set("wrench", Wrench{Vector(f, 0, 0), Vector(0, f, 0)});
  const double w0 = std::sqrt(k / m), z = d / (2 * std::sqrt(k * m)), wd = w0 * std::sqrt(1 - z * z);
  for (int i = 1; i <= 2000; ++i) {
    const double t = i * kPeriod,
                 x = f / k * (1 - std::exp(-z * w0 * t) * (std::cos(wd * t) + z * w0 / wd * std::sin(wd * t)));
    const Twist offset = *law.step().get<Twist>("offset");
    ASSERT_NEAR(offset.linear.x(), x, 0.03 * f / k) << t;
    EXPECT_EQ(offset.angular.y(), offset.linear.x());
  }
  EXPECT_NEAR(law.get<Twist>("offset")->linear.x(), f / k, 1e-6);
}

/// A spring so hard and a mass so light that an explicit step would explode in a few cycles.
TEST(Force, AdmittanceIsStableForAnyNumbers) {
  for (const auto& [m, d, k] : {std::tuple{1e-6, 0.0, 1e9}, {1e-6, 1e6, 0.0}, {1e-3, 0.0, 1e12}}) {
    PrimitiveHarness law("AdmittanceLaw", admittance(m, d, k));
    law.set("reset", false).set("wrench", Wrench{Vector(1, 0, 0), Vector::Zero()}).step(10);
    law.set("wrench", Wrench{}).step(1000);
    EXPECT_LT(std::abs(law.get<Twist>("offset")->linear.x()), 1e-2);
    EXPECT_LT(std::abs(law.get<Twist>("twist")->linear.x()), 1e-2);
  }
}

/// Against a wall of known stiffness: approach, contact without a jump, the wanted force without a remaining error, and
/// approach again when the wall is taken away.
TEST(Force, ControllerFindsTheWallAndPressesAsWanted) {
  PrimitiveHarness control("ForceController", {{"approach_velocity", 0.01},
                                               {"contact_force", 1.0},
                                               {"release_force", 0.3},
                                               {"release_time", 0.02},
                                               {"gain", 0.002},
                                               {"velocity_max", 0.02},
                                               {"acceleration_max", 0.5}});
  double x = 0.0, before = 0.0, wall = 0.005, largest = 0.0;
  const auto run = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) {
      const double force = std::max(0.0, 5000.0 * (x - wall));
      largest = std::max(largest, force);
      control.set("force", force).step();
      const double v = *control.get<Real>("velocity");
      ASSERT_LE(std::abs(v - before), 0.5 * kPeriod + 1e-12);
      ASSERT_LE(std::abs(v), 0.02);
      before = v;
      x += v * kPeriod;
    }
  };
  control.set("wanted", 10.0);
  run(300);
  EXPECT_EQ(control.get<Boolean>("contact"), false);
  run(6000);
  EXPECT_EQ(control.get<Boolean>("contact"), true);
  EXPECT_NEAR(5000.0 * (x - wall), 10.0, 0.01);
  EXPECT_LT(largest, 10.5) << "nothing of the approach is kept";
  EXPECT_EQ(control.get<Boolean>("at_force"), true);
  wall = 1.0;
  run(200);
  EXPECT_EQ(control.get<Boolean>("contact"), false);
  EXPECT_NEAR(before, 0.01, 1e-12);
  EXPECT_FALSE(PrimitiveHarness("ForceController", {{"approach_velocity", 0.01},
                                                    {"contact_force", 1.0},
                                                    {"release_force", 2.0},
                                                    {"release_time", 0.02},
                                                    {"gain", 0.002},
                                                    {"velocity_max", 0.02},
                                                    {"acceleration_max", 0.5}})
                   .ready());
}

class ArmPrimitives : public testing::Test {
 protected:
  DeviceEnvironment devices;
  const HarnessOptions options{.environment = &devices};
  const device::ArmDescription& arm = devices.arm->description();
  Random random{7};

  JointArray random_joints() {
    JointArray q;
    q.size = 7;
    for (std::size_t i = 0; i < 7; ++i) q.value[i] = random.uniform(-1.5, 1.5);
    return q;
  }
};

/// Virtual work: torques on joint rates do what the wrench does on the twist; and the twist is the change of the pose.
TEST_F(ArmPrimitives, TorquesAndTwistsAreDual) {
  const Json tool{{"device", "arm"}, {"tool", {{"position", {0.05, 0.02, 0.2}}, {"quaternion", {1, 0, 0, 0}}}}};
  Frame X_FT = Frame::Identity();
  X_FT.translation() = Vector(0.05, 0.02, 0.2);
  for (int i = 0; i < 30; ++i) {
    const JointArray q = random_joints(), dq = random_joints();
    const Wrench w = harness::random_value<Wrench>(random, harness::Numbers::kModerate);
    const JointArray tau =
        *PrimitiveHarness("JointTorques", tool, options).set("q", q).set("wrench", w).step().get<JointArray>("tau");
    const Twist V = *PrimitiveHarness("JointTwist", tool, options).set("q", q).set("dq", dq).step().get<Twist>("twist");
    EXPECT_NEAR(tau.map().dot(dq.map()), w.force.dot(V.linear) + w.torque.dot(V.angular), 1e-10);
    const double h = 1e-6;
    const kinematics::JointVector q0 = q.map(), q1 = q.map() + h * dq.map();
    const Vector moved = (arm.chain->forward(q1) * X_FT).translation() - (arm.chain->forward(q0) * X_FT).translation();
    EXPECT_LT((moved / h - V.linear).norm(), 1e-4);
  }
}

TEST_F(ArmPrimitives, ManipulabilityIsZeroInASingularPosture) {
  PrimitiveHarness measure("Manipulability", {{"device", "arm"}}, options);
  JointArray stretched;
  stretched.size = 7;
  EXPECT_LT(*measure.set("q", stretched).step().get<Real>("smallest"), 1e-6);
  EXPECT_LT(*measure.get<Real>("value"), 1e-6);
  EXPECT_GT(*measure.set("q", JointArray(arm.home)).step().get<Real>("smallest"), 0.05);
  EXPECT_GT(*measure.get<Real>("value"), 1e-3);
}

/// Twists that change at random, and such that drive the arm into its limits and through singular postures: what leaves
/// the primitive is differenced, and never breaks a limit.
TEST_F(ArmPrimitives, DifferentialKinematicsNeverBreaksALimit) {
  const motion::JointLimits& limits = arm.limits;
  const auto list = [](const kinematics::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
  for (int run = 0; run < 12; ++run) {
    PrimitiveHarness jog("DifferentialInverseKinematics", {{"device", "arm"}}, options);
    LimitOracle judge(
        {list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration), list(limits.jerk)},
        kPeriod, 1e-13);
    Random twists(static_cast<std::uint64_t>(run) + 1);
    for (int k = 0; k < 3000; ++k) {
      if (k % 700 == 0) {
        const double size = run % 2 == 0 ? 0.5 : 10.0;
        const auto part = [&] { return twists.uniform(-size, size); };
        jog.set("twist", Twist{Vector(part(), part(), part()), Vector(part(), part(), part())});
      }
      if (run % 3 == 2 && k % 1000 == 500) jog.set_null("twist");
      jog.step();
      ASSERT_FALSE(jog.is_null("q"));
      judge.add(list(kinematics::JointVector(jog.get<JointArray>("q")->map())));
    }
    EXPECT_LE(judge.range_excess, 1e-9) << run;
    EXPECT_LE(judge.velocity.share, 1.0 + 1e-4) << run;
    EXPECT_LE(judge.acceleration.share, 1.0 + 1e-4) << run;
    EXPECT_LE(judge.jerk.share, 1.0 + 1e-3) << run;
  }
}

/// In a good posture the tool moves as wanted once the rates have built up.
TEST_F(ArmPrimitives, DifferentialKinematicsReachesTheWantedTwist) {
  PrimitiveHarness jog("DifferentialInverseKinematics", {{"device", "arm"}}, options);
  const Twist wanted{Vector(0.0, 0.05, 0.02), Vector(0.0, 0.0, 0.1)};
  jog.set("twist", wanted).step(600);
  const Twist V = *jog.get<Twist>("achieved");
  EXPECT_LT((V.linear - wanted.linear).norm(), 1e-3);
  EXPECT_LT((V.angular - wanted.angular).norm(), 1e-3);
  jog.set_null("twist").step(600);
  EXPECT_EQ(jog.get<JointArray>("dq")->map().norm(), 0.0);
  EXPECT_FALSE(
      PrimitiveHarness("DifferentialInverseKinematics", {{"device", "arm"}, {"seed", {1, 2}}}, options).ready());
}

/// Rates that change at random and are far beyond what the arm can: no limit is broken, and the tool is not faster than
/// allowed but for what the joints do while they change.
TEST_F(ArmPrimitives, JoggedJointsNeverBreakALimit) {
  const motion::JointLimits& limits = arm.limits;
  const auto list = [](const kinematics::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
  for (int run = 0; run < 8; ++run) {
    PrimitiveHarness jog("JointJog", {{"device", "arm"}, {"linear_max", 0.5}, {"angular_max", 2.0}}, options);
    LimitOracle judge(
        {list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration), list(limits.jerk)},
        kPeriod, 1e-13);
    Random wishes(static_cast<std::uint64_t>(run) + 1);
    for (int k = 0; k < 3000; ++k) {
      if (k % 700 == 0) {
        kinematics::JointVector rates(limits.velocity.size());
        for (double& rate : rates) rate = wishes.uniform(-5.0, 5.0);
        jog.set("rates", JointArray(rates));
      }
      if (run % 3 == 2 && k % 1000 == 500) jog.set_null("rates");
      jog.step();
      ASSERT_FALSE(jog.is_null("q"));
      judge.add(list(kinematics::JointVector(jog.get<JointArray>("q")->map())));
      if (k % 700 < 400) continue;
      EXPECT_LE(jog.get<Twist>("achieved")->linear.norm(), 0.5 * 1.02) << run << " " << k;
      EXPECT_LE(jog.get<Twist>("achieved")->angular.norm(), 2.0 * 1.02) << run << " " << k;
    }
    EXPECT_LE(judge.range_excess, 1e-9) << run;
    EXPECT_LE(judge.velocity.share, 1.0 + 1e-4) << run;
    EXPECT_LE(judge.acceleration.share, 1.0 + 1e-4) << run;
    EXPECT_LE(judge.jerk.share, 1.0 + 1e-3) << run;
  }
}

/// Wishes of full speed that turn at random, by small joints and large: on the way from one to the next the tool keeps
/// to its bounds, but for what its Jacobian changes meanwhile.
TEST_F(ArmPrimitives, ABoundedToolIsNotFasterWhileJointsChangeTheirRates) {
  constexpr double kLinear = 0.5, kAngular = 1.0;
  for (const std::string kind : {"DifferentialInverseKinematics", "JointJog"}) {
    double linear = 0.0, angular = 0.0;
    for (std::uint64_t run = 1; run <= 40; ++run) {
      PrimitiveHarness jog(kind, {{"device", "arm"}, {"linear_max", kLinear}, {"angular_max", kAngular}}, options);
      Random wishes(run);
      const auto part = [&] { return wishes.uniform(-1.0, 1.0); };
      int next = 0;
      for (int k = 0; k < 3000; ++k) {
        if (k == next) {
          next += static_cast<int>(wishes.uniform(10.0, 500.0));
          kinematics::JointVector rates(arm.limits.velocity.size());
          for (double& rate : rates) rate = 1.5 * part();
          const Vector v(part(), part(), part()), w(part(), part(), part());
          if (kind == "JointJog") jog.set("rates", JointArray(rates));
          if (kind != "JointJog")
            jog.set("twist", Twist{2.0 * kLinear * v.normalized(), 2.0 * kAngular * w.normalized()});
        }
        jog.step();
        const Twist V = *jog.get<Twist>("achieved");
        linear = std::max(linear, V.linear.norm() / kLinear);
        angular = std::max(angular, V.angular.norm() / kAngular);
      }
    }
    RecordProperty(kind + " linear", std::to_string(linear));
    RecordProperty(kind + " angular", std::to_string(angular));
    EXPECT_LE(linear, 1.06) << kind;
    EXPECT_LE(angular, 1.15) << kind;
    EXPECT_GT(linear, 0.9) << kind << ": and it is not simply slow";
  }
}

/// Joints that are led to their rates together change them more slowly than they could, and keep their limits too.
TEST_F(ArmPrimitives, JointsOfABoundedToolNeverBreakALimit) {
  const motion::JointLimits& limits = arm.limits;
  const auto list = [](const kinematics::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
  for (std::uint64_t run = 1; run <= 40; ++run) {
    PrimitiveHarness jog("DifferentialInverseKinematics",
                         {{"device", "arm"}, {"linear_max", 1.5}, {"angular_max", 4.0}}, options);
    LimitOracle judge(
        {list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration), list(limits.jerk)},
        kPeriod, 1e-13);
    Random wishes(run);
    const auto part = [&] { return wishes.uniform(-1.0, 1.0); };
    int next = 0;
    for (int k = 0; k < 3000; ++k) {
      if (k == next) {
        next += static_cast<int>(wishes.uniform(10.0, 300.0));
        const Vector v(part(), part(), part()), w(part(), part(), part());
        jog.set("twist", Twist{1.5 * v.normalized(), 4.0 * w.normalized()});
      }
      jog.step();
      judge.add(list(kinematics::JointVector(jog.get<JointArray>("q")->map())));
    }
    EXPECT_LE(judge.range_excess, 1e-9) << run;
    EXPECT_LE(judge.velocity.share, 1.0 + 1e-6) << run;
    EXPECT_LE(judge.acceleration.share, 1.0 + 1e-4) << run;
    EXPECT_LE(judge.jerk.share, 1.0 + 1e-3) << run;
  }
}

TEST_F(ArmPrimitives, JoggedJointsKeepTheDirectionOfTheToolAndRestWithoutAWish) {
  PrimitiveHarness jog("JointJog", {{"device", "arm"}, {"linear_max", 0.1}, {"angular_max", 10.0}}, options);
  kinematics::JointVector rates = kinematics::JointVector::Zero(arm.home.size());
  rates[0] = 0.8;
  rates[3] = 0.4;
  jog.set("rates", JointArray(rates)).step(400);
  const Eigen::VectorXd dq = jog.get<JointArray>("dq")->map();
  EXPECT_NEAR(dq[0], 2.0 * dq[3], 1e-6) << "all by one factor";
  EXPECT_NEAR(jog.get<Twist>("achieved")->linear.norm(), 0.1, 2e-3);
  jog.set("rates", JointArray(Eigen::Vector2d(1.0, 1.0))).step(600);
  EXPECT_EQ(jog.get<JointArray>("dq")->map().norm(), 0.0) << "a wrong number of joints is no wish";
  jog.set("rates", JointArray(rates)).step(100);
  jog.set_null("rates").step(600);
  EXPECT_EQ(jog.get<JointArray>("dq")->map().norm(), 0.0);
}

TEST(TablePrimitives, ACharacteristicAndATrajectory) {
  PrimitiveHarness table("Table", {{"points", {{0.0, 1.0}, {1.0, 3.0}}}});
  EXPECT_DOUBLE_EQ(*table.set("input", 0.25).step().get<Real>("value"), 1.5);
  EXPECT_DOUBLE_EQ(*table.get<Real>("slope"), 2.0);
  EXPECT_EQ(table.set("input", 7.0).step().get<Boolean>("inside"), false);
  EXPECT_FALSE(PrimitiveHarness("Table", {{"points", {{0.0, 1.0, 2.0}, {1.0, 3.0, 2.0}}}}).ready());
  PrimitiveHarness joints("JointTable",
                          {{"points", {{0.0, 0.0, 1.0}, {1.0, 2.0, 0.0}, {2.0, 0.0, 0.0}}}, {"form", "rest"}});
  joints.set("rate", 0.5).set("rate_derivative", 0.1);
  // Backwards or at half the speed, the derivatives are those with respect to real time.
  const double h = 1e-5, t = 0.7;
  const auto at = [&](double time) { return joints.set("time", time).step().get<JointArray>("q")->value[0]; };
  const double slope = (at(t + h) - at(t - h)) / (2 * h), bend = (at(t + h) - 2 * at(t) + at(t - h)) / (h * h);
  joints.set("time", t).step();
  EXPECT_NEAR(joints.get<JointArray>("dq")->value[0], 0.5 * slope, 1e-6);
  EXPECT_NEAR(joints.get<JointArray>("ddq")->value[0], 0.25 * bend + 0.1 * slope, 1e-3);
}

}  // namespace
}  // namespace takt::test
