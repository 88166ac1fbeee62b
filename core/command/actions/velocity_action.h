#pragma once

#include <optional>
#include <string>

#include "core/command/action.h"
#include "core/command/actions/force_control_parameters.h"

namespace takt::command {

/// From any state that the limits of an arm allow to rest, with room for a generator that swings back, s.
/// @param acceleration  share of the limits of acceleration and jerk
[[nodiscard]] double time_to_rest(const ActuatorModel& actuator, double acceleration);

/// Adds a Boolean: the joints that a primitive moves (by its outputs "dq" and "ddq") are at rest. @return its port
[[nodiscard]] std::string add_standing(expression::FragmentWriter& fragment, const std::string& motion);

/// An action that moves an arm by a wanted velocity of its tool. Cancelled, or without a velocity, the arm comes to
/// rest.
class VelocityModel : public ActionModel {
 public:
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return time_to_rest(actuator, 1.0); }
  [[nodiscard]] bool net_knows_stop_time() const override { return false; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kTwist; }
  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override;

 protected:
  /// What the tool is never faster than, whatever velocity is wanted; nothing: what the limits of the arm allow.
  [[nodiscard]] virtual std::optional<ToolSpeed> speed() const { return std::nullopt; }
  /// Adds what gives "wanted.value", a twist of the tool centre point in the axes of the base; null: come to rest.
  virtual void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const = 0;

  /// The pose of the tool centre point in the base as "ID.frame"; `joints` is an output of ArmState.
  static void add_tool(expression::FragmentWriter& fragment, const ActuatorModel& actuator, const std::string& id,
                       const std::string& joints);
};

/// Adds the velocity that brings a force up and holds it, as "force_law.velocity"; null while the force is. The caller
/// feeds "servo.direction": that of the force, in the axes of the arm's base.
void add_force_law(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                   const expression::ExpressionPtr& pressing, const ForceControlParameters& parameters);

/// Adds "contact_known" and "touched": the force law has felt contact, now and at any time.
void add_touched(expression::FragmentWriter& fragment);
/// Adds "goes_on": people do not hold the actuator still; not known counts as held. @param speed  of the actuator
void add_moves_on(expression::FragmentWriter& fragment, const expression::RealSensor& speed);
/// Adds "wanted" from "moves": while the actuator is held still there is no approach; a force that has been brought up
/// is held.
void add_stand(expression::FragmentWriter& fragment, const expression::RealSensor& speed);

}  // namespace takt::command
