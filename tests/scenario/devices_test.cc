// Grippers, signals and beams in whole scenarios.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/session.h"

namespace takt::scenario {
namespace {

using testing::HasSubstr;

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

Description parsed(const std::string& text) {
  auto description = parse_description(text);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  return std::move(*description);
}

RunReport run(Description description) {
  auto session = Session::create(std::move(description), models());
  if (!session) {
    ADD_FAILURE() << session.error().to_string();
    return {};
  }
  return (*session)->run({});
}

std::string refusal(Description description) {
  const auto session = Session::create(std::move(description), models());
  return session ? "" : session.error().to_string();
}

void expect_passed(const RunReport& report) {
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.findings.to_string();
  for (const auto& one : report.expectations) EXPECT_TRUE(one.passed) << one.name << ": " << one.measured;
}

Description pick(const std::vector<Override>& overrides = {}) {
  auto description = read_description("scenarios/pick.json", overrides);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  std::erase_if(description->expectations, [](const auto& one) { return one.kind == "repeats"; });
  return std::move(*description);
}

TEST(Pick, ThePartStandsOnTheBox) { expect_passed(run(pick())); }

TEST(Pick, TooWeakAGripIsSeen) {
  const RunReport report = run(pick({{"/program/steps/2/force_N", "8"}}));
  EXPECT_EQ(report.verdict, Verdict::kFailed) << report.findings.to_string();
  EXPECT_FALSE(report.expectations[0].passed) << report.expectations[0].measured;
}

TEST(Pick, AGripOfNothingFailsTheStep) {
  const RunReport report = run(pick({{"/objects/part/at/position_m", "[0.56, -0.15, 0.78]"},
                                     {"/objects/part/vary", R"({"position_m": [0, 0.2, 0]})"}}));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.findings.to_string(), HasSubstr("no part was found"));
  EXPECT_THAT(report.findings.to_string(), HasSubstr("/program/steps/2"));
}

TEST(Pick, FiguresBeyondTheGripperAreFoundBeforeTheRun) {
  EXPECT_THAT(refusal(pick({{"/program/steps/2/force_N", "81"}})), HasSubstr("/program/steps/2/force_N"));
  EXPECT_THAT(refusal(pick({{"/program/steps/7/width_m", "0.2"}})), HasSubstr("/program/steps/7/width_m"));
  EXPECT_THAT(refusal(pick({{"/program/steps/2/part", "\"prat\""}})), HasSubstr("did you mean 'part'?"));
}

/// A motion that watches the grip stops where the part is lost; one that never loses it says so.
TEST(Pick, AMotionMayWatchTheGrip) {
  const Override watch{"/program/steps/4/until", R"({"gripper": "gripper", "is": "lost"})"};
  EXPECT_EQ(run(pick({watch, {"/program/steps/2/force_N", "8"}})).verdict, Verdict::kFailed);
  const RunReport held = run(pick({watch}));
  EXPECT_EQ(held.verdict, Verdict::kError);
  EXPECT_THAT(held.findings.to_string(), HasSubstr("the condition never held"));
}

/// A button pressed by a script, a valve that is read back, a lamp wired to a terminal.
constexpr const char* kTerminals = R"({
  "time_limit_s": 20,
  "devices": {
    "io": {"model": "io_block", "settings": {
      "do1": {"name": "lamp"}, "ao1": {"name": "valve"},
      "di1": {"name": "button", "script": [{"at_s": 0.1, "value": true}, {"at_s": 0.2, "value": false}]},
      "di2": {"name": "lamp seen", "from": "io/lamp"}, "ai1": {"name": "valve seen", "from": "io/valve"}}}
  },
  "program": {"do": "sequence", "steps": [
    {"do": "wait", "until": {"input": "io/button"}, "timeout_s": 1},
    {"do": "set", "output": "io/lamp", "value": true},
    {"do": "wait", "until": {"input": "io/lamp seen"}, "timeout_s": 0.01},
    {"do": "set", "output": "io/valve", "value": 7.5},
    {"do": "wait", "until": {"input": "io/valve seen", "above_V": 7.4}, "timeout_s": 0.01},
    {"do": "wait", "until": {"all": [{"input": "io/button", "is": false}, {"input": "io/valve seen", "below_V": 7.6}]},
     "timeout_s": 1}
  ]},
  "expectations": [
    {"kind": "signal", "signal": "io/lamp seen", "is": true, "rises": 1},
    {"kind": "signal", "signal": "io/button", "is": false, "rises": 1},
    {"kind": "signal", "signal": "io/valve", "at_least": 7.5, "at_most": 7.5},
    {"kind": "duration", "below_s": 0.4}
  ]
})";

TEST(Terminals, ProgramsSetAndWait) {
  const RunReport report = run(parsed(kTerminals));
  expect_passed(report);
  // 7.5 V at 100 V/s: 75 ms that the valve takes; the button is released before.
  EXPECT_GT(report.sim_time, 0.175);
}

TEST(Terminals, AWaitThatEndsInVainFails) {
  Description description = parsed(kTerminals);
  description.program["steps"][0]["timeout_s"] = 0.05;
  const RunReport report = run(std::move(description));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.findings.to_string(), HasSubstr("/program/steps/0/until"));
  EXPECT_THAT(report.findings.to_string(), HasSubstr("did not hold within 0.05 s"));
}

TEST(Terminals, MistakesAreFindingsWithTheirPlace) {
  const std::pair<const char*, const char*> mistakes[] = {
      {R"({"do9": {}})", "/devices/io/settings/do9"},
      {R"({"di1": {"from": "nothing"}})", "/devices/io/settings/di1"},
      {R"({"di1": {"from": "io/ao1"}})", "no digital output or light barrier"},
      {R"({"do1": {"from": "io/do2"}})", "key 'from' is not known here"},
      {R"({"do1": {"name": "do2"}})", "the name of two terminals"},
      {R"({"di1": {"script": [{"at_s": 1, "value": true}, {"at_s": 0.5, "value": false}]}})", "ascending times"},
      {R"({"di1": {"from": "io/do1", "script": []}})", "a wire, or a script"}};
  for (const auto& [settings, text] : mistakes) {
    Description description = parsed(R"({"devices": {"io": {"model": "io_block"}},
                                        "program": {"do": "wait", "seconds": 0}})");
    description.devices[0].settings = nlohmann::ordered_json::parse(settings);
    EXPECT_THAT(refusal(std::move(description)), HasSubstr(text)) << settings;
  }
}

TEST(Terminals, MistakesOfAProgramAreFindings) {
  const std::pair<const char*, const char*> mistakes[] = {
      {R"({"do": "set", "output": "io/lmap", "value": true})", "did you mean 'io/lamp'?"},
      {R"({"do": "set", "output": "io/valve", "value": true})", "/program/value"},
      {R"({"do": "set", "output": "io/valve", "value": 11})", "0 to 10 V"},
      {R"({"do": "wait", "until": {"input": "io/valve seen", "above_m": 1}})", "above_V"},
      {R"({"do": "wait", "until": {"input": "io/buton"}})", "did you mean 'io/button'?"},
      {R"({"do": "grip"})", "key 'gripper' is missing"}};
  for (const auto& [program, text] : mistakes) {
    Description description = parsed(kTerminals);
    description.expectations.clear();
    description.program = nlohmann::ordered_json::parse(program);
    EXPECT_THAT(refusal(std::move(description)), HasSubstr(text)) << program;
  }
}

/// A range finder below looks up at the flange, which comes down until it is 0.6 m away.
TEST(Beams, AMotionStopsWhereTheRangeFinderSays) {
  const RunReport report = run(parsed(R"({
    "devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}},
      "finder": {"model": "range_finder", "at": {"position_m": [0.56, 0, 0.45], "rpy_deg": [0, -90, 0]}}
    },
    "program": {"do": "sequence", "steps": [
      {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.1]}, "velocity_m_s": 0.05,
       "until": {"input": "finder", "below_m": 0.6}}
    ]},
    "expectations": [{"kind": "signal", "signal": "finder", "at_least": 0.59, "at_most": 0.601}]
  })"));
  expect_passed(report);
}

}  // namespace
}  // namespace takt::scenario
