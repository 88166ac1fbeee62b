#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/text_location.h"
#include "languages/behavior_tree/script.h"

/// Behaviour trees as they are written. Immutable once read.
namespace takt::languages {

/// What a node does with its children; kLeaf: what it does is for whoever runs the tree.
enum class TreeNodeKind : std::uint8_t {
  kSequence,
  kReactiveSequence,
  kSequenceWithMemory,
  kFallback,
  kReactiveFallback,
  kParallel,
  kParallelAll,
  kIfThenElse,
  kWhileDoElse,
  kSwitch,
  kInverter,
  kForceSuccess,
  kForceFailure,
  kRepeat,
  kRetry,
  kKeepRunningUntilFailure,
  kDelay,
  kTimeout,
  kRunOnce,
  kSubTree,
  kAlwaysSuccess,
  kAlwaysFailure,
  kScript,
  kScriptCondition,
  kSetBlackboard,
  kSleep,
  kLeaf
};

/// The value of an attribute: a text, or the key of an entry ("{key}").
struct TreePort {
  std::string text, key;  ///< key empty: the text is the value
  TextLocation at;
};

/// Scripts before a node, in their order, and after it.
enum class TreePre : std::uint8_t { kFailureIf, kSuccessIf, kSkipIf, kWhile };
enum class TreePost : std::uint8_t { kOnHalted, kOnFailure, kOnSuccess, kAlways };

struct TreeNodeSpec {
  TreeNodeKind kind = TreeNodeKind::kLeaf;
  std::string type, name;  ///< element or ID; for people
  TextLocation at;
  std::map<std::string, TreePort, std::less<>> ports;
  std::array<std::optional<TreeScript>, 4> pre, post;
  std::optional<TreeScript> script;  ///< of kScript and kScriptCondition
  int cases = 0;                     ///< of kSwitch
  bool autoremap = false;            ///< of kSubTree
  std::vector<TreeNodeSpec> children;

  [[nodiscard]] const TreePort* port(std::string_view key) const {
    const auto found = ports.find(key);
    return found == ports.end() ? nullptr : &found->second;
  }
};

struct TreeFile {
  std::string file;  ///< for diagnostics; may be empty
  std::string main;
  std::map<std::string, TreeNodeSpec, std::less<>> trees;  ///< the only node in each, by ID
};

/// What is known of a kind of node by its name.
struct TreeNodeType {
  std::string_view name;
  TreeNodeKind kind;
  int min_children, max_children;
  struct Port {
    std::string_view name;
    std::string_view fallback;  ///< empty: required
    bool number = true;         ///< else a text
  };
  std::vector<Port> ports;
};
[[nodiscard]] std::span<const TreeNodeType> tree_node_types();
[[nodiscard]] const TreeNodeType* tree_node_type(std::string_view name);
/// The same of a node that was read.
[[nodiscard]] const TreeNodeType& type_of(const TreeNodeSpec& node);

/// Reads trees in the XML form of BehaviorTree.CPP 4. All diagnostics at once, with line and column.
/// @param main  the tree to run; empty: what the file says, or its only one. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const TreeFile>> read_trees(std::string_view xml, const std::string& main = {});

}  // namespace takt::languages
