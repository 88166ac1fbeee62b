#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/device/description.h"

namespace takt::hw::modbus {

/// Where the terminals of a block lie in the tables of its coupler. The n-th terminal of a kind, in the order of the
/// model, has the first address and n.
struct MapOptions {
  std::uint16_t digital_inputs = 0;   ///< first discrete input
  std::uint16_t digital_outputs = 0;  ///< first coil
  std::uint16_t analog_inputs = 0;    ///< first input register
  std::uint16_t analog_outputs = 0;   ///< first holding register
  std::uint16_t counts = 32767;       ///< of the upper end of an analog range; 0 is the lower end
  std::uint8_t unit = 1;
};

/// The terminals of a block, by kind. Realtime: setup to make, cyclic to read.
class TerminalMap {
 public:
  /// Most terminals of a kind: what an image in the cycle has room for.
  static constexpr std::size_t kMost = 64;

  /// @param io  outlives the map
  TerminalMap(const MapOptions& options, const device::IoDescription& io) : options_(options) {
    for (const device::IoChannel& channel : io.channels) of(channel.kind).push_back(&channel);
  }
  [[nodiscard]] const MapOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<const device::IoChannel*>& list(device::IoChannel::Kind kind) const {
    return lists_[static_cast<std::size_t>(kind)];
  }
  /// First address of a kind.
  [[nodiscard]] std::uint16_t first(device::IoChannel::Kind kind) const {
    switch (kind) {
      case device::IoChannel::Kind::kDigitalInput:
        return options_.digital_inputs;
      case device::IoChannel::Kind::kDigitalOutput:
        return options_.digital_outputs;
      case device::IoChannel::Kind::kAnalogInput:
        return options_.analog_inputs;
      case device::IoChannel::Kind::kAnalogOutput:
        break;
    }
    return options_.analog_outputs;
  }
  /// The register of an analog value, and back.
  [[nodiscard]] std::uint16_t raw_of(const device::IoChannel& channel, double value) const {
    const double share = (value - channel.lower) / (channel.upper - channel.lower);
    return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * options_.counts));
  }
  [[nodiscard]] double value_of(const device::IoChannel& channel, std::uint16_t raw) const {
    return channel.lower + (channel.upper - channel.lower) * raw / options_.counts;
  }

 private:
  std::vector<const device::IoChannel*>& of(device::IoChannel::Kind kind) {
    return lists_[static_cast<std::size_t>(kind)];
  }
  MapOptions options_;
  std::vector<const device::IoChannel*> lists_[4];
};

}  // namespace takt::hw::modbus
