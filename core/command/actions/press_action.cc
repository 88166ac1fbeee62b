#include "core/command/actions/press_action.h"

#include <algorithm>

#include <nlohmann/json.hpp>

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
  Press(const RealSensor& pressing, const Eigen::Vector3d& direction_B, PressControlParameters parameters)
      : pressing_(pressing.node()), direction_B_(direction_B.normalized()), parameters_(std::move(parameters)) {}

  [[nodiscard]] std::string_view name() const override { return "press"; }
  [[nodiscard]] std::vector<ExpressionPtr> formulas() const override {
    std::vector<ExpressionPtr> formulas = parameters_.clock.formulas();
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

  [[nodiscard]] std::string add_state(FragmentWriter& fragment, const std::string& name, const Json&) const override {
    if (name == "in_contact") return "contact_known.value";
    if (name == "touched") return "touched.value";
    if (name == "path_ended") return "clock.at_end";
    if (name == "too_far") {
      fragment.add("too_far", "AtLeast", {{"b", parameters_.travel}});
      fragment.link("depth.value", "too_far.a");
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
  void add_velocity(FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_tool(fragment, actuator, "sent", "set_point_q");
    if (parameters_.sink || parameters_.deepest || holds_measured_place() || leads())
      add_tool(fragment, actuator, "felt", "q");
    fragment.add("begin", "SnapshotFrame", {{"trigger", true}});
    fragment.link("sent.frame", "begin.input");
    add_depth(fragment);
    add_force_law(fragment, actuator, pressing_, parameters_.force);
    fragment.add("push_direction", "ConstantVector", {{"value", vector_json(direction_B_)}});
    fragment.link("push_direction.value", "servo.direction");
    // A silent sensor has not felt anything.
    fragment.add("contact_known", "DefaultToBoolean", {{"fallback", false}});
    fragment.link("force_law.contact", "contact_known.input");
    fragment.add("touched", "SetResetLatch", {{"reset", false}});
    fragment.link("contact_known.value", "touched.set");
    add_follow(fragment);
    add_push(fragment);
  }

  /// How far the tool was sent along the direction: springs that meet something which the sensor does not feel are not
  /// bent further than that.
  void add_depth(FragmentWriter& fragment) const {
    fragment.add("here", "FrameComponents");
    fragment.link("sent.frame", "here.input");
    fragment.add("there", "FrameComponents");
    fragment.link("begin.value", "there.input");
    fragment.add("way", "SubtractVectors");
    fragment.link("here.position", "way.a");
    fragment.link("there.position", "way.b");
    fragment.add("depth", "DotProduct", {{"b", vector_json(direction_B_)}});
    fragment.link("way.value", "depth.a");
  }

  /// Twist of the tool towards where it should be, the path or where it began, as "follow_parts".
  void add_follow(FragmentWriter& fragment) const {
    fragment.add("off", "FrameDifference");
    fragment.link("sent.frame", "off.from");
    fragment.add("back", "ScaleTwist", {{"factor", kHoldGain}});
    fragment.link("off.value", "back.twist");
    fragment.add("follow_parts", "TwistComponents");
    if (!parameters_.path) {
      fragment.link(add_place(fragment), "off.to");
      return fragment.link("back.value", "follow_parts.input");
    }
    add_clock(fragment, *parameters_.path, parameters_.clock, "touched.value");
    const SetPoint path = add_path(fragment, "path", parameters_.path->path, Eigen::Isometry3d::Identity());
    if (leads()) {
      add_lead(fragment, path);
    } else {
      path.feed(fragment, "frame", "off.to");
    }
    fragment.add("follow", "AddTwists");
    fragment.link("back.value", "follow.a");
    path.feed(fragment, "twist", "follow.b");
    fragment.link("follow.value", "follow_parts.input");
  }

  /// Springs lag behind a path by what friction bends them.
  [[nodiscard]] bool leads() const { return parameters_.path && parameters_.softness_across; }
  /// The set point aims as far beyond the path as the tool lags behind it, across the direction and within what a
  /// friction as large as the force bends the springs: so the tool is where the path is, and a tool that is caught is
  /// not pressed harder than that.
  void add_lead(FragmentWriter& fragment, const SetPoint& path) const {
    fragment.add("lag", "FrameDifference");
    fragment.link("felt.frame", "lag.from");
    fragment.link("sent.frame", "lag.to");
    fragment.add("lag_parts", "TwistComponents");
    fragment.link("lag.value", "lag_parts.input");
    fragment.add("lag_split", "SplitVector", {{"direction", vector_json(direction_B_)}});
    fragment.link("lag_parts.linear", "lag_split.input");
    fragment.add("lag_slow", "LowPassVector", {{"cutoff", kLeadCutoff_Hz}});
    fragment.link("lag_split.across", "lag_slow.input");
    fragment.add("lead", "LimitVector", {{"length_max", *parameters_.softness_across * parameters_.force.force}});
    fragment.link("lag_slow.value", "lead.input");
    fragment.add("lead_by", "AssembleTwist", {{"angular", vector_json(Eigen::Vector3d::Zero())}});
    fragment.link("lead.value", "lead_by.linear");
    fragment.add("ahead", "DisplaceFrame");
    path.feed(fragment, "frame", "ahead.frame");
    fragment.link("lead_by.value", "ahead.displacement");
    fragment.link("ahead.value", "off.to");
  }

  /// A stiff tool that was pressed to a side is not pressed there any more. Springs stay bent as they are: to follow
  /// the tool would let it sink by its weight a little more each time.
  [[nodiscard]] bool holds_measured_place() const { return !parameters_.path && !parameters_.softness_across; }
  /// Where the tool is held without a path. @return the port.
  std::string add_place(FragmentWriter& fragment) const {
    if (!holds_measured_place()) return "begin.value";
    fragment.add("place", "SnapshotFrame", {{"trigger", true}});
    fragment.link("felt.frame", "place.input");
    return "place.value";
  }

  /// Along the direction as the force wants, across it after where the tool should be.
  void add_push(FragmentWriter& fragment) const {
    fragment.add("split", "SplitVector", {{"direction", vector_json(direction_B_)}});
    fragment.link("follow_parts.linear", "split.input");
    fragment.add("push", "ScaleVector", {{"vector", vector_json(direction_B_)}});
    fragment.link("force_law.velocity", "push.factor");
    fragment.add("linear", "AddVectors");
    fragment.link("split.across", "linear.a");
    fragment.link("push.value", "linear.b");
    const std::string twist = parameters_.clock.speed ? "moves" : "wanted";
    fragment.add(twist, "AssembleTwist");
    fragment.link("linear.value", twist + ".linear");
    fragment.link("follow_parts.angular", twist + ".angular");
    if (parameters_.clock.speed) add_stand(fragment);
  }

  /// While the clock is stopped there is no approach; a force that has been brought up is held.
  void add_stand(FragmentWriter& fragment) const {
    fragment.add("speed_known", "DefaultToReal", {{"fallback", 0.0}});
    fragment.feed(parameters_.clock.speed->node(), "speed_known.input");
    fragment.add("goes_on", "GreaterThan", {{"b", 0.0}});
    fragment.link("speed_known.value", "goes_on.a");
    fragment.add("may_move", "Or");
    fragment.link("goes_on.value", "may_move.a");
    fragment.link("touched.value", "may_move.b");
    fragment.add("wanted", "GateTwist");
    fragment.link("moves.value", "wanted.input");
    fragment.link("may_move.value", "wanted.open");
  }

  static std::string add_at_force(FragmentWriter& fragment) {
    fragment.add("at_force", "DefaultToBoolean", {{"fallback", false}});
    fragment.link("force_law.at_force", "at_force.input");
    return "at_force.value";
  }

  [[nodiscard]] std::string add_sideways(FragmentWriter& fragment) const {
    fragment.add("sideways", "AtLeast", {{"b", parameters_.lateral->most}});
    fragment.feed(parameters_.lateral->force.node(), "sideways.a");
    fragment.add("sideways_known", "DefaultToBoolean", {{"fallback", false}});
    fragment.link("sideways.value", "sideways_known.input");
    return "sideways_known.value";
  }

  /// The tool as measured: springs are bent further after the touch, and the set point goes on meanwhile.
  static std::string add_deeper(FragmentWriter& fragment, const std::string& name, double depth) {
    if (!fragment.has("felt_depth")) {
      fragment.add("felt_here", "FrameComponents");
      fragment.link("felt.frame", "felt_here.input");
      fragment.add("felt_depth", "DotProduct");
      fragment.link("felt_here.position", "felt_depth.a");
      fragment.link("push_direction.value", "felt_depth.b");
      fragment.add("depth_at_touch", "SnapshotReal");
      fragment.link("felt_depth.value", "depth_at_touch.input");
      fragment.link("touched.value", "depth_at_touch.trigger");
      fragment.add("sunk_by", "Subtract");
      fragment.link("felt_depth.value", "sunk_by.a");
      fragment.link("depth_at_touch.value", "sunk_by.b");
    }
    fragment.add(name, "AtLeast", {{"b", depth}});
    fragment.link("sunk_by.value", name + ".a");
    // Before the touch there is no depth to compare with.
    fragment.add(name + "_known", "DefaultToBoolean", {{"fallback", false}});
    fragment.link(name + ".value", name + "_known.input");
    return name + "_known.value";
  }

  ExpressionPtr pressing_;
  Eigen::Vector3d direction_B_;
  PressControlParameters parameters_;
};

}  // namespace

Action press(const RealSensor& pressing, const Eigen::Vector3d& direction_B, const PressControlParameters& parameters) {
  return Action(std::make_shared<const Press>(pressing, direction_B, parameters));
}

}  // namespace takt::command
