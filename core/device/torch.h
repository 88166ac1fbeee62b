#pragma once

#include <filesystem>
#include <memory>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

namespace takt::device {

/// What is known of a torch for arc welding with its source, gas valve and wire feeder. The tool centre point is the
/// end of the contact tube, z along the wire. The page: docs/devices/torch.md.
struct TorchDescription : ToolDescription {
  double ignition = 0.0;                            ///< s, from the request to the arc, with metal in reach
  double stick_out_min = 0.0, stick_out_max = 0.0;  ///< m, from the contact tube to the metal: where an arc burns
  double extinction = 0.0;                          ///< s out of that range after which an arc is out
  double wire_diameter = 0.0;                       ///< m
  double wire_speed = 0.0;                          ///< m/s, of the feeder
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// As the other readers of core/device/device_file.h. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const TorchDescription>> read_torch(const std::filesystem::path& folder);

/// The names of its terminals behind "NAME/".
namespace torch_terminal {
inline constexpr const char* kGas = "gas";                  ///< digital output: the valve
inline constexpr const char* kArc = "arc";                  ///< digital output: the source lights and holds the arc
inline constexpr const char* kWire = "wire";                ///< digital output: the feeder
inline constexpr const char* kEstablished = "established";  ///< digital input: current flows, the arc burns
}  // namespace torch_terminal

}  // namespace takt::device
