// How a press has ended, as a program in C++ asks for it: of runs that have failed, too.
#include <functional>

#include <fmt/format.h>

#include "app/interfaces/actuator_interfaces.h"
#include "core/expression/device_sensors.h"
#include "core/operations/force/pressing.h"
#include "tests/core/activity/fixture.h"

namespace takt::operations {
namespace {

class PressOutcomeTest : public test::ActivityTest {
 protected:
  /// From above the block, tared. @param at_cycle  called before each cycle of the press, with its number
  activity::RunPtr press(PressParameters parameters,
                         const std::function<void(int, activity::ActivityRun&)>& at_cycle = {}) {
    EXPECT_EQ(ActivityTest::run(sequence(R"({"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.034],
                                             "rpy_deg": [180, 0, 0]}}, {"do": "tare", "cycles": 20})")),
              Progress::kDone);
    parameters.direction = {0.0, 0.0, -1.0};
    parameters.in = "block";
    parameters.force = 20.0;
    parameters.approach = 0.001;
    const activity::RunPtr run = app::Actuator(program_, "arm").use<app::ForceInterface>().press(parameters).schedule();
    for (int i = 0; i < 30'000 && !run->over(); ++i) {
      if (at_cycle) at_cycle(i, *run);
      program_.step();
    }
    return run;
  }
  void expect_failed(const activity::RunPtr& run, PressOutcome outcome) {
    EXPECT_EQ(run->state(), activity::RunState::kFailed);
    EXPECT_EQ(name_of(press_outcome(*run)), name_of(outcome)) << run->diagnostics().to_string();
    program_.step();
    EXPECT_EQ(press_outcome(*run), outcome) << "also once the core has forgotten its net";
  }

 private:
  activity::Runtime program_{fake.core, fake.cell, [this] { fake.step(); }, {.variables = &variables}};
};

constexpr int kTouching = 8000;  ///< cycles after which the tool is on the block for sure

TEST_F(PressOutcomeTest, HeldForAsLongAsWasAsked) {
  const activity::RunPtr run = press({.seconds = 0.2});
  EXPECT_EQ(run->state(), activity::RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_EQ(press_outcome(*run), PressOutcome::kHeld);
}

TEST_F(PressOutcomeTest, NothingIsThereToTouch) { expect_failed(press({.travel = 0.002}), PressOutcome::kNotTouched); }

TEST_F(PressOutcomeTest, TheSensorIsSilent) {
  expect_failed(
      press({.seconds = 20.0}, [this](int cycle, activity::ActivityRun&) { fake.sensor->silent = cycle > 300; }),
      PressOutcome::kSensorSilent);
}

TEST_F(PressOutcomeTest, TheForceAcrossTheDirectionIsTooLarge) {
  expect_failed(press({.seconds = 20.0, .lateral = 3.0},
                      [this](int cycle, activity::ActivityRun&) { fake.extra.force.x() = cycle > 300 ? 6.0 : 0.0; }),
                PressOutcome::kPushedSideways);
}

TEST_F(PressOutcomeTest, TheToolGoesDeeperThanExpected) {
  expect_failed(press({.seconds = 20.0, .depth = 1e-3},
                      [this](int cycle, activity::ActivityRun&) {
                        if (cycle > kTouching) fake.X_WO_true.translation().z() -= 2e-6;
                      }),
                PressOutcome::kDeeper);
}

TEST_F(PressOutcomeTest, ItsAbortConditionBecomesTrue) {
  const expression::State slow = is_less(expression::channel<net::Real>(fake.cell, "override"), 0.5);
  const activity::RunPtr run = press({.seconds = 20.0, .abort_if = slow}, [this](int cycle, activity::ActivityRun&) {
    if (cycle == 300) (void)fake.speed->write(net::Real{0.4});
  });
  EXPECT_EQ(run->diagnostics().list().front().code, Code::kAbortCondition);
  expect_failed(run, PressOutcome::kAborted);
}

TEST_F(PressOutcomeTest, ACancelInterruptsItAndAStopReactionStopsIt) {
  const activity::RunPtr cancelled = press({.seconds = 20.0}, [](int cycle, activity::ActivityRun& run) {
    if (cycle == 300) run.cancel();
  });
  EXPECT_EQ(cancelled->state(), activity::RunState::kCancelled);
  EXPECT_EQ(press_outcome(*cancelled), PressOutcome::kInterrupted);
  expect_failed(press({.seconds = 20.0},
                      [](int cycle, activity::ActivityRun& run) {
                        if (cycle == 300) run.abort();
                      }),
                PressOutcome::kStopped);
}

TEST_F(PressOutcomeTest, OneThatCannotBeginIsStopped) {
  expect_failed(press({.travel = -1.0}), PressOutcome::kStopped);
}

}  // namespace
}  // namespace takt::operations
