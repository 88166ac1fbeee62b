// Two arms as one in the schema of scenario files, and in the code that reads them.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/file/description.h"
#include "cell/judge/expectations.h"
#include "core/program/tree/program.h"
#include "tests/cell/scenario_schema.h"

namespace takt::cell::pair_schema_test {
namespace {

using Json = nlohmann::json;
using test::Mistake;
using test::models;
using test::schema;

/// Two arms as one, and what must not hold meanwhile: a cell of its own, as the one above has one arm.
constexpr const char* kTwoArms = R"({
  "devices": {
    "left": {"model": "lwr4plus"}, "left wrist": {"model": "ft_gamma", "on": "left"},
    "right": {"model": "lwr4plus", "at": {"position_m": [1.2, 0, 0], "rpy_deg": [0, 0, 180]}},
    "right wrist": {"model": "ft_gamma", "on": "right"}},
  "program": {"do": "sequence", "steps": [
    {"do": "lin", "arm": "left", "follower": "right", "to": {"by_m": [0, 0, 0.05]}, "blend_m": 0.01,
     "abort_if": {"internal_force": ["left wrist", "right wrist"], "above_N": 40}},
    {"do": "circ", "arm": "left", "follower": "right", "about": {"position_m": [0.6, 0, 0.6], "angle_deg": 10},
     "until": {"internal_force": ["left wrist", "right wrist"], "below_N": "$5[N]"}, "on_end": "continue",
     "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": 500}},
    {"do": "ptp", "arm": "left", "to": "home", "abort_if": {"sensor": "left wrist", "above_N": 50}},
    {"do": "spline", "arm": "left", "through": ["home", "home"], "abort_if": {"sensor": "left wrist", "above_N": 50}},
    {"do": "transaction", "commands": {
      "one": {"do": "circ", "start": true, "arm": "left", "follower": "right",
              "about": {"position_m": [0.6, 0, 0.6], "angle_deg": 10}},
      "two": {"do": "motions", "steps": [
        {"do": "lin", "arm": "left", "follower": "right", "to": {"by_m": [0, 0, 0.05]}, "blend_m": 0.01},
        {"do": "lin", "arm": "left", "follower": "right", "to": {"by_m": [0, 0.05, 0]}}]}}}
  ]},
  "expectations": [{"kind": "relative_pose", "arms": ["left", "right"], "from": "lin", "to": "ptp",
                    "position_within_m": 0.001, "angle_within_deg": 0.1}]
})";

TEST(PairSchema, TwoArmsAsOneAreKnownToBothAndSoAreTheirMistakes) {
  Diagnostics warnings;
  auto built = build_cell(*parse_description(kTwoArms), models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  const auto refused = [&](const Json& json) {
    const auto description = parse_description(json.dump());
    const auto program = program::Program::parse(description->program, "/program", built->cell);
    return !program || !make_expectations(description->expectations, *built, program->names());
  };
  EXPECT_TRUE(schema().accepts(Json::parse(kTwoArms)));
  EXPECT_FALSE(refused(Json::parse(kTwoArms)));
  constexpr Mistake kWrong[] = {
      {"/program/steps/0/follower", "5"},
      {"/program/steps/0/weave", R"({"amplitude_m": 0.001, "frequency_Hz": 2})"},
      {"/program/steps/0/force_offset", R"({"sensor": "left wrist", "force_N": 5})"},
      {"/program/steps/0/base_to", "\"home\""},
      {"/program/steps/0/abort_if/above_N", nullptr},
      {"/program/steps/0/abort_if/below_N", "1"},
      {"/program/steps/0/abort_if/quantity", "\"force\""},
      {"/program/steps/0/abort_if/internal_force", "[\"left wrist\"]"},
      {"/program/steps/0/abort_if/internal_force", "\"left wrist\""},
      {"/program/steps/1/until/internal_force/0", "1"},
      {"/program/steps/1/compliance/force_N", "[0, 0, 5]"},
      {"/program/steps/1/compliance", R"({"mode": "joint_impedance", "torque_Nm": [1, 0, 0, 0, 0, 0, 0]})"},
      {"/program/steps/2/follower", "\"right\""},
      {"/program/steps/2/abort_if", "40"},
      {"/program/steps/3/follower", "\"right\""},
      {"/program/steps/4/commands/one/follower", "5"},
      {"/program/steps/4/commands/one/weave", R"({"amplitude_m": 0.001, "frequency_Hz": 2})"},
      {"/program/steps/4/commands/two/steps/0/weave", R"({"amplitude_m": 0.001, "frequency_Hz": 2})"},
      {"/program/steps/4/commands/two/steps/1/do", "\"ptp\""},
      {"/program/steps/4/commands/two/steps/1/follower", "false"},
      {"/expectations/0/arms", "[\"left\"]"},
      {"/expectations/0/arms", "\"left\""},
      {"/expectations/0/from", nullptr},
      {"/expectations/0/to", "1"},
      {"/expectations/0/position_within_m", "0"},
      {"/expectations/0/within_m", "1"},
  };
  for (const Mistake& mistake : kWrong) {
    SCOPED_TRACE(testing::PrintToString(mistake));
    const Json json = with_mistake(Json::parse(kTwoArms), mistake);
    EXPECT_FALSE(schema().accepts(json)) << "by the schema";
    EXPECT_TRUE(refused(json)) << "by takt";
  }
}

}  // namespace
}  // namespace takt::cell::pair_schema_test
