#include "core/command/actions/press_action.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/velocity_action.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// How fast a deviation from where the tool should be is corrected, 1/s.
constexpr double kHoldGain = 5.0;
/// How fast the lead over a path follows the lag of springs: slower than the lead itself.
constexpr double kLeadCutoff_Hz = 0.5;

Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }

class Press final : public VelocityModel {
 public:
  Press(const expression::RealSensor& pressing, const Eigen::Vector3d& direction_B, PressControlParameters parameters)
      : pressing_(pressing.node()), direction_B_(direction_B.normalized()), parameters_(std::move(parameters)) {}

  [[nodiscard]] std::string_view name() const override { return "press"; }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas = parameters_.clock.formulas();
    formulas.push_back(pressing_);
    if (parameters_.lateral) formulas.push_back(parameters_.lateral->force.node());
    return formulas;
  }
  [[nodiscard]] double duration() const override { return parameters_.path ? parameters_.path->duration() : 0.0; }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states{"in_contact", "touched", "at_force", "too_far", "error"};
    if (parameters_.sink) states.emplace_back("sunk");
    if (parameters_.deepest) states.emplace_back("too_deep");
    if (parameters_.lateral) states.emplace_back("sideways");
    if (parameters_.path) states.emplace_back("path_ended");
    return states;
  }

  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json&) const override {
    if (name == "in_contact") return "contact_known.value";
    if (name == "touched") return "touched.value";
    if (name == "path_ended") return "clock.at_end";
    if (name == "too_far") {
      add_linked(fragment, "too_far", "AtLeast", {{"a", "depth.value"}}, {{"b", parameters_.travel}});
      return "too_far.value";
    }
    if (name == "at_force") return add_at_force(fragment);
    if (name == "sunk") return add_deeper(fragment, "sunk", *parameters_.sink);
    if (name == "sideways") return add_sideways(fragment);
    if (name == "too_deep") return add_deeper(fragment, "too_deep", *parameters_.deepest);
    fragment.add("no_force", "IsNullReal");
    fragment.feed(pressing_, "no_force.input");
    return "no_force.value";
  }

 private:
  void add_velocity(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_tool(fragment, actuator, "sent", "set_point_q");
    if (parameters_.sink || parameters_.deepest || holds_measured_place() || leads())
      add_tool(fragment, actuator, "felt", "q");
    add_linked(fragment, "begin", "SnapshotFrame", {{"input", "sent.frame"}}, {{"trigger", true}});
    add_depth(fragment);
    add_force_law(fragment, actuator, pressing_, parameters_.force);
    fragment.add("push_direction", "ConstantVector", {{"value", vector_json(direction_B_)}});
    fragment.link("push_direction.value", "servo.direction");
    add_touched(fragment);
    add_follow(fragment, actuator);
    add_push(fragment, speed_on(actuator, parameters_.clock.speed));
  }

  /// How far the tool was sent along the direction: springs that meet something which the sensor does not feel are not
  /// bent further than that.
  void add_depth(expression::FragmentWriter& fragment) const {
    add_linked(fragment, "here", "FrameComponents", {{"input", "sent.frame"}});
    add_linked(fragment, "there", "FrameComponents", {{"input", "begin.value"}});
    add_linked(fragment, "way", "SubtractVectors", {{"a", "here.position"}, {"b", "there.position"}});
    add_linked(fragment, "depth", "DotProduct", {{"a", "way.value"}}, {{"b", vector_json(direction_B_)}});
  }

  /// Twist of the tool towards where it should be, the path or where it began, as "follow_parts".
  void add_follow(expression::FragmentWriter& fragment, const ActuatorModel& actuator) const {
    add_linked(fragment, "off", "FrameDifference", {{"from", "sent.frame"}});
    add_linked(fragment, "back", "ScaleTwist", {{"twist", "off.value"}}, {{"factor", kHoldGain}});
    fragment.add("follow_parts", "TwistComponents");
    if (!parameters_.path) {
      fragment.link(add_place(fragment), "off.to");
      return fragment.link("back.value", "follow_parts.input");
    }
    add_clock(fragment, actuator, *parameters_.path, parameters_.clock, "touched.value");
    const SetPoint path = add_path(fragment, "path", parameters_.path->path, Eigen::Isometry3d::Identity());
    if (leads()) {
      add_lead(fragment, path);
    } else {
      path.feed(fragment, "frame", "off.to");
    }
    add_linked(fragment, "follow", "AddTwists", {{"a", "back.value"}});
    path.feed(fragment, "twist", "follow.b");
    fragment.add("path_motion", "TwistComponents");
    path.feed(fragment, "twist", "path_motion.input");
    // The clock of the path waits for the contact.
    fragment.link_delayed("path_motion.linear", "force_law.path_velocity", vector_json(Eigen::Vector3d::Zero()));
    fragment.link("follow.value", "follow_parts.input");
  }

  /// Springs lag behind a path by what friction bends them.
  [[nodiscard]] bool leads() const { return parameters_.path && parameters_.softness_across; }
  /// The set point aims as far beyond the path as the tool lags behind it, across the direction and within what a
  /// friction as large as the force bends the springs: so the tool is where the path is, and a tool that is caught is
  /// not pressed harder than that.
  void add_lead(expression::FragmentWriter& fragment, const SetPoint& path) const {
    add_linked(fragment, "lag", "FrameDifference", {{"from", "felt.frame"}, {"to", "sent.frame"}});
    add_linked(fragment, "lag_parts", "TwistComponents", {{"input", "lag.value"}});
    add_linked(fragment, "lag_split", "SplitVector", {{"input", "lag_parts.linear"}},
               {{"direction", vector_json(direction_B_)}});
    add_linked(fragment, "lag_slow", "LowPassVector", {{"input", "lag_split.across"}}, {{"cutoff", kLeadCutoff_Hz}});
    add_linked(fragment, "lead", "LimitVector", {{"input", "lag_slow.value"}},
               {{"length_max", *parameters_.softness_across * parameters_.force.force}});
    add_linked(fragment, "lead_by", "AssembleTwist", {{"linear", "lead.value"}},
               {{"angular", vector_json(Eigen::Vector3d::Zero())}});
    fragment.add("ahead", "DisplaceFrame");
    path.feed(fragment, "frame", "ahead.frame");
    fragment.link("lead_by.value", "ahead.displacement");
    fragment.link("ahead.value", "off.to");
  }

  /// A stiff tool that was pressed to a side is not pressed there any more. Springs stay bent as they are: to follow
  /// the tool would let it sink by its weight a little more each time.
  [[nodiscard]] bool holds_measured_place() const { return !parameters_.path && !parameters_.softness_across; }
  /// Where the tool is held without a path. @return the port.
  std::string add_place(expression::FragmentWriter& fragment) const {
    if (!holds_measured_place()) return "begin.value";
    add_linked(fragment, "place", "SnapshotFrame", {{"input", "felt.frame"}}, {{"trigger", true}});
    return "place.value";
  }

  /// Along the direction as the force wants, across it after where the tool should be.
  void add_push(expression::FragmentWriter& fragment, const std::optional<expression::RealSensor>& speed) const {
    add_linked(fragment, "split", "SplitVector", {{"input", "follow_parts.linear"}},
               {{"direction", vector_json(direction_B_)}});
    add_linked(fragment, "push", "ScaleVector", {{"factor", "force_law.velocity"}},
               {{"vector", vector_json(direction_B_)}});
    add_linked(fragment, "linear", "AddVectors", {{"a", "split.across"}, {"b", "push.value"}});
    const std::string twist = speed ? "moves" : "wanted";
    add_linked(fragment, twist, "AssembleTwist", {{"linear", "linear.value"}, {"angular", "follow_parts.angular"}});
    if (speed) add_stand(fragment, *speed);
  }

  static std::string add_at_force(expression::FragmentWriter& fragment) {
    add_linked(fragment, "at_force", "DefaultToBoolean", {{"input", "force_law.at_force"}}, {{"fallback", false}});
    return "at_force.value";
  }

  [[nodiscard]] std::string add_sideways(expression::FragmentWriter& fragment) const {
    fragment.add("sideways", "AtLeast", {{"b", parameters_.lateral->most}});
    fragment.feed(parameters_.lateral->force.node(), "sideways.a");
    add_linked(fragment, "sideways_known", "DefaultToBoolean", {{"input", "sideways.value"}}, {{"fallback", false}});
    return "sideways_known.value";
  }

  /// The tool as measured: springs are bent further after the touch, and the set point goes on meanwhile.
  static std::string add_deeper(expression::FragmentWriter& fragment, const std::string& name, double depth) {
    if (!fragment.has("felt_depth")) {
      add_linked(fragment, "felt_here", "FrameComponents", {{"input", "felt.frame"}});
      add_linked(fragment, "felt_depth", "DotProduct", {{"a", "felt_here.position"}, {"b", "push_direction.value"}});
      add_linked(fragment, "depth_at_touch", "SnapshotReal",
                 {{"input", "felt_depth.value"}, {"trigger", "touched.value"}});
      add_linked(fragment, "sunk_by", "Subtract", {{"a", "felt_depth.value"}, {"b", "depth_at_touch.value"}});
    }
    add_linked(fragment, name, "AtLeast", {{"a", "sunk_by.value"}}, {{"b", depth}});
    // Before the touch there is no depth to compare with.
    add_linked(fragment, name + "_known", "DefaultToBoolean", {{"input", name + ".value"}}, {{"fallback", false}});
    return name + "_known.value";
  }

  expression::ExpressionPtr pressing_;
  Eigen::Vector3d direction_B_;
  PressControlParameters parameters_;
};

}  // namespace

Action press(const expression::RealSensor& pressing, const Eigen::Vector3d& direction_B,
             const PressControlParameters& parameters) {
  return Action(std::make_shared<const Press>(pressing, direction_B, parameters));
}

}  // namespace takt::command
