// Fragments that take turns at one arm in the middle of a motion (rows O3, O4): no cycle is left out, no limit is
// broken, and a conflict stops the arm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/motion/planner.h"
#include "tests/support/fake_cell.h"
#include "tests/support/motion_net.h"

namespace takt::command {
namespace {

using net::Cause;
using net::FragmentDescription;
using net::NetDescription;
using rcc::NetState;

class TakeTurns : public testing::Test {
 protected:
  /// A motion between joint positions, without its path and its arm: they go into fragments.
  TakeTurns() {
    device::JointVector goal = fake.arm->home;
    goal[0] += 0.6;
    goal[3] -= 0.4;
    fake.cell.override_channel.clear();  // the inside of the fragment stands alone here
    motion_ = *motion::plan_ptp(*fake.arm->chain, fake.arm->limits, fake.q(), goal, {.velocity = 0.5});
    net = test::motion_net({"turns", "arm", &motion_, fake.cell.arms.at("arm").X_FT, {}}, fake.cell, {})
              .fragments.front()
              .net;
    find("target_rate").parameters["condition"] = false;
    find("stopped").parameters["b"] = false;
    net.add("end", "Termination").link("done.value", "end.condition");
    path_ = find("path");
    arm_ = find("arm");
    std::erase_if(net.primitives, [](const auto& p) { return p.id == "path" || p.id == "arm"; });
    std::erase_if(net.links, [](const auto& l) { return l.to.starts_with("path.") || l.from.starts_with("path."); });
  }

  net::PrimitiveDescription& find(const std::string& id) {
    return *std::ranges::find(net.primitives, id, &net::PrimitiveDescription::id);
  }

  /// Active while the path parameter is below and above a limit.
  void add_switch(double below, double above) {
    net.add("early", "LessThan", {{"b", below}}).link("law.s", "early.a");
    net.add("late", "GreaterThan", {{"b", above}}).link("law.s", "late.a");
    net.add("not_early", "Not").link("early.value", "not_early.input");
  }

  void add_fragment(const std::string& id, const std::string& active, bool with_arm) {
    FragmentDescription f;
    f.id = id;
    f.net.primitives = {path_};
    for (const char* port : {"s", "ds", "dds"}) {
      f.inputs.emplace_back(port, std::string("path.") + port);
      net.link(std::string("law.") + port, id + "." + port);
    }
    if (with_arm) f.net.primitives.push_back(arm_);
    for (const char* port : {"q", "dq", "ddq"}) {
      if (with_arm) f.net.link(std::string("path.") + port, std::string("arm.") + port);
      f.outputs.emplace_back(port, std::string("path.") + port);
    }
    net.fragments.push_back(std::move(f));
    net.link(active, id + ".active");
  }

  void merge(const std::string& one, const std::string& other) {
    net.primitives.push_back(arm_);
    for (const std::string port : {"q", "dq", "ddq"}) {
      const std::string id = "merge_" + port;
      net.add(id, "MergeJoints").link(one + "." + port, id + ".input_1").link(other + "." + port, id + ".input_2");
      net.link(id + ".value", "arm." + port);
    }
  }

  /// Loads, starts and runs until the net has ended.
  rcc::NetId run() {
    const auto id = fake.core.load(net, {});
    EXPECT_TRUE(id.has_value()) << id.error().to_string();
    if (!id) return 0;
    const auto& exclusions = fake.core.net(*id)->report().exclusions;
    proven = std::ranges::all_of(exclusions, [](const auto& one) { return one.proven; });
    fake.core.start(*id);
    for (int i = 0; i < 20'000 && fake.core.state(*id) != NetState::kTerminated; ++i) fake.step();
    return *id;
  }

  void expect_at_the_goal(rcc::NetId id) const {
    EXPECT_EQ(fake.core.status(id).cause.code, Cause::Code::kTerminated) << fake.core.status(id).cause.text.view();
    EXPECT_EQ(fake.q(), motion_.q_goal);
    EXPECT_LE(fake.worst_limit_share(), 1.0);
  }

  test::FakeCell fake;
  NetDescription net;
  bool proven = false;  ///< that merged drivers exclude each other

 private:
  motion::Motion motion_;
  net::PrimitiveDescription path_, arm_;
};

TEST_F(TakeTurns, RowO4TwoDriversOfOneArmLeaveNoCycleOut) {
  add_switch(0.5, 0.5);
  add_fragment("first", "early.value", true);
  add_fragment("second", "not_early.value", true);
  expect_at_the_goal(run());
}

TEST_F(TakeTurns, RowO4FragmentsAtMerges) {
  add_switch(0.5, 0.5);
  add_fragment("first", "early.value", false);
  add_fragment("second", "not_early.value", false);
  merge("first", "second");
  expect_at_the_goal(run());
  EXPECT_TRUE(proven);
}

TEST_F(TakeTurns, RowO4AConflictStopsTheArmInsideItsLimits) {
  add_switch(0.6, 0.4);
  add_fragment("first", "early.value", false);
  add_fragment("second", "late.value", false);
  merge("first", "second");
  const auto id = run();
  EXPECT_FALSE(proven);
  EXPECT_EQ(fake.core.status(id).cause.code, Cause::Code::kConflict);
  fake.step(2000);
  EXPECT_EQ(fake.core_arm().set_point().dq.norm(), 0.0) << "it stands";
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

/// Between 0.4 and 0.6 neither runs: the guard sees a moving arm without a set point.
TEST_F(TakeTurns, RowO3WithoutAnActiveFragmentTheArmIsNotTouched) {
  add_switch(0.4, 0.6);
  add_fragment("first", "early.value", true);
  add_fragment("second", "late.value", true);
  const auto id = run();
  EXPECT_EQ(fake.core.status(id).cause.code, Cause::Code::kGuard);
  fake.step(2000);
  EXPECT_EQ(fake.core_arm().set_point().dq.norm(), 0.0);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::command
