#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/activity/program.h"
#include "tests/core/command/command_cell.h"

namespace takt::test {

using Json = nlohmann::ordered_json;

/// Programs on the fake cell with arm, force/torque sensor, gripper, outputs, an input and channels.
class CommandStepTest : public testing::Test {
 protected:
  /// @param more  adds to the cell before the first cycle
  explicit CommandStepTest(const std::function<void(CommandCell&)>& more = {}) : cell(more) {}

  /// All that is wrong with a program, before anything moves.
  Findings wrong(const std::string& text) {
    const auto program = activity::Program::parse(Json::parse(text), "/program", cell.cell);
    if (!program) return program.error();
    return program->rehearse(cell.cell, &cell.core.environment()).findings;
  }
  activity::Program good(const std::string& text) {
    auto program = activity::Program::parse(Json::parse(text), "/program", cell.cell);
    if (!program) {
      ADD_FAILURE() << program.error().to_string();
      return {};
    }
    const Findings found = program->rehearse(cell.cell, &cell.core.environment()).findings;
    EXPECT_FALSE(found.has_errors()) << found.to_string();
    return std::move(*program);
  }
  /// Runs a program to its end. `at_cycle` is called before each cycle with its number, from 0.
  activity::Progress run(const activity::Program& program,
                         const std::function<void(int, activity::ProgramRunner&)>& at_cycle = {}, int most = 60'000) {
    activity::Context context{cell.cell, cell.core, variables, latency, [this](auto source, auto name, auto text) {
                                log.push_back(std::string(source) + ": " + std::string(name) + " " + std::string(text));
                              }};
    activity::ProgramRunner runner(program, context);
    for (cycles = 0; cycles < most; ++cycles) {
      if (at_cycle) at_cycle(cycles, runner);
      if (runner.advance() != activity::Progress::kRunning) break;
      cell.step();
    }
    findings = runner.findings();
    return runner.progress();
  }
  activity::Progress run(const std::string& text) { return run(good(text)); }

  /// At rest, free, and nothing was ever beyond a limit.
  void expect_good_end() {
    cell.step(600);
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_FALSE(cell.core_arm().held());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
  }
  bool driver() const { return cell.cell.digital_outputs.at("driver")->value(); }
  bool lamp() const { return cell.cell.digital_outputs.at("lamp")->value(); }
  Eigen::Vector3d tool() const { return cell.tool_in_world(cell.q()).translation(); }
  double speed() const { return cell.core_arm().set_point().dq.cwiseAbs().maxCoeff(); }
  long count(const std::string& entry) const { return std::ranges::count(log, entry); }
  bool logged(const std::string& part) const {
    return std::ranges::any_of(log, [&](const std::string& line) { return line.find(part) != std::string::npos; });
  }

  CommandCell cell;
  activity::Variables variables;
  std::int64_t latency = 2;
  std::vector<std::string> log;
  Findings findings;
  int cycles = 0;
};

}  // namespace takt::test
