// A motion that another one has taken over early is not over before the blend leaves it: until then the successor
// carries out its rest, and a cancel of it stops the arm (docs/activity-layer.md).
#include <gtest/gtest.h>

#include "app/interfaces/two_arms.h"
#include "core/activity/dual_entry_motion.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/core/activity/two_arm_cell.h"

namespace takt::activity {
namespace {

class CarriedMotionTest : public testing::Test {
 protected:
  /// How far the tool has gone along the y axis of the base, m.
  double gone() const { return cell.robot.tool().translation().y() - from.y(); }
  double off_the_line() const {
    const Eigen::Vector3d way = cell.robot.tool().translation() - from;
    return std::hypot(way.x(), way.z());
  }
  RunPtr first() {
    return cell.motion.lin_by({0.0, 0.2, 0.0}, {.blend = BlendingCondition::at_distance(0.03)}).schedule();
  }
  RunPtr second(const operations::MotionParameters& parameters = {}) {
    return cell.motion.lin_by({-0.1, 0.0, 0.0}, parameters).schedule();
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) cell.program.step();
  }

  test::ActivityCell cell;
  const Eigen::Vector3d from = cell.robot.tool().translation();
};

TEST_F(CarriedMotionTest, P4_ItEndsWhereTheBlendLeavesItAndThereTheNextOneBegins) {
  const RunPtr a = first(), b = second();
  steps(100);
  ASSERT_TRUE(b->blended()) << "it was taken over early";
  EXPECT_LT(gone(), 0.1);
  EXPECT_EQ(a->state(), RunState::kRunning);
  EXPECT_FALSE(b->started());
  EXPECT_EQ(cell.program.current(), a->name());
  wait(cell.program, a);
  EXPECT_GT(gone(), 0.2 - 0.03 - 1e-3) << "in the blend, not before it";
  EXPECT_LT(gone(), 0.2);
  EXPECT_EQ(a->state(), RunState::kCompleted);
  EXPECT_TRUE(b->started());
  EXPECT_EQ(cell.program.current(), b->name());
  EXPECT_EQ(a->last_cycle() + 1, b->first_cycle()) << "the nets follow each other earlier";
  wait(cell.program, b);
  EXPECT_EQ(b->state(), RunState::kCompleted);
}

TEST_F(CarriedMotionTest, L6_ACancelStopsTheArmOnItsPathWhoeverCarriesItOut) {
  for (const int at : {20, 60, 150, 300}) {
    SCOPED_TRACE(at);
    test::ActivityCell own;
    const Eigen::Vector3d begin = own.robot.tool().translation();
    const RunPtr a =
        own.motion.lin_by({0.0, 0.2, 0.0}, {.velocity = 0.3, .blend = BlendingCondition::at_distance(0.03)}).schedule();
    const RunPtr b = own.motion.lin_by({-0.1, 0.0, 0.0}).schedule();
    for (int i = 0; i < at; ++i) own.program.step();
    ASSERT_TRUE(b->blended());
    ASSERT_EQ(a->state(), RunState::kRunning);
    a->cancel();
    for (int i = 0; i < 2'000 && !(a->over() && b->over()); ++i) own.program.step();
    EXPECT_EQ(a->state(), RunState::kCancelled);
    EXPECT_EQ(b->state(), RunState::kFailed) << "as when it had only waited";
    EXPECT_EQ(b->failure(), RunFailure::kGivenUp);
    EXPECT_TRUE(own.core_arm().at_rest());
    const Eigen::Vector3d way = own.robot.tool().translation() - begin;
    EXPECT_GT(way.y(), 0.0);
    EXPECT_LT(way.y(), 0.17);
    EXPECT_LT(std::hypot(way.x(), way.z()), 1e-5) << "on the line";
    EXPECT_LE(own.worst_limit_share(), 1.0);
  }
}

TEST_F(CarriedMotionTest, ACancelOfTheSuccessorStopsBoth) {
  const RunPtr a = first(), b = second();
  steps(100);
  b->cancel();
  for (int i = 0; i < 2'000 && !(a->over() && b->over()); ++i) steps(1);
  EXPECT_EQ(a->state(), RunState::kCancelled) << "it was never completed";
  EXPECT_EQ(b->state(), RunState::kCancelled);
  EXPECT_LT(off_the_line(), 1e-5);
}

/// What must not hold on the first motion does while the second one carries out the rest of it.
TEST_F(CarriedMotionTest, AFailureOfTheSuccessorFailsBoth) {
  const expression::State slow = is_less(expression::channel<net::Real>(cell.cell, "speed"), 0.5);
  const RunPtr a =
      cell.motion.lin_by({0.0, 0.2, 0.0}, {.blend = BlendingCondition::at_distance(0.03), .abort_if = slow}).schedule();
  const RunPtr b = second();
  steps(100);
  ASSERT_TRUE(b->blended());
  (void)cell.cell.channels.at("speed")->write(0.2);
  for (int i = 0; i < 2'000 && !(a->over() && b->over()); ++i) steps(1);
  EXPECT_EQ(a->state(), RunState::kFailed);
  EXPECT_EQ(b->failure(), RunFailure::kAborted) << b->diagnostics().to_string();
  EXPECT_LT(off_the_line(), 1e-5);
  EXPECT_TRUE(cell.core_arm().at_rest());
}

/// A third one waits until the second is the one that is being done: who stops whom stays clear.
TEST_F(CarriedMotionTest, P4_AChainIsBlendedThroughoutAndEachEndsInItsTurn) {
  const RunPtr a = first();
  const RunPtr b = cell.motion.lin_by({-0.15, 0.0, 0.0}, {.blend = BlendingCondition::at_distance(0.03)}).schedule();
  const RunPtr c = cell.motion.lin_by({0.0, 0.0, 0.1}).schedule();
  std::vector<std::string> order;
  for (int i = 0; i < 20'000 && !c->over(); ++i) {
    steps(1);
    const std::string now = a->over() ? b->over() ? "c" : "b" : "a";
    if (order.empty() || order.back() != now) order.push_back(now);
    EXPECT_FALSE(b->over() && !a->over());
  }
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(b->blended());
  EXPECT_TRUE(c->blended());
  for (const RunPtr& one : {a, b, c}) EXPECT_EQ(one->state(), RunState::kCompleted) << one->diagnostics().to_string();
  EXPECT_EQ(cell.cycles_at_rest(a->first_cycle() + 2, c->last_cycle() - 2), 0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST(CarriedMotionOfTwoArms, P5_ACancelStopsBothOnThePath) {
  test::TwoArmCell cell;
  const app::TwoArms both = cell.pair();
  const RunPtr a = both.lin_by({0.0, 0.0, 0.1}, {.velocity = 0.3, .blend = 0.7}).schedule();
  const RunPtr b = both.lin_by({0.0, 0.1, 0.0}).schedule();
  for (int i = 0; i < 150; ++i) cell.program.step();
  ASSERT_TRUE(b->blended());
  ASSERT_FALSE(a->over());
  a->cancel();
  for (int i = 0; i < 2'000 && !(a->over() && b->over()); ++i) cell.program.step();
  EXPECT_EQ(a->state(), RunState::kCancelled);
  EXPECT_EQ(b->failure(), RunFailure::kGivenUp);
  for (const char* name : {"left", "right"}) EXPECT_TRUE(cell.core.find_arm(name)->at_rest()) << name;
  EXPECT_LT((both.centre().matrix() - both.centre_by_follower().matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

/// A composition that goes on with a motion leaves it where its first part does.
TEST_F(CarriedMotionTest, P4_ACompositionCarriesTheRestToo) {
  const RunPtr a = first();
  const Activity there = cell.motion.lin_by({-0.1, 0.0, 0.0});
  const RunPtr b = sequence({there, cell.motion.lin_by({0.0, 0.0, 0.05})}).schedule();
  steps(100);
  ASSERT_TRUE(b->blended());
  EXPECT_FALSE(a->over());
  wait(cell.program, a);
  EXPECT_GT(gone(), 0.2 - 0.03 - 1e-3);
  wait(cell.program, b);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::activity
