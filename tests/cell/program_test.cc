// Programs run in a small cell: latency, budget of steps, guarded motions, rehearsal.
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::program_test {
namespace {

using Json = nlohmann::ordered_json;
using takt::test::Reports;
using testing::AllOf;

/// An arm with sensor and probe over a plinth, up to 4 mm too high or low: the complete file of docs/tutorial.md.
Json example() {
  std::ifstream stream("docs/tutorial.md");
  const std::string page{std::istreambuf_iterator<char>(stream), {}};
  const std::size_t begin = page.rfind("```json\n") + 8;
  return Json::parse(page.substr(begin, page.find("```", begin) - begin));
}

/// The same cell with other steps and no expectations.
Json cell_with(const std::string& steps) {
  Json json = example();
  json["program"]["steps"] = Json::parse(steps);
  json["expectations"] = Json::array();
  return json;
}

Result<std::unique_ptr<Session>> session_of(const Json& json) {
  static const device::ModelLibrary models({"models"});
  auto description = parse_description(json.dump());
  if (!description) return std::unexpected(std::move(description.error()));
  return Session::create(std::move(*description), models);
}

RunReport run(const Json& json) {
  auto session = session_of(json);
  if (!session) {
    RunReport report;
    report.diagnostics = session.error();
    return report;
  }
  return (*session)->run({});
}

Diagnostics refusal(const Json& json) {
  const auto session = session_of(json);
  return session ? Diagnostics() : session.error();
}

TEST(Program, DevicesMayHaveAnyName) {
  std::string text = example().dump();
  const auto rename = [&text](const std::string& from, const std::string& to) {
    for (auto at = text.find('"' + from + '"'); at != text.npos; at = text.find('"' + from + '"', at + to.size())) {
      text.replace(at + 1, from.size(), to);
    }
  };
  rename("arm", "left arm 1.5 %");
  rename("wrist", "until");  // the condition's primitives begin with this word, too
  rename("probe", "Tastkopf für 5 mm");
  Json json = Json::parse(text);
  json["program"]["steps"][2]["until"] = Json::parse(R"({"any": [
      {"sensor": "until", "quantity": "force_z", "above_N": 5}, {"sensor": "until", "above_N": 5}]})");
  const RunReport report = run(json);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Program, D2_ANetStartsLatencyCyclesAfterTheCommand) {
  Json json = cell_with(R"([{"do": "ptp", "to": {"by_m": [0, 0, 0.02]}}])");
  const auto cycles = [&](int latency) {
    json["program_latency_cycles"] = latency;
    const RunReport report = run(json);
    EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
    return report.cycles;
  };
  const auto at_once = cycles(0);
  for (const int latency : {1, 2, 17, 50}) EXPECT_EQ(cycles(latency), at_once + latency);
}

TEST(Program, D2_MeasuringHoldsWhateverTheLatency) {
  Json json = example();
  json["expectations"].erase(3);  // "repeats": one run is enough here
  for (const int latency : {0, 1, 50}) {
    json["program_latency_cycles"] = latency;
    const RunReport report = run(json);
    EXPECT_EQ(report.verdict, Verdict::kPassed) << latency << " cycles\n" << report.diagnostics.to_string();
  }
}

TEST(Program, D1_AProgramThatNeverWaitsIsStoppedAndNamed) {
  const auto waits = [](int times) {
    Json json = cell_with(R"([{"do": "sequence", "steps": [{"do": "wait", "name": "nothing", "seconds": 0}]}])");
    json["program"]["steps"][0]["times"] = times;
    return run(json);
  };
  EXPECT_EQ(waits(9'000).verdict, Verdict::kPassed);
  const RunReport report = waits(20'000);
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kTooLarge, "/program/steps/0/steps/0", {"10000"}));
}

TEST(Program, ASequenceRunsAsOftenAsItSays) {
  Json json = cell_with(R"([
      {"do": "sequence", "times": 3, "steps": [{"do": "wait", "seconds": 0.1}]},
      {"do": "sequence", "times": 0, "steps": [{"do": "wait", "name": "never", "seconds": 9}]}])");
  json["expectations"] = Json::parse(R"([{"kind": "step", "step": "wait"}, {"kind": "step", "step": "never"}])");
  const RunReport report = run(json);
  EXPECT_EQ(report.cycles, 300);
  ASSERT_EQ(report.expectations.size(), 2u);
  EXPECT_EQ(report.expectations[0].value, 3.0);
  EXPECT_FALSE(report.expectations[1].passed);
  EXPECT_EQ(report.verdict, Verdict::kFailed);
}

TEST(Program, AGuardedMotionThatMeetsNothingFailsUnlessToldToGoOn) {
  Json json = cell_with(R"([{"do": "tare"}, {"do": "lin", "name": "into the air", "to": {"by_m": [0, 0, 0.01]},
                             "until": {"sensor": "wrist", "above_N": 5}}])");
  const RunReport failed = run(json);
  EXPECT_EQ(failed.verdict, Verdict::kError);
  EXPECT_THAT(failed.diagnostics, Reports(Code::kConditionNotMet, "/program/steps/1/until"));
  json["program"]["steps"][1]["on_end"] = "continue";
  EXPECT_EQ(run(json).verdict, Verdict::kPassed);
}

TEST(Program, ARunThatDoesNotEndIsAnErrorThatNamesTheStep) {
  Json json = cell_with(R"([{"do": "wait", "name": "long", "seconds": 5}])");
  json["time_limit_s"] = 0.5;
  const RunReport report = run(json);
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kTimeout, "/time_limit_s", {"0.5 s", "long"}));
}

TEST(Rehearsal, FindsWhatCannotWorkBeforeAnythingMoves) {
  const Diagnostics found = refusal(cell_with(R"([
      {"do": "ptp", "to": {"in": "plinht", "position_m": [0, 0, 0]}},
      {"do": "lin", "to": {"in": "plinth", "position_m": [3, 0, 0]}},
      {"do": "ptp", "to": {"joints_deg": [0, 0, 0, 150, 0, 0, 0]}}])"));
  EXPECT_THAT(found, AllOf(Reports(Code::kUnknownName, "/program/steps/0/to", {"plinht", "plinth"}),
                           Reports(Code::kUnreachable, "/program/steps/1/to"),
                           Reports(Code::kOutOfRange, "/program/steps/2/to", {"a3"})));
}

TEST(Rehearsal, RefusesGoalsOutOfReachAndOutOfRange) {
  EXPECT_THAT(refusal(cell_with(R"([{"do": "ptp", "to": {"in": "world", "position_m": [3, 0, 0]}}])")),
              Reports(Code::kUnreachable, "/program/steps/0/to"));
  EXPECT_THAT(refusal(cell_with(R"([{"do": "ptp", "to": {"joints_deg": [0, 0, 0, 150, 0, 0, 0]}}])")),
              Reports(Code::kOutOfRange, "/program/steps/0/to", {"a3"}));
}

TEST(Rehearsal, AContactNeedsATouchAndAFitNeedsContacts) {
  const Diagnostics found = refusal(cell_with(R"([
      {"do": "ptp", "to": "home"},
      {"do": "record_contact", "as": "top"},
      {"do": "fit_pose", "object": "plinth", "as": "found", "contacts": ["tip"], "free": ["x", "z"]}])"));
  EXPECT_THAT(found, Reports(Code::kRequires, "/program/steps/1", {"arm", "until"}));
}

TEST(Rehearsal, AFittedFrameMayBeUsedAfterwardsAndNotBefore) {
  const std::string step = R"({"do": "ptp", "to": {"in": "plinth found", "position_m": [0, 0, 0.1]}})";
  Json json = example();
  auto& steps = json["program"]["steps"];
  steps.push_back(Json::parse(step));
  EXPECT_TRUE(refusal(json).empty());
  steps.insert(steps.begin(), Json::parse(step));
  EXPECT_THAT(refusal(json), Reports(Code::kUnknownName, "/program/steps/0/to", {"plinth found"}));
}

}  // namespace
}  // namespace takt::cell::program_test
