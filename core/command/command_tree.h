#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/command/command.h"

namespace takt::command {

/// A command and all inside of it, in the order of the tree (a command before what is inside of it). For checks,
/// planning and the mapping. Realtime: setup.
class CommandTree {
 public:
  struct Entry {
    CommandNode* node = nullptr;
    int parent = -1;
    int end = 0;  ///< what is inside of it has the numbers between its own and this one
    std::vector<int> children;
    bool with_parent = false;  ///< starts in the cycle in which its transaction does
    std::string path;          ///< "/screwing/insert"
  };
  /// An event handler of the tree.
  struct Handler {
    const EventHandler* handler;
    int owner;
    std::string path;  ///< "/screwing/handlers/0"
  };

  /// A command that is in the tree twice is entered once; doubles() has the other paths.
  explicit CommandTree(const Command& root);

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] const Entry& at(int i) const { return entries_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int size() const { return static_cast<int>(entries_.size()); }
  [[nodiscard]] const std::vector<Handler>& handlers() const { return handlers_; }
  [[nodiscard]] const Handler& handler(int h) const { return handlers_[static_cast<std::size_t>(h)]; }
  /// Numbers of the handlers with this effect (start, stop or cancel) on command `i`.
  [[nodiscard]] const std::vector<int>& acting_on(Effect::Kind kind, int i) const {
    return acting_on_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(i)];
  }
  /// Paths at which a command is in the tree once more.
  [[nodiscard]] const std::vector<std::string>& doubles() const { return doubles_; }

  /// The command that a subject belongs to: itself, or the one that carries the action out. -1: none, or several.
  [[nodiscard]] int find(const expression::SubjectPtr& subject) const;
  /// The transaction that a raised state belongs to; -1: none.
  [[nodiscard]] int find_raised(const expression::SubjectPtr& subject) const;
  /// Whether `inner` is `outer` or inside of it.
  [[nodiscard]] bool is_inside(int inner, int outer) const {
    return outer < 0 || (inner >= outer && inner < at(outer).end);
  }

  /// The state holds only once command `of` has ended.
  [[nodiscard]] bool implies_end(const expression::ExpressionPtr& state, int of) const;

  /// Commands whose start or end can make each command start: the edges of "who starts whom", from an earlier one to a
  /// later one. Between what is inside of transactions too.
  [[nodiscard]] const std::vector<std::set<int>>& starts() const { return starts_; }
  /// The name of an observation of a command in the whole, with the parts of compositions around it before it.
  [[nodiscard]] std::string name_of(int i, const Observation& observation) const;
  /// The command, or something in it, can fail as far as its net knows.
  [[nodiscard]] bool can_fail(int i) const;
  /// A cycle in starts(), as indices; empty if there is none.
  [[nodiscard]] std::vector<int> cycle_of_starts() const;
  /// Ranks in which who starts another comes before it, else the order of the tree. Without a cycle only.
  [[nodiscard]] std::vector<int> ranks() const;

 private:
  void enter(CommandNode& node, int parent, bool with_parent, const std::string& path);
  void enter_effects();
  void enter_starts();
  void add_inside(int i, std::set<int>& all) const;

  std::vector<Entry> entries_;
  std::vector<Handler> handlers_;
  std::vector<std::string> doubles_;
  std::set<const CommandNode*> seen_;
  std::map<const expression::Subject*, std::vector<int>> subjects_;
  std::map<const expression::Subject*, int> raised_;
  std::array<std::vector<std::vector<int>>, 3> acting_on_;  ///< by effect, then by command
  std::vector<std::set<int>> starts_;
};

/// A state of a command or an action that stays once it holds: started, completed ..., raised.
[[nodiscard]] bool is_lasting(const expression::Expression& leaf);
/// It was decided in the first cycle of the net, for good.
[[nodiscard]] bool is_decided(const expression::ExpressionPtr& state);

/// Whether an actuator of this name, or one of its devices, is given set points by it.
[[nodiscard]] bool drives(const Actuator& actuator, const std::string& name);

}  // namespace takt::command
