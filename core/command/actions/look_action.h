#pragma once

#include <optional>

#include "core/command/action.h"
#include "core/command/actions/tracking.h"

/// A camera that follows what it looks at. Realtime: setup.
namespace takt::command {

/// Where the camera is, seen from what it looks at. Changes while it runs are led in with bounded jerk.
struct OrbitParameters {
  expression::RealTerm distance{0.5};   ///< m
  expression::RealTerm azimuth{0.0};    ///< rad, about z of the axes; 0: on the side of their x
  expression::RealTerm elevation{0.5};  ///< rad, above their x-y plane
  double roll = 0.0;                    ///< rad, of the picture
  double linear_max = 0.2;              ///< of the distance, m/s
  double angular_max = 0.5;             ///< of the two angles, rad/s
};

/// What it looks at, in the base of the arm, and the axes from which the angles count.
struct WatchedFrame {
  expression::FrameSensor X_BW;                   ///< looked at: its origin
  std::optional<expression::TwistSensor> V_BW_B;  ///< nothing: it does not move
  expression::FrameSensor X_BU;                   ///< z is up
  std::optional<expression::TwistSensor> V_BU_B;  ///< nothing: they do not move
};

/// The tool, a camera that looks along z of its centre point with y down, keeps a point in the middle of its picture:
/// the velocity of the point is fed forward, what is left is corrected with a gain. Offers `in_view`: the difference is
/// within TrackingParameters' distance and angle; `unreachable`: the arm knows no way to the perspective for 0.3 s,
/// and rests until it does; `error`: it is not known where the point or the axes are.
[[nodiscard]] Action look_at(const WatchedFrame& watched, const OrbitParameters& orbit,
                             const TrackingParameters& tracking = {});

}  // namespace takt::command
