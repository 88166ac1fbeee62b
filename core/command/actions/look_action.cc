#include "core/command/actions/look_action.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/tracking.h"
#include "core/command/actions/velocity_action.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// From rest to the bound of a figure of the orbit, s; its acceleration is built up in the same time.
constexpr double kOrbitRamp = 0.4;
/// For which a pose has to be out of reach before the arm rests, s.
constexpr double kUnreachableFor = 0.3;

class LookAt final : public VelocityModel {
 public:
  LookAt(WatchedFrame watched, OrbitParameters orbit, const TrackingParameters& tracking)
      : watched_(std::move(watched)), orbit_(std::move(orbit)), tracking_(tracking) {}
  [[nodiscard]] std::string_view name() const override { return "look at"; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas{watched_.X_BW.node(), watched_.X_BU.node()};
    for (const auto& twist : {watched_.V_BW_B, watched_.V_BU_B}) {
      if (twist) formulas.push_back(twist->node());
    }
    for (const auto& term : {orbit_.distance, orbit_.azimuth, orbit_.elevation}) {
      if (term.operand().node != nullptr) formulas.push_back(term.operand().node);
    }
    return with_speed(std::move(formulas), tracking_);
  }
  [[nodiscard]] Diagnostics check(const ActuatorModel&) const override {
    Diagnostics diagnostics = check_tracking(tracking_);
    diagnostics.append(check_figures(
        {{"orbit_linear_max", orbit_.linear_max, "m/s"}, {"orbit_angular_max", orbit_.angular_max, "rad/s"}}));
    return diagnostics;
  }
  [[nodiscard]] std::vector<std::string> states() const override { return {"in_view", "unreachable", "error"}; }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "unreachable") return "unreachable.value";
    if (name == "error") {
      add_linked(fragment, "no_view", "IsNullFrame", {{"input", "view.frame"}});
      return "no_view.value";
    }
    add_linked(fragment, "in_view", "FramesNear", {{"a", "now.frame"}, {"b", "view.frame"}},
               {{"distance_max", tracking_.distance}, {"angle_max", tracking_.angle}});
    return "in_view.value";
  }

 private:
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_view(fragment);
    add_tool(fragment, actuator, "now", "set_point_q");
    add_reach(fragment, actuator);
    add_linked(fragment, "difference", "FrameDifference", {{"from", "now.frame"}, {"to", "pursued.value"}});
    add_tracking(fragment, actuator, tracking_, "view.twist");
  }
  [[nodiscard]] std::optional<ToolSpeed> speed() const override { return speed_of(tracking_); }

  /// "view": the pose that the camera should have, and how it moves.
  void add_view(expression::FragmentWriter& fragment) const {
    fragment.add("view", "OrbitFrame", {{"roll", orbit_.roll}});
    fragment.feed(watched_.X_BW.node(), "view.center");
    fragment.feed(watched_.X_BU.node(), "view.axes");
    add_twist(fragment, "center_twist", watched_.V_BW_B);
    add_twist(fragment, "axes_twist", watched_.V_BU_B);
    add_figure(fragment, "distance", orbit_.distance, orbit_.linear_max);
    add_figure(fragment, "azimuth", orbit_.azimuth, orbit_.angular_max);
    add_figure(fragment, "elevation", orbit_.elevation, orbit_.angular_max);
  }
  /// An unknown velocity is corrected like a difference.
  static void add_twist(expression::FragmentWriter& fragment, const std::string& input,
                        const std::optional<expression::TwistSensor>& twist) {
    const Json none = net::value_to_json(net::Twist{});
    if (twist) {
      fragment.add(input, "DefaultToTwist", {{"fallback", none}});
      fragment.feed(twist->node(), input + ".input");
    } else {
      fragment.add(input, "ConstantTwist", {{"value", none}});
    }
    fragment.link(input + ".value", "view." + input);
  }
  static void add_figure(expression::FragmentWriter& fragment, const std::string& figure,
                         const expression::RealTerm& term, double velocity) {
    const double acceleration = 2.0 * velocity / kOrbitRamp;
    add_linked(fragment, figure, "JerkLimitedPosition", {},
               {{"velocity_max", velocity},
                {"acceleration_max", acceleration},
                {"jerk_max", 2.0 * acceleration / kOrbitRamp}});
    if (const expression::Operand& target = term.operand(); target.node != nullptr) {
      fragment.feed(target.node, figure + ".target");
    } else {
      fragment.set_parameter(figure, "target", target.constant);
    }
    fragment.link(figure + ".position", "view." + figure);
    fragment.link(figure + ".velocity", "view." + figure + "_rate");
  }
  /// "pursued": the view; null, so that the arm rests, while it is out of reach.
  void add_reach(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const {
    add_linked(fragment, "reach", "FrameReach", {{"frame", "view.frame"}, {"q", "state.set_point_q"}},
               {{"device", actuator.name()}, {"tool", net::value_to_json(net::Frame(actuator.arm()->X_FT))}});
    add_linked(fragment, "out_of_reach", "Not", {{"input", "reach.reachable"}});
    add_linked(fragment, "out_of_reach_known", "DefaultToBoolean", {{"input", "out_of_reach.value"}},
               {{"fallback", false}});
    add_linked(fragment, "unreachable", "OnDelay", {{"input", "out_of_reach_known.value"}},
               {{"delay", kUnreachableFor}});
    add_linked(fragment, "may_pursue", "Not", {{"input", "unreachable.value"}});
    add_linked(fragment, "pursued", "GateFrame", {{"input", "view.frame"}, {"open", "may_pursue.value"}});
  }

  WatchedFrame watched_;
  OrbitParameters orbit_;
  TrackingParameters tracking_;
};

}  // namespace

Action look_at(const WatchedFrame& watched, const OrbitParameters& orbit, const TrackingParameters& tracking) {
  return Action(std::make_shared<const LookAt>(watched, orbit, tracking));
}

}  // namespace takt::command
