#pragma once

#include "core/program/tree/node.h"

namespace takt::languages {

/// {"do": "tree", "tree": {"file": F, "xml": TEXT}, "main": NAME}: a behaviour tree whose leaves are programs and
/// operations of the cell, ticked once a cycle until it is over. It fails if its root does.
[[nodiscard]] std::unique_ptr<program::Node> parse_tree(const nlohmann::ordered_json& json, const std::string& pointer,
                                                        program::NodeParser& parser);

/// The kind, for program::add_node_kind().
[[nodiscard]] program::NodeKind tree_kind();

}  // namespace takt::languages
