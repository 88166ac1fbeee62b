#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

namespace takt::device {

/// What is known of an electric screwdriver: a tool whose spindle a motor turns, with a transducer for torque and angle
/// and a clutch that lets go at a torque. The page: docs/devices/screwdriver.md.
struct ScrewdriverDescription : ToolDescription {
  std::string spindle;                        ///< joint that the motor turns; positive turns to the right
  std::string bit;                            ///< link that goes into the socket of a screw
  double speed_min = 0.0, speed_max = 0.0;    ///< rad/s
  double torque_min = 0.0, torque_max = 0.0;  ///< Nm, at which the clutch lets go
  double acceleration = 0.0;                  ///< rad/s^2
  double spindle_inertia = 0.0;               ///< kg m^2, that the drive adds behind the clutch
  double holding_force = 0.0;                 ///< N, of the magnet on a screw; 0: none
  double torque_noise = 0.0;                  ///< Nm, standard deviation per sample
  double torque_resolution = 0.0;             ///< Nm; 0: exact
  double angle_resolution = 0.0;              ///< rad; 0: exact
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// As the other readers of core/device/device_file.h. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const ScrewdriverDescription>> read_screwdriver(
    const std::filesystem::path& folder);

}  // namespace takt::device
