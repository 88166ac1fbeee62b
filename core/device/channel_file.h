#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/form_of.h"
#include "core/device/channel.h"

namespace takt::device {

/// What a file says of one channel (docs/channels.md):
///   {"type": "Real", "writer": "net", "unit": "m/s", "frame": "A>B", "initial": 0.1, "timeout_s": 0.1}
[[nodiscard]] const FormOf<ChannelDescription>& channel_form();
/// Reads it, and checks it as a channel. What is wrong goes to `diagnostics`; there is a fallback in its place.
/// Realtime: setup.
[[nodiscard]] ChannelDescription channel_from_json(const std::string& name, const nlohmann::ordered_json& json,
                                                   const std::string& pointer, Diagnostics& diagnostics);

/// A value as a file has it. @return nothing, with diagnostics, if it is not of this type. Realtime: setup.
[[nodiscard]] std::optional<ChannelValue> channel_value_from_json(const nlohmann::ordered_json& json,
                                                                  net::ValueType type, const std::string& pointer,
                                                                  Diagnostics& diagnostics);

}  // namespace takt::device
