#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

namespace takt::device {

/// What is known of a suction cup with its ejector, valve and vacuum switch: a tool that holds flat parts by the
/// pressure of the air around them. Pressures are vacuums: Pa below ambient. The page: docs/devices/vacuum-cup.md.
struct VacuumCupDescription : ToolDescription {
  std::vector<std::string> lips;  ///< links whose spheres are a lip each, z out of the mouth; all on the same vacuum
  double area = 0.0;              ///< m^2, of each, on which the pressure acts
  double vacuum_max = 0.0;        ///< Pa, that the ejector reaches with a tight lip
  double evacuation = 0.0;        ///< s, time constant
  double venting = 0.0;           ///< s, time constant when the valve is closed
  double lip_leak =
      0.0;  ///< flow through one lip that is open all around, over that of the ejector, at the same vacuum
  double switch_on = 0.0;   ///< Pa, from which on the vacuum switch tells of a part
  double switch_off = 0.0;  ///< Pa, below which it does not any more
  double resolution = 0.0;  ///< Pa, of the vacuum as measured; 0: exact
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// As the other readers of core/device/device_file.h. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const VacuumCupDescription>> read_vacuum_cup(const std::filesystem::path& folder);

/// The names of its terminals behind "NAME/".
namespace cup_terminal {
inline constexpr const char* kSuction = "suction";  ///< digital output: the valve of the ejector
inline constexpr const char* kHolding = "holding";  ///< digital input: the vacuum switch
inline constexpr const char* kVacuum = "vacuum";    ///< analog input: Pa below ambient
}  // namespace cup_terminal

}  // namespace takt::device
