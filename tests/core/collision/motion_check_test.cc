#include "core/collision/motion_check.h"

#include <array>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/collision/body_pair.h"
#include "core/collision/swept_space.h"

namespace takt::collision {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

kinematics::RobotModel model_of(const std::string& name) {
  auto model = kinematics::RobotModel::load("models/" + name + "/" + name + ".urdf");
  EXPECT_TRUE(model.has_value());
  return *model;
}

Eigen::Isometry3d moved_to(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  return X;
}

world::Object::Part box(double x, double y, double z) { return {.shape = world::Box{{x, y, z}}}; }

/// All joints from one posture to another, at rest at both ends: a cubic in time.
Trajectory between(const std::vector<double>& from, const std::vector<double>& to, double duration) {
  Trajectory motion;
  motion.duration = duration;
  for (std::size_t j = 0; j < from.size(); ++j) {
    motion.joints.push_back(static_cast<int>(j));
    motion.acceleration.push_back(6.0 * std::abs(to[j] - from[j]) / (duration * duration));
  }
  motion.at = [=](double time, std::vector<double>& q) {
    const double u = time / duration, s = u * u * (3.0 - 2.0 * u);
    for (std::size_t j = 0; j < from.size(); ++j) q[j] = from[j] + s * (to[j] - from[j]);
  };
  return motion;
}

/// The least distance of any pair that the check looks at, found another way: all pairs at each of many times, which
/// lie so close that no point moves further than 0.1 mm, or than the pairs are apart, from one to the next.
double least_distance(const Scene& scene, const Trajectory& motion, const std::vector<double>& change) {
  constexpr double kReach = 2.0, kPeak = 1.5, kFine = 1e-4;  // m; of the speed of a cubic; m
  double speed = 0.0;
  for (const double one : change) speed += kReach * kPeak * std::abs(one) / motion.duration;
  State state = scene.start();
  Poses poses;
  const std::vector<bool> moved = scene.moved_by(state, motion.joints);
  const int n = static_cast<int>(scene.bodies().size());
  std::vector<BodyPair> pairs;
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if ((moved[static_cast<std::size_t>(a)] || moved[static_cast<std::size_t>(b)]) && !scene.never_meet(a, b))
        pairs.emplace_back(scene, a, b);
  double least = 1e9;
  for (double time = 0.0; time <= motion.duration;) {
    motion.at(time, state.q);
    scene.place(state, poses);
    double now = 1.0;
    for (BodyPair& pair : pairs) now = std::min(now, pair.distance(poses, now));
    least = std::min(least, now);
    if (least <= 0.0) return 0.0;
    time += std::max(kFine, 0.5 * now) / speed;
  }
  return least;
}

class OfOneArm : public ::testing::Test {
 protected:
  OfOneArm() {
    EXPECT_TRUE(scene.add_robot("arm", model_of("lwr4plus"), -1, moved_to(0, 0, 0.75)).empty());
    scene.add_object("table", {box(1.0, 0.8, 0.05)}, -1, moved_to(0.75, 0, 0.725));
    scene.add_object("post", {{.shape = world::Cylinder{0.03, 0.8}}}, -1, moved_to(0.4, 0.35, 1.16));
    scene.find_pairs_that_never_meet();
  }
  Scene scene;
};

TEST_F(OfOneArm, StandsFreeOfItself) {
  const std::vector<bool> all(scene.bodies().size(), true);
  EXPECT_THAT(check_state(scene, scene.start(), all, {}), IsEmpty());
}

TEST_F(OfOneArm, AThinPlateBetweenTwoSamplesIsFound) {
  Scene thin;
  ASSERT_TRUE(thin.add_robot("arm", model_of("lwr4plus"), -1, moved_to(0, 0, 0)).empty());
  thin.add_object("plate", {box(0.0002, 0.5, 0.5)}, -1, moved_to(0.0, 0.6, 0.6));
  thin.find_pairs_that_never_meet();
  // The outstretched arm sweeps through it at 10 rad/s: 30 mm from sample to sample.
  std::vector<double> from(7, 0.0), to(7, 0.0);
  from[1] = to[1] = -0.8;
  from[0] = 0.8, to[0] = 2.4;
  const std::vector<Hit> hits = check_motion(thin, thin.start(), between(from, to, 0.24), {});
  ASSERT_FALSE(hits.empty());
  EXPECT_EQ(thin.body(hits.front().b).name, "plate");
}

TEST_F(OfOneArm, TheFirstHitTellsBodiesTimeJointsAndDepth) {
  std::vector<double> from(7, 0.0), to(7, 0.0);
  to[1] = -2.05;  // down into the table
  const std::vector<Hit> hits = check_motion(scene, scene.start(), between(from, to, 2.0), {});
  ASSERT_FALSE(hits.empty());
  const Hit& hit = hits.front();
  EXPECT_EQ(scene.body(hit.a).owner, "arm");
  EXPECT_EQ(scene.body(hit.b).name, "table");
  EXPECT_LT(hit.distance, -0.01);
  EXPECT_GT(hit.time, 0.5);
  EXPECT_LT(hit.time, 2.0);
  State state = scene.start();
  state.q = hit.q;
  Poses poses;
  scene.place(state, poses);
  EXPECT_LE(distance(scene, poses, hit.a, hit.b), 1e-3);
}

// A day of slow motion: samples are a hundred thousand times as far apart, and the bound of each step finds the same.
TEST_F(OfOneArm, ASlowMotionCollidesWhereTheFastOneDoes) {
  constexpr double kFast = 2.0, kSlow = 86400.0;
  std::vector<double> from(7, 0.0), to(7, 0.0);
  to[1] = -2.05;
  const std::vector<Hit> fast = check_motion(scene, scene.start(), between(from, to, kFast), {});
  Trajectory motion = between(from, to, kSlow);
  const std::vector<double> as_if_fast = between(from, to, kFast).acceleration, truly = motion.acceleration;
  motion.acceleration = as_if_fast;
  motion.acceleration_between = [&truly](double, double, std::vector<double>& most) { most = truly; };
  const std::vector<Hit> slow = check_motion(scene, scene.start(), motion, {});
  ASSERT_EQ(slow.size(), fast.size());
  for (std::size_t i = 0; i < fast.size(); ++i) {
    EXPECT_EQ(slow[i].a, fast[i].a);
    EXPECT_EQ(slow[i].b, fast[i].b);
    EXPECT_NEAR(slow[i].time / kSlow, fast[i].time / kFast, 5e-3);
  }
}

TEST_F(OfOneArm, WhatIsIgnoredOrLeftIsNoHit) {
  std::vector<double> from(7, 0.0), to(7, 0.0);
  to[1] = -2.05;
  CheckOptions options;
  options.rule = [](int, int) { return PairRule{.kind = PairRule::Kind::kIgnored}; };
  EXPECT_THAT(check_motion(scene, scene.start(), between(from, to, 2.0), options), IsEmpty());
  // Out of the table again: they are in contact at the beginning, and part.
  options.rule = [](int, int) { return PairRule{.kind = PairRule::Kind::kLeave}; };
  EXPECT_THAT(check_motion(scene, scene.start(), between(to, from, 2.0), options), IsEmpty());
  EXPECT_FALSE(check_motion(scene, scene.start(), between(to, from, 2.0), {}).empty());
  // From a light touch into it.
  std::vector<double> touching = to;
  touching[1] = -1.75;
  EXPECT_FALSE(check_motion(scene, scene.start(), between(touching, to, 2.0), options).empty());
}

TEST_F(OfOneArm, WhatStandsOnSomethingMayTouchItButNotSinkIn) {
  Scene stack;
  stack.add_object("table", {box(1, 1, 0.1)}, -1, moved_to(0, 0, 0));
  stack.add_object("part", {box(0.1, 0.1, 0.1)}, -1, moved_to(0, 0, 0.0999));
  stack.find_pairs_that_never_meet();
  const std::vector<bool> all(2, true);
  CheckOptions options;
  EXPECT_THAT(check_state(stack, stack.start(), all, options), SizeIs(1));
  options.rule = [](int, int) { return PairRule{.kind = PairRule::Kind::kTouch, .overlap = 1e-3}; };
  EXPECT_THAT(check_state(stack, stack.start(), all, options), IsEmpty());
  State sunk = stack.start();
  sunk.fixings[1].X_P = moved_to(0, 0, 0.095);
  EXPECT_THAT(check_state(stack, sunk, all, options), SizeIs(1));
}

/// Random motions of three robots among boxes: nothing that touches is missed, and what is reported comes within the
/// margin. TAKT_MOTIONS=10000 tries that many.
TEST(CheckMotion, MissesNothingAndReportsNothingBeyondTheMargin) {
  const char* wanted = std::getenv("TAKT_MOTIONS");
  const int motions = wanted ? std::atoi(wanted) : 90;
  const std::array<std::string, 3> robots{"lwr4plus", "ur5", "tx90"};
  Random random(11);
  int hit = 0, free = 0;
  for (int round = 0; round < motions; ++round) {
    Scene scene;
    ASSERT_TRUE(
        scene.add_robot("arm", model_of(robots[static_cast<std::size_t>(round % 3)]), -1, moved_to(0, 0, 0)).empty());
    for (int i = 0; i < 12; ++i) {
      const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
      if (std::hypot(x, y) < 0.4) continue;
      scene.add_object("box " + std::to_string(i), {box(0.1, 0.15, 0.2)}, -1, moved_to(x, y, random.uniform(0, 1)));
    }
    scene.find_pairs_that_never_meet();
    const std::size_t joints = scene.joints().size();
    std::vector<double> from(joints), to(joints), change(joints);
    for (std::size_t j = 0; j < joints; ++j) {
      change[j] = random.uniform(-0.6, 0.6);
      from[j] = random.uniform(-1.5, 1.5);
      to[j] = from[j] + change[j];
    }
    const Trajectory motion = between(from, to, 1.0);
    const double least = least_distance(scene, motion, change);
    const std::vector<Hit> hits = check_motion(scene, scene.start(), motion, {});
    if (least <= 0.0) {
      EXPECT_FALSE(hits.empty()) << round;
    }
    constexpr double kMargin = 1e-3, kBetweenLooks = 1e-4;
    if (!hits.empty()) {
      EXPECT_LE(least, kMargin + kBetweenLooks) << round;
    }
    (hits.empty() ? free : hit) += 1;
  }
  EXPECT_GT(hit, motions / 5);
  EXPECT_GT(free, motions / 5);
}

/// Random points of bodies at random times: each is as near to where one of the poses has it as that pose says.
TEST_F(OfOneArm, SweepsNoPointThatItsPosesLeaveOut) {
  Random random(11);
  std::vector<double> from(7), to(7);
  for (std::size_t j = 0; j < 7; ++j) {
    from[j] = random.uniform(-1.5, 1.5);
    to[j] = random.uniform(-1.5, 1.5);
  }
  const Trajectory motion = between(from, to, 1.3);
  const std::vector<int> bodies{scene.find("arm/link5"), scene.find("arm/link7"), scene.root_of("post")};
  ASSERT_THAT(bodies, ::testing::Each(::testing::Ge(0)));
  SweptSpace swept;
  add_swept(scene, scene.start(), motion, bodies, 0.01, 2.0, swept.source("turn"), swept);
  ASSERT_THAT(swept.bodies, SizeIs(3));
  EXPECT_THAT(swept.bodies[bodies[2]], SizeIs(1)) << "it stands";
  State state = scene.start();
  Poses poses;
  for (int i = 0; i < 300; ++i) {
    const double time = random.uniform(0.0, motion.duration);
    motion.at(time, state.q);
    scene.place(state, poses);
    for (const int body : bodies) {
      const Eigen::AlignedBox3d& box = scene.body(body).box;
      const Eigen::Vector3d share(random.unit(), random.unit(), random.unit());
      const Eigen::Vector3d p = box.min() + share.cwiseProduct(box.sizes());
      bool covered = false;
      for (const SweptPose& pose : swept.bodies[body]) {
        const double away = (poses[static_cast<std::size_t>(body)] * p - pose.X_WB * p).norm();
        covered = covered || away <= pose.within + 1e-12;
      }
      EXPECT_TRUE(covered) << scene.body(body).name << " at " << time << " s";
    }
  }
  // From one pose to the next the last link travels at most the spacing, or what it does in one sample of 4 ms.
  const std::vector<SweptPose>& last = swept.bodies[bodies[1]];
  EXPECT_GT(last.size(), 50U);
  for (const SweptPose& pose : last) EXPECT_LT(pose.within, 0.015);
  EXPECT_EQ(last.front().time, 2.0);
  EXPECT_NEAR(last.back().time, 3.3, 1e-9);
  EXPECT_EQ(swept.sources.at(static_cast<std::size_t>(last.front().source)), "turn");
}

}  // namespace
}  // namespace takt::collision
