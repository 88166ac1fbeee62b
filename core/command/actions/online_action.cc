#include "core/command/actions/online_action.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/tracking.h"
#include "core/command/actions/velocity_action.h"
#include "core/device/description.h"
#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

Json joints_json(const JointVector& q) { return net::value_to_json(net::JointArray(q)); }

void check_share(const char* name, double value, Diagnostics& diagnostics) {
  if (value > 0.0 && value <= 1.0) return;
  diagnostics.error(Code::kOutOfRange, pointer_segment(name), fmt::format("a share of {:g}", value),
                    "Choose a share above 0, at most 1");
}

constexpr double kShortest = 1e-9;  ///< of a direction that is none

expression::ExpressionPtr no_direction(net::ValueType type) {
  return expression::broken(Code::kOutOfRange, type, "a direction of no length", "Give a vector that is not zero");
}

class Jog final : public VelocityModel {
 public:
  Jog(const expression::TwistSensor& velocity, const expression::State& enabled, const TrackingParameters& bounds)
      : velocity_(velocity.node()), enabled_(enabled.node()), bounds_(bounds) {}
  [[nodiscard]] std::string_view name() const override { return "jog"; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    return with_speed({velocity_, enabled_}, bounds_);
  }
  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    return check_figures({{"linear_max", bounds_.linear_max, "m/s"}, {"angular_max", bounds_.angular_max, "rad/s"}});
  }

 private:
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    fragment.add("held", "GateTwist");
    fragment.feed(velocity_, "held.input");
    fragment.feed(enabled_, "held.open");
    add_with_speed(fragment, actuator, bounds_, [this, &fragment](const std::string& id) {
      add_linked(fragment, id, "LimitTwist", {{"input", "held.value"}},
                 {{"linear_max", bounds_.linear_max}, {"angular_max", bounds_.angular_max}});
    });
  }
  [[nodiscard]] std::optional<ToolSpeed> speed() const override { return speed_of(bounds_); }

  expression::ExpressionPtr velocity_, enabled_;
  TrackingParameters bounds_;
};

class FollowPose final : public VelocityModel {
 public:
  FollowPose(const expression::FrameSensor& target, const TrackingParameters& parameters)
      : target_(target.node()), parameters_(parameters) {}
  [[nodiscard]] std::string_view name() const override { return "follow"; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas{target_};
    if (parameters_.target_twist) formulas.push_back(parameters_.target_twist->node());
    return with_speed(std::move(formulas), parameters_);
  }
  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override { return check_tracking(parameters_); }
  [[nodiscard]] std::vector<std::string> states() const override { return {"arrived", "error"}; }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "error") {
      fragment.add("no_target", "IsNullFrame");
      fragment.feed(target_, "no_target.input");
      return "no_target.value";
    }
    add_linked(fragment, "arrived", "FramesNear", {{"a", "now.frame"}},
               {{"distance_max", parameters_.distance}, {"angle_max", parameters_.angle}});
    fragment.feed(target_, "arrived.b");
    return "arrived.value";
  }

 private:
  /// From where the tool was sent last to the target, with a gain; and as the target moves.
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_tool(fragment, actuator, "now", "set_point_q");
    add_linked(fragment, "difference", "FrameDifference", {{"from", "now.frame"}});
    fragment.feed(target_, "difference.to");
    if (!parameters_.target_twist) return add_tracking(fragment, actuator, parameters_, "");
    fragment.add("target_twist", "DefaultToTwist", {{"fallback", net::value_to_json(net::Twist{})}});
    fragment.feed(parameters_.target_twist->node(), "target_twist.input");
    add_tracking(fragment, actuator, parameters_, "target_twist.value");
  }
  [[nodiscard]] std::optional<ToolSpeed> speed() const override { return speed_of(parameters_); }

  expression::ExpressionPtr target_;
  TrackingParameters parameters_;
};

class HoldForce final : public VelocityModel {
 public:
  HoldForce(const expression::RealSensor& pressing, const expression::FrameTerm& X_BT,
            const Eigen::Vector3d& direction_T, const ForceControlParameters& parameters)
      : pressing_(pressing.node()),
        direction_(direction_T.norm() > kShortest
                       ? expression::rotate(X_BT, Eigen::Vector3d(direction_T.normalized())).node()
                       : no_direction(net::ValueType::kVector)),
        parameters_(parameters) {}
  [[nodiscard]] std::string_view name() const override { return "hold force"; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return {pressing_, direction_}; }
  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics = check_figures({{"force", parameters_.force, "N"},
                                             {"approach_velocity", parameters_.approach_velocity, "m/s"},
                                             {"contact_force", parameters_.contact_force, "N"},
                                             {"release_time", parameters_.release_time, "s"},
                                             {"gain", parameters_.gain.value_or(1.0), "m/s/N"},
                                             {"velocity_max", parameters_.velocity_max, "m/s"},
                                             {"acceleration_max", parameters_.acceleration_max, "m/s^2"}});
    check_share("release_share", parameters_.release_share, diagnostics);
    check_share("band", parameters_.band, diagnostics);
    return diagnostics;
  }
  [[nodiscard]] std::vector<std::string> states() const override { return {"in_contact", "at_force", "error"}; }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "in_contact") return "force_law.contact";
    if (name == "at_force") return "force_law.at_force";
    fragment.add("no_force", "IsNullReal");
    fragment.feed(pressing_, "no_force.input");
    return "no_force.value";
  }

 private:
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_force_law(fragment, actuator, pressing_, parameters_);
    fragment.feed(direction_, "servo.direction");
    fragment.add("along", "ScaleVector");
    fragment.feed(direction_, "along.vector");
    fragment.link("force_law.velocity", "along.factor");
    const auto speed = actuator.speed();
    add_linked(fragment, speed ? "moves" : "wanted", "AssembleTwist", {{"linear", "along.value"}},
               {{"angular", net::value_to_json(net::Vector(net::Vector::Zero()))}});
    if (!speed) return;
    add_touched(fragment);
    add_stand(fragment, *speed);
  }

  expression::ExpressionPtr pressing_, direction_;
  ForceControlParameters parameters_;
};

/// When it is cancelled, where the arm then is becomes the target.
class FollowJoints final : public ActionModel {
 public:
  FollowJoints(const expression::JointsSensor& target, double velocity, double acceleration)
      : target_(target.node()), velocity_(velocity), acceleration_(acceleration) {}
  [[nodiscard]] std::string_view name() const override { return "follow"; }
  [[nodiscard]] SetPointKind gives(const ActuatorModel&) const override { return SetPointKind::kJoints; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return {target_}; }
  [[nodiscard]] std::vector<std::string> states() const override { return {"arrived", "error"}; }
  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics;
    check_share("velocity", velocity_, diagnostics);
    check_share("acceleration", acceleration_, diagnostics);
    return diagnostics;
  }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override {
    return time_to_rest(actuator, acceleration_);
  }
  [[nodiscard]] bool net_knows_stop_time() const override { return false; }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    const device::ArmDescription& arm = actuator.arm()->device->description();
    fragment.add("state", "ArmState", {{"device", actuator.name()}});
    add_target(fragment, actuator);
    add_linked(fragment, "generator", "JerkLimitedJointPosition",
               {{"target", "target.value"}, {"start", "begin.value"}},
               {{"joints", arm.limits.velocity.size()},
                {"velocity_max", joints_json(velocity_ * arm.limits.velocity)},
                {"acceleration_max", joints_json(acceleration_ * arm.limits.acceleration)},
                {"jerk_max", joints_json(acceleration_ * arm.limits.jerk)}});
    SetPoint set_point{.kind = SetPointKind::kJoints, .ports = {}, .constants = {}};
    set_point.ports["q"] = "generator.position";
    set_point.ports["dq"] = "generator.velocity";
    set_point.ports["ddq"] = "generator.acceleration";
    return {.set_point = set_point,
            .done = expression::Signal::at(fragment.gate_with_cancel("done", "And", "generator.arrived"))};
  }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "arrived") return "generator.arrived";
    fragment.add("no_target", "IsNullJoints");
    fragment.feed(target_, "no_target.input");
    return "no_target.value";
  }

 private:
  /// The newest target; before the first where the arm is; from a cancel on, and in a pause, where it was then.
  void add_target(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const {
    if (const auto speed = actuator.speed()) add_stands(fragment, *speed);
    add_linked(fragment, "begin", "SnapshotJoints", {{"input", "state.set_point_q"}}, {{"trigger", true}});
    fragment.add("newest", "HoldLastJoints", {{"cycles", 1'000'000'000}});
    fragment.feed(target_, "newest.input");
    add_linked(fragment, "known", "DefaultToJoints", {{"input", "newest.value"}, {"fallback", "begin.value"}});
    add_linked(fragment, "here", "SnapshotJoints", {{"input", "state.set_point_q"}});
    add_linked(fragment, "target", "SelectJoints", {{"if_true", "here.value"}, {"if_false", "known.value"}});
    for (const char* port : {"here.trigger", "target.condition"}) {
      if (actuator.speed()) {
        fragment.link("stands.value", port);
      } else {
        fragment.feed(fragment.cancel(), port);
      }
    }
  }
  /// It is cancelled, or people hold its actuator still.
  static void add_stands(expression::FragmentWriter& fragment, const expression::RealSensor& speed) {
    add_moves_on(fragment, speed);
    add_linked(fragment, "held_still", "Not", {{"input", "goes_on.value"}});
    add_linked(fragment, "stands", "Or", {{"a", "held_still.value"}});
    fragment.feed(fragment.cancel(), "stands.b");
  }

  expression::ExpressionPtr target_;
  double velocity_, acceleration_;
};

}  // namespace

Action jog(const expression::TwistSensor& velocity, const expression::State& enabled,
           const TrackingParameters& bounds) {
  return Action(std::make_shared<const Jog>(velocity, enabled, bounds));
}
Action follow(const expression::FrameSensor& target, const TrackingParameters& parameters) {
  return Action(std::make_shared<const FollowPose>(target, parameters));
}
Action follow(const expression::JointsSensor& target, double velocity, double acceleration) {
  return Action(std::make_shared<const FollowJoints>(target, velocity, acceleration));
}
Action hold_force(const expression::RealSensor& pressing, const expression::FrameTerm& X_BT,
                  const Eigen::Vector3d& direction_T, const ForceControlParameters& parameters) {
  return Action(std::make_shared<const HoldForce>(pressing, X_BT, direction_T, parameters));
}

namespace {

/// What a sensor on an arm feels, in the axes of the arm's base.
expression::VectorSensor felt_in_base(const expression::Cell& cell, const std::string& sensor,
                                      const expression::Biases& biases) {
  const expression::VectorSensor felt = expression::force(expression::contact_wrench(cell, sensor, biases));
  const auto mounted = cell.sensors.find(sensor);
  if (mounted == cell.sensors.end()) return felt;  // refused by every check: the sensor is not there
  return expression::rotate(expression::flange_fixed_pose(cell, mounted->second.arm, mounted->second.X_FS), felt);
}

}  // namespace

expression::RealSensor pressing_force(const expression::Cell& cell, const std::string& sensor,
                                      const Eigen::Vector3d& direction_B, const expression::Biases& biases) {
  if (!(direction_B.norm() > kShortest)) return expression::RealSensor(no_direction(net::ValueType::kReal));
  return expression::dot(felt_in_base(cell, sensor, biases), Eigen::Vector3d(-direction_B.normalized()));
}

expression::RealSensor lateral_force(const expression::Cell& cell, const std::string& sensor,
                                     const Eigen::Vector3d& direction_B, const expression::Biases& biases) {
  if (!(direction_B.norm() > kShortest)) return expression::RealSensor(no_direction(net::ValueType::kReal));
  constexpr double kCutoff_Hz = 30.0;
  const expression::VectorSensor felt = expression::low_pass(felt_in_base(cell, sensor, biases), kCutoff_Hz);
  const Eigen::Vector3d x = direction_B.unitOrthogonal(), y = direction_B.normalized().cross(x);
  const expression::RealSensor along_x = expression::dot(felt, x), along_y = expression::dot(felt, y);
  return expression::sqrt(along_x * along_x + along_y * along_y);
}

}  // namespace takt::command
