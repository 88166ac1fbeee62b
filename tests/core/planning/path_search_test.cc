#include "core/planning/path_search.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/motion/path.h"
#include "core/planning/rounded_path.h"
#include "tests/support/planning_cells.h"

namespace takt::planning {
namespace {

using test::PlanningCell;

constexpr double kMargin = 1e-3;

/// The least distance of any pair of bodies at a posture, all pairs asked afresh: another way than the planner's.
double least_distance(const PlanningCell& cell, const JointVector& q, std::string* who = nullptr) {
  collision::State state = cell.state;
  for (std::size_t j = 0; j < cell.joints.size(); ++j)
    state.q[static_cast<std::size_t>(cell.joints[j])] = q[static_cast<Eigen::Index>(j)];
  collision::Poses poses;
  cell.scene.place(state, poses);
  const std::vector<bool> moved = cell.scene.moved_by(state, cell.joints);
  double least = std::numeric_limits<double>::infinity();
  const int n = static_cast<int>(cell.scene.bodies().size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      const bool either = moved[static_cast<std::size_t>(a)] || moved[static_cast<std::size_t>(b)];
      if (!either || cell.scene.never_meet(a, b) || collision::quick_bound(cell.scene, poses, a, b) > least) continue;
      const double apart = collision::signed_distance(cell.scene, poses, a, b);
      if (apart < least && who != nullptr) *who = cell.scene.body(a).name + " and " + cell.scene.body(b).name;
      least = std::min(least, apart);
    }
  }
  return least;
}

motion::ArmModel model_of(const PlanningCell& cell) {
  return {.chain = *cell.arm->chain, .inverse = nullptr, .limits = cell.arm->limits, .cartesian = cell.arm->cartesian};
}

std::optional<FoundPath> found(const PlanningCell& cell, const PlanningCell::Task& task, std::uint64_t seed = 1) {
  FreeSpace space = cell.free_space();
  return find_path(space, cell.query(task, seed));
}

class WaysAround : public ::testing::TestWithParam<PlanningCell::Kind> {};

TEST_P(WaysAround, KeepTheMarginAtEverySampleOfTheTimedPath) {
  PlanningCell cell(GetParam());
  Random random(5);
  for (int i = 0; i < 3; ++i) {
    const PlanningCell::Task task = cell.draw(random);
    FreeSpace space = cell.free_space();
    const auto path = find_path(space, cell.query(task));
    ASSERT_TRUE(path);
    const motion::ArmModel arm = model_of(cell);
    const auto leg = rounded_path(space, arm, path->points);
    ASSERT_TRUE(leg) << leg.error().to_string();
    const auto plan = motion::plan_sequence(arm, task.start, {[&leg](const JointVector&) { return *leg; }});
    ASSERT_TRUE(plan) << plan.error().to_string();
    EXPECT_LT((plan->motion.q_goal - task.goal).norm(), 1e-9);
    const double period = 4e-3;
    JointVector before = task.start, speed_before = JointVector::Zero(before.size());
    for (double time = 0.0; time < plan->motion.duration(); time += period) {
      const JointVector q = motion::sample(plan->motion.path, {.s = plan->motion.law.at(time).s}).joints.q;
      std::string who;
      ASSERT_GT(least_distance(cell, q, &who), kMargin) << who << " at " << time << " s";
      const JointVector speed = (q - before) / period;
      for (Eigen::Index j = 0; time > 0.0 && j < q.size(); ++j) {
        EXPECT_LE(std::abs(speed[j]), 1.001 * cell.arm->limits.velocity[j]);
        EXPECT_LE(std::abs(speed[j] - speed_before[j]) / period, 1.05 * cell.arm->limits.acceleration[j]);
      }
      before = q;
      speed_before = time > 0.0 ? speed : speed_before;
    }
  }
}

TEST_P(WaysAround, AreTheSameBitsAgainAndDifferWithTheSeed) {
  PlanningCell cell(GetParam());
  Random random(6);
  const PlanningCell::Task task = cell.draw(random);
  const auto first = found(cell, task), again = found(cell, task), other = found(cell, task, 2);
  ASSERT_TRUE(first && again && other);
  EXPECT_EQ(first->points, again->points);
  EXPECT_NE(first->points, other->points);
}

std::string name_of(const ::testing::TestParamInfo<PlanningCell::Kind>& kind) {
  return std::array{"Shelf", "TwoArms", "Container"}[static_cast<std::size_t>(kind.param)];
}
INSTANTIATE_TEST_SUITE_P(Cells, WaysAround,
                         ::testing::Values(PlanningCell::Kind::kShelf, PlanningCell::Kind::kTwoArms,
                                           PlanningCell::Kind::kContainer),
                         name_of);

/// What the proof says of random lines, against postures so close to each other that nothing moves further than 0.5 mm
/// between them.
TEST(FreeSpace, CallsNoLineFreeThatComesTooNear) {
  PlanningCell cell(PlanningCell::Kind::kShelf);
  FreeSpace space = cell.free_space();
  Random random(7);
  int free = 0, blocked = 0;
  for (int i = 0; i < 400; ++i) {
    JointVector from = cell.arm->home, to = from;
    for (Eigen::Index j = 0; j < from.size(); ++j) {
      from[j] += random.uniform(-1.0, 1.0);
      to[j] = from[j] + random.uniform(-0.4, 0.4);
    }
    const bool is_free = space.is_free_line(from, to);
    ++(is_free ? free : blocked);
    constexpr int kSteps = 50;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= kSteps; ++k)
      least = std::min(least, least_distance(cell, from + static_cast<double>(k) / kSteps * (to - from)));
    EXPECT_TRUE(!is_free || least > kMargin) << least;
  }
  EXPECT_GT(free, 50);
  EXPECT_GT(blocked, 50);
}

TEST(FreeSpace, APlateBetweenTwoPosturesIsFound) {
  PlanningCell cell(PlanningCell::Kind::kEmpty);
  JointVector from = cell.arm->home, to = from;
  from[0] = -0.6;
  to[0] = 0.6;
  ASSERT_TRUE(cell.free_space().is_free_line(from, to));
  // As thin as paper, upright where the arm comes past.
  const Eigen::Isometry3d X = cell.arm->chain->forward(cell.arm->home);
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  X_WP.translation() = X.translation();
  cell.scene.add_object("paper", {{.shape = world::Box{{0.4, 1e-4, 0.4}}}}, -1, X_WP);
  cell.scene.find_pairs_that_never_meet();
  cell.state = cell.scene.start();
  FreeSpace space = cell.free_space();
  EXPECT_TRUE(space.is_free(from));
  EXPECT_TRUE(space.is_free(to));
  EXPECT_FALSE(space.is_free_line(from, to));
  const Obstruction found = space.last_obstruction();
  EXPECT_TRUE(cell.scene.body(found.a).name == "paper" || cell.scene.body(found.b).name == "paper");
}

/// Of an object that stands in the world from everything else.
double distance_of(const PlanningCell& cell, int object) {
  collision::Poses poses;
  cell.scene.place(cell.state, poses);
  double least = std::numeric_limits<double>::infinity();
  for (int body = 0; body < object; ++body)
    if (cell.scene.body(body).owner != "table" && !cell.scene.body(body).parts.empty())
      least = std::min(least, collision::signed_distance(cell.scene, poses, body, object));
  return least;
}

TEST(FreeSpace, StartAndGoalBesideAWallAreAdmittedAndTheirDistanceIsKept) {
  PlanningCell cell(PlanningCell::Kind::kEmpty);
  const JointVector q = cell.arm->home;
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  X_WP.translation() = cell.arm->chain->forward(q).translation() + Eigen::Vector3d(0.0, 0.3, 0.0);
  cell.scene.add_object("wall", {{.shape = world::Box{{0.5, 0.02, 0.5}}}}, -1, X_WP);
  cell.scene.find_pairs_that_never_meet();
  cell.state = cell.scene.start();
  const int wall = cell.scene.root_of("wall");
  for (int k = 0; k < 100; ++k)
    cell.state.fixings[static_cast<std::size_t>(wall)].X_P.translation().y() -= distance_of(cell, wall) - 2e-3;
  ASSERT_NEAR(distance_of(cell, wall), 2e-3, 1e-5);
  FreeSpace space = cell.free_space();
  EXPECT_FALSE(space.is_free(q)) << "5 mm are asked for";
  EXPECT_FALSE(space.admit_start(q));
  EXPECT_TRUE(space.is_free(q));
  // Away from the wall is free; into it is not.
  JointVector into = q, away = q;
  into[0] += 0.05;
  away[0] -= 0.3;
  EXPECT_FALSE(space.is_free_line(q, into));
  EXPECT_TRUE(space.is_free_line(q, away));
}

TEST(FreeSpace, AStartInsideOfSomethingIsRefusedWithBothBodies) {
  PlanningCell cell(PlanningCell::Kind::kEmpty);
  const Eigen::Isometry3d X = cell.arm->chain->forward(cell.arm->home);
  cell.scene.add_object("lump", {{.shape = world::Sphere{0.05}}}, -1, X);
  cell.scene.find_pairs_that_never_meet();
  cell.state = cell.scene.start();
  const auto rule = [](int, int) { return collision::PairRule{}; };
  FreeSpace space(cell.scene, cell.state, cell.joints,
                  {.lower = cell.arm->limits.lower, .upper = cell.arm->limits.upper, .rule = rule});
  const auto obstruction = space.admit_start(cell.arm->home);
  ASSERT_TRUE(obstruction);
  EXPECT_EQ(std::max(obstruction->a, obstruction->b), cell.scene.root_of("lump"));
  EXPECT_LT(obstruction->distance, 0.0);
  FreeSpace other = cell.free_space();
  EXPECT_TRUE(other.admit_goal(cell.arm->home));
}

TEST(PathSearch, SaysNoWhereThereIsNoPathAndWhatIsInTheWay) {
  PlanningCell cell(PlanningCell::Kind::kEmpty);
  // A wall through the axis of the first joint, with a hole for the foot of the arm, which its elbow does not fit
  // through.
  const auto at = [](double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(0.0, y, z)); };
  cell.scene.add_object("wall",
                        {{.shape = world::Box{{0.02, 2.0, 3.0}}, .X_OS = at(1.2, 1.45)},
                         {.shape = world::Box{{0.02, 2.0, 3.0}}, .X_OS = at(-1.2, 1.45)},
                         {.shape = world::Box{{0.02, 0.4, 2.4}}, .X_OS = at(0.0, 1.8)}},
                        -1, Eigen::Isometry3d::Identity());
  cell.scene.find_pairs_that_never_meet();
  cell.state = cell.scene.start();
  PlanningCell::Task task{.start = cell.arm->home, .goal = cell.arm->home};
  task.start[0] = 0.1;
  task.goal[0] = 2.9;
  FreeSpace space = cell.free_space();
  ASSERT_FALSE(space.admit_start(task.start));
  ASSERT_FALSE(space.admit_goal(task.goal));
  Query query = cell.query(task);
  query.looks = 20'000;
  const std::int64_t before = space.looks();
  EXPECT_FALSE(find_path(space, query));
  EXPECT_LT(space.looks() - before, 2 * query.looks) << "the effort is bounded";
  const Obstruction most = space.most_frequent_obstruction();
  ASSERT_GE(most.a, 0);
  EXPECT_EQ(std::max(most.a, most.b), cell.scene.root_of("wall"));
}

// -- Beside what others move
// ---------------------------------------------------------------------------------------------------

/// Two arms; the neighbour turns its first joint from one side to the other, and its gripper with it.
class BesideANeighbour : public ::testing::Test {
 protected:
  BesideANeighbour() {
    const auto& joints = cell.scene.joints();
    const auto first = std::ranges::find_if(joints, [](const auto& name) { return name.starts_with("neighbour/"); });
    turning = static_cast<int>(first - joints.begin());
    put_neighbour();
    motion = {.duration = 1.0, .joints = {turning}, .acceleration = {0.0}, .at = {}};
    motion.at = [this](double time, std::vector<double>& q) { q[static_cast<std::size_t>(turning)] = turn_at(time); };
    const std::vector<bool> moved = cell.scene.moved_by(cell.state, motion.joints);
    for (std::size_t body = 0; body < moved.size(); ++body)
      if (moved[body]) bodies.push_back(static_cast<int>(body));
  }
  static double turn_at(double time) { return -0.9 + 0.6 * time; }
  static constexpr double kReaching[] = {0.0, -0.6, 0.0, 1.2, 0.0, -0.7, 0.0};
  void put_neighbour() {
    for (std::size_t j = 0; j < 7; ++j) cell.state.q[static_cast<std::size_t>(turning) + j] = kReaching[j];
  }
  /// Of the own arm: reaching into the middle too.
  static JointVector drawn(Random& random) {
    JointVector q(7);
    for (Eigen::Index j = 0; j < 7; ++j) q[j] = kReaching[j] + random.uniform(-0.6, 0.6);
    return q;
  }

  [[nodiscard]] FreeSpace space_beside(const collision::SweptSpace& swept) const {
    return FreeSpace(cell.scene, cell.state, cell.joints,
                     {.lower = cell.arm->limits.lower, .upper = cell.arm->limits.upper, .rule = {}, .swept = &swept});
  }
  [[nodiscard]] collision::SweptSpace swept() const {
    collision::SweptSpace space;
    collision::add_swept(cell.scene, cell.state, motion, bodies, 0.01, 0.0, space.source("turn"), space);
    return space;
  }
  /// The least distance at an own posture, wherever the neighbour is on its way.
  [[nodiscard]] double least_distance_beside(const JointVector& q) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 50; ++k) {
      cell.state.q[static_cast<std::size_t>(turning)] = turn_at(k / 50.0);
      least = std::min(least, least_distance(cell, q));
    }
    return least;
  }

  PlanningCell cell{PlanningCell::Kind::kTwoArms};
  int turning = 0;
  collision::Trajectory motion;
  std::vector<int> bodies;
};

/// What the proof says of random lines, against the neighbour at many places on its way.
TEST_F(BesideANeighbour, CallsNoLineFreeThatComesTooNearToWhatItSweeps) {
  const collision::SweptSpace space_swept = swept();
  FreeSpace space = space_beside(space_swept);
  Random random(3);
  int free = 0, blocked = 0;
  for (int i = 0; i < 60; ++i) {
    const JointVector from = drawn(random);
    JointVector to = from;
    for (Eigen::Index j = 0; j < to.size(); ++j) to[j] += random.uniform(-0.2, 0.2);
    const bool is_free = space.is_free_line(from, to);
    ++(is_free ? free : blocked);
    for (int k = 0; is_free && k <= 4; ++k) EXPECT_GT(least_distance_beside(from + k / 4.0 * (to - from)), kMargin);
  }
  EXPECT_GT(free, 5);
  EXPECT_GT(blocked, 5);
}

TEST_F(BesideANeighbour, WhatItSweepsCountsInPlaceOfWhereItStands) {
  collision::SweptSpace elsewhere;
  for (const int body : bodies) elsewhere.bodies[body] = {};
  Random random(8);
  int blocked = 0;
  for (int i = 0; i < 2000 && blocked < 5; ++i) {
    const JointVector q = drawn(random);
    cell.state.q[static_cast<std::size_t>(turning)] = 3.0;  // it looks away
    if (!cell.free_space().is_free(q)) continue;
    cell.state.q[static_cast<std::size_t>(turning)] = -0.3;
    if (cell.free_space().is_free(q)) continue;
    ++blocked;
    EXPECT_TRUE(space_beside(elsewhere).is_free(q));
    cell.state.q[static_cast<std::size_t>(turning)] = 3.0;
    EXPECT_FALSE(space_beside(swept()).is_free(q)) << "it comes by there";
  }
  EXPECT_EQ(blocked, 5);
}

TEST_F(BesideANeighbour, AStartWithinWhatItSweepsMayBeLeftAndAGoalThereIsRefused) {
  const collision::SweptSpace space_swept = swept();
  Random random(5);
  JointVector inside;
  for (int i = 0; i < 2000 && inside.size() == 0; ++i) {
    const JointVector q = drawn(random);
    collision::SweptSpace nothing;
    for (const int body : bodies) nothing.bodies[body] = {};
    FreeSpace without = space_beside(nothing), beside = space_beside(space_swept);
    if (without.is_free(q) && !beside.is_free(q)) inside = q;
  }
  ASSERT_GT(inside.size(), 0);
  FreeSpace as_goal = space_beside(space_swept);
  const auto refused = as_goal.admit_goal(inside);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->source, 0);
  EXPECT_GE(refused->from, 0.0);
  EXPECT_LE(refused->to, motion.duration);
  EXPECT_THAT(cell.scene.body(refused->b).name, ::testing::StartsWith("neighbour"));
  FreeSpace as_start = space_beside(space_swept);
  EXPECT_FALSE(as_start.admit_start(inside));
  EXPECT_TRUE(as_start.is_free(inside));
}

}  // namespace
}  // namespace takt::planning
