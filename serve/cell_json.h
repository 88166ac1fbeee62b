#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "core/rcc/watch.h"
#include "serve/served_cell.h"

/// Values, events and the state of a cell as clients get them. Realtime: setup.
namespace takt::serve {

/// A value of a port or channel as nets write it; null: none.
[[nodiscard]] nlohmann::ordered_json to_json(const std::optional<device::ChannelValue>& value);
[[nodiscard]] nlohmann::ordered_json to_json(const rcc::WatchedValue& value);
[[nodiscard]] nlohmann::ordered_json to_json(const LoggedEvent& event);
[[nodiscard]] nlohmann::ordered_json to_json(const CellView& view);

/// Reads a value of a type. @param value  nothing for null. @return all that is wrong with it
[[nodiscard]] Diagnostics read_value(const nlohmann::ordered_json& json, net::ValueType type,
                                     std::optional<device::ChannelValue>& value);

}  // namespace takt::serve
