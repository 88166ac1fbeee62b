// What a run tells of itself: what happened, when, in which step, and why (docs/recording.md).
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/device/arm.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "record/recording.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::story_test {
namespace {

using takt::test::Names;
using takt::test::Notes;
using test::parsed;

/// An arm with a probe over a block, whose flange points down.
std::string cell(const std::string& steps, const std::string& more = "") {
  return R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "program": {"do": "sequence", "name": "main", "steps": [)" +
         steps + "]}" + more + "}";
}

RunReport run(const std::string& text, const RunOptions& options = {}) { return test::run(parsed(text), options); }

std::vector<LogEntry> entries(const RunReport& report, const std::string& source, const std::string& name) {
  std::vector<LogEntry> found;
  for (const LogEntry& entry : report.log)
    if (entry.source == source && entry.name == name) found.push_back(entry);
  return found;
}

std::vector<std::string> words(const std::vector<LogEntry>& log, LogLevel least = LogLevel::kDebug) {
  std::vector<std::string> words;
  for (const LogEntry& entry : log)
    if (entry.level >= least) words.push_back(entry.source + " " + entry.name);
  return words;
}

constexpr const char* kAbove = R"({"do": "ptp", "name": "above", "to": {"in": "block", "position_m": [0, 0, 0.12],
                                                                       "rpy_deg": [180, 0, 0]}})";
constexpr const char* kTouch = R"({"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.04]}, "velocity_m_s": 0.01,
                                   "until": {"sensor": "wrist", "above_N": 5}})";
constexpr const char* kAway = R"({"do": "lin", "name": "away", "to": {"by_m": [0, 0, 0.03]}})";

TEST(Story, StepsContactsAndLogLinesHaveTimeAndPath) {
  const RunReport report = run(cell(std::string(kAbove) + R"(, {"do": "tare"}, )" + kTouch + "," + kAway +
                                    R"(, {"do": "log", "text": "done"}, {"do": "wait", "seconds": 0.2})"));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_EQ(words(report.log, LogLevel::kInfo),
            (std::vector<std::string>{"contact contact", "arm touch", "contact parted", "program log"}));
  const LogEntry touched = entries(report, "contact", "contact").at(0);
  EXPECT_EQ(touched.step, "main / touch");
  EXPECT_THAT(touched.text, Names("probe", "block", "N"));
  const LogEntry parted = entries(report, "contact", "parted").at(0);
  EXPECT_THAT(parted.text, Names("probe", "block"));
  EXPECT_GT(parted.time, touched.time);
  EXPECT_EQ(entries(report, "program", "log").at(0).text, "done");
  const auto begun = entries(report, "program", "begin");
  ASSERT_EQ(begun.size(), 5u);
  EXPECT_EQ(begun[2].step, "main / touch");
  EXPECT_EQ(report.log_omitted, 0);
}

TEST(Story, RetriesAndTheirReasonsAreTold) {
  const RunReport report = run(cell(R"({"do": "try", "name": "carefully", "retry": 1, "steps": [
        {"do": "lin", "name": "nothing there", "to": {"by_m": [0, 0, 0.01]},
         "until": {"sensor": "wrist", "above_N": 50}}],
        "on_error": {"steps": [{"do": "log", "text": "given up"}]}})"));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_EQ(words(report.log, LogLevel::kInfo),
            (std::vector<std::string>{"program failed", "program retry", "program failed", "program handled",
                                      "program log"}));
  const auto failed = entries(report, "program", "failed");
  EXPECT_EQ(failed.at(0).step, "main / carefully / nothing there");
  EXPECT_EQ(failed.at(1).step, "main / carefully (2) / nothing there");
  EXPECT_THAT(failed.at(0).text, Names("nothing", "there"));
}

TEST(Story, AFaultIsToldWithJointAndContact) {
  // Blind, and much too far: the block stops the probe.
  const RunReport report =
      run(cell(std::string(kAbove) + R"(, {"do": "lin", "name": "ram", "to": {"by_m": [0, 0, -0.08]},
      "velocity_m_s": 0.2, "until": {"sensor": "wrist", "above_N": 5000}, "on_end": "continue"})"));
  EXPECT_EQ(report.verdict, Verdict::kError);
  const auto fault = entries(report, "arm", "fault");
  ASSERT_EQ(fault.size(), 1u) << report.diagnostics.to_string();
  EXPECT_EQ(fault[0].level, LogLevel::kError);
  EXPECT_EQ(fault[0].step, "main / ram");
  EXPECT_THAT(fault[0].text, Names("joint", "block", "N"));
  EXPECT_THAT(fault[0].text, testing::HasSubstr("'probe/")) << "the body that hit";
  EXPECT_THAT(report.diagnostics, Notes("", {"arm", "block", "ram"})) << "in the report too";
  EXPECT_EQ(words(report.log).back(), "run error");
}

/// Begins to move a joint with constant jerk, and after a tenth of a second is somewhere else at once.
class JumpsForTest final : public net::Primitive {
 public:
  explicit JumpsForTest(net::Setup& setup)
      : arm_(setup.device<device::Arm>("device", device::Arm::kKind, "the arm that is driven")) {
    setup.claims("device");
  }
  void update(const net::Cycle& cycle) override {
    constexpr double kJerk = 1.0;  // rad/s^3
    if (cycle.first) begin_ = arm_->set_point().q;
    const double t = 1e-3 * static_cast<double>(cycle.index_in_net);
    device::JointVector q = begin_, dq = 0.0 * begin_, ddq = 0.0 * begin_;
    q[1] += kJerk * t * t * t / 6.0 + (cycle.index_in_net >= 100 ? 0.1 : 0.0);
    dq[1] = kJerk * t * t / 2.0;
    ddq[1] = kJerk * t;
    arm_->propose(q, dq, ddq);
  }

 private:
  device::Arm* arm_;
  device::JointVector begin_;
};
TAKT_PRIMITIVE(JumpsForTest, "test", "Begins to move a joint and jumps after a tenth of a second.");

TEST(Story, WhatAGuardRefusesIsToldWithTheContactBeforeIt) {
  const RunReport report = run(
      cell(std::string(kAbove) + R"(, {"do": "tare"}, )" + kTouch + R"(, {"do": "net", "name": "wild", "net": "jump"})",
           R"(, "nets": {"jump": {"primitives": [{"id": "arm", "type": "JumpsForTest", "parameters": {"device": "arm"}},
                  {"id": "end", "type": "Termination", "parameters": {"condition": false}}]}})"));
  EXPECT_EQ(report.verdict, Verdict::kError);
  const auto guard = entries(report, "arm", "guard");
  ASSERT_EQ(guard.size(), 1u) << report.diagnostics.to_string();
  EXPECT_EQ(guard[0].level, LogLevel::kError);
  EXPECT_EQ(guard[0].step, "main / wild");
  EXPECT_THAT(guard[0].text, Names("block", "N"));
  EXPECT_THAT(guard[0].text, testing::HasSubstr("'probe/")) << "what touched before";
  EXPECT_THAT(report.diagnostics, Notes("", {"arm", "block", "wild"})) << "in the report too";
}

TEST(Story, WhatTheOperatorDoesIsTold) {
  const RunReport report =
      run(cell(kAbove, R"(, "operator": [{"at_s": 0.2, "do": "pause"}, {"at_s": 0.4, "do": "resume"},
      {"at_s": 0.5, "do": "override", "value": 0.5}, {"at_s": 0.6, "do": "cancel"}])"));
  EXPECT_EQ(words(report.log, LogLevel::kInfo),
            (std::vector<std::string>{"operator pause", "operator resume", "operator override", "operator cancel"}));
  EXPECT_EQ(entries(report, "operator", "pause").at(0).time, 200 * kMillisecond);
  EXPECT_EQ(entries(report, "operator", "pause").at(0).step, "main / above");
}

TEST(Story, TheRecordingHasAllOfIt) {
  const auto file = std::filesystem::path(testing::TempDir()) / "story.mcap";
  std::vector<std::string> told;
  RunOptions options;
  options.record = file;
  options.tell = [&](const LogEntry& entry) { told.push_back(entry.source + " " + entry.name); };
  const RunReport report = run(cell(std::string(kAbove) + R"(, {"do": "tare"}, )" + kTouch + "," + kAway), options);
  EXPECT_EQ(words(report.log), told) << "as it happens";
  const auto recording = record::Recording::open(file);
  ASSERT_TRUE(recording);
  std::size_t recorded = 0;
  for (const char* topic : {"/program", "/contacts"}) {
    const auto events = recording->events(topic);
    ASSERT_TRUE(events) << topic;
    recorded += events->size();
    for (const record::RecordedEvent& event : *events) {
      const auto same = [&](const LogEntry& entry) {
        return entry.name == event.name && entry.step == event.step && entry.text == event.text;
      };
      EXPECT_TRUE(std::ranges::any_of(report.log, same)) << event.text;
    }
  }
  EXPECT_EQ(recorded, report.log.size());
  EXPECT_EQ(recording->events("/log")->size(), report.log.size()) << "as other tools show it";
}

TEST(Story, TheLogChangesNoBit) {
  const std::string text = cell(std::string(kAbove) + R"(, {"do": "tare"}, )" + kTouch);
  RunOptions options;
  options.tell = [](const LogEntry&) {};
  EXPECT_EQ(run(text).digest, run(text, options).digest);
}

/// More shapes touch than friction is remembered of: said once, with how many.
TEST(Story, TellsOnceThatContactsAreForgotten) {
  std::string posts;
  for (int i = 0; i < 14; ++i) {
    posts += fmt::format(R"({}{{"shape": "box", "size_m": [0.01, 0.1, 0.1], "position_m": [{}, 0, 0.05]}})",
                         i > 0 ? ", " : "", 0.03 * i - 0.195);
  }
  const auto report = run(R"({"devices": {"arm": {"model": "lwr4plus"}},
    "objects": {
      "posts": {"parts": [)" +
                          posts + R"(], "at": {"position_m": [0, 0.8, 0]}},
      "slab": {"shape": "box", "size_m": [0.5, 0.1, 0.01], "fixed": false, "mass_kg": 1,
        "at": {"position_m": [0, 0.8, 0.105]}}},
    "program": {"do": "wait", "seconds": 0.05}})");
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  const auto told = entries(report, "contact", "forgotten");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].level, LogLevel::kWarning);
  EXPECT_THAT(told[0].text, testing::HasSubstr("12 pairs"));
}

}  // namespace
}  // namespace takt::cell::story_test
