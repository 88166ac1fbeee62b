// Motions that say where they begin, single joints and composed devices as actuators.
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"

namespace takt::command {
namespace {

class ExplicitStartTest : public ::testing::Test {
 protected:
  RuntimeCommand moved(const char* name, const Action& action) const { return {name, cell.arm_actuator(), action}; }
  /// The tool with the arm at q.
  Eigen::Isometry3d tool_at(const device::JointVector& q) const {
    return cell.arm->chain->forward(q) * cell.cell.arms.at("arm").X_FT;
  }
  rcc::NetId load(const Command& command) {
    const Diagnostics unplanned = plan(command);
    EXPECT_TRUE(unplanned.empty()) << unplanned.to_string();
    auto mapped = map(command, cell.core.period());
    if (!mapped) {
      ADD_FAILURE() << mapped.error().to_string();
      return 0;
    }
    const auto id = cell.core.load(mapped->net, mapped->options);
    EXPECT_TRUE(id) << id.error().to_string();
    return id.value_or(0);
  }
  test::CommandCell cell;
};

// scheduleAfter of the papers: the second motion is planned and loaded before the first one has begun.
TEST_F(ExplicitStartTest, MotionsWithAStartAreChainedWithoutAnEmptyCycle) {
  cell.step(5);
  const device::JointVector between = cell.joints(0.1);
  Eigen::Isometry3d X_goal = tool_at(between);
  X_goal.translation().z() += 0.05;
  const rcc::NetId first = load(moved("first", ptp(between)));
  const rcc::NetId second = load(moved("second", lin(X_goal, {.from = between})));
  ASSERT_TRUE(cell.core.schedule_after(first, second));
  ASSERT_NE(cell.core.start(first), 0);
  for (int i = 0; i < 10'000 && cell.core.state(second) != rcc::NetState::kTerminated; ++i) cell.step();
  EXPECT_TRUE(cell.core.status(second).cause.in_order());
  EXPECT_EQ(cell.core.status(second).first_cycle, cell.core.status(first).last_cycle + 1);
  EXPECT_LT((tool_at(cell.q()).translation() - X_goal.translation()).norm(), 1e-9);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ExplicitStartTest, AStartThatTheArmWillNotBeAtIsRefusedWhereThatIsKnown) {
  cell.step(5);
  TransactionCommand both("both");
  const RuntimeCommand first = moved("first", ptp(cell.joints(0.1)));
  const RuntimeCommand second = moved("second", ptp(cell.joints(0.3), {.from = cell.joints(0.2)}));
  both.add_started(first).add(second);
  both.on_entered(first.completed(), start(second));
  const Diagnostics found = plan(both);
  ASSERT_EQ(found.list().size(), 1U) << found.to_string();
  EXPECT_EQ(found.list().front().code, Code::kConflict);
  EXPECT_EQ(found.list().front().pointer, "/both/second/from");
  const RuntimeCommand other = moved("other", ptp(cell.joints(0.3), {.from = device::JointVector::Zero(2)}));
  EXPECT_EQ(plan(other).list().front().code, Code::kWrongSize);
}

// Where the first one may be cut short nothing but the run shows whether the start is right.
TEST_F(ExplicitStartTest, AWrongStartInTheRunIsAFailureWithAName) {
  cell.step(5);
  const auto after_a_cancel_at = [this](double share) {
    TransactionCommand both("both");
    const RuntimeCommand first = moved("first", ptp(cell.joints(0.2)));
    const RuntimeCommand second = moved("second", ptp(cell.joints(0.0), {.from = cell.joints(0.2)}));
    both.add_started(first).add(second);
    both.on_entered(first.action().at_path(share), cancel(first));
    both.on_entered(first.completed(), start(second));
    return both;
  };
  const CommandStatus status = cell.runtime.execute(after_a_cancel_at(0.3));
  EXPECT_EQ(status.cause.code, net::Cause::Code::kError);
  EXPECT_THAT(std::string(status.cause.text.view()), ::testing::HasSubstr("not where its motion begins"));
  cell.step(500);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ExplicitStartTest, AJointMovesWhileTheOthersStand) {
  cell.step(5);
  const device::JointVector before = cell.q();
  const CommandStatus status = cell.runtime.execute(
      RuntimeCommand("turned", joint(cell.cell, "arm", 3), ptp(device::JointVector::Constant(1, before[3] + 0.2))));
  EXPECT_TRUE(status.succeeded()) << status.to_string();
  device::JointVector goal = before;
  goal[3] += 0.2;
  EXPECT_LT((cell.q() - goal).norm(), 1e-9);
}

TEST_F(ExplicitStartTest, WhatAJointCannotDoIsRefused) {
  cell.step(5);
  const auto code_of = [this](const Actuator& actuator, const Action& action) {
    const RuntimeCommand command("turned", actuator, action);
    Diagnostics found = plan(command);
    found.append(check(command, false));
    return found.empty() ? std::nullopt : std::optional(found.list().front().code);
  };
  EXPECT_EQ(code_of(joint(cell.cell, "arm", 9), ptp(device::JointVector::Constant(1, 0.1))), Code::kOutOfRange);
  EXPECT_EQ(code_of(joint(cell.cell, "amr", 0), ptp(device::JointVector::Constant(1, 0.1))), Code::kUnknownName);
  EXPECT_EQ(code_of(joint(cell.cell, "arm", 1), ptp(cell.joints(0.1))), Code::kWrongSize);
  EXPECT_EQ(code_of(joint(cell.cell, "arm", 1), lin(cell.moved(0, 0, 0.05))), Code::kInvalidValue);
}

TEST_F(ExplicitStartTest, AComposedDeviceGivesEachActionToThePartThatTakesIt) {
  cell.step(5);
  const Actuator welder = composed("welder", {cell.arm_actuator(), cell.lamp(), gripper(cell.cell, "gripper")});
  TransactionCommand both("both");
  const RuntimeCommand moved("moved", welder, ptp(cell.joints(0.1)));
  const RuntimeCommand lit("lit", welder, set_value(true));
  both.add_started(moved).add_started(lit);
  const CommandStatus status = cell.runtime.execute(both);
  EXPECT_TRUE(status.succeeded()) << status.to_string();
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  EXPECT_LT((cell.q() - cell.joints(0.1)).norm(), 1e-9);
}

TEST_F(ExplicitStartTest, AComposedDeviceWithNoPartOrTwoForAnActionIsRefused) {
  const auto code_of = [](const Actuator& actuator) {
    const Diagnostics found = check(RuntimeCommand("lit", actuator, set_value(true)), false);
    return found.empty() ? std::nullopt : std::optional(found.list().front().code);
  };
  EXPECT_EQ(code_of(composed("welder", {cell.arm_actuator()})), Code::kUnsupported);
  EXPECT_EQ(code_of(composed("lamps", {cell.lamp(), cell.driver()})), Code::kConflict);
  EXPECT_EQ(code_of(composed("nothing", {})), Code::kMissing);
}

}  // namespace
}  // namespace takt::command
