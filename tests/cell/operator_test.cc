// What an operator may do to a running program: pause, resume, override, cancel, abort, write to channels; where a
// program is entered. On a small cell with physics.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "record/recording.h"
#include "tests/support/reports.h"

namespace takt::cell::operator_test {
namespace {

using takt::test::ReportsAnywhere;
using testing::AllOf;
using testing::ElementsAre;

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

Result<std::unique_ptr<Session>> open(const std::string& more, const std::string& steps) {
  auto description = parse_description(R"({"devices": {"arm": {"model": "lwr4plus"}},
    "channels": {"go": {"type": "Boolean", "initial": false}, "felt": {"type": "Real", "writer": "net"},
                 "pressed": {"type": "Boolean", "timeout_s": 0.05}},)" +
                                       more + R"("program": {"do": "sequence", "steps": [)" + steps +
                                       R"(]}, "expectations": [{"kind": "limits"}]})");
  if (!description) return std::unexpected(std::move(description.error()));
  return Session::create(std::move(*description), models());
}

constexpr const char* kThereAndBack = R"(
    {"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.2},
    {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.1]}, "velocity_m_s": 0.2})";

struct Watched {
  RunReport report;
  std::vector<double> speed;  ///< of the fastest joint's set point, rad/s, cycle by cycle
  bool at_rest = false, free = false;
};

Watched run(const std::string& script, const std::string& steps = kThereAndBack, const std::string& from = {}) {
  auto session = open(script.empty() ? "" : "\"operator\": [" + script + "],", steps);
  Watched watched;
  if (!session) {
    watched.report.diagnostics = session.error();
    return watched;
  }
  RunOptions options;
  options.measure_times = false;
  options.from = from;
  options.after_cycle = [&](BuiltCell& built) {
    const device::Arm& arm = *built.core->arms().front();
    watched.speed.push_back(arm.set_point().dq.size() == 0 ? 0.0 : arm.set_point().dq.cwiseAbs().maxCoeff());
    return true;
  };
  watched.report = (*session)->run(options);
  // A stop that the last cycle asked for takes some more.
  rcc::ControlCore& core = *(*session)->built().core;
  for (int i = 0; i < 500; ++i) {
    core.step();
    (void)(*session)->built().world->step();
  }
  watched.at_rest = core.arms().front()->at_rest();
  watched.free = !core.arms().front()->held();
  return watched;
}

double largest(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  return *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(begin),
                           values.begin() + static_cast<std::ptrdiff_t>(std::min(end, values.size())));
}

TEST(Operator, APauseStandsOnThePathAndTheProgramGoesOn) {
  const Watched plain = run("");
  const Watched paused = run(R"({"at_s": 0.3, "do": "pause"}, {"at_s": 1.3, "do": "resume"})");
  ASSERT_EQ(paused.report.verdict, Verdict::kPassed) << paused.report.diagnostics.to_string();
  EXPECT_GT(largest(plain.speed, 500, 600), 0.01);
  EXPECT_EQ(largest(paused.speed, 700, 1300), 0.0);
  EXPECT_NEAR(paused.report.sim_time, plain.report.sim_time + 1.0, 0.2);
}

TEST(Operator, NoStepBeginsInAPause) {
  const Watched paused = run(R"({"at_step": "first", "after_s": 0.01, "do": "pause"}, {"at_s": 0.5, "do": "resume"})",
                             R"({"do": "wait", "name": "first", "seconds": 0.1}, {"do": "wait", "seconds": 0.1})");
  EXPECT_NEAR(paused.report.sim_time, 0.6, 0.01);
}

TEST(Operator, AnOverrideScalesTheSpeed) {
  const Watched plain = run("");
  const Watched slow = run(R"({"at_s": 0, "do": "override", "value": 0.5})");
  ASSERT_EQ(slow.report.verdict, Verdict::kPassed) << slow.report.diagnostics.to_string();
  EXPECT_NEAR(slow.report.sim_time, 2 * plain.report.sim_time, 0.2 * plain.report.sim_time);
  EXPECT_NEAR(largest(slow.speed, 0, slow.speed.size()) / largest(plain.speed, 0, plain.speed.size()), 0.5, 0.05);
}

TEST(Operator, ACancelEndsTheProgramInOrder) {
  const Watched cancelled = run(R"({"at_s": 0.3, "do": "cancel"})");
  EXPECT_EQ(cancelled.report.verdict, Verdict::kPassed) << cancelled.report.diagnostics.to_string();
  EXPECT_LT(cancelled.report.sim_time, 0.6);
  EXPECT_TRUE(cancelled.at_rest);
  EXPECT_TRUE(cancelled.free);
}

TEST(Operator, ACancelInAPauseEndsIt) {
  const Watched cancelled = run(R"({"at_s": 0.3, "do": "pause"}, {"at_s": 1, "do": "cancel"})");
  EXPECT_EQ(cancelled.report.verdict, Verdict::kPassed) << cancelled.report.diagnostics.to_string();
  EXPECT_NEAR(cancelled.report.sim_time, 1.0, 0.05);
}

TEST(Operator, AnAbortStopsTheDevicesAndFailsTheProgram) {
  const Watched aborted = run(R"({"at_s": 0.3, "do": "abort"})");
  EXPECT_EQ(aborted.report.verdict, Verdict::kError);
  EXPECT_THAT(aborted.report.diagnostics, ReportsAnywhere(Code::kStopped));
  EXPECT_FALSE(aborted.report.expectations.front().judged) << "within the limits until it was cut off";
  EXPECT_TRUE(aborted.at_rest);
  EXPECT_TRUE(aborted.free);
}

TEST(Operator, AnAbortBetweenTwoNetsStopsTheNextOne) {
  const Watched aborted = run(R"({"at_s": 0.05, "do": "abort"})",
                              R"({"do": "wait", "seconds": 0.1}, {"do": "lin", "to": {"by_m": [0, 0, 0.1]}})");
  EXPECT_EQ(aborted.report.verdict, Verdict::kError);
  EXPECT_THAT(aborted.report.diagnostics, ReportsAnywhere(Code::kCancelled));
  EXPECT_LT(aborted.report.sim_time, 0.3);
  EXPECT_TRUE(aborted.free);
}

TEST(Operator, EverythingThatIsWrongIsToldAtOnce) {
  const auto diagnostics = [](const std::string& script) {
    const auto session = open("\"operator\": [" + script + "],", kThereAndBack);
    std::vector<std::string> pointers;
    if (session) return pointers;
    for (const Diagnostic& diagnostic : session.error().list()) pointers.push_back(diagnostic.pointer);
    return pointers;
  };
  EXPECT_THAT(diagnostics(R"({"at_s": -1, "do": "pause"}, {"do": "resume"}, {"at_s": 1, "do": "jump"},
                          {"at_s": 1, "do": "override"}, {"at_s": 1, "do": "override", "value": 2},
                          {"at_s": 1, "do": "write", "channel": "go"}, {"at_s": 1, "do": "cancel", "value": 1})"),
              ElementsAre("/operator/0/at_s", "/operator/1", "/operator/2/do", "/operator/3", "/operator/4/value",
                          "/operator/5", "/operator/6/value"));
  EXPECT_THAT(
      diagnostics(R"({"at_step": "upp", "do": "pause"}, {"at_s": 1, "do": "write", "channel": "gone", "value": 1},
                          {"at_s": 1, "do": "write", "channel": "felt", "value": 1},
                          {"at_s": 1, "do": "write", "channel": "go", "value": 1},
                          {"at_s": 1, "do": "write", "channel": "go", "value": true})"),
      ElementsAre("/operator/0/at_step", "/operator/1/channel", "/operator/2/channel", "/operator/3/value"));
}

TEST(Operator, ValuesReachNetsAtTheirTime) {
  auto session = open(R"("operator": [{"at_s": 0.2, "do": "write", "channel": "go", "value": true}],
    "nets": {"waits": {"primitives": [{"id": "go", "type": "InputBoolean", "parameters": {"channel": "go"}},
                                      {"id": "end", "type": "Termination"}],
                       "links": [{"from": "go.value", "to": "end.condition"}]}},)",
                      R"({"do": "net", "net": "waits", "within_s": 1})");
  ASSERT_TRUE(session) << session.error().to_string();
  RunOptions options;
  options.record = testing::TempDir() + "operator.mcap";
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_NEAR(report.sim_time, 0.2, 0.01);
  const auto recording = record::Recording::open(options.record);
  ASSERT_TRUE(recording);
  std::vector<std::string> acts;
  const auto events = recording->events("/program");
  for (const auto& event : *events) {
    if (event.source == "operator") acts.push_back(event.name + " " + event.text);
  }
  EXPECT_THAT(acts, ElementsAre("write go = true"));
}

TEST(Operator, WhatIsHeldIsWrittenAgainAndAgain) {
  const auto cycles_pressed = [](const std::string& more) {
    auto session =
        open(R"("operator": [{"at_s": 0.2, "do": "write", "channel": "pressed", "value": true)" + more + "}],",
             R"({"do": "wait", "seconds": 1})");
    int cycles = 0;
    RunOptions options;
    options.after_cycle = [&](BuiltCell& built) {
      cycles += built.core->find_channel("pressed")->slot<net::Boolean>().null == 0 ? 1 : 0;
      return true;
    };
    EXPECT_EQ((*session)->run(options).verdict, Verdict::kPassed);
    return cycles;
  };
  EXPECT_NEAR(cycles_pressed(""), 50, 2);  // its timeout
  EXPECT_NEAR(cycles_pressed(R"(, "held_s": 0.5)"), 550, 2);
}

TEST(Operator, AProgramIsEnteredAtAStep) {
  const Watched whole = run("");
  const Watched entered = run("", kThereAndBack, "down");
  EXPECT_EQ(entered.report.verdict, Verdict::kPassed) << entered.report.diagnostics.to_string();
  EXPECT_NEAR(entered.report.sim_time, 0.5 * whole.report.sim_time, 0.1);
  const Watched nowhere = run("", kThereAndBack, "dwon");
  EXPECT_EQ(nowhere.report.verdict, Verdict::kRefused);
  EXPECT_THAT(nowhere.report.diagnostics, ReportsAnywhere(Code::kUnknownName, {"dwon", "down"}));
}

}  // namespace
}  // namespace takt::cell::operator_test
