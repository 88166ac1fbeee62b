// Geometry, force, path and kinematics primitives against formulas written a second time.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/motion/path_clock.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using net::Boolean;
using net::Frame;
using net::Integer;
using net::JointArray;
using net::Real;
using net::Twist;
using net::Vector;
using net::Wrench;
using Json = nlohmann::ordered_json;

Frame random_frame(Random& random) {
  Frame X = Frame::Identity();
  X.translate(Vector(random.normal(), random.normal(), random.normal()));
  X.rotate(Eigen::AngleAxisd(random.uniform(-3, 3), Vector(random.normal(), random.normal(), 1.0).normalized()));
  return X;
}

TEST(Geometry, FramesMeet) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Frame X_AB = random_frame(random), X_BC = random_frame(random);
    const Vector p(random.normal(), random.normal(), random.normal());
    const auto X_AC = PrimitiveHarness("Compose").set("left", X_AB).set("right", X_BC).step().get<Frame>("value");
    ASSERT_TRUE(X_AC);
    EXPECT_LT(((*X_AC * p) - (X_AB * (X_BC * p))).norm(), 1e-12);
    const auto X_BA = PrimitiveHarness("Inverse").set("input", X_AB).step().get<Frame>("value");
    EXPECT_LT(((*X_BA * (X_AB * p)) - p).norm(), 1e-12);
    const auto q = PrimitiveHarness("TransformPoint").set("frame", X_AB).set("point", p).step().get<Vector>("value");
    EXPECT_LT((*q - X_AB * p).norm(), 1e-12);
    const auto v = PrimitiveHarness("RotateVector").set("frame", X_AB).set("vector", p).step().get<Vector>("value");
    EXPECT_LT((*v - (X_AB * p - X_AB.translation())).norm(), 1e-12);
    PrimitiveHarness parts("FrameComponents");
    parts.set("input", X_AB).step();
    PrimitiveHarness again("AssembleFrame");
    again.set("position", *parts.get<Vector>("position")).set("rotation", *parts.get<net::Rotation>("rotation")).step();
    EXPECT_LT((again.get<Frame>("value")->matrix() - X_AB.matrix()).norm(), 1e-12);
  }
}

TEST(Geometry, Vectors) {
  const Vector a(1, 2, 3), b(-2, 0.5, 4);
  const auto of = [&](const char* type) { return std::move(PrimitiveHarness(type).set("a", a).set("b", b).step()); };
  EXPECT_EQ(of("AddVectors").get<Vector>("value"), Vector(a + b));
  EXPECT_EQ(of("SubtractVectors").get<Vector>("value"), Vector(a - b));
  EXPECT_EQ(of("DotProduct").get<Real>("value"), 11.0);
  EXPECT_EQ(of("CrossProduct").get<Vector>("value"), Vector(6.5, -10, 4.5));
  EXPECT_EQ(PrimitiveHarness("Norm").set("input", Vector(2, 3, 6)).step().get<Real>("value"), 7.0);
  EXPECT_EQ(PrimitiveHarness("ScaleVector").set("vector", a).set("factor", -2.0).step().get<Vector>("value"),
            Vector(-2, -4, -6));
  PrimitiveHarness parts("VectorComponents");
  parts.set("input", a).step();
  EXPECT_EQ(parts.get<Real>("z"), 3.0);
}

/// The power of a wrench on a twist does not depend on the frame it is told in.
TEST(Geometry, AWrenchKeepsItsPower) {
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Frame X_AB = random_frame(random);
    const Wrench w_B{Vector(random.normal(), random.normal(), random.normal()), Vector(1, random.normal(), 2)};
    const Vector v_B(random.normal(), 1, 0), omega_B(0, random.normal(), random.normal());
    const auto w_A =
        PrimitiveHarness("TransformWrench").set("frame", X_AB).set("wrench", w_B).step().get<Wrench>("value");
    // The same body, its velocity told at the origin of A.
    const Vector omega_A = X_AB.linear() * omega_B;
    const Vector v_A = X_AB.linear() * v_B - omega_A.cross(X_AB.translation());
    EXPECT_NEAR(w_A->force.dot(v_A) + w_A->torque.dot(omega_A), w_B.force.dot(v_B) + w_B.torque.dot(omega_B), 1e-11);
  }
}

TEST(Force, TareTakesTheMean) {
  PrimitiveHarness tare("Tare", {{"cycles", 3}});
  const auto reading = [](double x) { return Wrench{Vector(x, 0, -x), Vector(0, 2 * x, 0)}; };
  tare.set("trigger", true).set("wrench", reading(1.0)).step();
  EXPECT_EQ(tare.get<Boolean>("done"), false);
  tare.set_null("wrench").step();  // does not count
  tare.set("wrench", reading(2.0)).step();
  EXPECT_TRUE(tare.is_null("tared"));
  tare.set("wrench", reading(6.0)).step();
  EXPECT_EQ(tare.get<Boolean>("done"), true);
  EXPECT_DOUBLE_EQ(tare.get<Wrench>("bias")->force.x(), 3.0);
  EXPECT_DOUBLE_EQ(tare.get<Wrench>("tared")->torque.y(), 6.0);
  tare.set("trigger", false).step().set("trigger", true).step();  // anew
  EXPECT_TRUE(tare.is_null("tared"));
  EXPECT_DOUBLE_EQ(tare.get<Wrench>("bias")->force.x(), 3.0);
}

TEST(Force, CompensationLeavesTheContact) {
  Random random(4);
  const double mass = 0.7;
  const Vector centre(0.01, -0.02, 0.06), contact(3, 4, 5), g(0, 0, -9.81);
  for (int i = 0; i < 20; ++i) {
    const Frame X_WS = random_frame(random);
    const Vector a_W(random.normal(), random.normal(), random.normal());
    const Vector weight = mass * (X_WS.linear().inverse() * (g - a_W));
    PrimitiveHarness compensation("PayloadCompensation",
                                  {{"mass", mass}, {"centre", {centre.x(), centre.y(), centre.z()}}});
    compensation.set("wrench", Wrench{contact + weight, centre.cross(weight)}).set("frame", X_WS);
    compensation.set("acceleration", a_W).step();
    const auto result = compensation.get<Wrench>("compensated");
    EXPECT_LT((result->force - contact).norm(), 1e-12);
    EXPECT_LT(result->torque.norm(), 1e-12);
  }
}

class Arm7 : public testing::Test {
 protected:
  const kinematics::Chain& chain() { return *devices.arm->description().chain; }
  DeviceEnvironment devices;
};

TEST_F(Arm7, ForwardKinematicsGivesToolPoseAndTwist) {
  Random random(9);
  const Json tool = {{"position", {0.02, 0.0, 0.15}}, {"quaternion", {1.0, 0.0, 0.0, 0.0}}};
  Frame X_FT = Frame::Identity();
  X_FT.translation() << 0.02, 0, 0.15;
  for (int i = 0; i < 20; ++i) {
    kinematics::JointVector q(7), dq(7);
    for (int j = 0; j < 7; ++j) q[j] = random.uniform(-1.5, 1.5), dq[j] = random.normal();
    PrimitiveHarness fk("ForwardKinematics", {{"device", "arm"}, {"tool", tool}}, {.environment = &devices});
    fk.set("q", JointArray(q)).set("dq", JointArray(dq)).step();
    const Frame X_BT = chain().forward(q) * X_FT;
    EXPECT_LT((fk.get<Frame>("frame")->matrix() - X_BT.matrix()).norm(), 1e-12);
    const double h = 1e-6;
    const Frame later = chain().forward(q + h * dq) * X_FT, before = chain().forward(q - h * dq) * X_FT;
    const Vector v = (later.translation() - before.translation()) / (2 * h);
    const Eigen::AngleAxisd turn(later.linear() * before.linear().transpose());
    EXPECT_LT((fk.get<Twist>("twist")->linear - v).norm(), 1e-8);
    EXPECT_LT((fk.get<Twist>("twist")->angular - turn.axis() * turn.angle() / (2 * h)).norm(), 1e-8);
  }
}

/// A moving tool frame: the joints that come back move it as asked, derivatives included.
TEST_F(Arm7, InverseKinematicsMovesTheToolFrame) {
  const Json tool = {{"position", {0.02, 0.0, 0.15}}, {"quaternion", {1.0, 0.0, 0.0, 0.0}}};
  Frame X_FT = Frame::Identity();
  X_FT.translation() << 0.02, 0, 0.15;
  const Frame start = chain().forward(devices.arm->description().home) * X_FT;
  const Vector direction = Vector(0.3, 0.5, -0.2), axis = Vector(0.2, -0.4, 0.6);
  PrimitiveHarness ik("InverseKinematics", {{"device", "arm"}, {"tool", tool}}, {.environment = &devices});
  kinematics::JointVector q_before, dq_before;
  for (int k = 0; k < 200; ++k) {
    const double t = 1e-3 * k;  // p = p0 + direction t^2 / 2, turned about `axis` by |axis| t^2 / 2
    Frame X = start;
    X.translation() += 0.5 * t * t * direction;
    X.linear() = Eigen::AngleAxisd(0.5 * t * t * axis.norm(), axis.normalized()) * start.linear();
    ik.set("frame", X).set("twist", Twist{t * direction, t * axis}).set("acceleration", Twist{direction, axis});
    const kinematics::JointVector held = devices.arm->description().inverse->held(devices.arm->description().home);
    ik.set("held", JointArray(held));
    ik.set("held_velocity", JointArray(kinematics::JointVector::Zero(1).eval()));
    ik.set("held_acceleration", JointArray(kinematics::JointVector::Zero(1).eval())).step();
    ASSERT_EQ(ik.get<Integer>("status"), 0) << k;
    const kinematics::JointVector q = ik.get<JointArray>("q")->map(), dq = ik.get<JointArray>("dq")->map();
    const kinematics::JointVector ddq = ik.get<JointArray>("ddq")->map();
    EXPECT_LT(((chain().forward(q) * X_FT).matrix() - X.matrix()).norm(), 1e-10);
    if (k > 0) {
      EXPECT_LT((q - q_before - 0.5e-3 * (dq + dq_before)).norm(), 1e-8);
      EXPECT_LT((dq - dq_before - 1e-3 * ddq).norm(), 1e-5);
    }
    q_before = q;
    dq_before = dq;
  }
}

TEST_F(Arm7, OutOfReachIsNullWithAStatus) {
  PrimitiveHarness ik("InverseKinematics", {{"device", "arm"}}, {.environment = &devices});
  Frame far = Frame::Identity();
  far.translation().x() = 5.0;
  const JointArray zero(kinematics::JointVector::Zero(1).eval());
  ik.set("frame", far).set("twist", Twist{}).set("acceleration", Twist{});
  ik.set("held", zero).set("held_velocity", zero).set("held_acceleration", zero).step();
  EXPECT_EQ(ik.get<Integer>("status"), 1);
  for (const char* port : {"q", "dq", "ddq"}) EXPECT_TRUE(ik.is_null(port));
}

TEST(Path, S1_ANullTargetStopsTheClock) {
  PrimitiveHarness clock("PathClock",
                         {{"bounds", {{"acceleration_max", 4.0}, {"jerk_max", 80.0}}}, {"duration", 10.0}});
  clock.set("target_rate", 1.0).step(100);
  EXPECT_EQ(clock.get<Real>("rate"), 1.0);
  EXPECT_NEAR(*clock.get<Real>("time"), 0.1, 1e-12);
  clock.set_null("target_rate").step();
  EXPECT_LT(*clock.get<Real>("rate"), 1.0);  // the same cycle
  clock.step(1000);
  EXPECT_EQ(clock.get<Boolean>("standstill"), true);
  EXPECT_EQ(clock.get<Boolean>("at_end"), false);
}

TEST(Path, WrongKindOfPathIsAFinding) {
  PrimitiveHarness line("JointLine", {{"path", {{"kind", "cartesian_line"}}}});
  EXPECT_FALSE(line.ready());
  EXPECT_THAT(line.diagnostics(), Reports(Code::kInvalidValue, "/primitives/4/parameters/path/kind"));
}

}  // namespace
}  // namespace takt::test
