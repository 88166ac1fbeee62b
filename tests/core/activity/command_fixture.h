#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/core/command/command_cell.h"
#include "tests/core/program/tree/program_runs.h"

namespace takt::test {

/// Programs on the fake cell with arm, force/torque sensor, gripper, outputs, an input and channels.
class CommandStepTest : public ProgramRuns {
 protected:
  /// @param more  adds to the cell before the first cycle
  explicit CommandStepTest(const std::function<void(CommandCell&)>& more = {}) : cell(more) {}

  using ProgramRuns::run;
  operations::Progress run(const std::string& text) { return run(good(text)); }

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

 private:
  [[nodiscard]] expression::Cell& programs_cell() override { return cell.cell; }
  [[nodiscard]] rcc::ControlCore& programs_core() override { return cell.core; }
  void one_cycle() override { cell.step(); }
};

}  // namespace takt::test
