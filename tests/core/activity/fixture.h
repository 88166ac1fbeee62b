#pragma once

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/activity/program.h"
#include "tests/support/fake_cell.h"

namespace takt::test {

using Json = nlohmann::ordered_json;

/// Parses programs against a fake cell and runs them on it.
class ActivityTest : public testing::Test {
 protected:
  Result<activity::Program> parse(const std::string& text) const {
    return activity::Program::parse(Json::parse(text), "/program", fake.cell);
  }
  activity::Program good(const std::string& text) const {
    auto program = parse(text);
    if (!program) ADD_FAILURE() << program.error().to_string();
    return program ? std::move(*program) : activity::Program();
  }
  static std::vector<std::string> pointers(const Findings& findings) {
    std::vector<std::string> pointers;
    for (const Finding& finding : findings.list()) pointers.push_back(finding.pointer);
    return pointers;
  }
  /// Pointers of what is wrong with the form of a program.
  std::vector<std::string> refused(const std::string& text) const {
    const auto program = parse(text);
    return program ? std::vector<std::string>() : pointers(program.error());
  }

  /// Runs a program to its end. `at_cycle` is called before each cycle with its number, from 0.
  activity::Progress run(const activity::Program& program,
                         const std::function<void(int, activity::ProgramRunner&)>& at_cycle = {}, int most = 100'000) {
    activity::Context context{fake.cell, fake.core, variables, latency, [this](auto source, auto name, auto text) {
                                log.push_back(std::string(source) + ": " + std::string(name) + " " + std::string(text));
                              }};
    activity::ProgramRunner runner(program, context);
    cycles = 0;
    for (; cycles < most; ++cycles) {
      if (at_cycle) at_cycle(cycles, runner);
      if (runner.advance() != activity::Progress::kRunning) break;
      fake.step();
    }
    findings = runner.findings();
    steps_done = runner.steps_done();
    return runner.progress();
  }
  activity::Progress run(const std::string& text) { return run(good(text)); }

  FakeCell fake;
  activity::Variables variables;
  std::int64_t latency = 2;
  std::vector<std::string> log;
  Findings findings;
  std::int64_t steps_done = 0;
  int cycles = 0;
};

}  // namespace takt::test
