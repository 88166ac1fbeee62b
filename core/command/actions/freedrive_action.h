#pragma once

#include <optional>
#include <string>

#include "core/command/action.h"

/// A person guides an arm by hand (docs/control-modes.md). Realtime: setup.
namespace takt::command {

struct GuidanceParameters {
  /// While it holds, a person has the arm in hand (dead-man). When it falls or is unknown, the arm comes to rest and
  /// is stiff again. Default: always.
  std::optional<expression::State> enabled = {};
  double linear_max = 0.25;  ///< of the tool centre point, m/s
  double angular_max = 1.0;  ///< rad/s

  /// Arms with joint impedance: soft springs whose rest position follows the measured joints: they never wind up.
  struct Springs {
    double stiffness = 100.0;  ///< of each joint, Nm/rad (sliding joints: N/m); brought into what the device allows
    double torque = 1.5;  ///< a joint that is bent by less stays where it is, Nm or N: what weights are not exact by
    double gain = 8.0;    ///< velocity for the rest of the bend, 1/s
    /// The springs' rest position stays so far inside of each joint's range (rad, m), so that an arm that is bent at
    /// its end is inside when it becomes stiff.
    double margin = 0.02;
  } springs = {};

  /// Stiff arms with a force/torque sensor: the tool yields as a body in oil does.
  struct Body {
    double mass = 10.0;               ///< kg
    double damping = 150.0;           ///< N for 1 m/s
    double inertia = 0.5;             ///< kg m^2
    double rotational_damping = 6.0;  ///< Nm for 1 rad/s
    double force = 3.0;               ///< a force that is smaller moves nothing, N: what the sensor is not exact by
    double torque = 0.3;              ///< Nm
    double cutoff = 8.0;              ///< of the low pass over what the sensor feels, Hz
    double tare_time = 0.5;           ///< of a sensor without a known bias: it is tared at the beginning, s
  } body = {};
};

/// Who can guide an arm, and how.
enum class FreedriveKind : std::uint8_t {
  kSprings,  ///< the arm has joint impedance, and has to be in that control mode
  kBody,     ///< it has a force/torque sensor and inverse kinematics
  kNone
};
[[nodiscard]] FreedriveKind freedrive_kind(const expression::Cell& cell, const std::string& arm);

/// The arm goes where a hand leads it, never out of its joint ranges (at their ends it resists) nor faster than
/// allowed, until it is cancelled; then it comes to rest where it is, stiff. The device carries the weights of arm and
/// tool.
/// @param biases  of the cell's sensors; one that is not there is tared at the beginning: do not touch the arm then
/// An arm with neither kind is refused with the reason. Offers `enabled`, and `error`: the arm, or the sensor, does not
/// answer, so it rests.
[[nodiscard]] Action freedrive(const expression::Cell& cell, const std::string& arm,
                               const GuidanceParameters& parameters = {}, const expression::Biases& biases = {});

}  // namespace takt::command
