// Fingers that give way (models/wsg50_sprung): what they run into, and what they hold.
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "tests/cell/runs.h"

namespace takt::cell {
namespace {

using test::parsed;
using test::Ran;
using test::run_kept;

/// Closed fingers go down onto a block at 5 mm/s until 5 N.
Ran touched_with(const std::string& arm, const std::string& gripper, const std::string& force) {
  return run_kept(parsed(R"({"devices": {
      "arm": {"model": ")" +
                         arm + R"(", "at": {"position_m": [0, 0, 0.75]}},
      "wrist": {"model": "ft_gamma", "on": "arm"},
      "gripper": {"model": ")" +
                         gripper +
                         R"(", "on": "wrist", "settings": {"start_width_m": 0}}},
    "objects": {"block": {"shape": "box", "size_m": [0.2, 0.2, 0.1], "at": {"position_m": [0.55, 0, 0.75]}}},
    "collisions": {"allow": [{"between": ["gripper", "block"], "reason": "the fingers touch it"}]},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.08], "rpy_deg": [180, 0, 0]}, "speed": 0.5},
      {"do": "tare"},
      {"do": "lin", "to": {"by_m": [0, 0, -0.03]}, "velocity_m_s": 0.005, "until": {"sensor": "wrist", "above_N": 5}},
      {"do": "lin", "to": {"by_m": [0, 0, 0.02]}, "speed": 0.3}]},
    "expectations": [{"kind": "contact_force", "between": ["gripper", "block"], )" +
                         force + "}]}"));
}

TEST(SprungFingers, TouchABlockGentlyWithAnyArm) {
  const auto measured = [](const Ran& ran) { return ran.report.expectations.at(0).measured; };
  for (const char* arm : {"lwr4plus", "ur5", "tx90"}) {
    const Ran soft = touched_with(arm, "wsg50_sprung", R"("at_least_N": 4, "below_N": 7)");
    EXPECT_EQ(soft.report.verdict, Verdict::kPassed) << arm << "\n" << soft.report.diagnostics.to_string();
    const Ran hard = touched_with(arm, "wsg50", R"("at_least_N": 8, "below_N": 100)");
    EXPECT_EQ(hard.report.verdict, Verdict::kPassed) << arm << ": so the case is one";
    std::printf("%s, springs: %s\n%s, plain: %s\n", arm, measured(soft).c_str(), arm, measured(hard).c_str());
  }
}

/// What hangs between the tips rests on their stops: an arm lifts it as stiffly as between plain fingers.
TEST(SprungFingers, HoldAPartAsPlainOnesDo) {
  const Ran ran = run_kept(parsed(R"({"devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}},
      "gripper": {"model": "wsg50_sprung", "on": "arm"}},
    "objects": {
      "table": {"model": "table", "at": {"position_m": [0.78, 0, 0]}},
      "part": {"shape": "box", "size_m": [0.04, 0.04, 0.06], "mass_kg": 0.5, "fixed": false,
               "at": {"position_m": [0.55, 0, 0.78]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "part", "position_m": [0, 0, 0.15], "rpy_deg": [180, 0, 0]}, "speed": 0.5},
      {"do": "lin", "to": {"in": "part", "position_m": [0, 0, 0.005], "rpy_deg": [180, 0, 0]}, "velocity_m_s": 0.1},
      {"do": "grip", "force_N": 60},
      {"do": "lin", "to": {"by_m": [0, 0, 0.2]}, "velocity_m_s": 0.3}]},
    "expectations": [
      {"kind": "object_pose", "object": "part", "in": "world", "position_m": [0.55, 0, 0.98],
       "position_within_m": 0.001, "angle_within_deg": 0.5}]})"));
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
}

}  // namespace
}  // namespace takt::cell
