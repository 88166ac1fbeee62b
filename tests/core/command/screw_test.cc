// The papers' example (2013, Fig. 3): a screw is inserted until a force is felt, then the force is held while it is
// tightened. Here holding is a hold of the arm; the force comes with force control.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"

namespace takt::command {
namespace {

using net::Cause;

class Screw : public testing::Test {
 protected:
  Screw()
      : insert("insert", cell.arm_actuator(), lin(cell.moved(0, 0, -0.05), {.linear_velocity = 0.05})),
        keep("keep", cell.arm_actuator(), hold()),
        turn("turn", cell.driver(), set_value(true)),
        turned("turned", 0.2),
        off("off", cell.driver(), set_value(false)),
        screwing("screwing") {
    insert.on_entered(cell.hard(), cancel(insert));
    screwing.add_started(insert).add(keep).add(turn).add(turned).add(off);
    screwing.on_entered(insert.completed(), start(keep)).on_entered(insert.completed(), start(turn));
    screwing.on_entered(turn.completed(), start(turned)).on_entered(turned.completed(), start(off));
    screwing.on_entered(off.completed(), cancel(keep));
  }
  LoadedCommand load() {
    auto handle = cell.runtime.load(screwing);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    return handle.value();
  }

  test::CommandCell cell;
  RuntimeCommand insert, keep, turn;
  WaitCommand turned;
  RuntimeCommand off;
  TransactionCommand screwing;
};

TEST_F(Screw, RunsFromContactToTheEnd) {
  LoadedCommand handle = load();
  handle.start();
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  EXPECT_FALSE(cell.cell.digital_outputs.at("driver")->value()) << "nothing is turned before the contact";
  cell.extra.force.z() = 6.0;
  cell.runtime.step();
  const auto begun = cell.core.cycle();
  while (!cell.cell.digital_outputs.at("driver")->value()) {
    cell.runtime.step();
    ASSERT_LT(cell.core.cycle(), begun + 500);
  }
  EXPECT_TRUE(cell.core_arm().at_rest()) << "it turns when the arm has come to rest";
  const CommandStatus status = cell.run(handle);
  EXPECT_EQ(status.cause.code, Cause::Code::kTerminated) << status.to_string();
  EXPECT_FALSE(cell.cell.digital_outputs.at("driver")->value());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(Screw, O4_HoldingAndInsertingExcludeEachOther) {
  const LoadedCommand handle = load();
  const auto& report = cell.core.net(handle.net())->report();
  int shared = 0;
  for (const auto& exclusion : report.exclusions) {
    EXPECT_TRUE(exclusion.proven) << exclusion.at;
    ++shared;
  }
  EXPECT_EQ(shared, 2) << "arm and driver";
}

}  // namespace
}  // namespace takt::command
