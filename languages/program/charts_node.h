#pragma once

#include "core/program/tree/node.h"

namespace takt::languages {

/// {"do": "charts", "charts": {"NAME": {"file": F, "scxml": TEXT}}}: charts that coordinate what they invoke, until all
/// of them are over. A chart that ends in a state whose data has `failure` fails the node with that text.
[[nodiscard]] std::unique_ptr<program::Node> parse_charts(const nlohmann::ordered_json& json,
                                                          const std::string& pointer, program::NodeParser& parser);

/// The kind, for program::add_node_kind().
[[nodiscard]] program::NodeKind charts_kind();

}  // namespace takt::languages
