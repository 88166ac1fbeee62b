#pragma once

#include "core/program/tree/node.h"

namespace takt::languages {

/// {"do": "urscript", "program": {"file": F, "source": S}, "arm": A, "map": {...}}: a program in URScript that moves
/// one arm (docs/urscript.md). cell/file puts the text in for the name of a file.
[[nodiscard]] std::unique_ptr<program::Node> parse_urscript(const nlohmann::ordered_json& json,
                                                            const std::string& pointer, program::NodeParser& parser);

/// The kind, for program::add_node_kind().
[[nodiscard]] program::NodeKind urscript_kind();

}  // namespace takt::languages
