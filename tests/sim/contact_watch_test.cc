// What presses one way, of touches that push against each other.
#include "sim/contact/contact_watch.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace takt::sim::contact_watch_test {
namespace {

using Eigen::Vector3d;

TEST(PressingForce, OpposingTouchesDoNotCancel) {
  EXPECT_EQ(pressing_force({}), 0.0);
  const std::vector<Vector3d> fingers{{42.0, 0.0, 3.0}, {-42.0, 0.0, 3.0}};
  EXPECT_NEAR(pressing_force(fingers), fingers[0].norm(), 1e-9) << "N: what one finger presses with, not 6";
  const std::vector<Vector3d> slot{{0.0, 20.0, 0.0}, {0.0, -20.0, 0.0}, {0.0, 0.0, 5.0}};
  EXPECT_NEAR(pressing_force(slot), std::hypot(20.0, 5.0), 1e-9) << "a ball between two walls, on the floor";
  const double half = 0.5 * std::sqrt(3.0);
  const std::vector<Vector3d> chuck{{10.0, 0.0, 0.0}, {-5.0, 10.0 * half, 0.0}, {-5.0, -10.0 * half, 0.0}};
  EXPECT_NEAR(pressing_force(chuck), 10.0, 1e-9) << "three jaws";
}

/// A face that is made of many shapes is pressed as hard as one of a single shape.
TEST(PressingForce, TouchesThatPushOneWayAddUp) {
  const std::vector<Vector3d> face(16, Vector3d(0.5, 0.0, 2.0));
  EXPECT_NEAR(pressing_force(face), 16.0 * Vector3d(0.5, 0.0, 2.0).norm(), 1e-9);
}

/// It is the greatest resultant of any of them together: never less than that of all, of one, or of any other choice.
TEST(PressingForce, IsTheGreatestResultantOfAnyOfThem) {
  std::mt19937 random(39);
  std::normal_distribution<double> part(0.0, 10.0);
  int missed = 0;
  constexpr int kCases = 500;
  for (int i = 0; i < kCases; ++i) {
    std::vector<Vector3d> forces(2 + static_cast<std::size_t>(i % 7));
    for (Vector3d& force : forces) force = {part(random), part(random), part(random)};
    double greatest = 0.0;
    for (unsigned chosen = 1; chosen < 1u << forces.size(); ++chosen) {
      Vector3d sum = Vector3d::Zero();
      for (std::size_t k = 0; k < forces.size(); ++k)
        if (chosen >> k & 1u) sum += forces[k];
      greatest = std::max(greatest, sum.norm());
    }
    const double pressing = pressing_force(forces);
    ASSERT_LE(pressing, greatest + 1e-9);
    ASSERT_GE(pressing, 0.95 * greatest) << "case " << i;
    missed += pressing < greatest - 1e-9 ? 1 : 0;
  }
  EXPECT_LT(missed, kCases / 10) << "it climbs from each force, and seldom ends below the top";
}

}  // namespace
}  // namespace takt::sim::contact_watch_test
