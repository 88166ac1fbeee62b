#pragma once

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/command/action.h"

/// What the actions share that lead a tool after something. Realtime: setup.
namespace takt::command {

/// Bounds of a velocity, and how hard a difference is followed.
struct TrackingParameters {
  double linear_max = 0.1;   ///< m/s
  double angular_max = 0.5;  ///< rad/s
  double gain = 4.0;         ///< velocity for a difference, 1/s
  double distance = 1e-4;    ///< of `arrived`, m
  double angle = 1e-3;       ///< of `arrived`, rad
  /// Share of the wanted velocity, 0 to 1, beside the speed of the actuator; 0 or null: the arm rests.
  std::optional<expression::RealSensor> speed = {};
  /// Of `follow`: velocity of the target, of its origin in the axes of the arm's base. It is fed forward, so that the
  /// tool does not lag behind. Nothing or null: only the difference is followed.
  std::optional<expression::TwistSensor> target_twist = {};
};

/// Adds "wanted", what `limited` gives times the speed of the actuator. @param limited  adds a primitive of this id,
/// with the port "value"
void add_with_speed(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                    const TrackingParameters& parameters, const std::function<void(const std::string& id)>& limited);

/// Adds "wanted": the velocity of the target, and a gain times "difference.value", of which only this is shortened
/// where the sum would be beyond a bound. @param target_twist  a port that is never null; empty: the target rests
void add_tracking(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                  const TrackingParameters& parameters, const std::string& target_twist);

/// Diagnostics of bounds, gain, distance and angle: all of them are above 0 and finite.
[[nodiscard]] Diagnostics check_tracking(const TrackingParameters& parameters);

/// Formulas, and the speed of the parameters if they have one.
[[nodiscard]] std::vector<expression::ExpressionPtr> with_speed(std::vector<expression::ExpressionPtr> formulas,
                                                                const TrackingParameters& parameters);

/// A figure of an action.
struct Figure {
  const char* name;
  double value;
  const char* unit;
};
/// All of them are above 0 and finite.
[[nodiscard]] Diagnostics check_figures(std::initializer_list<Figure> figures);

/// The bounds, for what turns velocities into joint rates.
[[nodiscard]] inline ToolSpeed speed_of(const TrackingParameters& parameters) {
  return {.linear = parameters.linear_max, .angular = parameters.angular_max};
}

}  // namespace takt::command
