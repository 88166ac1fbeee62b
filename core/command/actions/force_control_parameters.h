#pragma once

#include <optional>

namespace takt::command {

/// How a force is brought up and held (primitives ForceController, ServoStiffness; docs/force-control.md).
struct ForceControlParameters {
  double force = 10.0;              ///< with which the tool shall press, N
  double approach_velocity = 0.01;  ///< while nothing is touched, m/s
  double contact_force = 1.0;       ///< from here on there is contact, N
  double release_share = 0.5;       ///< of contact_force: below it there is none any more
  double release_time = 0.05;       ///< for so long at least, s
  double band = 0.1;                ///< share of the force: so far off still counts as at force
  /// Velocity for a lack of force, m/s/N; nothing: from the arm's stiffness and delay. At most twice that counts.
  std::optional<double> gain = {};
  bool surface_moves = true;        ///< an integral part follows a surface that comes or goes under the tool
  bool measures_stiffness = false;  ///< a soft surface raises the gain while the force is brought up
  double sensor_delay = 1e-3;       ///< from a force to when it is known, s
  double velocity_max = 0.02;       ///< m/s
  double acceleration_max = 1.0;    ///< m/s^2
  /// How fast the approach begins, m/s^2; 0: acceleration_max. A sensor feels the tool that is accelerated.
  double approach_acceleration = 0.0;

  bool operator==(const ForceControlParameters&) const = default;
};

}  // namespace takt::command
