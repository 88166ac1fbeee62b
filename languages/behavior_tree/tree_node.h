#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "languages/behavior_tree/session.h"

/// What every kind of node has in common while its tree runs. Thread: the session's.
namespace takt::languages {

struct TreeSession::Shared {
  TreeLeaves& host;
  std::vector<std::unique_ptr<TreeBoard>> boards = {};
  std::vector<TreeLeaf> leaves = {};
  Nanoseconds now = 0;
  std::optional<Diagnostic> error = {};
};

/// A node while its tree runs: what every kind does around its own tick.
class TreeSession::Node {
 public:
  Node(const TreeNodeSpec& spec, TreeBoard& board, Shared& shared) : spec_(spec), board_(board), shared_(shared) {}
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  std::vector<std::unique_ptr<Node>> children;

  [[nodiscard]] TreeStatus status() const { return status_; }
  [[nodiscard]] const TreeNodeSpec& spec() const { return spec_; }

  TreeStatus execute() {
    TreeStatus next = TreeStatus::kIdle;
    if (const auto decided = before()) {
      next = *decided;
    } else if (!shared_.error) {
      next = tick();
    }
    if (shared_.error) next = TreeStatus::kFailure;
    if (next == TreeStatus::kSuccess || next == TreeStatus::kFailure) after(next);
    if (next != TreeStatus::kSkipped) status_ = next;
    if (is_decorator()) {
      Node& child = *children.front();
      if (child.status_ == TreeStatus::kSuccess || child.status_ == TreeStatus::kFailure)
        child.status_ = TreeStatus::kIdle;
    }
    return next;
  }

  /// Of a node that runs.
  void halt_running() {
    halt();
    run(spec_.post[static_cast<std::size_t>(TreePost::kOnHalted)]);
  }
  void reset_status() { status_ = TreeStatus::kIdle; }
  void collect_running(std::vector<std::string>& names) const {
    if (status_ != TreeStatus::kRunning) return;
    names.push_back(spec_.name);
    for (const auto& child : children) child->collect_running(names);
  }

 protected:
  [[nodiscard]] virtual TreeStatus tick() = 0;
  virtual void halt() {
    reset_children();
    status_ = TreeStatus::kIdle;
  }
  [[nodiscard]] virtual bool is_decorator() const { return false; }

  [[nodiscard]] std::size_t count() const { return children.size(); }
  void halt_child(std::size_t i) {
    if (children[i]->status_ == TreeStatus::kRunning) children[i]->halt_running();
    children[i]->status_ = TreeStatus::kIdle;
  }
  void reset_children() {
    for (std::size_t i = 0; i < children.size(); ++i) halt_child(i);
  }
  void set_running() { status_ = TreeStatus::kRunning; }
  [[nodiscard]] bool is_idle() const { return status_ == TreeStatus::kIdle; }
  [[nodiscard]] bool was_active() const { return status_ != TreeStatus::kIdle && status_ != TreeStatus::kSkipped; }

  /// A script's value; an error of it is that of the tree.
  std::optional<TreeValue> run(const std::optional<TreeScript>& script) {
    if (!script || shared_.error) return std::nullopt;
    auto value = script->run(board_);
    if (value) return std::move(*value);
    fail(value.error().list().front());
    return std::nullopt;
  }
  void fail(Diagnostic why) {
    if (shared_.error) return;
    why.severity = Severity::kError;
    why.message = fmt::format("{}: {}", spec_.name, why.message);
    why.line = spec_.at.line;
    why.column = spec_.at.column;
    shared_.error = std::move(why);
  }
  void fail(Code code, std::string message, std::string hint) {
    Diagnostics one;
    one.error(code, {}, std::move(message), std::move(hint));
    fail(one.list().front());
  }
  /// A whole number of a port; 0 with an error.
  [[nodiscard]] std::int64_t whole(std::string_view port) {
    const auto value = port_value(spec_, port, board_);
    if (value && value->is_number() && std::trunc(value->number()) == value->number() &&
        std::abs(value->number()) < 1e15)
      return static_cast<std::int64_t>(value->number());
    fail(value ? Code::kWrongType : Code::kUnknownName,
         fmt::format("'{}' is {}", port, value ? value->to_text() : "not set"), "Give a whole number");
    return 0;
  }
  [[nodiscard]] Nanoseconds milliseconds(std::string_view port) { return whole(port) * kMillisecond; }

  const TreeNodeSpec& spec_;
  TreeBoard& board_;
  Shared& shared_;

 private:
  /// What the scripts before it say; nothing: tick it.
  std::optional<TreeStatus> before() {
    for (std::size_t i = 0; i < spec_.pre.size(); ++i) {
      if (!spec_.pre[i]) continue;
      const auto what = static_cast<TreePre>(i);
      const bool begins = status_ == TreeStatus::kIdle || status_ == TreeStatus::kSkipped;
      if (!begins && !(status_ == TreeStatus::kRunning && what == TreePre::kWhile)) continue;
      const auto value = run(spec_.pre[i]);
      const auto holds = value ? truth_of(*value) : std::nullopt;
      if (!holds) {
        if (!shared_.error) fail(Code::kWrongType, "a condition that is no number", "Compare it with something");
        return TreeStatus::kFailure;
      }
      if (what == TreePre::kWhile) {
        if (*holds) continue;
        if (!begins) halt_running();
        return TreeStatus::kSkipped;
      }
      if (!*holds) continue;
      return what == TreePre::kFailureIf   ? TreeStatus::kFailure
             : what == TreePre::kSuccessIf ? TreeStatus::kSuccess
                                           : TreeStatus::kSkipped;
    }
    return std::nullopt;
  }
  void after(TreeStatus status) {
    run(spec_.post[static_cast<std::size_t>(status == TreeStatus::kSuccess ? TreePost::kOnSuccess
                                                                           : TreePost::kOnFailure)]);
    run(spec_.post[static_cast<std::size_t>(TreePost::kAlways)]);
  }

  TreeStatus status_ = TreeStatus::kIdle;
};

[[nodiscard]] inline bool is_over(TreeStatus status) {
  return status == TreeStatus::kSuccess || status == TreeStatus::kFailure;
}

/// The node and all below it, subtrees written out; leaves and boards go to `shared`. @param around  path of the node
/// around it
[[nodiscard]] std::unique_ptr<TreeSession::Node> make_tree_node(const TreeFile& file, const TreeNodeSpec& spec,
                                                                TreeBoard& board, const std::string& around,
                                                                TreeSession::Shared& shared);

}  // namespace takt::languages
