#include "core/kinematics/wheel_drive.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::kinematics {
namespace {

/// The base of the youBot.
constexpr MecanumDrive kDrive{.wheel_radius = 0.0475, .wheelbase = 0.47, .track = 0.3};

Eigen::Vector3d random_twist(Random& random) {
  return {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-2.0, 2.0)};
}

/// Written a second time, from the rollers: the one on the floor is free to roll across its axis, so along the axis the
/// floor, the roller and the rim have one speed. Seen from above the axes on the floor form a diamond.
TEST(MecanumDrive, NoRollerSlipsAlongItsAxis) {
  const double x = 0.5 * kDrive.wheelbase, y = 0.5 * kDrive.track;
  const Eigen::Vector2d places[] = {{x, y}, {x, -y}, {-x, y}, {-x, -y}};
  const Eigen::Vector2d axes[] = {{1, -1}, {1, 1}, {1, 1}, {1, -1}};
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d V = random_twist(random);
    const auto speeds = kDrive.wheel_speeds(V);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d hub(V.x() - V.z() * places[i].y(), V.y() + V.z() * places[i].x());
      const Eigen::Vector2d rim_on_floor(-kDrive.wheel_radius * speeds[i], 0.0);  // against the hub
      EXPECT_NEAR((hub + rim_on_floor).dot(axes[i]), 0.0, 1e-12) << "wheel " << i;
    }
  }
}

TEST(MecanumDrive, OdometryOfWheelsThatDoNotSlipIsTheMotion) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d V = random_twist(random);
    EXPECT_LT((kDrive.body_motion(kDrive.wheel_speeds(V)) - V).norm(), 1e-13);
  }
}

/// A wheel that rolls: its hub moves ahead by radius times angle, and nothing moves it along its axle.
TEST(DifferentialDrive, WheelsRollWhereTheirHubsGo) {
  constexpr DifferentialDrive kTwo{.wheel_radius = 0.24, .track = 0.54};
  Random random(6);
  for (int k = 0; k < 1000; ++k) {
    const Eigen::Vector3d V(random.uniform(-1.0, 1.0), 0.0, random.uniform(-2.0, 2.0));
    const auto speeds = kTwo.wheel_speeds(V);
    for (int i = 0; i < 2; ++i) {
      const double y = i == 0 ? 0.27 : -0.27;
      EXPECT_NEAR(V.x() - V.z() * y, kTwo.wheel_radius * speeds[i], 1e-12) << "wheel " << i;
      EXPECT_LE(std::abs(speeds[i]), kTwo.fastest_wheel(std::abs(V.x()), std::abs(V.z())) + 1e-12);
    }
    EXPECT_LT((kTwo.body_motion(speeds) - V).norm(), 1e-13);
  }
  EXPECT_TRUE(is_nonholonomic(kTwo));
  EXPECT_FALSE(is_nonholonomic(kDrive));
}

TEST(MecanumDrive, WheelsThatDisagreeGiveTheMotionThatFitsBest) {
  Random random(5);
  for (int k = 0; k < 200; ++k) {
    MecanumDrive::Wheels w;
    for (double& one : w) one = random.uniform(-20.0, 20.0);
    const Eigen::Vector3d best = kDrive.body_motion(w);
    const double error = (kDrive.wheel_speeds(best) - w).norm();
    for (int i = 0; i < 3; ++i) {
      for (const double step : {-1e-3, 1e-3}) {
        EXPECT_GE((kDrive.wheel_speeds(best + step * Eigen::Vector3d::Unit(i)) - w).norm(), error);
      }
    }
  }
}

TEST(MecanumDrive, TheFastestWheelIsABoundThatIsReached) {
  Random random(6);
  double most = 0.0;
  for (int k = 0; k < 20'000; ++k) {
    const double angle = random.uniform(-M_PI, M_PI), turn = random.uniform(-0.6, 0.6);
    const double speed =
        kDrive.wheel_speeds({0.4 * std::cos(angle), 0.4 * std::sin(angle), turn}).cwiseAbs().maxCoeff();
    EXPECT_LE(speed, kDrive.fastest_wheel(0.4, 0.6) * (1 + 1e-12));
    most = std::max(most, speed);
  }
  EXPECT_GT(most, 0.99 * kDrive.fastest_wheel(0.4, 0.6));
}

TEST(MecanumDrive, ReflectedInertiaHasTheEnergyOfTheWheels) {
  constexpr double kAxial = 1.3e-3;
  const Eigen::Vector3d reflected = kDrive.reflected_inertia(kAxial);
  Random random(7);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d V = random_twist(random);
    EXPECT_NEAR(reflected.dot(V.cwiseAbs2()), kAxial * kDrive.wheel_speeds(V).squaredNorm(), 1e-12);
  }
}

}  // namespace
}  // namespace takt::kinematics
