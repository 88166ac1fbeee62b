#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/device/channel.h"
#include "core/table/table.h"

namespace takt::device {

/// What a file says of one channel (docs/channels.md), but its name.
[[nodiscard]] const table::Table<ChannelDescription>& channel_table();

/// Reads what a file says of one channel, and checks that there can be such a channel. What is wrong goes to
/// `diagnostics` with `pointer` in front; there is a fallback in its place. Realtime: setup.
[[nodiscard]] ChannelDescription channel_from_json(const std::string& name, const nlohmann::ordered_json& json,
                                                   const std::string& pointer, Diagnostics& diagnostics);

/// A value as a file has it. @return nothing, with diagnostics, if it is not of this type. Realtime: setup.
[[nodiscard]] std::optional<ChannelValue> channel_value_from_json(const nlohmann::ordered_json& json,
                                                                  net::ValueType type, const std::string& pointer,
                                                                  Diagnostics& diagnostics);

}  // namespace takt::device
