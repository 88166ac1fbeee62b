// The law that presses, against a tool on the position loops of an arm and a surface; the figures of an arm that it
// works with, against their definition.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "core/device/servo.h"
#include "core/kinematics/chain.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::JointArray;
using net::Real;
using net::Vector;
using Json = nlohmann::ordered_json;

constexpr double kCycle = 1e-3;

/// A tool of some mass whose position loop follows a set point, and a surface at 0: a spring with little damping.
struct PressedTool {
  double mass, frequency, surface;
  double x = -0.002, v = 0.0, force = 0.0;
  double sent = -0.002, sent_v = 0.0;

  /// One cycle with this velocity of the set point.
  void step(double wanted) {
    constexpr int kParts = 20;
    const double h = kCycle / kParts, a = (wanted - sent_v) / kCycle;
    const double damping = 0.2 * std::sqrt(surface * mass);
    for (int i = 0; i < kParts; ++i) {
      force = x > 0.0 ? std::max(0.0, surface * x + damping * v) : 0.0;
      const double pull = a + 2.0 * frequency * (sent_v - v) + frequency * frequency * (sent - x);
      v += h * (pull - force / mass);
      x += h * v;
      sent += h * sent_v + 0.5 * h * h * a;
      sent_v += h * a;
    }
  }
};

struct Pressed {
  double over = 0.0;     ///< N, largest from 50 ms after the first contact on
  double settled = 0.0;  ///< s from the first contact until within 5 %
  double swing = 0.0;    ///< N, of the last second
};

Json law(double wanted, double approach, bool measures = true) {
  return {{"approach_velocity", approach},
          {"contact_force", std::min(0.3 * wanted, 2.0)},
          {"release_force", 0.1 * std::min(wanted, 6.0)},
          {"release_time", 0.05},
          {"measures_stiffness", measures},
          {"velocity_max", 5.0 * approach},
          {"acceleration_max", 1.0}};
}

/// 6 kg on loops of 60 rad/s.
void set_arm(PrimitiveHarness& control, double wanted) {
  control.set("wanted", wanted)
      .set("stiffness", 21600.0)
      .set("natural_frequency", 60.0)
      .set("damping_ratio", 1.0)
      .set("delay", kCycle);
}

Pressed press(PressedTool tool, double wanted, double approach = 0.005) {
  PrimitiveHarness control("ForceController", law(wanted, approach));
  control.set("wanted", wanted)
      .set("stiffness", tool.mass * tool.frequency * tool.frequency)
      .set("natural_frequency", tool.frequency)
      .set("damping_ratio", 1.0)
      .set("delay", kCycle);
  std::vector<double> force;
  for (int i = 0; i < 5000; ++i) {
    control.set("force", tool.force).step();
    tool.step(*control.get<Real>("velocity"));
    if (!force.empty() || tool.force > 0.0) force.push_back(tool.force);
  }
  Pressed pressed;
  for (std::size_t i = 50; i < force.size(); ++i) pressed.over = std::max(pressed.over, force[i]);
  for (std::size_t i = 0; i < force.size(); ++i)
    if (std::abs(force[i] - wanted) > 0.05 * wanted) pressed.settled = kCycle * static_cast<double>(i);
  const auto end = std::minmax_element(force.end() - 1000, force.end());
  pressed.swing = *end.second - *end.first;
  return pressed;
}

/// A sensor that carries a heavy tool feels it while it is accelerated; after the first touch the law is as fast as
/// ever.
TEST(ForceControl, TheApproachBeginsAsGentlyAsTold) {
  Json parameters = law(5.0, 0.01);
  parameters["approach_acceleration"] = 0.1;
  PrimitiveHarness control("ForceController", parameters);
  set_arm(control, 5.0);
  double last = 0.0;
  for (int i = 0; i < 200; ++i) {
    control.set("force", 0.0).step();
    const double velocity = *control.get<Real>("velocity");
    EXPECT_LE(velocity - last, 0.1 * kCycle * (1.0 + 1e-9));
    last = velocity;
  }
  EXPECT_DOUBLE_EQ(last, 0.01);
  control.set("force", 6.0).step();
  EXPECT_NEAR(last - *control.get<Real>("velocity"), 1.0 * kCycle, 1e-12);
}

/// Light and heavy arms, slow and fast loops, from foam to steel: nobody tunes anything.
TEST(ForceControl, TheForceComesQuicklyAndStaysOnAnySurfaceWithAnyArm) {
  for (const auto& [mass, frequency] : {std::pair{3.0, 60.0}, {6.0, 80.0}, {26.0, 60.0}, {10.0, 30.0}})
    for (const double surface : {1e4, 1e5, 1e6})
      for (const double wanted : {5.0, 20.0, 50.0}) {
        SCOPED_TRACE(testing::Message() << mass << " kg, " << frequency << " rad/s, " << surface << " N/m, " << wanted
                                        << " N");
        const Pressed pressed = press({.mass = mass, .frequency = frequency, .surface = surface}, wanted);
        // A blow is what the mass does at this speed, and again after it was thrown back; no law can take it away.
        const double blow = 1.6 * 0.005 * std::sqrt(surface * mass);
        EXPECT_LT(pressed.over, std::max(1.1 * wanted, blow));
        EXPECT_LT(pressed.settled, (surface < 5e4 ? 1.0 : 0.5) * std::max(1.0, 60.0 / frequency));
        EXPECT_LT(pressed.swing, 0.02 * wanted);
      }
}

/// The figures may be wrong by a half either way.
TEST(ForceControl, WrongFiguresOfTheArmDoNotMakeItSwing) {
  for (const double error : {0.5, 0.7, 1.5, 2.0}) {
    SCOPED_TRACE(error);
    PressedTool tool{.mass = 6.0, .frequency = 60.0, .surface = 1e6};
    PrimitiveHarness control("ForceController", law(20.0, 0.005));
    control.set("wanted", 20.0)
        .set("stiffness", error * tool.mass * tool.frequency * tool.frequency)
        .set("natural_frequency", tool.frequency)
        .set("damping_ratio", 1.0)
        .set("delay", kCycle);
    double low = 1e9, high = 0.0;
    for (int i = 0; i < 4000; ++i) {
      control.set("force", tool.force).step();
      tool.step(*control.get<Real>("velocity"));
      if (i < 3000) continue;
      low = std::min(low, tool.force);
      high = std::max(high, tool.force);
    }
    EXPECT_NEAR(low, 20.0, 0.4);
    EXPECT_NEAR(high, 20.0, 0.4);
  }
}

/// An arm whose tool is exactly where it was sent is harder than any position loop: the figures are wrong, and the law
/// sees it.
TEST(ForceControl, AnArmThatIsFarHarderThanItsFiguresSayIsFound) {
  PrimitiveHarness control("ForceController", law(20.0, 0.001));
  set_arm(control, 20.0);
  double x = -0.001, largest = 0.0, force = 0.0, low = 1e9, high = 0.0;
  for (int i = 0; i < 6000; ++i) {
    control.set("force", force).step();
    x += kCycle * *control.get<Real>("velocity");
    force = std::max(0.0, 1e6 * x);
    largest = std::max(largest, force);
    if (i < 5000) continue;
    low = std::min(low, force);
    high = std::max(high, force);
  }
  EXPECT_LT(largest, 40.0);
  EXPECT_NEAR(low, 20.0, 0.2);
  EXPECT_NEAR(high, 20.0, 0.2);
}

TEST(ForceControl, AGainByHandIsBoundedByWhatTheArmAllows) {
  Json parameters = law(20.0, 0.005);
  parameters["gain"] = 1.0;
  PressedTool tool{.mass = 6.0, .frequency = 60.0, .surface = 1e6};
  PrimitiveHarness control("ForceController", parameters);
  set_arm(control, 20.0);
  for (int i = 0; i < 4000; ++i) {
    control.set("force", tool.force).step();
    tool.step(*control.get<Real>("velocity"));
  }
  EXPECT_NEAR(tool.force, 20.0, 0.4);
}

TEST(ForceControl, AtForceMeansInsideTheBandAndInContact) {
  Json parameters = law(20.0, 0.005);
  parameters["band"] = 0.05;
  PrimitiveHarness control("ForceController", parameters);
  set_arm(control, 20.0);
  control.set("force", 0.0).step(100);
  EXPECT_EQ(control.get<Boolean>("at_force"), false);
  control.set("force", 18.5).step(500);
  EXPECT_EQ(control.get<Boolean>("at_force"), false) << "7.5 % are missing";
  control.set("force", 19.5).step(500);
  EXPECT_EQ(control.get<Boolean>("at_force"), true);
  control.set("force", 22.0).step(500);
  EXPECT_EQ(control.get<Boolean>("at_force"), false) << "it may leave the band again";
  control.set("force", 0.0).step(100);
  EXPECT_EQ(control.get<Boolean>("contact"), false);
}

/// A surface that comes towards a tool that slides on a slope: 3 mm/s.
TEST(ForceControl, ASurfaceThatComesIsFollowedWithoutAnError) {
  Json parameters = law(20.0, 0.005, false);
  for (const bool integral : {false, true}) {
    parameters["surface_moves"] = integral;
    PrimitiveHarness control("ForceController", parameters);
    PressedTool tool{.mass = 6.0, .frequency = 60.0, .surface = 1e5};
    set_arm(control, 20.0);
    for (int i = 0; i < 6000; ++i) {
      if (i > 3000) tool.x += 0.003 * kCycle, tool.sent += 0.003 * kCycle;  // seen from the surface
      control.set("force", tool.force).step();
      tool.step(*control.get<Real>("velocity"));
    }
    if (integral) {
      EXPECT_NEAR(tool.force, 20.0, 0.2);
    } else {
      EXPECT_GT(tool.force, 22.0) << "so the case is one";
    }
  }
}

/// A path to and fro across a surface that is tilted by 10 degrees: once the tilt is known, neither a turn nor another
/// speed costs anything.
TEST(ForceControl, ATiltIsLearnedOnceForAllSpeedsAndDirections) {
  Json parameters = law(20.0, 0.005, false);
  parameters["surface_moves"] = true;
  for (const bool told : {false, true}) {
    PrimitiveHarness control("ForceController", parameters);
    PressedTool tool{.mass = 6.0, .frequency = 60.0, .surface = 1e5};
    set_arm(control, 20.0);
    double worst = 0.0;
    for (int i = 0; i < 9000; ++i) {
      const double t = kCycle * i - 3.0;
      const double way = t < 2.0 ? 0.02 : 0.03 * std::cos(5.0 * (t - 2.0));  // m/s, and turns back each 0.6 s
      const double along = t < 0.0 ? 0.0 : way * std::min(1.0, 20.0 * t);
      const double comes = along * std::tan(10.0 * M_PI / 180.0) * kCycle;  // seen from the surface
      tool.x += comes, tool.sent += comes;
      if (told) control.set("path_velocity", Vector(0.6 * along, -0.8 * along, 0.0));
      control.set("force", tool.force).step();
      tool.step(*control.get<Real>("velocity"));
      if (t > 3.0) worst = std::max(worst, std::abs(tool.force - 20.0));
    }
    if (told) {
      EXPECT_LT(worst, 0.4);
    } else {
      EXPECT_GT(worst, 1.0) << "so the case is one";
    }
  }
}

/// As at the end of the range of an offset: half the force is missing, and the tool may not go after it.
TEST(ForceControl, NothingIsLearnedOfASurfaceThatTheToolMayNotFollow) {
  Json parameters = law(20.0, 0.005, false);
  parameters["surface_moves"] = true;
  for (const bool told : {false, true}) {
    PrimitiveHarness control("ForceController", parameters);
    set_arm(control, 20.0);
    control.set("path_velocity", Vector(0.02, 0.0, 0.0)).set("force", 20.0).step(1000);
    ASSERT_EQ(control.get<Boolean>("at_force"), true);
    if (told) control.set("held_back", true);
    control.set("force", 10.0).step(2000);
    control.set("force", 20.0).step(500);
    if (told) {
      EXPECT_NEAR(*control.get<Real>("velocity"), 0.0, 1e-5);
    } else {
      EXPECT_GT(*control.get<Real>("velocity"), 1e-3) << "so the case is one";
    }
  }
}

/// A path across a slope presses without any travel of the law: that is no hard surface.
TEST(ForceControl, ASlopeIsNotTakenForAHardSurface) {
  Json parameters = law(8.0, 0.005, false);
  parameters["surface_moves"] = true;
  PrimitiveHarness control("ForceController", parameters);
  PressedTool tool{.mass = 6.0, .frequency = 60.0, .surface = 1e5};
  set_arm(control, 8.0);
  double most = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double along = i < 3000 ? 0.0 : 0.05;
    const double comes = along * std::tan(10.0 * M_PI / 180.0) * kCycle;
    tool.x += comes, tool.sent += comes;
    control.set("path_velocity", Vector(along, 0.0, 0.0)).set("force", tool.force).step();
    tool.step(*control.get<Real>("velocity"));
    if (i > 3000) most = std::max(most, tool.force);
  }
  EXPECT_LT(most, 25.0);
  EXPECT_NEAR(tool.force, 8.0, 0.2);
}

/// A tip of 20 N/mm on an arm of 100 kg: the arm's mass is behind it, so the force comes much faster.
TEST(ForceControl, ATipThatYieldsMakesAHeavyArmQuick) {
  const device::ServoResponse arm{.stiffness = 360e3, .natural_frequency = 60.0, .damping_ratio = 1.0};
  const device::ServoResponse soft = device::through_tip(arm, 1.0 / 20e3);
  EXPECT_NEAR(soft.stiffness, 1.0 / (1.0 / 360e3 + 1.0 / 20e3), 1e-6);
  EXPECT_NEAR(soft.natural_frequency, 60.0 * 18.0, 1e-9);
  const device::ServoResponse hard = device::through_tip(arm, 1.0 / 1e6);
  EXPECT_NEAR(hard.natural_frequency, 60.0, 1e-12);
  EXPECT_LT(hard.stiffness, arm.stiffness);
  const auto settled = [&](const device::ServoResponse& figures) {
    PrimitiveHarness control("ForceController", law(20.0, 0.005));
    control.set("wanted", 20.0)
        .set("stiffness", figures.stiffness)
        .set("natural_frequency", figures.natural_frequency)
        .set("damping_ratio", figures.damping_ratio)
        .set("delay", kCycle);
    PressedTool tool{.mass = 100.0, .frequency = 60.0, .surface = 20e3};  // the tip on something hard
    double last = 0.0, touched = 0.0;
    for (int i = 0; i < 4000; ++i) {
      control.set("force", tool.force).step();
      tool.step(*control.get<Real>("velocity"));
      if (tool.force <= 0.0) touched = kCycle * i;
      if (std::abs(tool.force - 20.0) > 1.0) last = kCycle * i;
      EXPECT_LT(tool.force, 22.0);
    }
    return last - touched;
  };
  EXPECT_LT(settled(soft), 0.3);
  EXPECT_LT(settled(soft), 0.5 * settled(arm));
}

TEST(ForceControl, WithoutFiguresAndWithoutAGainNothingMoves) {
  PrimitiveHarness control("ForceController", law(20.0, 0.005));
  control.set("wanted", 20.0).set("force", 0.0).step();
  EXPECT_TRUE(control.is_null("velocity"));
}

/// Stiffness is what a force does to the position loops: M w^2 e = J^T f, tip = J e.
TEST(ForceControl, TheStiffnessOfAnArmIsThatOfItsLoops) {
  DeviceEnvironment devices;
  const device::ArmDescription& arm = devices.arm->description();
  const HarnessOptions options{.environment = &devices};
  const kinematics::JointVector q = arm.home;
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, -2).normalized();
  PrimitiveHarness servo("ServoStiffness", {{"device", "arm"}}, options);
  servo.set("q", JointArray(q)).set("direction", Vector(3.0 * direction)).step();

  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  arm.chain->jacobian(q, X_BF, J);
  const Eigen::Vector3d p = X_BF.linear() * devices.arm->tool().X_FT.translation();
  for (Eigen::Index i = 0; i < J.cols(); ++i) J.col(i).head<3>() += J.col(i).tail<3>().cross(p);
  const device::PayloadSetting& load = devices.arm->tool().payload;
  Eigen::MatrixXd loops = arm.chain->mass_matrix(q, {load.mass, load.p_FC, load.I_C});
  if (arm.armature.size() > 0) loops.diagonal() += arm.armature;
  for (Eigen::Index i = 0; i < loops.cols(); ++i) {
    const double w = arm.natural_frequency.size() > 0 ? arm.natural_frequency[i] : 60.0;
    loops.col(i) *= w * w;
  }
  const Eigen::VectorXd e = loops.partialPivLu().solve(J.topRows<3>().transpose() * direction);
  const double tip = direction.dot(J.topRows<3>() * e);
  EXPECT_NEAR(*servo.get<Real>("stiffness") * tip, 1.0, 1e-9);
  EXPECT_GT(*servo.get<Real>("natural_frequency"), 55.0);
  EXPECT_LT(*servo.get<Real>("natural_frequency"), 85.0);
  EXPECT_NEAR(*servo.get<Real>("damping_ratio"), 1.0, 0.05);
  servo.set_null("q").step();
  EXPECT_TRUE(servo.is_null("stiffness"));
}

TEST(ForceControl, OnSpringsTheStiffnessIsThatOfTheSprings) {
  DeviceEnvironment devices;
  const device::ArmDescription& arm = devices.arm->description();
  kinematics::Jacobian J;
  Eigen::Isometry3d X_BF;
  arm.chain->jacobian(arm.home, X_BF, J);
  device::Compliance springs{.mode = device::ControlMode::kCartesianImpedance,
                             .stiffness = device::JointVector::Constant(6, 200.0),
                             .damping_ratio = device::JointVector::Constant(6, 0.7)};
  springs.stiffness.head(3) << 1000.0, 500.0, 2000.0;
  const Eigen::Matrix3d R = X_BF.linear();
  const device::ServoPosture posture{.q = arm.home, .J_BT = J, .R_BT = R, .payload = {}};
  EXPECT_NEAR(servo_response(arm, springs, posture, Eigen::Vector3d::UnitY()).stiffness, 500.0, 1e-9);
  const Eigen::Vector3d between = Eigen::Vector3d(1, 1, 0).normalized();
  const auto response = servo_response(arm, springs, posture, between);
  EXPECT_NEAR(response.stiffness, 1.0 / (0.5 / 1000.0 + 0.5 / 500.0), 1e-9);
  EXPECT_GT(response.damping_time(), 0.03) << "springs are slow";
  springs.in_tool_axes = true;
  EXPECT_NEAR(servo_response(arm, springs, posture, R * Eigen::Vector3d::UnitZ()).stiffness, 2000.0, 1e-9);
  springs.stiffness[1] = 0.0;
  EXPECT_EQ(servo_response(arm, springs, posture, R * Eigen::Vector3d::UnitY()).stiffness, 0.0);
}

}  // namespace
}  // namespace takt::test
