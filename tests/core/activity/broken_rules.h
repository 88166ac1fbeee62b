#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/core/activity/activity_cell.h"

/// Programs that are wrong in one way each, for rules_broken_once_test.cc. Places are JSON pointers below the node.
namespace takt::test {

/// A rule of form or of the rehearsal.
struct BrokenRule {
  std::string step;  ///< a node of a program
  std::string place;
  Code code;
  std::vector<std::string> names = {};  ///< in message or hint
  std::string programs = "{}";          ///< "programs" of the file; names are used by one rule only
};

/// Refused by Program::parse: nodes and variables, steps and their keys, expressions.
[[nodiscard]] std::vector<BrokenRule> broken_nodes();
[[nodiscard]] std::vector<BrokenRule> broken_steps();
[[nodiscard]] std::vector<BrokenRule> broken_expressions();
[[nodiscard]] std::vector<BrokenRule> broken_transactions();
/// Of a form that is right, refused by the rehearsal.
[[nodiscard]] std::vector<BrokenRule> broken_plans();
[[nodiscard]] std::vector<BrokenRule> broken_transaction_plans();

/// What only the run can tell: the step fails.
struct BrokenRun {
  std::string step;
  std::string place;
  Code code;
  std::vector<std::string> names = {};
  /// Called before each cycle, from 0.
  std::function<void(int cycle, ActivityCell& cell)> meanwhile = {};
  bool moves = false;  ///< the arm moved before, or is stopped on its way; else no set point ever changes
};
[[nodiscard]] std::vector<BrokenRun> broken_runs();
[[nodiscard]] std::vector<BrokenRun> broken_transaction_runs();

}  // namespace takt::test
