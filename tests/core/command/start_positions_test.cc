// Where planned motions of a tree begin: known before, or refused.
#include "core/command/start_positions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::ReportsAnywhere;

class WhereaboutsTest : public testing::Test {
 protected:
  RuntimeCommand motion(const std::string& name, double a1) const {
    return {name, cell.arm_actuator(), ptp(cell.joints(a1))};
  }
  RuntimeCommand light(const std::string& name) const { return {name, cell.lamp(), set_value(true)}; }
  void expect_known(const Command& command) {
    const Diagnostics diagnostics = plan(command);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  void expect_unknown(const Command& command, const char* who) {
    EXPECT_THAT(plan(command), ReportsAnywhere(Code::kUnknownPosition, {who}));
    EXPECT_FALSE(cell.runtime.load(command).has_value());
  }
  test::CommandCell cell;
};

TEST_F(WhereaboutsTest, OneAfterTheOtherGoesFromEndToEnd) {
  RuntimeCommand a = motion("a", 0.2), b = motion("b", 0.4), c = motion("c", 0.0);
  TransactionCommand all("all");
  all.add_started(a).add(b).add(c);
  all.on_entered(a.completed(), start(b)).on_entered(b.completed(), start(c));
  expect_known(all);
  LoadedCommand handle = cell.runtime.load(all).value();
  handle.start();
  EXPECT_TRUE(cell.run(handle).succeeded());
  EXPECT_LT((cell.q() - cell.joints(0.0)).norm(), 1e-9);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(WhereaboutsTest, WhatComesBetweenDoesNotMatter) {
  RuntimeCommand a = motion("a", 0.2), b = motion("b", 0.4), lamp = light("lamp");
  WaitCommand wait("wait", 0.01);
  TransactionCommand all("all");
  all.add_started(a).add(lamp).add(wait).add(b);
  all.on_entered(a.completed(), start(lamp)).on_entered(lamp.completed(), start(wait));
  all.on_entered(wait.completed() && lamp.completed(), start(b));
  expect_known(all);
}

TEST_F(WhereaboutsTest, ACancelMakesItUnknownUnlessTheStartExcludesIt) {
  for (const bool excluded : {false, true}) {
    RuntimeCommand a = motion("a", 0.2), b = motion("b", 0.4);
    TransactionCommand all("all");
    a.on_entered(cell.hard(), cancel(a));
    all.add_started(a).add(b);
    all.on_entered(excluded ? a.completed() && !a.cancelled() : a.completed(), start(b));
    excluded ? expect_known(all) : expect_unknown(all, "b");
  }
}

TEST_F(WhereaboutsTest, ACancelOfTheWholeIsNoneOfItsBusiness) {
  RuntimeCommand a = motion("a", 0.2), b = motion("b", 0.4), c = motion("c", 0.1), d = motion("d", 0.3);
  TransactionCommand all("all"), forwarded("forwarded");
  all.add_started(a).add(b);
  all.on_entered(cell.hard(), cancel(all)).on_entered(a.completed(), start(b));
  expect_known(all);
  // Forwarded to the first only, the second is started where that was cut short.
  forwarded.add_started(c).add(d).on_cancel_forward_to({c});
  forwarded.on_entered(c.completed(), start(d));
  expect_unknown(forwarded, "d");
}

TEST_F(WhereaboutsTest, WhatBeginsByChanceIsRefused) {
  RuntimeCommand a = motion("a", 0.2), b = motion("b", 0.4);
  WaitCommand time("time", 1.0);
  TransactionCommand all("all");
  all.add_started(time).add(a).add(b);
  all.on_entered(expression::digital_input(cell.cell, "button"), start(a)).on_entered(cell.hard(), start(b));
  expect_unknown(all, "b");
  // Alone on its arm it begins where the arm is.
  RuntimeCommand c = motion("c", 0.2);
  WaitCommand more("more", 1.0);
  TransactionCommand one("one");
  one.add_started(more).add(c).on_entered(expression::digital_input(cell.cell, "button"), start(c));
  expect_known(one);
}

TEST_F(WhereaboutsTest, PlacesAreTakenAndGivenBack) {
  RuntimeCommand a("a", cell.arm_actuator(), lin(cell.moved(0.0, 0.05, 0.0)));
  expression::Places places{{"arm", cell.joints(0.2)}};
  EXPECT_TRUE(plan(a, places).empty());
  const Eigen::Isometry3d there = cell.arm->chain->forward(places.at("arm")) * cell.cell.arms.at("arm").X_FT;
  EXPECT_LT((there.translation() - cell.moved(0.0, 0.05, 0.0).translation()).norm(), 1e-6);
  EXPECT_EQ(a.node()->model().begins().front().q, cell.joints(0.2));
}

}  // namespace
}  // namespace takt::command
