#pragma once

#include <functional>
#include <map>
#include <set>

#include "core/command/command_tree.h"
#include "core/expression/net_writer.h"

namespace takt::command {

/// Which commands of a tree that has begun can still be started: what keeps their transactions alive (row L9 of
/// docs/semantics.md). Writes a signal that is true while a handler may still start a command, and the command has not
/// started. The state of a handler may still come to hold if it depends on sensors; a state of a command or an action,
/// as long as that command runs or may still be started. Used by the mapping. Realtime: setup.
class AwaitedStarts {
 public:
  /// What the mapping knows of the commands of the tree.
  struct Life {
    std::function<expression::Signal(int)> started, running;
    std::function<expression::Signal(const CommandTree::Handler&)>
        called_off;  ///< of a start: it will not happen any more
    std::function<expression::Signal(const CommandTree::Handler&)>
        held;  ///< of a handler on leaving: its state has held
  };
  AwaitedStarts(const CommandTree& tree, expression::NetWriter& writer, Life life)
      : tree_(tree), writer_(writer), life_(std::move(life)) {}

  /// Command `i` has not started, and one of its handlers may still start it.
  [[nodiscard]] expression::Signal awaited(int i);

  /// The commands whose end is an event itself: a handler of one around it reacts when one of its states that end with
  /// it is left. So what is around has to last one cycle longer.
  [[nodiscard]] static std::set<int> heard_ends(const CommandTree& tree);

 private:
  [[nodiscard]] expression::Signal may_happen(const CommandTree::Handler& h);
  [[nodiscard]] expression::Signal may_be(const expression::ExpressionPtr& state, bool value, int transaction);
  [[nodiscard]] expression::Signal may_gate(const expression::Expression& gate, bool value, int transaction, bool all);
  [[nodiscard]] expression::Signal leaf_may_be(const expression::Expression& leaf, bool value, int transaction);
  [[nodiscard]] expression::Signal may_be_raised(const expression::Expression& leaf, int transaction);
  [[nodiscard]] expression::Signal alive(int i, int transaction);
  [[nodiscard]] expression::Signal speaker_alive(const expression::SubjectPtr& subject, int transaction);

  const CommandTree& tree_;
  expression::NetWriter& writer_;
  Life life_;
  std::map<int, expression::Signal> awaited_;
  std::set<int> open_;  ///< being written: the graph of starts has no cycle, states of transactions may
  std::set<const expression::Subject*> raising_;  ///< states that raise each other
};

}  // namespace takt::command
