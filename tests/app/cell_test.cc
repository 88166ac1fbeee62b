// A cell for programs in C++ (docs/cpp-api.md): how it is opened, refused, operated, interrupted and judged.
#include "app/cell.h"

#include <chrono>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cell_setup.h"
#include "app/interfaces/two_arms.h"
#include "app/takt.h"
#include "tests/support/reports.h"

namespace takt::app {
namespace {

using takt::test::Reports;
using testing::Not;

CellOptions with(const std::string& pointer, const std::string& value) { return {.set = {{pointer, value}}}; }

Diagnostics error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const ActivityError& error) {
    return error.diagnostics();
  }
  return {};
}

/// There and back on a line, 0.2 m.
void there_and_back(Cell& cell) {
  const auto motion = cell.arm().use<MotionInterface>();
  motion.lin_by({0.0, 0.2, 0.0}, {.velocity = 0.5}).execute();
  motion.lin_by({0.0, -0.2, 0.0}, {.velocity = 0.5}).execute();
}

/// Runs it as run() does, without a command line.
RunReport report_of(Cell& cell, const Program& program) {
  Diagnostics why;
  try {
    program(cell);
  } catch (const ProgramCancelled&) {
    // It was asked for.
  } catch (const ActivityError& error) {
    why = error.diagnostics();
  }
  return cell.finish(why);
}

/// The names of the expectations that do not hold; of a run that was cut off nothing is judged.
std::vector<std::string> failed(const RunReport& report) {
  std::vector<std::string> names;
  for (const auto& one : report.expectations)
    if (one.judged && !one.passed) names.push_back(one.name);
  return names;
}

constexpr const char* kOnlyLimits = R"([{"name": "limits", "kind": "limits"}])";

TEST(Cell, WhatIsWrongWithTheFileIsToldAtOnce) {
  EXPECT_THAT(error_of([] { Cell cell("nothing.json"); }), Reports(Code::kNotFound, ""));
  const Diagnostics wrong = error_of([] {
    Cell cell("wave.json", {.set = {{"/devices/arm/model", "lwr4"}, {"/cameras/overview/fovy", "3"}}});
  });
  EXPECT_THAT(wrong, Reports(Code::kUnknownName, "/devices/arm/model", {"lwr4plus"}));
  EXPECT_THAT(wrong, Reports(Code::kUnknownKey, "/cameras/overview/fovy"));
}

TEST(Cell, AFileWithoutAProgramIsACell) {
  const std::string file = testing::TempDir() + "cell_without_program.json";
  std::ofstream(file) << R"({"devices": {"arm": {"model": "lwr4plus"}}})";
  Cell cell(file);
  EXPECT_EQ(cell.arm().name(), "arm");
  EXPECT_EQ(cell.title(), "cell_without_program");
}

TEST(Cell, NamesThatAreNotThereAreToldWithTheNearest) {
  Cell cell("pick.json");
  EXPECT_EQ(cell.arm().name(), "arm") << "the only one";
  EXPECT_EQ(cell.gripper("gripper").name(), "gripper");
  EXPECT_EQ(cell.output("io/lamp").name(), "io/lamp");
  EXPECT_THAT(error_of([&] { (void)cell.output(); }), Reports(Code::kMissing, "", {"10"}));
  EXPECT_THAT(error_of([&] { (void)cell.arm("amr"); }), Reports(Code::kUnknownName, "", {"amr", "arm"}));
  EXPECT_THAT(error_of([&] { (void)cell.output("io/lmap"); }), Reports(Code::kUnknownName, "", {"io/lamp"}));
  EXPECT_THAT(error_of([&] { (void)cell.force(); }), Reports(Code::kUnknownName, ""));
  EXPECT_THAT(error_of([&] { (void)cell.gripper_is("holdin"); }), Reports(Code::kUnknownName, "", {"holding"}));
  EXPECT_THAT(error_of([&] { (void)cell.gripper().use<LinInterface>(); }),
              Reports(Code::kUnsupported, "/gripper", {"gripper"}));
}

TEST(Cell, AChannelIsWrittenWithAValueOfItsTypeAndCountsFromTheNextCycleOn) {
  Cell cell("pick.json");
  const auto override_now = [&] { return expression::channel<net::Real>(cell.model(), "operator/override").now(); };
  cell.write_channel("operator/override", net::Real(0.5));
  cell.wait(0.002);
  EXPECT_EQ(override_now(), 0.5);
  EXPECT_THAT(error_of([&] { cell.write_channel("operator/override", net::Boolean(true)); }),
              Reports(Code::kWrongType, "", {"Real"}));
  EXPECT_THAT(error_of([&] { cell.write_channel("operator/overide", net::Real(1.0)); }),
              Reports(Code::kUnknownName, "", {"operator/override"}));
}

TEST(Cell, D1_TwoRunsHaveOneDigestAndASeedOfTheirOwn) {
  const auto digest = [](std::uint64_t seed) {
    Cell cell("touch.json", {.set = {{"/expectations", "[]"}}, .seed = seed});
    cell.tare();
    cell.wait(0.1);
    return cell.finish().digest;
  };
  EXPECT_EQ(digest(1), digest(1));
  EXPECT_NE(digest(1), digest(2));
}

TEST(Cell, StepsExpectationsAndLinesAreInTheReport) {
  Cell cell("wave.json", {.quiet = true});
  cell.step("home");
  there_and_back(cell);
  cell.print("done");
  cell.expect("back again", true, "0 mm");
  const RunReport report = cell.finish();
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_THAT(report.lines, testing::ElementsAre("done"));
  EXPECT_EQ(report.expectations.front().name, "back again");
  EXPECT_GT(report.expectations.size(), 3u) << "those of the file too";
}

TEST(Cell, WhatTheProgramFindsWrongFailsTheRun) {
  Cell cell("wave.json", with("/expectations", kOnlyLimits));
  cell.expect("never", false, "1 of 0");
  EXPECT_EQ(cell.finish().verdict, Verdict::kFailed);
}

TEST(Cell, WhatWasBegunIsWaitedFor) {
  Cell cell("wave.json", with("/expectations", kOnlyLimits));
  const auto home = cell.arm().tool();
  const RunPtr run = cell.arm().use<LinInterface>().lin_by({0.0, 0.1, 0.0}).schedule();
  const RunReport report = cell.finish();
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_EQ(run->state(), RunState::kCompleted);
  EXPECT_NEAR((cell.arm().tool().translation() - home.translation()).norm(), 0.1, 1e-6);
}

TEST(Cell, AnErrorOfTheProgramEndsWhatRunsInOrder) {
  Cell cell("wave.json", with("/expectations", kOnlyLimits));
  const RunReport report = report_of(cell, [](Cell& own) {
    own.arm().use<LinInterface>().lin_by({0.0, 0.2, 0.0}).begin_execute();
    own.wait(0.3);
    (void)own.arm("hand");
  });
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kUnknownName, "", {"hand"}));
  EXPECT_THAT(report.diagnostics, Not(takt::test::ReportsAnywhere(Code::kNotPossibleNow)));
  EXPECT_TRUE(failed(report).empty());
  EXPECT_FALSE(cell.core().find_arm("arm")->held());
}

expression::State never(Cell& cell) {
  return is_greater(element(expression::measured_joints(cell.model(), cell.arm().name()), 0), 100.0);
}

TEST(Cell, WhatFailsWhileNobodyWaitsIsAnErrorOfTheRunUnlessItsOutcomeIsRead) {
  for (const bool asks : {false, true}) {
    Cell cell("wave.json", with("/expectations", kOnlyLimits));
    const RunReport report = report_of(cell, [asks](Cell& own) {
      const auto guarded = own.arm().use<LinInterface>().lin_by({0.0, 0.02, 0.0}, {.until = never(own)});
      const RunPtr run = guarded.begin_execute();
      own.wait(3.0);
      EXPECT_EQ(run->state(), RunState::kFailed);
      if (asks) {
        EXPECT_EQ(run->failure(), RunFailure::kAborted);
      }
    });
    EXPECT_EQ(report.verdict, asks ? Verdict::kPassed : Verdict::kError) << report.diagnostics.to_string();
    if (!asks) {
      EXPECT_THAT(report.diagnostics, Reports(Code::kConditionNotMet, "/arm LIN/until"));
    }
  }
}

TEST(Cell, AWaitThatIsNotFulfilledIsAnAnswerAndNoFailure) {
  Cell cell("wave.json", with("/expectations", kOnlyLimits));
  EXPECT_FALSE(cell.wait_until(never(cell), 0.05));
  EXPECT_TRUE(cell.wait_until(!never(cell), 0.05));
  EXPECT_EQ(cell.finish().verdict, Verdict::kPassed);
}

TEST(Cell, AProgramIsGoneThroughStepByStep) {
  std::vector<std::string> asked;
  CellSetup setup;
  setup.open.overrides.push_back({"/expectations", kOnlyLimits});
  setup.run.before_step = [&asked](const cell::NextStep& next) {
    asked.push_back(next.name);
    return asked.size() < 2 ? cell::StepAnswer::kNext : cell::StepAnswer::kCancel;
  };
  Cell cell("wave.json", {}, std::move(setup));
  const RunReport report = report_of(cell, [](Cell& own) {
    own.step("there");
    there_and_back(own);
    there_and_back(own);
  });
  EXPECT_THAT(asked, testing::ElementsAre("there: arm LIN", "there: arm LIN"));
  EXPECT_EQ(report.verdict, Verdict::kInterrupted) << report.diagnostics.to_string();
}

/// Two arms side by side, of which the right one is a UR5 unless it is said: told 17 ms late.
CellOptions two_arms(CooperatingArms cooperating, const std::string& right = "ur5") {
  return {.set = {{"/expectations", "[]"}, {"/devices/right/model", right}}, .cooperating = std::move(cooperating)};
}
Nanoseconds delay(Cell& cell, const std::string& arm) {
  const device::BackendTiming timing = cell.core().find_arm(arm)->timing();
  return timing.driver_delay + timing.dead_time;
}

TEST(Cell, OnlyArmsThatCooperateAreEquallyLate) {
  Cell unknown("beside.json", two_arms({}));
  EXPECT_EQ(delay(unknown, "left"), 17 * kMillisecond) << "which arms will move as one is not known";
  Cell alone("beside.json", two_arms({{}}));
  EXPECT_EQ(delay(alone, "left"), 0);
  EXPECT_EQ(delay(alone, "right"), 17 * kMillisecond);
  Cell together("beside.json", two_arms({{{"left", "right"}}}));
  EXPECT_EQ(delay(together, "left"), 17 * kMillisecond);
}

TEST(Cell, AGroupNamesArmsOfTheCell) {
  const Diagnostics why = error_of([] { Cell("beside.json", two_arms({{{"left", "rigth"}}})); });
  EXPECT_THAT(why, Reports(Code::kUnknownName, "", {"cooperating", "rigth", "right", "left"}));
}

/// They would not be together at their flanges.
TEST(Cell, ArmsOfDifferentGroupsDoNotMoveAsOne) {
  const auto lift = [](Cell& cell) {
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.translation() << 0.6, 0.0, 0.5;
    const app::TwoArms pair(cell.arm("left"), cell.arm("right"), X_WC);
    pair.lin_by({0.0, 0.0, 0.02}).execute();
  };
  Cell apart("beside.json", two_arms({{{"left"}, {"right"}}}, "lwr4plus"));
  const Diagnostics why = error_of([&] { lift(apart); });
  EXPECT_THAT(why, takt::test::ReportsAnywhere(Code::kConflict, {"left", "right"})) << why.to_string();
  EXPECT_EQ(report_of(apart,
                      [](Cell& cell) {
                        cell.arm("left").use<MotionInterface>().lin_by({0.0, 0.0, 0.02}).execute();
                      })
                .verdict,
            Verdict::kPassed);
  Cell together("beside.json", two_arms({{{"right", "left"}}}, "lwr4plus"));
  EXPECT_EQ(report_of(together, lift).verdict, Verdict::kPassed);
}

/// The cycle has a thread of its own: it goes on while the program calculates.
TEST(Cell, InRealTimeTheCycleRunsBesideTheProgram) {
  CellOptions options = with("/expectations", kOnlyLimits);
  options.realtime = true;
  Cell cell("wave.json", options);
  const double begun = cell.time();
  cell.beside([] { std::this_thread::sleep_for(std::chrono::milliseconds(300)); });
  EXPECT_GT(cell.time() - begun, 0.1);
  cell.arm().use<LinInterface>().lin_by({0.0, 0.1, 0.0}).begin_execute();
  cell.beside([] { std::this_thread::sleep_for(std::chrono::milliseconds(100)); });
  cell.wait_for_all();
  const RunReport report = report_of(cell, there_and_back);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  ASSERT_TRUE(report.realtime);
  EXPECT_GT(report.cycles, 1000);
}

/// In lock-step the time stands still between two calls, whatever the program does.
TEST(Cell, InLockStepWorkBesideTakesNoTime) {
  Cell cell("wave.json", with("/expectations", kOnlyLimits));
  const double begun = cell.time();
  cell.beside([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
  EXPECT_EQ(cell.time(), begun);
  EXPECT_FALSE(report_of(cell, there_and_back).realtime);
}

/// What is thrown in it comes out, and the cell goes on.
TEST(Cell, AnExceptionOfWorkBesideDoesNotStopTheCell) {
  CellOptions options = with("/expectations", kOnlyLimits);
  options.realtime = true;
  Cell cell("wave.json", options);
  EXPECT_THROW(cell.beside([] { throw std::runtime_error("no answer"); }), std::runtime_error);
  EXPECT_EQ(report_of(cell, there_and_back).verdict, Verdict::kPassed);
}

TEST(Cell, ACellInRealTimeThatIsNotFinishedEndsItsThreads) {
  CellOptions options;
  options.realtime = true;
  Cell cell("wave.json", options);
  cell.wait(0.05);
}

TEST(Cell, TheTimeLimitEndsAProgramThatWaitsForEver) {
  Cell cell("wave.json", {.set = {{"/expectations", kOnlyLimits}, {"/time_limit_s", "0.5"}}});
  const RunReport report = report_of(cell, [](Cell& own) { own.wait(1e6); });
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kTimeout, "/time_limit_s", {"0.5"}));
}

TEST(Cell, WaitUntilTellsWhetherItHeld) {
  Cell cell("pick.json", with("/expectations", kOnlyLimits));
  const State lit = digital_output(cell.model(), "io/lamp");
  EXPECT_FALSE(cell.wait_until(lit, 0.05));
  cell.output("io/lamp").use<OutputInterface>().set(true).execute();
  EXPECT_TRUE(cell.wait_until(lit, 0.05));
}

TEST(Cell, ACommandOfOnesOwnMayBeCarriedOutAgain) {
  Cell cell("pick.json", with("/expectations", kOnlyLimits));
  RuntimeCommand on("on", command::output(cell.model(), "io/lamp"), command::set_value(true));
  WaitCommand burning("burning", 0.05);
  RuntimeCommand off("off", command::output(cell.model(), "io/lamp"), command::set_value(false));
  TransactionCommand flash("flash");
  flash.add_started(on).add(burning).add(off);
  flash.on_entered(on.completed(), start(burning)).on_entered(burning.completed(), start(off));
  std::vector<std::int64_t> lit;
  flash.on_entered(on.completed(), command::external("lit", [&lit](const command::ExternalEvent& event) {
                     lit.push_back(event.cycle.value_or(-1));
                   }));
  const Activity flashing = cell.as_activity(flash);
  EXPECT_THAT(flashing.model()->actuators(), testing::ElementsAre("io/lamp"));
  for (int i = 0; i < 2; ++i) {
    const RunPtr run = flashing.execute();
    EXPECT_GE(run->last_cycle() - run->first_cycle(), 50);
    ASSERT_EQ(lit.size(), static_cast<std::size_t>(i) + 1) << "external handlers are called";
    EXPECT_GE(lit.back(), run->first_cycle());
    EXPECT_FALSE(digital_output(cell.model(), "io/lamp").now().value());
  }
}

// -- Reactions ------------------------------------------------------------------------------------------------------

TEST(Cell, O7_AForceBrakesTheMotionWhenTheCertificateSays) {
  Cell cell("touch.json", with("/expectations", kOnlyLimits));
  const Actuator robot = cell.arm();
  const auto motion = robot.use<MotionInterface>();
  const auto down = robot.above("block", 0.05);
  motion.ptp(down, {.velocity = 0.5}).execute();
  cell.tare();
  motion.lin_by({0.0, 0.0, -0.1}, {.linear_velocity = 0.01, .until = is_greater(cell.force(), 5.0)}).execute();
  const double now = cell.force().now().value();
  const RunReport report = cell.finish();
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  ASSERT_EQ(report.reactions.size(), 1u);
  const Reaction& reaction = report.reactions.front();
  EXPECT_GT(reaction.event_cycle, 0);
  EXPECT_EQ(reaction.least, 0);
  EXPECT_EQ(reaction.most, 0) << "a sensor's event acts in the same cycle";
  EXPECT_EQ(reaction.braking_cycle, reaction.event_cycle);
  EXPECT_GT(now, 1.0) << "it still touches";
  EXPECT_LT(now, 15.0);
}

// -- Operator ---------------------------------------------------------------------------------------------------------

RunReport operated(const std::string& script, bool with_coroutines = false) {
  Cell cell("wave.json", {.set = {{"/expectations", kOnlyLimits}, {"/operator", script}}});
  return report_of(cell, [with_coroutines](Cell& own) {
    if (!with_coroutines) return there_and_back(own);
    const auto task = [](Cell& inner) -> Task {
      const auto motion = inner.arm().use<MotionInterface>();
      const Activity there = motion.lin_by({0.0, 0.2, 0.0}, {.velocity = 0.5});
      const Activity back = motion.lin_by({0.0, -0.2, 0.0}, {.velocity = 0.5});
      co_await there;
      co_await inner.runtime().cycles(50);
      co_await back;
    };
    own.runtime().spawn(task(own));
    own.run(task(own));
  });
}

TEST(Cell, P2_APauseOfTheOperatorStandsOnThePathAndGoesOn) {
  const RunReport plain = operated("[]");
  const RunReport paused = operated(R"([{"at_s": 0.3, "do": "pause"}, {"at_s": 1.3, "do": "resume"}])");
  const RunReport slow = operated(R"([{"at_s": 0, "do": "override", "value": 0.5}])");
  for (const RunReport* report : {&plain, &paused, &slow})
    EXPECT_EQ(report->verdict, Verdict::kPassed) << report->diagnostics.to_string();
  EXPECT_GT(paused.sim_time, plain.sim_time + 0.8);
  EXPECT_GT(slow.sim_time, 1.5 * plain.sim_time);
}

TEST(Cell, L6_ACancelOfTheOperatorEndsTheProgramInOrder) {
  for (const bool coroutines : {false, true}) {
    const RunReport cancelled = operated(R"([{"at_s": 0.4, "do": "cancel"}])", coroutines);
    EXPECT_EQ(cancelled.verdict, Verdict::kPassed) << cancelled.diagnostics.to_string();
    EXPECT_LT(cancelled.sim_time, 1.2);
  }
  const RunReport in_pause = operated(R"([{"at_s": 0.3, "do": "pause"}, {"at_s": 1, "do": "cancel"}])");
  EXPECT_EQ(in_pause.verdict, Verdict::kPassed) << in_pause.diagnostics.to_string();
  EXPECT_LT(in_pause.sim_time, 1.3);
}

TEST(Cell, L6_AnAbortStopsTheDevicesAndFailsTheProgram) {
  for (const bool coroutines : {false, true}) {
    const RunReport aborted = operated(R"([{"at_s": 0.4, "do": "abort"}])", coroutines);
    EXPECT_EQ(aborted.verdict, Verdict::kError);
    EXPECT_THAT(aborted.diagnostics, Reports(Code::kCancelled, ""));
    EXPECT_THAT(aborted.diagnostics, Not(takt::test::ReportsAnywhere(Code::kNotPossibleNow)));
    EXPECT_TRUE(failed(aborted).empty()) << "within the limits";
  }
}

TEST(Cell, L6_AnAbortBetweenTwoNetsStopsTheNextOne) {
  Cell cell("wave.json", {.set = {{"/expectations", kOnlyLimits}, {"/operator", R"([{"at_s": 0.1, "do": "abort"}])"}}});
  const RunReport aborted = report_of(cell, [](Cell& own) {
    own.wait(0.3);
    there_and_back(own);
  });
  EXPECT_EQ(aborted.verdict, Verdict::kError);
  EXPECT_THAT(aborted.diagnostics, Reports(Code::kCancelled, ""));
  EXPECT_LT(aborted.sim_time, 0.5);
}

TEST(Cell, AToolIsChangedAsInAFile) {
  Cell cell("tool_change.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const Actuator arm = cell.arm();
  const auto motion = arm.use<MotionInterface>();
  const auto changer = cell.tool_changer().use<ToolChangerInterface>();
  const auto above = [&](double height) { return cell.frame("probe side").offset(0, 0, -height).in("arm"); };
  EXPECT_THAT(error_of([&] { arm.use_tool("probe"); }), Reports(Code::kNotPossibleNow, "/arm/tool", {"probe"}));
  arm.use_tool("changer");
  motion.ptp(above(0.06)).execute();
  EXPECT_THAT(error_of([&] { changer.couple().execute(); }), takt::test::ReportsAnywhere(Code::kConditionNotMet))
      << "60 mm above it";
  changer.uncouple().execute();
  motion.lin(above(0.0), {.linear_velocity = 0.05}).execute();
  changer.couple({.tool = "probe"}).execute();
  arm.use_tool("probe");
  motion.lin_by({0.0, 0.0, 0.16}).execute();
  EXPECT_NEAR(arm.tcp("probe").translation().z(), arm.tcp("changer").translation().z() + 0.022 + 0.11, 1e-9);
  EXPECT_THAT(error_of([&] { changer.couple().execute(); }), takt::test::ReportsAnywhere(Code::kConflict));
  const Eigen::Isometry3d back = cell.frame("probe place").in("arm");
  arm.use_tool("changer");
  motion.lin(back, {.linear_velocity = 0.1}).execute();
  changer.uncouple({.onto = "probe dock"}).execute();
  EXPECT_LT((cell.frame("probe side").in("probe place").translation()).norm(), 1e-3);
  EXPECT_THAT(error_of([&] { arm.use_tool("probe"); }), Reports(Code::kNotPossibleNow, "/arm/tool", {"probe"}));
}

TEST(Cell, AMoveGoesAroundAndIsRefusedWhereItsGoalCollides) {
  Cell cell("touch.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto motion = cell.arm().use<MotionInterface>();
  kinematics::JointVector into_block(7);
  into_block << 0.0, -1.3, 0.0, 1.3, 0.0, -0.5, 0.0;
  const double before = cell.time();
  EXPECT_THAT(error_of([&] { motion.move(into_block).execute(); }),
              takt::test::ReportsAnywhere(Code::kCollision, {"chuck"}));
  EXPECT_LT(cell.time() - before, 0.1) << "nothing has moved";
  // Out of reach of the block the same motion is carried out.
  kinematics::JointVector aside = into_block;
  aside[0] = 1.2;
  aside[1] = -0.6;
  motion.move(aside).execute();
  EXPECT_LT((cell.arm().q() - aside).norm(), 1e-6);
}

/// Two arms on either side of a room for one.
kinematics::JointVector turned(double degrees) {
  kinematics::JointVector q(7);
  q << degrees, -50.0, 0.0, 70.0, 0.0, -60.0, 0.0;
  return q * (std::numbers::pi / 180.0);
}

TEST(Cell, AMoveGoesAroundWhatOthersDoMeanwhile) {
  Cell cell("beside.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto left = cell.arm("left").use<MotionInterface>(), right = cell.arm("right").use<MotionInterface>();
  const auto to_begin = [&] {
    left.ptp(turned(-60.0)).execute();
    right.ptp(turned(-60.0)).execute();
  };
  to_begin();
  right.ptp(turned(60.0)).begin_execute();
  left.move(turned(60.0)).begin_execute();
  cell.wait_for_all();
  EXPECT_LT((cell.arm("left").q() - turned(60.0)).norm(), 1e-6);
  EXPECT_LT((cell.arm("right").q() - turned(60.0)).norm(), 1e-6);
  // The other is on its way already.
  left.move(turned(-60.0)).execute();
  right.ptp(turned(-60.0)).execute();
  right.ptp(turned(60.0), {.velocity = 0.5}).begin_execute();
  cell.wait(0.3);
  left.move(turned(60.0)).execute();
  cell.wait_for_all();
  EXPECT_EQ(report_of(cell, [](Cell&) {}).verdict, Verdict::kPassed) << "nothing has met";
}

TEST(Cell, AMoveToWhereAnotherMachineComesIsRefused) {
  Cell cell("beside.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto left = cell.arm("left").use<MotionInterface>(), right = cell.arm("right").use<MotionInterface>();
  left.ptp(turned(-60.0)).execute();
  right.ptp(turned(-60.0)).execute();
  right.ptp(turned(0.0)).begin_execute();
  EXPECT_THAT(error_of([&] { left.move(turned(0.0)).execute(); }),
              takt::test::ReportsAnywhere(Code::kCollision, {"left/", "right/", "PTP", " s after"}));
  cell.wait_for_all();
  EXPECT_LT((cell.arm("left").q() - turned(-60.0)).norm(), 1e-6) << "it has not moved";
}

TEST(Cell, AnyMotionSeesWhatOthersMoveMeanwhile) {
  Cell cell("beside.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto left = cell.arm("left").use<MotionInterface>(), right = cell.arm("right").use<MotionInterface>();
  left.ptp(turned(-60.0)).execute();
  right.ptp(turned(-60.0)).execute();
  right.ptp(turned(60.0)).begin_execute();
  EXPECT_THAT(error_of([&] { left.ptp(turned(60.0)).execute(); }),
              takt::test::ReportsAnywhere(Code::kCollision, {"left/", "right/", "PTP"}));
  EXPECT_LT((cell.arm("left").q() - turned(-60.0)).norm(), 1e-6) << "it has not moved";
  left.lin_by({0.0, 0.0, 0.02}).execute();  // there is room, and time
  cell.wait_for_all();
  EXPECT_LT((cell.arm("right").q() - turned(60.0)).norm(), 1e-6);
}

TEST(Cell, AMotionThatWouldCollideIsRefusedBeforeItBegins) {
  Cell cell("touch.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto motion = cell.arm().use<MotionInterface>();
  kinematics::JointVector into_block(7);
  into_block << 0.0, -1.3, 0.0, 1.3, 0.0, -0.5, 0.0;
  const double before = cell.time();
  EXPECT_THAT(error_of([&] { motion.ptp(into_block).execute(); }),
              takt::test::ReportsAnywhere(Code::kCollision, {"block"}));
  EXPECT_LT(cell.time() - before, 0.1);
  motion.lin_by({0.0, 0.1, 0.0}).execute();  // there is room
  EXPECT_EQ(report_of(cell, [](Cell&) {}).verdict, Verdict::kPassed);
}

TEST(Cell, TheDistanceOfTwoBodiesIsASensor) {
  Cell cell("touch.json", {.set = {{"/expectations", "[]"}}, .quiet = true});
  const auto motion = cell.arm().use<MotionInterface>();
  const expression::RealSensor distance = cell.distance({"probe"}, {"table"});
  ASSERT_TRUE(distance.now());
  const double before = *distance.now();
  motion.lin_by({0.0, 0.0, 0.05}).execute();
  EXPECT_GT(*distance.now(), before + 0.02);
  const auto run = motion.lin_by({0.0, 0.0, -0.3}, {.linear_velocity = 0.05, .until = is_less(distance, before)});
  run.execute();
  EXPECT_NEAR(*distance.now(), before, 2e-3) << "it brakes within a millisecond or two";
  EXPECT_THAT(error_of([&] { (void)cell.distance({"arm"}, {"tabel"}); }),
              Reports(Code::kUnknownName, "", {"tabel", "table"}));
}

}  // namespace
}  // namespace takt::app
