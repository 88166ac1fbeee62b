#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "languages/behavior_tree/model.h"

namespace takt::languages {

enum class TreeStatus : std::uint8_t { kIdle, kRunning, kSuccess, kFailure, kSkipped };
[[nodiscard]] std::string_view name_of(TreeStatus status);

/// The entries of a tree: its own, and those that are entries of the tree around it.
class TreeBoard final : public TreeVariables {
 public:
  /// @param around  null: the outermost
  explicit TreeBoard(TreeBoard* around = nullptr, bool autoremap = false) : around_(around), autoremap_(autoremap) {}

  void remap(const std::string& name, const std::string& outside) { remapped_[name] = outside; }
  /// An entry of its own, which hides one around it.
  void define(const std::string& name, TreeValue value) { own_[name] = std::move(value); }
  [[nodiscard]] const TreeValue* find(const std::string& name) const override;
  void set(const std::string& name, TreeValue value) override;
  /// Those that it holds itself.
  [[nodiscard]] const std::map<std::string, TreeValue, std::less<>>& own() const { return own_; }

 private:
  TreeBoard* around_;
  bool autoremap_;
  std::map<std::string, std::string, std::less<>> remapped_;
  std::map<std::string, TreeValue, std::less<>> own_;
};

/// What a tree is made of when it runs: a leaf where it stands, subtrees written out.
struct TreeLeaf {
  const TreeNodeSpec* spec = nullptr;
  TreeBoard* board = nullptr;
  std::string path;  ///< names of the trees and nodes around it, " / " between
};

/// Carries leaves out. Thread: the one that ticks.
class TreeLeaves {
 public:
  virtual ~TreeLeaves() = default;
  /// @param number  of TreeSession::leaves(). @param fresh  it did not run before this tick
  /// @return kRunning, kSuccess or kFailure; kSkipped if it does not apply
  [[nodiscard]] virtual TreeStatus tick(std::size_t number, const TreeLeaf& leaf, bool fresh) = 0;
  /// A leaf that runs is not wanted any more.
  virtual void halt(std::size_t number, const TreeLeaf& leaf) = 0;
};

/// A tree while it runs: it is ticked, by the rules of BehaviorTree.CPP 4 (docs/behavior-trees.md). Deterministic: time
/// is an input. Thread: one.
class TreeSession {
 public:
  /// The file must outlive it.
  TreeSession(const TreeFile& file, TreeLeaves& leaves);
  ~TreeSession();
  TreeSession(const TreeSession&) = delete;
  TreeSession& operator=(const TreeSession&) = delete;

  /// One tick of the root. Once it is over, the next one begins anew. @param now  since the begin
  TreeStatus tick(Nanoseconds now);
  /// Halts what runs.
  void halt();
  [[nodiscard]] TreeStatus status() const;
  [[nodiscard]] const std::vector<TreeLeaf>& leaves() const;
  [[nodiscard]] TreeBoard& board();
  /// What went wrong in a script or at a port; the tree has failed by it.
  [[nodiscard]] const std::optional<Diagnostic>& error() const;
  /// Names of the nodes that run, from the root.
  [[nodiscard]] std::vector<std::string> running() const;

  class Node;
  struct Shared;

 private:
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<Node> root_;
};

/// A port's value now; nothing: an entry that is not set, or none given. A fallback of its type counts.
[[nodiscard]] std::optional<TreeValue> port_value(const TreeNodeSpec& node, std::string_view port,
                                                  const TreeBoard& board);

}  // namespace takt::languages
