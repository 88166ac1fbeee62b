#pragma once

#include <string>

#include "core/base/diagnostics.h"
#include "core/command/command_tree.h"

namespace takt::command {

/// Effects of event handlers: each has a target that it may reach from where the handler is (rules C1, C2, C5, C10 of
/// docs/command-layer.md). Part of check(). Realtime: setup.
class EffectCheck {
 public:
  EffectCheck(const CommandTree& tree, Diagnostics& diagnostics) : tree_(tree), diagnostics_(diagnostics) {}

  void check(const CommandTree::Handler& h);

 private:
  [[nodiscard]] const std::string& name(int i) const { return tree_.at(i).node->name; }
  void error(const CommandTree::Handler& h, Code code, const char* rule, const std::string& message,
             const std::string& hint);
  void check_start(const CommandTree::Handler& h);
  void check_start_condition(const CommandTree::Handler& h);
  void check_end(const CommandTree::Handler& h);
  void check_raise(const CommandTree::Handler& h);
  void check_external(const CommandTree::Handler& h);

  const CommandTree& tree_;
  Diagnostics& diagnostics_;
};

}  // namespace takt::command
