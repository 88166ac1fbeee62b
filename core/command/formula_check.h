#pragma once

#include <string>

#include "core/base/diagnostics.h"
#include "core/command/command_tree.h"

namespace takt::command {

/// Formulas of a tree: each can be, and the states that it asks for belong to the tree and exist (rules C6, C8, C10 of
/// docs/command-layer.md). Part of check(). Realtime: setup.
class FormulaCheck {
 public:
  FormulaCheck(const CommandTree& tree, Diagnostics& diagnostics) : tree_(tree), diagnostics_(diagnostics) {}

  /// @param location  of what uses the formula, in the tree
  void check(const expression::ExpressionPtr& formula, const std::string& location);

 private:
  [[nodiscard]] const CommandNode& node(int i) const { return *tree_.at(i).node; }
  void error(Code code, const std::string& location, const char* rule, const std::string& message,
             const std::string& hint);
  void check_leaves(const expression::ExpressionPtr& formula, const std::string& location);
  void check_leaf(const expression::Expression& leaf, const std::string& location);
  void check_raised(const expression::Expression& leaf, const std::string& location);
  void check_driven(const std::string& actuator, const std::string& location);
  void check_state(int i, const expression::Expression& leaf, const std::string& location);
  void check_via(const CommandNode& command, const expression::Expression& leaf, const std::string& location);

  const CommandTree& tree_;
  Diagnostics& diagnostics_;
};

}  // namespace takt::command
