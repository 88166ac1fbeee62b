// Manual control in the simulation: an operator holds a dead-man switch and lets it go.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/motion/limits.h"
#include "tests/cell/described.h"

namespace takt::cell::jog_test {
namespace {

constexpr const char* kCell = R"({
  "devices": {"arm": {"model": "lwr4plus"}},
  "channels": {"stick": {"type": "Twist", "unit": "m/s,rad/s"}, "switch": {"type": "Boolean", "initial": false},
               "done": {"type": "Boolean", "initial": false}},
  "program": {"do": "transaction", "name": "by hand", "commands": {
    "jog": {"do": "jog", "start": true, "channel": "stick", "in": "world", "while": {"channel": "switch"},
            "linear_max_m_s": 0.1}},
    "on": [{"entered": {"channel": "switch"}, "tell": "held"}, {"entered": {"channel": "done"}, "cancel": "jog"}]},
  "operator": [
    {"at_s": 0.1, "do": "write", "channel": "stick", "value": {"linear": [0, 0.08, 0], "angular": [0, 0, 0]}},
    {"at_s": 0.5, "do": "write", "channel": "switch", "value": true},
    {"at_s": 1.5, "do": "write", "channel": "switch", "value": false},
    {"at_s": 2.5, "do": "write", "channel": "switch", "value": true},
    {"at_s": 3.0, "do": "write", "channel": "stick", "value": null},
    {"at_s": 4.0, "do": "write", "channel": "done", "value": true}],
  "expectations": [{"kind": "limits"}, {"kind": "duration", "below_s": 4.5}]})";

TEST(Jog, TheArmMovesOnlyWhileTheSwitchIsHeldAndRestsInTheCyclesOfTheBound) {
  auto session = Session::create(test::parsed(kCell), test::models());
  ASSERT_TRUE(session.has_value()) << session.error().to_string();
  std::vector<double> speed;  // of the fastest joint's set point, rad/s, cycle by cycle
  RunOptions options;
  options.measure_times = false;
  options.repeat = false;
  options.after_cycle = [&](BuiltCell& built) {
    const device::Arm& arm = *built.core->arms().front();
    speed.push_back(arm.set_point().dq.size() == 0 ? 0.0 : arm.set_point().dq.cwiseAbs().maxCoeff());
    return true;
  };
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  for (const ExpectationResult& result : report.expectations) EXPECT_TRUE(result.passed) << result.measured;

  const auto& limits = (*session)->built().core->arms().front()->description().limits;
  const auto bound = static_cast<std::size_t>(std::ceil(motion::longest_stop(limits) / 1e-3)) + 2;
  ASSERT_GT(speed.size(), 3900u);
  for (std::size_t i = 0; i < speed.size(); ++i) {
    const bool may_move = (i >= 498 && i < 1500 + bound) || (i >= 2498 && i < 3000 + bound);
    if (!may_move) {
      ASSERT_EQ(speed[i], 0.0) << "cycle " << i;
    }
  }
  EXPECT_GT(speed[1400], 0.02);
  EXPECT_GT(speed[2900], 0.02);
  EXPECT_LT(speed[1504], speed[1499]) << "it brakes at once";
}

}  // namespace
}  // namespace takt::cell::jog_test
