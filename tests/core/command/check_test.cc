// Each rule of the layer, broken once: the diagnostic has the rule and its location, and nothing is loaded.
#include "core/command/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/actions/online_action.h"
#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::Reports;
using testing::AllOf;
using testing::Not;

class CheckTest : public testing::Test {
 protected:
  RuntimeCommand driver(const std::string& name, bool value = true) const {
    return {name, cell.driver(), set_value(value)};
  }
  RuntimeCommand lamp(const std::string& name) const { return {name, cell.lamp(), set_value(true)}; }

  /// Refused by the check, by the mapping and by LOAD, with the rule and the location.
  void expect_refused(const Command& command, const char* rule, const char* pointer, Code code) {
    EXPECT_THAT(check(command), Reports(code, pointer, {rule}));
    EXPECT_FALSE(map(command).has_value());
    EXPECT_FALSE(cell.runtime.load(command).has_value());
  }

  test::CommandCell cell;
};

TEST_F(CheckTest, C1_StartTargetsTheSameTransaction) {
  RuntimeCommand a = driver("a"), b = lamp("b");
  TransactionCommand both("both");
  a.on_entered(a.completed(), start(b));
  both.add_started(a).add(b);
  expect_refused(both, "C1", "/both/a/handlers/0", Code::kConflict);

  RuntimeCommand c = driver("c"), d = lamp("d");
  TransactionCommand inner("inner"), outer("outer");
  inner.add(d);
  inner.on_entered(inner.started(), start(d));
  outer.add_started(c).add_started(inner);
  outer.on_entered(c.completed(), start(d));
  expect_refused(outer, "C1", "/outer/handlers/0", Code::kConflict);
}

TEST_F(CheckTest, C2_StopAndCancelTargetOneselfOrWhatIsInside) {
  RuntimeCommand a = driver("a"), b = lamp("b");
  b.on_entered(b.completed(), cancel(a));
  TransactionCommand both("both");
  both.add_started(a).add_started(b);
  expect_refused(both, "C2", "/both/b/handlers/0", Code::kConflict);

  RuntimeCommand c = driver("c");
  TransactionCommand inner("inner");
  inner.add_started(c);
  c.on_entered(c.completed(), stop(inner));
  expect_refused(inner, "C2", "/inner/c/handlers/0", Code::kConflict);
}

TEST_F(CheckTest, C4_CancelIsForwardedToWhatIsInside) {
  RuntimeCommand a = driver("a"), elsewhere = lamp("elsewhere");
  TransactionCommand one("one");
  one.add_started(a).on_cancel_forward_to({a, elsewhere});
  expect_refused(one, "C4", "/one", Code::kInvalidValue);
}

TEST_F(CheckTest, C5_NothingStartsItself) {
  RuntimeCommand a = driver("a"), b = lamp("b"), c = driver("c");
  TransactionCommand round("round");
  round.add_started(c).add(a).add(b);
  round.on_entered(c.completed() || b.completed(), start(a)).on_entered(a.completed(), start(b));
  expect_refused(round, "C5", "/round/a", Code::kInvalidValue);

  RuntimeCommand d = driver("d"), e = lamp("e");
  TransactionCommand twice("twice");
  twice.add_started(d).add_started(e);
  twice.on_entered(d.completed(), start(e));
  expect_refused(twice, "C5", "/twice/handlers/0", Code::kInvalidValue);
}

TEST_F(CheckTest, C6_ACommandHasOnePlaceInOneTree) {
  RuntimeCommand a = driver("a");
  TransactionCommand inner("inner"), outer("outer");
  inner.add_started(a);
  outer.add_started(inner).add(a);
  expect_refused(outer, "C6", "/outer/a", Code::kDuplicate);

  RuntimeCommand b = driver("b"), stranger = lamp("stranger");
  TransactionCommand one("one");
  one.add_started(b);
  one.on_entered(stranger.completed(), cancel(b));
  expect_refused(one, "C6", "/one/handlers/0", Code::kUnknownName);

  TransactionCommand itself("itself");
  itself.add_started(b).add(itself);
  EXPECT_THAT(check(itself), Reports(Code::kDuplicate, "/itself/itself", {"C6"}));
}

TEST_F(CheckTest, C7_WhatRunsTogetherHasDevicesOfItsOwn) {
  RuntimeCommand a = driver("a"), b = driver("b");
  TransactionCommand inner("inner"), both("both");
  inner.add_started(b);
  both.add_started(a).add_started(inner);
  expect_refused(both, "C7", "/both/inner/b", Code::kResourceConflict);
}

TEST_F(CheckTest, C8_AnActionNeedsWhatItsActuatorOffers) {
  expect_refused(RuntimeCommand("x", cell.driver(), lin(Eigen::Isometry3d::Identity())), "C8", "/x",
                 Code::kInvalidValue);
  expect_refused(RuntimeCommand("y", cell.arm_actuator(), grip()), "C8", "/y", Code::kInvalidValue);
  RuntimeCommand z = driver("z");
  z.on_entered(z.action().at_path(0.5), cancel(z));
  expect_refused(z, "C8", "/z/handlers/0", Code::kUnknownName);
}

TEST_F(CheckTest, C9_SomethingMustStart) {
  expect_refused(TransactionCommand("empty"), "C9", "/empty", Code::kNeverFires);
  RuntimeCommand a = driver("a"), b = lamp("b");
  TransactionCommand idle("idle");
  idle.add(a).add(b);
  idle.on_entered(a.completed(), start(b));
  expect_refused(idle, "C9", "/idle", Code::kNeverFires);
}

TEST_F(CheckTest, C10_ARaisedStateBelongsToATransaction) {
  RuntimeCommand a = driver("a");
  TransactionCommand one("one");
  one.add_started(a);
  a.on_entered(a.completed(), raise(RaisedState("loose")));
  expect_refused(one, "C10", "/one/a/handlers/0", Code::kInvalidValue);

  RuntimeCommand b = driver("b");
  TransactionCommand two("two"), stranger("stranger");
  const RaisedState foreign = stranger.raised("foreign");
  two.add_started(b);
  two.on_entered(foreign.state(), cancel(b));
  expect_refused(two, "C10", "/two/handlers/0", Code::kInvalidValue);
}

TEST_F(CheckTest, AllFindingsComeAtOnce) {
  RuntimeCommand a = driver("a"), b("b", output(cell.cell, "dirver"), set_value(true));
  TransactionCommand many("many"), empty("empty");
  many.add_started(a).add_started(b).add(empty).add(a);
  many.on_entered(expression::is_greater(expression::element(expression::measured_joints(cell.cell, "amr"), 0), 1.0),
                  stop(b), {.delay = -1.0});
  const Diagnostics text = check(many);
  EXPECT_THAT(text,
              AllOf(Reports(Code::kDuplicate, "/many/a", {"C6"}), Reports(Code::kNeverFires, "/many/empty", {"C9"}),
                    Reports(Code::kUnknownName, "/many/b", {"dirver"}),
                    Reports(Code::kUnknownName, "/many/handlers/0", {"amr"}),
                    Reports(Code::kOutOfRange, "/many/handlers/0", {"-1"})));
}

TEST_F(CheckTest, FiguresOutOfRangeAreRefusedWithTheRange) {
  expect_refused(RuntimeCommand("x", output(cell.cell, "valve"), set_value(true)), "C8", "/x", Code::kInvalidValue);
  const auto valve = RuntimeCommand("valve", output(cell.cell, "valve"), set_value(11.0));
  EXPECT_THAT(check(valve), Reports(Code::kOutOfRange, "/valve", {"0", "10"}));
  const auto wide = RuntimeCommand("wide", gripper(cell.cell, "gripper"), grip({.width = 0.3}));
  EXPECT_THAT(check(wide), Reports(Code::kOutOfRange, "/wide/width", {"0", "0.11"}));
  const auto far = RuntimeCommand("far", cell.arm_actuator(), lin(cell.moved(5, 0, 0)));
  EXPECT_THAT(check(far), Reports(Code::kRequires, "/far"));
  EXPECT_THAT(cell.runtime.load(far).error(), Reports(Code::kUnreachable, "/far/goal"));
}

TEST_F(CheckTest, OneFaultOfPlanningBringsNoOthersWithIt) {
  RuntimeCommand far("far", cell.arm_actuator(), lin(cell.moved(5, 0, 0))),
      back("back", cell.arm_actuator(), ptp(cell.joints(0.1))), home("home", cell.arm_actuator(), ptp(cell.arm->home));
  TransactionCommand all("all");
  all.add_started(far).add(back).add(home);
  all.on_entered(far.completed(), start(back)).on_entered(back.completed(), start(home));
  const Diagnostics diagnostics = cell.runtime.load(all).error();
  ASSERT_EQ(diagnostics.list().size(), 1u) << diagnostics.to_string();
  EXPECT_EQ(diagnostics.list().front().pointer, "/all/far/goal");
  EXPECT_THAT(diagnostics, Reports(Code::kUnreachable, "/all/far/goal"));
}

TEST_F(CheckTest, WhatIsNotPlannedBecauseOfAnotherFaultIsNoFaultOfItsOwn) {
  RuntimeCommand one("one", cell.arm_actuator(), ptp(cell.joints(0.1))),
      other("other", cell.arm_actuator(), ptp(cell.joints(0.2)));
  TransactionCommand all("all");
  all.add(one).add(other);
  all.on_entered(one.completed(), start(other)).on_entered(other.completed(), start(one));
  const Diagnostics diagnostics = cell.runtime.load(all).error();
  EXPECT_THAT(diagnostics,
              AllOf(Reports(Code::kInvalidValue, "/all/one"), Not(takt::test::ReportsAnywhere(Code::kRequires))));
}

TEST_F(CheckTest, AFormulaTooDeepIsRefused) {
  expression::RealSensor deep = expression::element(expression::measured_joints(cell.cell, "arm"), 0);
  for (int i = 0; i < 1001; ++i) deep = deep + 1.0;
  EXPECT_EQ(deep.now(), std::nullopt);
  EXPECT_THAT(check(WaitCommand("wait", expression::is_greater(deep, 0.0))), Reports(Code::kTooLarge, "/wait"));
}

}  // namespace
}  // namespace takt::command
