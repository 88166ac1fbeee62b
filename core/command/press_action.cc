#include "core/command/press_action.h"

#include <nlohmann/json.hpp>

#include "core/command/velocity_action.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// How fast a deviation from where the tool should be is taken back, 1/s.
constexpr double kHoldGain = 5.0;

Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }

class Press final : public VelocityModel {
 public:
  Press(const RealSensor& pressing, const Eigen::Vector3d& direction_B, PressWish wish)
      : pressing_(pressing.node()), direction_B_(direction_B.normalized()), wish_(std::move(wish)) {}

  [[nodiscard]] std::string_view name() const override { return "press"; }
  [[nodiscard]] std::vector<ExpressionPtr> formulas() const override {
    std::vector<ExpressionPtr> formulas = wish_.clock.formulas();
    formulas.push_back(pressing_);
    return formulas;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states{"in_contact", "touched", "too_far", "error"};
    if (wish_.sink) states.emplace_back("sunk");
    if (wish_.path) states.emplace_back("path_ended");
    return states;
  }

  [[nodiscard]] std::string add_state(FragmentWriter& fragment, const std::string& name, const Json&) const override {
    if (name == "in_contact") return "contact_known.value";
    if (name == "touched") return "touched.value";
    if (name == "path_ended") return "clock.at_end";
    if (name == "too_far") {
      fragment.add("too_far", "AtLeast", {{"b", wish_.travel}});
      fragment.link("depth.value", "too_far.a");
      return "too_far.value";
    }
    if (name == "sunk") return add_sunk(fragment);
    fragment.add("no_force", "IsNullReal");
    fragment.feed(pressing_, "no_force.input");
    return "no_force.value";
  }

 private:
  void add_velocity(FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    add_tool(fragment, actuator, "sent", "set_point_q");
    // Measured: a tool that is pressed to a side is not pressed there any more.
    add_tool(fragment, actuator, "felt", "q");
    fragment.add("begin", "SnapshotFrame", {{"trigger", true}});
    fragment.link("felt.frame", "begin.input");
    add_depth(fragment);
    add_force_law(fragment, pressing_, wish_.force);
    // A silent sensor has not felt anything.
    fragment.add("contact_known", "DefaultToBoolean", {{"fallback", false}});
    fragment.link("force_law.contact", "contact_known.input");
    fragment.add("touched", "SetResetLatch", {{"reset", false}});
    fragment.link("contact_known.value", "touched.set");
    add_follow(fragment);
    add_push(fragment);
  }

  /// How far the tool was sent along the direction.
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
    if (!wish_.path) {
      fragment.link("begin.value", "off.to");
      return fragment.link("back.value", "follow_parts.input");
    }
    add_clock(fragment, *wish_.path, wish_.clock, "touched.value");
    const SetPoint path = add_path(fragment, "path", wish_.path->path, Eigen::Isometry3d::Identity());
    path.feed(fragment, "frame", "off.to");
    fragment.add("follow", "AddTwists");
    fragment.link("back.value", "follow.a");
    path.feed(fragment, "twist", "follow.b");
    fragment.link("follow.value", "follow_parts.input");
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
    fragment.add("wanted", "AssembleTwist");
    fragment.link("linear.value", "wanted.linear");
    fragment.link("follow_parts.angular", "wanted.angular");
  }

  std::string add_sunk(FragmentWriter& fragment) const {
    fragment.add("depth_at_touch", "SnapshotReal");
    fragment.link("depth.value", "depth_at_touch.input");
    fragment.link("touched.value", "depth_at_touch.trigger");
    fragment.add("sunk_by", "Subtract");
    fragment.link("depth.value", "sunk_by.a");
    fragment.link("depth_at_touch.value", "sunk_by.b");
    fragment.add("sunk", "AtLeast", {{"b", *wish_.sink}});
    fragment.link("sunk_by.value", "sunk.a");
    // Before the touch nobody knows a depth to compare with.
    fragment.add("sunk_known", "DefaultToBoolean", {{"fallback", false}});
    fragment.link("sunk.value", "sunk_known.input");
    return "sunk_known.value";
  }

  ExpressionPtr pressing_;
  Eigen::Vector3d direction_B_;
  PressWish wish_;
};

}  // namespace

Action press(const RealSensor& pressing, const Eigen::Vector3d& direction_B, const PressWish& wish) {
  return Action(std::make_shared<const Press>(pressing, direction_B, wish));
}

}  // namespace takt::command
