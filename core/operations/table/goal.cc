#include "core/operations/table/goal.h"

#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/angles.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/joint_range.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;

Goal::Joints read_joints(ObjectReader& reader, const expression::MountedArm* arm) {
  // Without a device (a cell that cannot be built) any number of joints is right in form.
  const std::size_t count = arm && arm->device ? static_cast<std::size_t>(arm->device->joint_count()) : 0;
  const auto degrees = reader.numbers("joints_deg", count);
  warn_of_radians(degrees, reader.at("joints_deg"), reader.diagnostics());
  const std::size_t kept = std::min<std::size_t>(degrees.size(), kinematics::kMaxJoints);
  Goal::Joints joints{kinematics::JointVector(static_cast<Eigen::Index>(kept))};
  for (std::size_t i = 0; i < kept; ++i) joints.q[static_cast<Eigen::Index>(i)] = degrees[i] * std::numbers::pi / 180.0;
  return joints;
}

Goal::Step read_step(ObjectReader& reader) {
  Goal::Step step;
  step.in = reader.text("in", "world");
  step.translation = reader.vector("by_m", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  const auto rpy = reader.numbers("by_rpy_deg", 3, std::vector<double>{0, 0, 0});
  warn_of_radians(rpy, reader.at("by_rpy_deg"), reader.diagnostics());
  constexpr double kDegree = std::numbers::pi / 180.0;
  step.rotation = Eigen::AngleAxisd(rpy[2] * kDegree, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(rpy[1] * kDegree, Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(rpy[0] * kDegree, Eigen::Vector3d::UnitX());
  return step;
}

}  // namespace

const std::vector<ParameterInfo>& goal_fields() {
  using Type = ParameterInfo::Type;
  static const auto fields = [] {
    const auto field = [](const char* key, Type type, const char* unit, const char* doc) {
      return ParameterInfo{.key = key, .type = type, .unit = unit, .doc = doc};
    };
    return std::vector<ParameterInfo>{
        field("home", Type::kBoolean, "", "True: the home posture of the model, as \"home\" alone."),
        field("joints_deg", Type::kNumbers, "deg", "Joint positions."),
        field("absolute", Type::kBoolean, "",
              "Of home or joint positions: a joint without limits takes back all its turns; else it goes to the turn "
              "that is nearest."),
        field("in", Type::kText, "", "Frame of a pose; of a step its axes, \"tcp\" for those of the tool."),
        field("position_m", Type::kVector, "m", "Position of the tool centre point in that frame."),
        field("rpy_deg", Type::kVector, "deg", "Orientation: roll, pitch, yaw; without one the tool keeps its own."),
        field("quaternion", Type::kNumbers, "", "Orientation: w, x, y, z."),
        field("by_m", Type::kVector, "m", "Step from the present set point."),
        field("by_rpy_deg", Type::kVector, "deg", "Turn about the tool's own axes.")};
  }();
  return fields;
}

Goal read_goal(ObjectReader& parent, const expression::MountedArm* arm, std::string_view key) {
  if (const Json* json = parent.child(key)) return read_goal(*json, parent.at(key), arm, parent.diagnostics());
  parent.diagnostics().error(Code::kMissing, parent.pointer(), fmt::format("key '{}' is missing", key),
                             "Give \"home\" or an object {...}");
  return {};
}

Goal read_goal(const Json& json, const std::string& pointer, const expression::MountedArm* arm,
               Diagnostics& diagnostics) {
  if (json == "home") return {Goal::Home{}};
  if (json.is_string()) {
    diagnostics.error(Code::kWrongType, pointer, fmt::format("unexpected value {}", short_dump(json)),
                      "Give \"home\" or an object {...}");
    return {};
  }
  ObjectReader reader(json, pointer, diagnostics);
  Goal goal;
  if (reader.has("home")) {
    if (!reader.boolean("home"))
      reader.diagnostics().error(Code::kInvalidValue, reader.at("home"), "a goal that is not home",
                                 "Set it to true, or give another goal");
    goal.absolute = reader.boolean("absolute", false);
  } else if (reader.has("joints_deg")) {
    goal.value = read_joints(reader, arm);
    goal.absolute = reader.boolean("absolute", false);
  } else if (reader.has("by_m") || reader.has("by_rpy_deg")) {
    goal.value = read_step(reader);
  } else {
    Goal::Pose pose;
    pose.in = reader.text("in");
    pose.keep_orientation = !reader.has("rpy_deg") && !reader.has("quaternion");
    pose.X.translation() = reader.vector("position_m");
    pose.X.linear() = reader.rotation().toRotationMatrix();
    goal.value = pose;
  }
  reader.finish();
  return goal;
}

bool depends_on_moving_frame(const Goal& goal, const expression::Cell& cell, const std::string& arm) {
  const auto* pose = std::get_if<Goal::Pose>(&goal.value);
  const auto* step = std::get_if<Goal::Step>(&goal.value);
  return (pose != nullptr && expression::moves(cell.frames, pose->in, arm)) ||
         (step != nullptr && expression::moves(cell.frames, step->in, arm));
}

Result<ResolvedGoal> resolve(const Goal& goal, const expression::Cell& cell, const std::string& name,
                             const kinematics::JointVector& q) {
  const expression::MountedArm& arm = cell.arms.find(name)->second;
  const device::ArmDescription& model = arm.device->description();
  const auto turned = [&](const kinematics::JointVector& to) {
    return goal.absolute ? to : kinematics::in_nearest_turns(*model.chain, to, q);
  };
  if (std::holds_alternative<Goal::Home>(goal.value)) return turned(model.home);
  if (const auto* joints = std::get_if<Goal::Joints>(&goal.value)) return turned(joints->q);
  if (const auto* one = std::get_if<Goal::OneJoint>(&goal.value)) {
    kinematics::JointVector q_goal = q;
    q_goal[one->joint] = one->by ? q[one->joint] + one->q : one->q;
    return one->by ? q_goal : turned(q_goal);
  }
  const Eigen::Isometry3d X_BT = tool_pose(arm, q);
  if (const auto* pose = std::get_if<Goal::Pose>(&goal.value)) {
    const auto X_BI = cell.frames.pose(pose->in, name);
    if (!X_BI) return std::unexpected(X_BI.error());
    Eigen::Isometry3d X_goal = *X_BI * pose->X;
    if (pose->keep_orientation) X_goal.linear() = X_BT.linear();
    return X_goal;
  }
  const auto& step = std::get<Goal::Step>(goal.value);
  Eigen::Matrix3d R_BI = X_BT.linear();
  if (step.in != "tcp") {
    const auto X_BI = cell.frames.pose(step.in, name);
    if (!X_BI) return std::unexpected(X_BI.error());
    R_BI = X_BI->linear();
  }
  Eigen::Isometry3d X_goal = X_BT;
  X_goal.translation() += R_BI * step.translation;
  X_goal.linear() = X_BT.linear() * step.rotation.toRotationMatrix();
  return X_goal;
}

}  // namespace takt::operations
