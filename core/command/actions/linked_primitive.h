#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "core/expression/net_writer.h"

namespace takt::command {

/// An input of a primitive, and the port in the same fragment that feeds it.
using LinkedInput = std::pair<std::string_view, std::string>;

/// Adds a primitive to a fragment and links its inputs, in their order. Realtime: setup.
inline void add_linked(expression::FragmentWriter& fragment, const std::string& id, std::string type,
                       std::initializer_list<LinkedInput> inputs,
                       nlohmann::ordered_json parameters = nlohmann::ordered_json::object()) {
  fragment.add(id, std::move(type), std::move(parameters));
  for (const auto& [input, source] : inputs) fragment.link(source, id + "." + std::string(input));
}

}  // namespace takt::command
