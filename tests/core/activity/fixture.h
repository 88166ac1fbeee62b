#pragma once

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/activity/program.h"
#include "core/activity/runtime.h"
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

  static std::string sequence(const std::string& steps) { return R"({"do": "sequence", "steps": [)" + steps + "]}"; }
  Findings rehearsed(const std::string& text) {
    return good(text).rehearse(fake.cell, &fake.core.environment()).findings;
  }
  /// Ends whatever runs by its stop reaction.
  void abort_all() {
    for (rcc::NetId net = 1; net < 1000; ++net) {
      if (fake.core.knows(net) && fake.core.state(net) == rcc::NetState::kRunning) (void)fake.core.abort(net);
    }
  }

  /// Names of the steps in the order in which they began.
  std::vector<std::string> begun() const {
    std::vector<std::string> names;
    for (const std::string& line : log) {
      if (line.starts_with("program: begin ")) names.push_back(line.substr(15));
    }
    return names;
  }
  /// Cycles in which the arm stood, between its first and its last motion.
  int standing_cycles() const {
    const auto& sent = fake.backend->sent;
    std::size_t first = 0;
    std::size_t last = sent.size() - 1;
    while (first < last && sent[first].dq.isZero(0.0)) ++first;
    while (last > first && sent[last].dq.isZero(0.0)) --last;
    // Its very first and last cycles are slow too.
    constexpr std::size_t kRamp = 20;
    int count = 0;
    for (std::size_t i = first + kRamp; i + kRamp <= last; ++i) count += sent[i].dq.cwiseAbs().maxCoeff() < 1e-4;
    return count;
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

  FakeCell fake{[this] {
    const Findings wrong = activity::declare_channels(fake.core, fake.cell);
    EXPECT_FALSE(wrong.has_errors()) << wrong.to_string();
  }};
  activity::Variables variables;
  std::int64_t latency = 2;
  std::vector<std::string> log;
  Findings findings;
  std::int64_t steps_done = 0;
  int cycles = 0;
};

}  // namespace takt::test
