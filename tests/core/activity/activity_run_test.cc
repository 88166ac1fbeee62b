// Activities: who follows whom, and how (docs/activity-layer.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/dual_entry_motion.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/support/reports.h"

namespace takt::activity {
namespace {

using rcc::NetState;
using takt::test::Reports;
using testing::ElementsAre;

class ActivityRunTest : public testing::Test {
 protected:
  Eigen::Isometry3d by(double x, double y, double z) const { return cell.moved(x, y, z); }
  Diagnostics error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const ActivityError& error) {
      return error.diagnostics();
    }
    return {};
  }

  test::ActivityCell cell;
  const Eigen::Isometry3d goal = by(0.0, 0.1, 0.0), goal2 = by(-0.1, 0.1, 0.0), goal3 = by(-0.1, 0.1, 0.08);
};

// Listing 2 of the 2013 paper.
TEST_F(ActivityRunTest, P4_AMotionIsBlendedIntoTheNextAndTheOneAfterBeginsAtRest) {
  const RunPtr first = cell.motion.lin(goal, {.blend = 0.7}).begin_execute();
  EXPECT_EQ(first->state(), RunState::kRunning);
  const RunPtr second = cell.motion.lin(goal2).execute();
  const RunPtr third = cell.motion.lin(goal3).execute();
  EXPECT_TRUE(second->blended());
  EXPECT_FALSE(third->blended());
  EXPECT_EQ(second->first_cycle(), first->last_cycle() + 1);
  EXPECT_EQ(cell.core.status(first->net()).cause.code, net::Cause::Code::kTakenOver);
  EXPECT_EQ(cell.cycles_at_rest(first->first_cycle() + 2, second->last_cycle() - 2), 0)
      << "it never stops at the blend";
  EXPECT_GT(cell.nearest_to(goal.translation()), 1e-3) << "it cuts the corner";
  EXPECT_LT(cell.nearest_to(goal2.translation()), 1e-6);
  EXPECT_LT((cell.robot.tool().translation() - goal3.translation()).norm(), 1e-6);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ActivityRunTest, AWeaveGoesOnThroughTheBlendsOfOnePlanAndIsGoneBeforeAnotherOne) {
  const Eigen::Matrix3d R = cell.robot.tool().linear();
  const command::WeaveParameters weave{.amplitude = 0.002, .direction_M = R.transpose() * Eigen::Vector3d::UnitZ()};
  const auto seam = [&](const Eigen::Isometry3d& to) {
    return cell.motion.lin(to, {.linear_velocity = 0.05, .blend = 0.7, .weave = weave});
  };
  const double plane = goal.translation().z();
  const RunPtr one = sequence({seam(goal), seam(goal2)}).begin_execute();
  const RunPtr next = cell.motion.lin(goal3).execute();
  EXPECT_EQ(cell.cycles_at_rest(one->first_cycle() + 2, one->last_cycle() - 20), 0) << "not in the corner";
  EXPECT_FALSE(next->blended()) << "it would have driven the rest of the seam bare";
  double in_corner = 0.0;
  for (const auto& sent : cell.backend->sent) {
    const Eigen::Vector3d p = (cell.arm->chain->forward(sent.q) * cell.cell.arms.at("arm").X_FT).translation();
    if ((p - goal.translation()).head<2>().norm() < 0.03) in_corner = std::max(in_corner, std::abs(p.z() - plane));
  }
  EXPECT_NEAR(in_corner, weave.amplitude, 1e-4);
  EXPECT_LT(cell.nearest_to(goal2.translation()), 1e-6);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
  EXPECT_THAT(error_of([&] { cell.motion.lin(goal, {.weave = command::WeaveParameters{.frequency = 0.0}}).execute(); }),
              Reports(Code::kOutOfRange, "/arm LIN/weave/frequency_Hz"));
}

TEST_F(ActivityRunTest, L8_ASuccessorThatComesTooLateBeginsAfterTheNaturalEndWithoutAnEmptyCycle) {
  const RunPtr first = cell.motion.lin(goal, {.blend = 0.7}).begin_execute();
  const double duration = first->value<double>("none").value_or(0.0);
  EXPECT_EQ(duration, 0.0) << "nothing is observed";
  while (!first->over() && (cell.robot.tool().translation() - goal.translation()).norm() > 2e-4) cell.program.step();
  ASSERT_FALSE(first->over());
  const RunPtr second = cell.motion.lin(goal2).execute();
  EXPECT_FALSE(second->blended());
  EXPECT_EQ(cell.core.status(first->net()).cause.code, net::Cause::Code::kTerminated);
  EXPECT_LT(cell.nearest_to(goal.translation()), 1e-6);
  EXPECT_EQ(second->first_cycle(), first->last_cycle() + 1);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

/// Others post more than the core's queue holds: the start is posted again, and not lost.
TEST_F(ActivityRunTest, AStartThatFindsTheQueueFullIsPostedInALaterCycle) {
  const RunPtr run = cell.motion.lin(goal).schedule();
  for (int i = 0; i < 20; ++i) {
    while (cell.core.cancel(4711) != 0) continue;
    cell.program.step();
    EXPECT_LT(run->state(), RunState::kRunning) << i;
  }
  for (int i = 0; i < 20'000 && !run->over(); ++i) cell.program.step();
  EXPECT_EQ(run->state(), RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_LT(cell.nearest_to(goal.translation()), 1e-6);
}

TEST_F(ActivityRunTest, P4_ItIsBlendedAtAnyOverrideAndAfterAPause) {
  for (const double speed : {0.83, 0.4}) {
    test::ActivityCell own;
    own.robot.set_speed(speed);
    const RunPtr first = own.motion.lin(goal, {.linear_velocity = 0.1, .blend = 0.6}).begin_execute();
    for (int i = 0; i < 100; ++i) own.program.step();
    own.robot.pause();
    for (int i = 0; i < 1'000; ++i) own.program.step();
    EXPECT_TRUE(own.core_arm().at_rest());
    const RunPtr second = own.motion.lin(goal2).schedule();
    for (int i = 0; i < 200; ++i) own.program.step();
    own.robot.resume();
    wait(own.program, second);
    EXPECT_TRUE(second->blended()) << speed;
    EXPECT_EQ(own.core.status(first->net()).cause.code, net::Cause::Code::kTakenOver);
    EXPECT_LT((own.robot.tool().translation() - goal2.translation()).norm(), 1e-6);
    EXPECT_LE(own.worst_limit_share(), 1.0);
  }
}

TEST_F(ActivityRunTest, O4_BothWaysExcludeEachOtherAndLoadProvesIt) {
  cell.motion.lin(goal, {.blend = 0.7}).begin_execute();
  const RunPtr second = cell.motion.ptp(cell.joints(0.4, 0.2)).begin_execute();
  const auto& report = cell.core.net(second->net())->report();
  ASSERT_FALSE(report.exclusions.empty());
  for (const auto& exclusion : report.exclusions) EXPECT_TRUE(exclusion.proven) << exclusion.at;
  wait(cell.program, second);
  EXPECT_LT((cell.q() - cell.joints(0.4, 0.2)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(ActivityRunTest, AnyNumberMayWaitAndAllKindsAreBlended) {
  std::vector<RunPtr> runs;
  runs.push_back(cell.motion.lin(goal, {.blend = 0.6}).schedule());
  runs.push_back(cell.motion.ptp(cell.joints(0.3, 0.1), {.blend = 0.6}).schedule());
  runs.push_back(cell.motion.lin_by({0.0, 0.0, 0.1}, {.blend = BlendingCondition::at_distance(0.03)}).schedule());
  runs.push_back(cell.motion.lin_by({-0.1, 0.0, 0.0}).schedule());
  wait(cell.program, runs.back());
  for (std::size_t i = 1; i < runs.size(); ++i) {
    EXPECT_TRUE(runs[i]->blended()) << i;
    EXPECT_EQ(runs[i]->first_cycle(), runs[i - 1]->last_cycle() + 1);
  }
  EXPECT_EQ(cell.cycles_at_rest(runs.front()->first_cycle() + 2, runs.back()->last_cycle() - 2), 0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ActivityRunTest, WithoutABlendTheNextBeginsInTheCycleAfterTheEnd) {
  const RunPtr first = cell.motion.lin(goal).schedule(), second = cell.motion.lin(goal2).schedule();
  wait(cell.program, second);
  EXPECT_FALSE(second->blended());
  EXPECT_EQ(second->first_cycle(), first->last_cycle() + 1);
  EXPECT_LT(cell.nearest_to(goal.translation()), 1e-6);
}

TEST_F(ActivityRunTest, AfterACancelNothingStartsByItself) {
  const RunPtr first = cell.motion.lin(goal, {.blend = 0.6}).begin_execute();
  const RunPtr second = cell.motion.lin(goal2, {.blend = 0.6}).schedule(), third = cell.motion.lin(goal3).schedule();
  first->cancel();
  cell.program.run_until([&] { return third->over(); });
  EXPECT_EQ(first->state(), RunState::kCancelled);
  EXPECT_EQ(second->state(), RunState::kFailed);
  EXPECT_THAT(third->diagnostics(), Reports(Code::kStopped, "/arm LIN"));
  EXPECT_THAT(second->diagnostics(), Reports(Code::kStopped, "/arm LIN", {"arm LIN"}));
  for (int i = 0; i < 1'000; ++i) cell.program.step();
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
  // Asked for again, it goes from where the arm is.
  EXPECT_EQ(cell.motion.lin(goal2).execute()->state(), RunState::kCompleted);
}

TEST_F(ActivityRunTest, AnActivityForAnArmWithAFaultIsGivenUpWithTheFault) {
  const RunPtr first = cell.motion.lin(goal).begin_execute();
  for (int i = 0; i < 50; ++i) cell.program.step();
  cell.backend->state().ready = false;
  cell.backend->state().fault = 7;
  cell.program.run_until([&] { return first->over(); });
  EXPECT_EQ(first->failure(), RunFailure::kStopped);
  const RunPtr second = cell.motion.lin(goal).schedule();
  for (int i = 0; i < 10; ++i) cell.program.step();
  ASSERT_EQ(second->state(), RunState::kFailed) << "it does not stay queued without a word";
  EXPECT_EQ(second->failure(), RunFailure::kFault);
  EXPECT_THAT(second->diagnostics(), Reports(Code::kDeviceFault, "/arm LIN", {"arm LIN", "7"}));
  const app::Actuator lamp(cell.program, "lamp");
  EXPECT_EQ(lamp.use<app::OutputInterface>().set(true).execute()->state(), RunState::kCompleted) << "others go on";
  cell.backend->state().ready = true;
  cell.backend->state().fault = 0;
  for (int i = 0; i < 1'000; ++i) cell.program.step();
  EXPECT_EQ(cell.motion.lin(goal).execute()->state(), RunState::kCompleted) << "asked for again, it goes";
}

TEST_F(ActivityRunTest, AGuardedMotionEndsNobodyKnowsWhereSoTheNextWaitsForIt) {
  const auto down = cell.motion.lin_by({0, 0, -0.05}, {.linear_velocity = 0.05, .until = cell.hard()});
  const RunPtr first = down.begin_execute();
  const RunPtr second = cell.motion.lin_by({0, 0, 0.02}).schedule();
  for (int i = 0; i < 200; ++i) cell.program.step();
  EXPECT_EQ(second->state(), RunState::kQueued);
  cell.extra.force.z() = 6.0;
  cell.program.run_until([&] { return first->over(); });
  EXPECT_EQ(first->state(), RunState::kCompleted);
  cell.extra.force.z() = 0.0;
  const double z = cell.robot.tool().translation().z();
  wait(cell.program, second);
  EXPECT_NEAR(cell.robot.tool().translation().z(), z + 0.02, 1e-6);
  EXPECT_THAT(error_of([&] { cell.motion.lin(goal, {.blend = 0.7, .until = cell.hard()}).execute(); }),
              Reports(Code::kConflict, "/arm LIN/blend"));
}

TEST_F(ActivityRunTest, N3_AGuardedMotionTellsContactNoContactAndADeadSensorApart) {
  using enum GuardedOutcome::Kind;
  const auto down = cell.motion.lin_by({0, 0, -0.02}, {.linear_velocity = 0.05, .until = cell.hard()});
  const auto after = [&](const std::function<void(ActivityRun&)>& meanwhile) {
    const RunPtr run = down.begin_execute();
    for (int i = 0; i < 200; ++i) cell.program.step();
    meanwhile(*run);
    cell.program.run_until([&] { return run->over(); });
    cell.extra.force.z() = 0.0;
    cell.sensor->silent = false;
    cell.program.step();
    return guarded_outcome(*run);
  };
  const GuardedOutcome touched = after([&](ActivityRun&) { cell.extra.force.z() = 6.0; });
  EXPECT_EQ(touched.kind, kTouched);
  ASSERT_TRUE(touched.X_BT && touched.force);
  EXPECT_NEAR(touched.force->norm(), 6.0, 1e-6);
  EXPECT_LT((touched.X_BT->translation() - cell.robot.tool().translation()).norm(), 5e-3) << "it has braked since";
  const GuardedOutcome free = after([](ActivityRun&) {});
  EXPECT_EQ(free.kind, kNotTouched);
  EXPECT_FALSE(free.X_BT || free.force);
  EXPECT_EQ(after([](ActivityRun& run) { run.cancel(); }).kind, kInterrupted);
  EXPECT_EQ(after([&](ActivityRun&) { cell.sensor->silent = true; }).kind, kSensorSilent);
  EXPECT_EQ(name_of(kSensorSilent), "sensor silent");
}

/// As a step of a file: what was not found, and what could not be felt, is no good end.
TEST_F(ActivityRunTest, N3_AGuardedMotionWithoutATouchFailsAsInAFile) {
  operations::MotionParameters guarded{.linear_velocity = 0.05, .until = cell.hard()};
  EXPECT_THAT(error_of([&] {
                cell.motion.lin_by({0, 0, -0.02}, guarded).execute();
              }),
              Reports(Code::kConditionNotMet, "/arm LIN/until"));
  const RunPtr silent = cell.motion.lin_by({0, 0, -0.02}, guarded).begin_execute();
  cell.sensor->silent = true;
  cell.program.run_until([&] { return silent->over(); });
  cell.sensor->silent = false;
  EXPECT_EQ(silent->failure(), RunFailure::kAborted);
  EXPECT_THAT(silent->diagnostics(), Reports(Code::kSensorSilent, "/arm LIN/until"));
  EXPECT_TRUE(cell.core_arm().at_rest());
  guarded.must_touch = false;
  EXPECT_EQ(cell.motion.lin_by({0, 0, 0.02}, guarded).execute()->state(), RunState::kCompleted);
}

TEST_F(ActivityRunTest, WhatCannotBeDoneIsThrownAndNothingMoves) {
  const auto before = cell.q();
  EXPECT_THAT(error_of([&] { cell.motion.lin(by(3.0, 0, 0)).execute(); }), Reports(Code::kUnreachable, "/arm LIN/to"));
  EXPECT_THAT(error_of([&] { cell.motion.lin(goal, {.blend = 0.2}).execute(); }),
              Reports(Code::kOutOfRange, "/arm LIN/blend", {"0.5"}));
  EXPECT_EQ(cell.q(), before);
  EXPECT_THAT(error_of([&] { (void)app::Actuator(cell.program, "gripper").use<app::LinInterface>(); }),
              Reports(Code::kUnsupported, "/gripper", {"gripper"}));
  EXPECT_THAT(error_of([&] { (void)app::Actuator(cell.program, "amr"); }),
              Reports(Code::kUnknownName, "/amr", {"arm"}));
  EXPECT_TRUE(cell.robot.offers<app::PtpInterface>());
  EXPECT_FALSE(cell.robot.offers<app::GrippingInterface>());
  EXPECT_THAT(cell.robot.interfaces(), ElementsAre("MotionInterface", "PtpInterface", "LinInterface", "JointInterface",
                                                   "HoldInterface", "ForceInterface", "JogInterface", "FollowInterface",
                                                   "ControlModeInterface", "FreedriveInterface"));
}

// Listing 3 of the paper: different actuators know nothing of each other.
TEST_F(ActivityRunTest, ActivitiesOnOtherActuatorsRunBeside) {
  const app::Actuator lamp(cell.program, "lamp");
  const RunPtr first = cell.motion.lin(goal, {.blend = 0.7}).begin_execute();
  lamp.use<app::OutputInterface>().set(true).execute();
  EXPECT_FALSE(first->over());
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  EXPECT_TRUE(cell.motion.lin(goal2).execute()->blended());
}

Task square(test::ActivityCell& cell, std::vector<std::string>& log) {
  for (const Eigen::Vector3d& way : {Eigen::Vector3d(0, 0.05, 0), Eigen::Vector3d(-0.05, 0, 0)}) {
    co_await started(cell.motion.lin_by(way, {.blend = 0.6}));
    log.emplace_back("side");
  }
  co_await cell.motion.lin_by({0.0, -0.05, 0.0});
  log.emplace_back("done");
}

Task blink(test::ActivityCell& cell, std::vector<std::string>& log) {
  const app::Actuator lamp(cell.program, "lamp");
  for (int i = 0; i < 2; ++i) {
    co_await lamp.use<app::OutputInterface>().set(i % 2 == 0);
    co_await cell.program.cycles(20);
  }
  log.emplace_back("blinked");
}

Task both(test::ActivityCell& cell, std::vector<std::string>& log) {
  cell.program.spawn(blink(cell, log));
  co_await square(cell, log);
}

Task blocks(test::ActivityCell& cell) {
  cell.motion.lin_by({0, 0, 0.01}).execute();
  co_return;
}

TEST_F(ActivityRunTest, D1_CoroutinesAwaitActivitiesAndARunRepeatsToTheBit) {
  std::vector<std::string> digests;
  for (int run = 0; run < 2; ++run) {
    test::ActivityCell own;
    std::vector<std::string> log;
    own.program.run(both(own, log));
    EXPECT_THAT(log, ElementsAre("side", "blinked", "side", "done")) << "the second begins where the first is left";
    EXPECT_LE(own.worst_limit_share(), 1.0);
    digests.push_back(rcc::to_string(own.core.digest().value()));
  }
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_THAT(error_of([&] { cell.program.run(blocks(cell)); }), Reports(Code::kNotPossibleNow, "", {"co_await"}));
  EXPECT_THAT(error_of([&] {
                Task failing = [](test::ActivityCell& own) -> Task { co_await own.motion.lin_by({9, 0, 0}); }(cell);
                cell.program.run(std::move(failing));
              }),
              Reports(Code::kUnreachable, "/arm LIN/to"));
}

TEST_F(ActivityRunTest, ASequenceBlendsItsMotionsAndMayBeLeftItself) {
  const auto corner = sequence({cell.motion.lin(goal, {.blend = 0.7}), cell.motion.lin(goal2, {.blend = 0.7})});
  EXPECT_EQ(corner.model()->name(), "arm LIN LIN") << "one motion";
  const RunPtr first = corner.begin_execute();
  const RunPtr second = cell.motion.lin(goal3).execute();
  EXPECT_TRUE(second->blended());
  EXPECT_EQ(cell.cycles_at_rest(first->first_cycle() + 2, second->last_cycle() - 2), 0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ActivityRunTest, ASequenceOverSeveralActuatorsRunsInOrder) {
  const app::Actuator lamp(cell.program, "lamp");
  const auto all =
      sequence({cell.motion.lin(goal), lamp.use<app::OutputInterface>().set(true), cell.motion.lin(goal2)});
  const RunPtr run = all.schedule();
  bool lit_at_goal = false;
  while (!run->over()) {
    const bool lit = cell.cell.digital_outputs.at("lamp")->value();
    if (lit && !lit_at_goal) {
      EXPECT_LT((cell.robot.tool().translation() - goal.translation()).norm(), 1e-4);
    }
    lit_at_goal = lit_at_goal || lit;
    cell.program.step();
  }
  require(run);
  EXPECT_TRUE(lit_at_goal);
  EXPECT_LT((cell.robot.tool().translation() - goal2.translation()).norm(), 1e-6);
}

TEST_F(ActivityRunTest, PartsInParallelBeginInOneCycleAndAConditionChoosesInTheFirst) {
  const app::Actuator lamp(cell.program, "lamp");
  const auto lit = lamp.use<app::OutputInterface>().set(true);
  parallel({cell.motion.lin(goal), lit}).execute();
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  const auto choice =
      conditional(expression::digital_input(cell.cell, "button"), cell.motion.lin(goal2), cell.motion.lin(goal3));
  cell.button->sample.value = true;
  cell.button->sample.stamp = cell.core.time();
  choice.execute();
  EXPECT_LT((cell.robot.tool().translation() - goal2.translation()).norm(), 1e-6);
}

// Neither motion after the choice ends where it would have without it.
TEST_F(ActivityRunTest, WhatFollowsAChoiceBeginsAtEitherEnd) {
  for (const bool pressed : {true, false}) {
    SCOPED_TRACE(pressed);
    test::ActivityCell own;
    const Eigen::Isometry3d to = own.moved(0.0, 0.08, 0.0), other = own.moved(0.05, 0.0, 0.0), home = own.robot.tool();
    const auto pressed_now = expression::digital_input(own.cell, "button");
    const app::Actuator lamp(own.program, "lamp"), driver(own.program, "driver");
    own.button->sample.value = pressed;
    own.step(2);
    sequence({conditional(pressed_now, own.motion.lin(to), own.motion.lin(other)),
              lamp.use<app::OutputInterface>().set(true), own.motion.lin_by({0.0, 0.0, 0.05}),
              own.motion.lin_by({0.0, 0.0, 0.03}), driver.use<app::OutputInterface>().set(true)})
        .execute();
    Eigen::Vector3d expected = (pressed ? to : other).translation();
    expected.z() += 0.08;
    EXPECT_LT((own.robot.tool().translation() - expected).norm(), 1e-6);
    EXPECT_TRUE(own.cell.digital_outputs.at("driver")->value());
    // Both come to one place, so there is one way on.
    sequence(
        {conditional(pressed_now, own.motion.lin_by({0.0, 0.02, 0.0}), lamp.use<app::OutputInterface>().set(false)),
         own.motion.ptp(own.arm->home), own.motion.lin_by({0.0, 0.0, 0.02})})
        .execute();
    EXPECT_NEAR(own.robot.tool().translation().z(), home.translation().z() + 0.02, 1e-6);
    EXPECT_LE(own.worst_limit_share(), 1.0);
  }
}

TEST_F(ActivityRunTest, ASubtaskBeginsAtAShareOfTheMainTask) {
  const app::Actuator lamp(cell.program, "lamp");
  const auto all =
      with_subtasks(cell.motion.lin(goal), {{.activity = lamp.use<app::OutputInterface>().set(true), .at_share = 0.5}});
  const RunPtr run = all.schedule();
  const Eigen::Vector3d from = cell.robot.tool().translation();
  double share = 0.0;
  while (!run->over()) {
    if (!cell.cell.digital_outputs.at("lamp")->value())
      share = (cell.robot.tool().translation() - from).norm() / (goal.translation() - from).norm();
    cell.program.step();
  }
  require(run);
  EXPECT_NEAR(share, 0.5, 0.02);
  EXPECT_THAT(error_of([&] {
                with_subtasks(lamp.use<app::OutputInterface>().set(true),
                              {{.activity = cell.motion.lin(goal2), .at_share = 0.5}})
                    .execute();
              }),
              Reports(Code::kConflict, "/set lamp with subtasks/subtasks/0"));
}

// Cancel at every tenth cycle of a blended pair: no limit is broken, the arm comes to rest, everything is free again.
TEST_F(ActivityRunTest, L6_ACancelAtAnyCycleOfABlendedPairComesToRestWithinAllLimits) {
  for (int at = 5; at < 700; at += 31) {
    test::ActivityCell own;
    const RunPtr first = own.motion.lin(goal, {.blend = 0.6}).begin_execute();
    const RunPtr second = own.motion.lin(goal2).schedule();
    for (int i = 0; i < at; ++i) own.program.step();
    first->cancel();
    second->cancel();
    own.program.run_until([&] { return first->over() && second->over(); });
    for (int i = 0; i < 5; ++i) own.program.step();
    EXPECT_TRUE(own.core_arm().at_rest()) << at;
    EXPECT_LE(own.worst_limit_share(), 1.0) << at;
    EXPECT_EQ(own.motion.lin_by({0, 0, 0.01}).execute()->state(), RunState::kCompleted) << at;
  }
}

}  // namespace
}  // namespace takt::activity
