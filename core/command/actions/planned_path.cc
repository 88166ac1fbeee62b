#include "core/command/actions/planned_path.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/expression/device_sensors.h"
#include "core/motion/path.h"
#include "core/motion/path_clock.h"

namespace takt::command {
namespace {

struct PathKind {
  const char* primitive;
  SetPointKind kind;
};

PathKind primitive_of(const motion::Path& path) {
  if (std::holds_alternative<motion::JointLine>(path)) return {"JointLine", SetPointKind::kJoints};
  if (std::holds_alternative<motion::CartesianLine>(path)) return {"CartesianLine", SetPointKind::kPose};
  if (std::holds_alternative<motion::CartesianArc>(path)) return {"CartesianArc", SetPointKind::kPose};
  const auto& composite = std::get<motion::CompositePath>(path);
  if (!composite.has_cartesian_pieces()) return {"CompositePath", SetPointKind::kJoints};
  return {"CompositePath", composite.has_joint_pieces() ? SetPointKind::kPath : SetPointKind::kPose};
}

/// The rate of "target_rate" while a Boolean in here does not hold, else 0.
std::string add_stand(expression::FragmentWriter& fragment, const std::string& id, const std::string& stands,
                      const std::string& rate) {
  add_linked(fragment, id, "SelectReal", {{"condition", stands}, {"if_false", rate}}, {{"if_true", 0.0}});
  return id + ".value";
}

}  // namespace

std::vector<expression::ExpressionPtr> ClockInputs::formulas() const {
  std::vector<expression::ExpressionPtr> formulas;
  if (speed) formulas.push_back(speed->node());
  if (pause) formulas.push_back(pause->node());
  return formulas;
}

std::string path_time_channel(const std::string& arm) { return arm + ".path_time"; }
std::string path_rate_channel(const std::string& arm) { return arm + ".path_rate"; }

std::optional<expression::RealSensor> speed_on(const ActuatorModel& actuator,
                                               const std::optional<expression::RealSensor>& own) {
  const auto wanted = actuator.speed();
  if (wanted && own) return *wanted * *own;
  return wanted ? wanted : own;
}

void add_clock(expression::FragmentWriter& fragment, const ActuatorModel& actuator, const motion::Motion& motion,
               const ClockInputs& inputs, const std::string& waits_for) {
  fragment.add("target_rate", "SelectReal", {{"if_true", 0.0}});
  fragment.feed(fragment.cancel(), "target_rate.condition");
  if (const auto speed = speed_on(actuator, inputs.speed)) {
    fragment.feed(speed->node(), "target_rate.if_false");
  } else {
    fragment.set_parameter("target_rate", "if_false", 1.0);
  }
  std::string rate = "target_rate.value";
  if (inputs.pause) {
    fragment.add("paused", "DefaultToBoolean", {{"fallback", true}});
    fragment.feed(inputs.pause->node(), "paused.input");
    rate = add_stand(fragment, "rate", "paused.value", rate);
  }
  if (!waits_for.empty()) {
    add_linked(fragment, "waits", "Not", {{"input", waits_for}});
    rate = add_stand(fragment, "rate_after", "waits.value", rate);
  }
  const nlohmann::ordered_json law = motion::to_json(motion.law);
  add_linked(fragment, "clock", "PathClock", {{"target_rate", rate}},
             {{"duration", motion.duration()}, {"bounds", motion::to_json(motion.clock)}, {"law", law}});
  fragment.add("law", "TimeLaw", {{"law", law}});
  fragment.link_all("clock", "law", {"time", "rate", "rate_derivative"});
}

SetPointKind kind_of(const motion::Path& path) { return primitive_of(path).kind; }

SetPoint add_path(expression::FragmentWriter& fragment, const std::string& id, const motion::Path& path,
                  const Eigen::Isometry3d& X_FM) {
  const PathKind kind = primitive_of(path);
  fragment.add(id, kind.primitive, {{"path", motion::to_json(path)}});
  fragment.link_all("law", id, {"s", "ds", "dds"});
  SetPoint set_point{.kind = kind.kind, .ports = {}, .constants = {}, .X_FM = X_FM};
  const auto offer = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) set_point.ports[name] = fmt::format("{}.{}", id, name);
  };
  if (kind.kind != SetPointKind::kPose) offer({"q", "dq", "ddq"});
  if (kind.kind != SetPointKind::kJoints) {
    offer({"frame", "twist", "acceleration", "held", "held_velocity", "held_acceleration"});
  }
  if (kind.kind == SetPointKind::kPath) offer({"cartesian"});
  return set_point;
}

}  // namespace takt::command
