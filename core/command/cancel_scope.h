#pragma once

#include <vector>

#include "core/command/command_tree.h"

namespace takt::command {

/// What a cancel reaches in a tree, as far as that is certain before the run (rule C4 of docs/command-layer.md): what a
/// transaction starts because it was cancelled, and what that leads to, is its clean-up and runs to its end. Made once
/// for a tree. Realtime: setup.
class CancelScope {
 public:
  explicit CancelScope(const CommandTree& tree);

  /// A cancel of the transaction around command `i` may start it.
  [[nodiscard]] bool may_clean_up(int i) const { return may_clean_up_[static_cast<std::size_t>(i)]; }
  /// The handler starts something because its own transaction is cancelled.
  [[nodiscard]] bool waits_for_cancel(const CommandTree::Handler& h) const;
  /// The commands of the handler's transaction that may clean up and that it speaks of.
  [[nodiscard]] std::vector<int> cleaners_of(const CommandTree::Handler& h) const;
  /// A cancel of the tree does not reach command `i`, or not always.
  [[nodiscard]] bool is_exempt(int i) const { return is_exempt_[static_cast<std::size_t>(i)]; }
  /// The policy of the transaction around command `i`, which is not the root, passes a cancel on to it.
  [[nodiscard]] bool is_forwarded(int i) const;

 private:
  [[nodiscard]] std::vector<int> branches_of(const CommandTree::Handler& h) const;
  void find_clean_up();

  const CommandTree& tree_;
  std::vector<bool> may_clean_up_, is_exempt_;
};

}  // namespace takt::command
