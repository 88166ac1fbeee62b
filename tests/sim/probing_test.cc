// A ball of 5 mm radius touches a clamped block: contacts must be stiff enough to measure with and soft enough to stop.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

constexpr double kBallRadius = 0.005;
constexpr double kThreshold = 5.0;  // N, where braking begins
constexpr double kJerk = 100.0;     // m/s^3, of the LWR's device file

/// A straight line at constant speed that brakes with limited jerk once told to. Position by resolved rates.
class Line {
 public:
  Line(JointVector q, const Eigen::Vector3d& direction, double speed)
      : chain_(lwr_chain()), q_(std::move(q)), direction_(direction), speed_(speed) {}

  void brake() { braking_ = true; }
  [[nodiscard]] bool at_rest() const { return brake_time_ >= duration(); }

  device::ArmSetPoint next() {
    const double dt = 1e-3;
    if (braking_) brake_time_ = std::min(brake_time_ + dt, duration());
    ramp_ = std::min(ramp_ + dt / 0.2, 1.0);
    const double s = brake_time_ / duration();
    // Half the way with full jerk down, half with full jerk up.
    const double rate = s < 0.5 ? 1.0 - 2.0 * s * s : 2.0 * (1.0 - s) * (1.0 - s);
    kinematics::Vector6 twist = kinematics::Vector6::Zero();
    twist.head<3>() = direction_ * (speed_ * rate * ramp_ * ramp_ * (3.0 - 2.0 * ramp_));
    Pose X_BF;
    kinematics::Jacobian J;
    chain_.jacobian(q_, X_BF, J);
    const JointVector dq = J.completeOrthogonalDecomposition().solve(twist);
    const JointVector ddq = (dq - dq_) / dt;
    q_ += dq * dt;
    dq_ = dq;
    return set_point(q_, dq, ddq);
  }

 private:
  [[nodiscard]] double duration() const { return 2.0 * std::sqrt(speed_ / kJerk); }

  kinematics::Chain chain_;
  JointVector q_;
  JointVector dq_ = JointVector::Zero(7);
  Eigen::Vector3d direction_;
  double speed_;
  bool braking_ = false;
  double brake_time_ = 0.0;
  double ramp_ = 0.0;
};

struct Touch {
  double max_force = 0.0;          // N, true, of all physics steps
  double at_detection = 0.0;       // m, ball's deepest point beyond the surface when the threshold was met
  double at_rest = 0.0;            // m, likewise after braking
  double force_at_rest = 0.0;      // N
  double force_range_after = 0.0;  // N, spread over the last 0.2 s: chatter
};

/// @param direction  towards the block, in the world; the surface lies `gap` beyond the ball
Touch touch(const Eigen::Vector3d& direction, double speed, Nanoseconds timestep = kMillisecond) {
  WorldDescription description;
  description.physics.timestep = timestep;
  description.robots.push_back(lwr());
  add_probe(description);
  description.arms.push_back(lwr_controller());
  const double gap = std::max(0.004, speed * 0.3);
  const Eigen::Vector3d size(0.12, 0.08, 0.06);
  World empty = make(description);
  const Eigen::Vector3d ball = empty.body_pose(empty.body("probe/tcp")).translation();
  const double half = 0.5 * size.cwiseProduct(direction).norm();
  description.objects.push_back(box("block", size, ball + direction * (kBallRadius + gap + half)));
  World world = make(description);
  const std::size_t watch = *world.watch_contact("probe", "block");
  const int body = world.body("probe/tcp");
  const auto depth = [&] { return (world.body_pose(body).translation() - ball).dot(direction) - gap; };

  hold(world, lwr_home(), 200);
  const Eigen::Vector3d tare = wrench(world).wrench.force;
  Line line(lwr_home(), direction, speed);
  Touch touch;
  bool met = false;
  for (int k = 0; k < 20'000 && !line.at_rest(); ++k) {
    world.arm("arm")->write(line.next());
    EXPECT_TRUE(world.step());
    if (met || (wrench(world).wrench.force - tare).norm() < kThreshold) continue;
    met = true;
    touch.at_detection = depth();
    line.brake();
  }
  EXPECT_TRUE(met);
  for (int k = 0; k < 500; ++k) EXPECT_TRUE(world.step());
  double least = 1e9, most = 0.0;
  for (int k = 0; k < 200; ++k) {
    EXPECT_TRUE(world.step());
    least = std::min(least, world.contact(watch).force);
    most = std::max(most, world.contact(watch).force);
  }
  touch.max_force = world.contact(watch).max_force;
  touch.at_rest = depth();
  touch.force_at_rest = world.contact(watch).force;
  touch.force_range_after = most - least;
  return touch;
}

class Probing : public testing::TestWithParam<Eigen::Vector3d> {};

TEST_P(Probing, SlowTouchStaysBelow15Newton) {
  const Touch slow = touch(GetParam(), 0.005);
  EXPECT_LT(slow.max_force, 15.0);
  EXPECT_GT(slow.max_force, kThreshold);
  EXPECT_LT(slow.force_range_after, 0.1) << "a contact at rest must not chatter";
  EXPECT_GT(slow.force_at_rest, 1.0) << "the arm leans on the block after braking";
}

TEST_P(Probing, FastTouchExceeds15Newton) { EXPECT_GT(touch(GetParam(), 0.05).max_force, 15.0); }

TEST_P(Probing, SurfaceGivesLittle) {
  // What the ball sinks in is an error of the measured place; 0.3 mm is all there is for everything.
  const Touch slow = touch(GetParam(), 0.005);
  EXPECT_LT(slow.at_detection, 0.05e-3);
  EXPECT_GT(slow.at_detection, 0.0);
  EXPECT_LT(slow.at_rest, 0.05e-3);
}

TEST_P(Probing, HalfTheTimestepGivesTheSameTouch) {
  const Touch one = touch(GetParam(), 0.005);
  const Touch half = touch(GetParam(), 0.005, kMillisecond / 2);
  EXPECT_NEAR(one.max_force, half.max_force, 0.1 * half.max_force);
  EXPECT_NEAR(one.at_detection, half.at_detection, 0.02e-3);
}

INSTANTIATE_TEST_SUITE_P(Directions, Probing,
                         testing::Values(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0),
                                         Eigen::Vector3d(1, 0, 0)));

}  // namespace
}  // namespace takt::sim::test
