#pragma once

#include <string>

namespace takt::cell {

/// The beginning of a device's topics. Other tools take a blank for the end of a topic.
[[nodiscard]] std::string device_topic(const std::string& device);
/// Topic of what the core handed over to a device: a row for each call, in the cycles in which the calls are not those
/// of the cycle before (docs/replay.md).
[[nodiscard]] std::string command_topic(const std::string& device);

}  // namespace takt::cell
