#pragma once

#include <optional>

#include "core/command/action.h"

/// Actions that need no plan. Realtime: setup.
namespace takt::command {

/// Sets a digital output, and is done in the cycle in which it does.
[[nodiscard]] Action set_value(bool value);
/// Brings an analog output to a value as fast as it may; a value outside of its range is refused. In its own unit.
[[nodiscard]] Action set_value(double value);
/// An analog output goes after a sensor until it is cancelled: inside of its range, and as fast as it may. While the
/// sensor says nothing it keeps what it was sent last. Offers `error`: the sensor says nothing.
[[nodiscard]] Action track_value(const expression::RealSensor& sensor);
/// An analog output is what a sensor says until it is cancelled; the guard refuses what is too fast.
[[nodiscard]] Action follow_value(const expression::RealSensor& sensor);

/// How a gripper closes or opens; what is not given: closed or open, a quarter of its speed, half of its force, and
/// time for the whole stroke at that speed twice over and a second more.
struct FingerParameters {
  std::optional<double> width = {};    ///< m
  std::optional<double> speed = {};    ///< m/s
  std::optional<double> force = {};    ///< N
  std::optional<double> timeout = {};  ///< s
};
/// Within which the fingers have to be at rest, s.
[[nodiscard]] double finger_timeout(const FingerParameters& parameters, const device::GripperDescription& gripper);
/// Done when the fingers are at rest, at the width or at a part, or when the time is over. Offers `holding`, `error`:
/// the part was lost, and `overdue`.
[[nodiscard]] Action grip(const FingerParameters& parameters = {});
[[nodiscard]] Action release(const FingerParameters& parameters = {});

/// Holds an arm at rest where it is, until it is cancelled.
[[nodiscard]] Action hold();

}  // namespace takt::command
