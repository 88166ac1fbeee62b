#pragma once

#include "core/program/tree/node.h"

namespace takt::languages {

/// {"do": "krl", "program": {"modules": [...]}, "arm": A, "map": {...}}: a program in KRL that moves one arm
/// (docs/krl.md). cell/file puts the modules in for the name of a file.
[[nodiscard]] std::unique_ptr<program::Node> parse_krl(const nlohmann::ordered_json& json, const std::string& pointer,
                                                       program::NodeParser& parser);

/// The kind, for program::add_node_kind().
[[nodiscard]] program::NodeKind krl_kind();

}  // namespace takt::languages
