#include "core/command/actions/velocity_action.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/device/description.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

/// Joints that are slower and change their velocity less than this are at rest, rad/s and rad/s^2.
constexpr double kStanding = 1e-9;

}  // namespace

std::string add_standing(expression::FragmentWriter& fragment, const std::string& motion) {
  for (const char* port : {"dq", "ddq"}) {
    const std::string id = std::string("largest_") + port;
    add_linked(fragment, id, "LargestJoint", {{"input", motion + "." + port}});
    add_linked(fragment, id + "_none", "LessThan", {{"a", id + ".value"}}, {{"b", kStanding}});
  }
  add_linked(fragment, "standing", "And", {{"a", "largest_dq_none.value"}, {"b", "largest_ddq_none.value"}});
  return "standing.value";
}

double time_to_rest(const ActuatorModel& actuator, double acceleration) {
  const auto& limits = actuator.arm()->device->description().limits;
  double longest = 0.0;
  for (Eigen::Index i = 0; i < limits.velocity.size(); ++i) {
    const double ramp = limits.acceleration[i] / limits.jerk[i];
    longest = std::max(longest, limits.velocity[i] / (acceleration * limits.acceleration[i]) + 2.0 * ramp);
  }
  return 4.0 * longest;
}

Contribution VelocityModel::add_to(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const {
  add_velocity(fragment, actuator);
  fragment.add("go", "Not");
  fragment.feed(fragment.cancel(), "go.input");
  add_linked(fragment, "twist", "GateTwist", {{"input", "wanted.value"}, {"open", "go.value"}});
  return {.set_point = {.kind = SetPointKind::kTwist,
                        .ports = {{"twist", "twist.value"}},
                        .constants = {},
                        .sensors = {},
                        .X_FM = actuator.arm()->X_FT,
                        .speed = speed()},
          .done = expression::Signal::at(fragment.gate_with_cancel("done", "And", add_standing(fragment, "inverse")))};
}

void VelocityModel::add_tool(expression::FragmentWriter& fragment, const ActuatorModel& actuator, const std::string& id,
                             const std::string& joints) {
  if (!fragment.has("state")) fragment.add("state", "ArmState", {{"device", actuator.name()}});
  add_linked(fragment, id, "ForwardKinematics", {{"q", "state." + joints}},
             {{"device", actuator.name()}, {"tool", net::value_to_json(net::Frame(actuator.arm()->X_FT))}});
}

void add_force_law(expression::FragmentWriter& fragment, const ActuatorModel& actuator,
                   const expression::ExpressionPtr& pressing, const ForceControlParameters& parameters) {
  if (!fragment.has("state")) fragment.add("state", "ArmState", {{"device", actuator.name()}});
  const expression::MountedArm& arm = *actuator.arm();
  add_linked(fragment, "servo", "ServoStiffness", {{"q", "state.q"}},
             {{"device", actuator.name()},
              {"tool", net::value_to_json(net::Frame(arm.X_FT))},
              {"tip_compliance", net::value_to_json(net::Vector(arm.tip.compliance_T))}});
  fragment.add("force_law", "ForceController",
               {{"wanted", parameters.force},
                {"approach_velocity", parameters.approach_velocity},
                {"contact_force", parameters.contact_force},
                {"release_force", parameters.release_share * parameters.contact_force},
                {"release_time", parameters.release_time},
                {"band", parameters.band},
                {"gain", parameters.gain.value_or(0.0)},
                {"surface_moves", parameters.surface_moves},
                {"measures_stiffness", parameters.measures_stiffness},
                {"sensor_delay", parameters.sensor_delay},
                {"velocity_max", parameters.velocity_max},
                {"acceleration_max", parameters.acceleration_max},
                {"approach_acceleration", parameters.approach_acceleration}});
  fragment.link_all("servo", "force_law", {"stiffness", "natural_frequency", "damping_ratio", "delay"});
  fragment.feed(pressing, "force_law.force");
}

void add_touched(expression::FragmentWriter& fragment) {
  // A silent sensor has not felt anything.
  add_linked(fragment, "contact_known", "DefaultToBoolean", {{"input", "force_law.contact"}}, {{"fallback", false}});
  add_linked(fragment, "touched", "SetResetLatch", {{"set", "contact_known.value"}}, {{"reset", false}});
}

void add_moves_on(expression::FragmentWriter& fragment, const expression::RealSensor& speed) {
  fragment.add("speed_known", "DefaultToReal", {{"fallback", 0.0}});
  fragment.feed(speed.node(), "speed_known.input");
  add_linked(fragment, "goes_on", "GreaterThan", {{"a", "speed_known.value"}}, {{"b", 0.0}});
}

void add_stand(expression::FragmentWriter& fragment, const expression::RealSensor& speed) {
  add_moves_on(fragment, speed);
  add_linked(fragment, "may_move", "Or", {{"a", "goes_on.value"}, {"b", "touched.value"}});
  add_linked(fragment, "wanted", "GateTwist", {{"input", "moves.value"}, {"open", "may_move.value"}});
}

}  // namespace takt::command
