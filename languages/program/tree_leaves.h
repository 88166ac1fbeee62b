#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "languages/behavior_tree/session.h"
#include "languages/program/chart_calls.h"

namespace takt::languages {

/// What a leaf of a tree is in a cell: a program or an operation, or a condition over sensors. Immutable.
struct ProgramLeaf {
  ChartProgram program = {};  ///< without a node: it is a condition
  std::optional<program::Expression> condition = {};
  std::string result_key = {};  ///< entry that gets the result; empty: none
};

/// A tree that is a part of a program, with all its leaves.
struct ProgramTree {
  std::shared_ptr<const TreeFile> file;
  std::string name;  ///< of its file, for diagnostics
  std::map<const TreeNodeSpec*, ProgramLeaf> leaves;
};

/// Makes the nodes of all leaves: all diagnostics at once, in the tree's file.
/// @param pointer  of the tree in the scenario. Realtime: setup.
void read_tree_leaves(ProgramTree& tree, const std::string& pointer, program::NodeParser& parser);

/// What the ports of a leaf are worth now, for declare_arguments(); an entry that is not set is null.
[[nodiscard]] std::vector<std::pair<std::string, Data>> leaf_arguments(const TreeLeaf& leaf);
/// A value of a program as an entry.
[[nodiscard]] TreeValue entry_of(const program::Value& value);

/// Puts diagnostics of a leaf where it is written, from number `first` on.
void move_to_leaf(Diagnostics& diagnostics, std::size_t first, const ProgramTree& tree, const TreeNodeSpec& leaf);

}  // namespace takt::languages
