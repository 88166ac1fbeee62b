#pragma once

#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/program.h"

namespace takt::test {

using Json = nlohmann::ordered_json;

/// Reads programs and runs them, cycle for cycle, on the cell that a fixture has.
class ProgramRuns : public testing::Test {
 protected:
  /// Called before each cycle with its number, from 0.
  using AtCycle = std::function<void(int, program::ProgramRunner&)>;

  [[nodiscard]] virtual expression::Cell& programs_cell() = 0;
  [[nodiscard]] virtual rcc::ControlCore& programs_core() = 0;
  virtual void before_first_cycle() {}
  virtual void one_cycle() = 0;

  /// All that is wrong with a program, before anything moves.
  Diagnostics wrong(const std::string& text) {
    const auto program = program::Program::parse(Json::parse(text), "/program", programs_cell());
    if (!program) return program.error();
    return program->rehearse(programs_cell(), &programs_core().environment()).diagnostics;
  }
  /// A program whose rehearsal finds no errors.
  program::Program good(const std::string& text) {
    auto program = program::Program::parse(Json::parse(text), "/program", programs_cell());
    if (!program) {
      ADD_FAILURE() << program.error().to_string();
      return {};
    }
    rehearsed = program->rehearse(programs_cell(), &programs_core().environment()).diagnostics;
    EXPECT_FALSE(rehearsed.has_errors()) << rehearsed.to_string();
    return std::move(*program);
  }

  activity::Context context() {
    return {programs_cell(), programs_core(), variables, latency, [this](auto source, auto name, auto text) {
              log.push_back(std::string(source) + ": " + std::string(name) + " " + std::string(text));
              paths.push_back(std::string(name) + ": " + (running ? running->path() : ""));
            }};
  }
  /// To its end.
  operations::Progress run(const program::Program& program, const AtCycle& at_cycle = {}, int most = 100'000) {
    activity::Context own = context();
    program::ProgramRunner runner(program, own);
    return follow(runner, at_cycle, most);
  }
  /// Cancels a program in this cycle.
  static AtCycle cancelling(int at) {
    return [at](int cycle, program::ProgramRunner& runner) {
      if (cycle == at) runner.cancel();
    };
  }
  /// From the state that a snapshot has as text.
  operations::Progress go_on(const program::Program& program, const std::string& snapshot, const AtCycle& at_cycle = {},
                             int most = 100'000) {
    activity::Context own = context();
    program::ProgramRunner runner(program, own);
    const Diagnostics found = runner.restore(Json::parse(snapshot));
    EXPECT_TRUE(found.empty()) << found.to_string();
    return follow(runner, at_cycle, most);
  }
  /// Runs a program until this holds, takes a snapshot there, and cancels it.
  std::string snapshot_when(const program::Program& program,
                            const std::function<bool(const program::ProgramRunner&)>& there) {
    std::string snapshot;
    EXPECT_EQ(run(program,
                  [&](int, program::ProgramRunner& runner) {
                    if (!snapshot.empty() || !there(runner)) return;
                    snapshot = runner.snapshot().dump();
                    runner.cancel();
                  }),
              operations::Progress::kDone);
    return snapshot;
  }

  /// Names of the steps in the order in which they began.
  std::vector<std::string> begun() const {
    std::vector<std::string> names;
    for (const std::string& line : log)
      if (line.starts_with("program: begin ")) names.push_back(line.substr(15));
    return names;
  }
  static std::vector<std::string> pointers(const Diagnostics& diagnostics) {
    std::vector<std::string> pointers;
    for (const Diagnostic& diagnostic : diagnostics.list()) pointers.push_back(diagnostic.pointer);
    return pointers;
  }

  activity::Variables variables;
  std::int64_t latency = 2;
  std::vector<std::string> log;
  std::vector<std::string> paths;  ///< for each line of the log: what happened, and where in the tree
  Diagnostics rehearsed;           ///< of the last good program
  Diagnostics diagnostics;         ///< of the last run
  std::int64_t steps_done = 0;
  int cycles = 0;

 private:
  const program::ProgramRunner* running = nullptr;

  operations::Progress follow(program::ProgramRunner& runner, const AtCycle& at_cycle, int most) {
    before_first_cycle();
    running = &runner;
    for (cycles = 0; cycles < most; ++cycles) {
      if (at_cycle) at_cycle(cycles, runner);
      if (runner.advance() != operations::Progress::kRunning) break;
      one_cycle();
    }
    diagnostics = runner.diagnostics();
    steps_done = runner.steps_done();
    running = nullptr;
    return runner.progress();
  }
};

}  // namespace takt::test
