// Channels in scenario files: nets of one program share values through them (row O5).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::channels_test {
namespace {

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// Counts to five, a step a run, in a channel that outlives the nets.
constexpr const char* kCounter = R"({
  "channels": {"count": {"type": "Real", "writer": "net", "unit": "m", "initial": 1},
               "step": {"type": "Real", "unit": "UNIT", "initial": 2}},
  "nets": {"add": {"primitives": [
      {"id": "was", "type": "InputReal", "parameters": {"channel": "count"}},
      {"id": "step", "type": "InputReal", "parameters": {"channel": "step"}},
      {"id": "sum", "type": "Add"},
      {"id": "is", "type": "OutputReal", "parameters": {"channel": "count"}},
      {"id": "shown", "type": "MonitorReal"},
      {"id": "end", "type": "Termination", "parameters": {"condition": true}}],
    "links": [{"from": "was.value", "to": "sum.a"}, {"from": "step.value", "to": "sum.b"},
              {"from": "sum.value", "to": "is.value"}, {"from": "sum.value", "to": "shown.value"}]}},
  "program": {"do": "sequence", "times": 2, "steps": [{"do": "net", "net": "add"}]},
  "expectations": [{"kind": "monitor", "net": "add", "monitor": "shown", "is": 5}]
})";

Result<std::unique_ptr<Session>> session_with(std::string unit) {
  std::string text = kCounter;
  text.replace(text.find("UNIT"), 4, unit);
  auto description = parse_description(text);
  if (!description) return std::unexpected(description.error());
  return Session::create(std::move(*description), models());
}

TEST(ChannelsOfAScenario, O5_OneRunOfANetReadsWhatTheLastOneWrote) {
  auto session = session_with("m");
  ASSERT_TRUE(session) << session.error().to_string();
  const RunReport report = (*session)->run({});
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  ASSERT_EQ(report.expectations.size(), 1u);
  EXPECT_TRUE(report.expectations[0].passed) << report.expectations[0].measured;
}

TEST(ChannelsOfAScenario, U1_TheirUnitsHoldForTheNetsBeforeAnythingRuns) {
  const auto session = session_with("N");
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(), takt::test::ReportsAnywhere(Code::kUnitMismatch, {"step", "N"}));
}

}  // namespace
}  // namespace takt::cell::channels_test
