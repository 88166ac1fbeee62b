// Planning beside the cycle: what takes long costs no cycle (docs/realtime.md).
#include "core/activity/planning_thread.h"

#include <chrono>
#include <semaphore>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "tests/core/activity/activity_cell.h"

namespace takt::activity {
namespace {

using namespace std::chrono_literals;

/// Plans like another one, but not before it may.
class HeldUp final : public ActivityModel {
 public:
  HeldUp(ActivityPtr inner, std::binary_semaphore& may)
      : ActivityModel(inner->name()), inner_(std::move(inner)), may_(may) {}
  [[nodiscard]] std::vector<std::string> actuators() const override { return inner_->actuators(); }
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    may_.acquire();
    return inner_->prepare(planning);
  }

 private:
  ActivityPtr inner_;
  std::binary_semaphore& may_;
};

class ThrowsInPlanning final : public ActivityModel {
 public:
  ThrowsInPlanning() : ActivityModel("ill") {}
  [[nodiscard]] std::vector<std::string> actuators() const override { return {"arm"}; }
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext&) const override {
    throw std::runtime_error("no idea");
  }
};

class PlanningThreadTest : public testing::Test {
 protected:
  /// One cycle, and a look of the program behind it.
  void step() {
    cell.step();
    const auto news = cell.core.events();
    events.insert(events.end(), news.begin(), news.end());
    look();
  }
  void look() {
    scheduler.poll();
    events.clear();
  }
  /// Steps until the run is over; the planning thread has its time meanwhile.
  void run_to_end(const RunPtr& run) {
    for (int i = 0; i < 30'000 && !run->over(); ++i) {
      if (run->state() == RunState::kQueued) std::this_thread::sleep_for(1ms);
      step();
    }
  }
  ActivityPtr lin(double x, double y, double z, const operations::MotionParameters& how = {}) {
    return cell.motion.lin(cell.moved(x, y, z), how).model();
  }

  test::ActivityCell cell;
  std::vector<rcc::Event> events;
  PlanningThread planning;
  Scheduler scheduler{cell.core, cell.cell, {.margin_cycles = 40}, {.planning = &planning, .events = &events}};
  std::binary_semaphore may{0};
};

TEST_F(PlanningThreadTest, CyclesGoOnWhileAPlanIsMade) {
  step();
  const RunPtr run = scheduler.schedule(std::make_shared<HeldUp>(lin(0.0, 0.1, 0.0), may));
  for (int i = 0; i < 100; ++i) step();
  EXPECT_EQ(run->state(), RunState::kQueued) << "a hundred cycles have passed, and nobody waited for the plan";
  may.release();
  run_to_end(run);
  EXPECT_EQ(run->state(), RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_GT(run->first_cycle(), 100);
  EXPECT_LT(cell.nearest_to(cell.moved(0.0, 0.0, 0.0).translation()), 1e-6) << "the tool is where it was to go";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(PlanningThreadTest, AMotionIsTakenOverInMotionByAPlanThatCameLater) {
  step();
  const RunPtr first = scheduler.schedule(lin(0.0, 0.1, 0.0, {.blend = 0.6}));
  while (first->state() != RunState::kRunning) {
    std::this_thread::sleep_for(1ms);
    step();
  }
  const RunPtr second = scheduler.schedule(std::make_shared<HeldUp>(lin(-0.1, 0.1, 0.0), may));
  for (int i = 0; i < 10; ++i) step();  // it is planned from where the first one will be in some 40 cycles
  may.release();
  while (second->state() == RunState::kQueued) {
    std::this_thread::sleep_for(1ms);
    look();
  }
  run_to_end(second);
  EXPECT_EQ(second->state(), RunState::kCompleted) << second->diagnostics().to_string();
  EXPECT_TRUE(second->blended());
  EXPECT_EQ(second->first_cycle(), first->last_cycle() + 1);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(PlanningThreadTest, WhatIsCancelledWhileItIsPlannedNeverBegins) {
  step();
  const RunPtr run = scheduler.schedule(std::make_shared<HeldUp>(lin(0.0, 0.1, 0.0), may));
  step();
  run->cancel();
  step();
  EXPECT_EQ(run->state(), RunState::kCancelled);
  may.release();
  const RunPtr next = scheduler.schedule(lin(0.0, 0.05, 0.0));
  run_to_end(next);
  EXPECT_EQ(next->state(), RunState::kCompleted);
  EXPECT_EQ(run->first_cycle(), -1);
  EXPECT_TRUE(scheduler.idle());
}

TEST_F(PlanningThreadTest, AnExceptionOfAPlannerFailsItsRunOnly) {
  step();
  const RunPtr run = scheduler.schedule(std::make_shared<ThrowsInPlanning>());
  run_to_end(run);
  ASSERT_EQ(run->state(), RunState::kFailed);
  ASSERT_FALSE(run->diagnostics().list().empty());
  EXPECT_EQ(run->diagnostics().list().front().code, Code::kInternal);
  const RunPtr next = scheduler.schedule(lin(0.0, 0.05, 0.0));
  run_to_end(next);
  EXPECT_EQ(next->state(), RunState::kCompleted);
}

TEST(PlanningThread, DoesItsWorkInOrderAndForgetsWhatHasNotBegun) {
  std::string order;
  std::binary_semaphore begun{0}, go_on{0};
  {
    PlanningThread thread;
    thread.submit([&] {
      order += "a";
      begun.release();
      go_on.acquire();
    });
    thread.submit([&] { order += "b"; });
    begun.acquire();
    std::jthread end([&go_on] {
      std::this_thread::sleep_for(20ms);
      go_on.release();
    });
  }
  EXPECT_TRUE(order == "a" || order == "ab") << order;
  EXPECT_EQ(order.front(), 'a');
}

}  // namespace
}  // namespace takt::activity
