#include "core/activity/grip_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/goal.h"
#include "core/base/read_parts.h"

namespace takt::activity {
namespace {

/// Pose of the part in the tool centre point, with the arm at q; identity if either has no place.
Eigen::Isometry3d part_in_tool(const command::Cell& cell, const std::string& arm, const kinematics::JointVector& q,
                               const std::string& part) {
  const auto X_BO = cell.frames.pose(part, arm);
  return X_BO ? tool_pose(cell.arms.find(arm)->second, q).inverse() * *X_BO : Eigen::Isometry3d::Identity();
}

/// Puts the frame of a carried part where the tool now is.
void leave_part(command::Cell& cell, const std::string& arm, const kinematics::JointVector& q, const CarriedPart& part,
                Findings& findings) {
  const auto X_WB = cell.frames.pose(arm);
  if (!X_WB || part.object.empty()) return;
  findings.append(cell.frames.set(part.object, std::string(world::FrameGraph::kWorld),
                                  *X_WB * tool_pose(cell.arms.find(arm)->second, q) * part.X_TO));
}

/// The arm's payload with the part, a point mass at the origin of its frame.
void tell_payload(device::Arm& arm, const CarriedPart& part, double mass) {
  device::ToolSetting tool = part.before;
  const device::PayloadSetting load{.mass = mass, .p_FC = (tool.X_FT * part.X_TO).translation()};
  tool.payload = device::combine(tool.payload, load);
  arm.set_tool(tool);
}

/// Whatever it carried before, it has let go.
void leave_former(const GripRequest& request, const kinematics::JointVector& q, Context& context, Findings& findings) {
  const auto carried = context.variables.carried.find(request.gripper);
  if (carried == context.variables.carried.end()) return;
  const std::string& arm = context.cell.grippers.find(request.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  leave_part(context.cell, arm, q, carried->second, findings);
  if (carried->second.told && !device.held()) device.set_tool(carried->second.before);
  context.variables.carried.erase(carried);
}

void take(const GripRequest& request, const kinematics::JointVector& q, Context& context) {
  const std::string& arm = context.cell.grippers.find(request.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  CarriedPart part{.object = request.part, .before = device.tool()};
  if (!request.part.empty()) part.X_TO = part_in_tool(context.cell, arm, q, request.part);
  // The payload of an arm changes between nets only; one that moves while it grips keeps what it believes.
  part.told = request.mass > 0.0 && !device.held();
  if (part.told) tell_payload(device, part, request.mass);
  context.variables.carried[request.gripper] = part;
}

GripRequest read_request(ObjectReader& reader, const command::Cell& cell) {
  GripRequest request;
  (void)reader.text("do");
  (void)read_name(reader, "");
  std::vector<std::string> names;
  for (const auto& [name, gripper] : cell.grippers) names.push_back(name);
  request.gripper = reader.choice("gripper", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  if (reader.has("width_m")) request.width = reader.number("width_m", {}, kNotNegative);
  if (reader.has("speed_m_s")) request.speed = reader.number("speed_m_s", {}, kPositive);
  if (reader.has("force_N")) request.force = reader.number("force_N", {}, kPositive);
  return request;
}

}  // namespace

command::GripCommand command_of(const GripRequest& request, const device::GripperDescription& gripper) {
  return {.gripper = request.gripper,
          .width = request.width.value_or(request.opens ? gripper.stroke : 0.0),
          .speed = request.speed.value_or(0.25 * gripper.speed_max),
          .force = request.force.value_or(0.5 * gripper.force_max)};
}

bool check_figures(const GripRequest& request, const device::GripperDescription& gripper, const std::string& pointer,
                   Findings& findings) {
  const command::GripCommand command = command_of(request, gripper);
  bool right = true;
  const auto check = [&](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    findings.error(pointer + key, fmt::format("{:g} is not for '{}'", value, command.gripper),
                   fmt::format("{:g} to {:g}", low, high));
    right = false;
  };
  check("/width_m", command.width, 0.0, gripper.stroke);
  check("/speed_m_s", command.speed, gripper.speed_min, gripper.speed_max);
  check("/force_N", command.force, gripper.force_min, gripper.force_max);
  return right;
}

Progress note_grip(const GripRequest& request, const GripOutcome& outcome, Context& context, Findings& findings) {
  const auto& [holding, width, q] = outcome;
  if (!holding || !width) {
    findings.error({}, fmt::format("'{}' did not answer", request.gripper), "its power and its wires");
    return Progress::kFailed;
  }
  context.event(request.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
  if (request.expect == GripRequest::Expect::kPart && !*holding) {
    findings.error({}, fmt::format("no part was found; the fingers stand {:.1f} mm apart", 1e3 * *width),
                   "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  if (request.expect == GripRequest::Expect::kNothing && *holding) {
    findings.error({}, fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                   "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  leave_former(request, q, context, findings);
  if (*holding && !request.opens) take(request, q, context);
  return Progress::kDone;
}

void rehearse_grip(const GripRequest& request, Rehearsal& rehearsal, Findings& findings) {
  const command::MountedGripper& mounted = rehearsal.cell.grippers.find(request.gripper)->second;
  const device::GripperDescription& gripper = mounted.device->description();
  rehearsal.duration += gripper.stroke / command_of(request, gripper).speed;
  const kinematics::JointVector& q = rehearsal.q[mounted.arm];
  if (const auto carried = rehearsal.carried.find(request.gripper); carried != rehearsal.carried.end()) {
    leave_part(rehearsal.cell, mounted.arm, q, carried->second, findings);
    rehearsal.carried.erase(carried);
  }
  if (request.opens || request.part.empty()) return;
  rehearsal.carried[request.gripper] = {.object = request.part,
                                        .X_TO = part_in_tool(rehearsal.cell, mounted.arm, q, request.part)};
}

GripRequest read_grip(ObjectReader& reader, const command::Cell& cell) {
  GripRequest request = read_request(reader, cell);
  const std::string expect = reader.choice("expect", {"part", "nothing", "any"}, "part");
  request.expect = expect == "part"      ? GripRequest::Expect::kPart
                   : expect == "nothing" ? GripRequest::Expect::kNothing
                                         : GripRequest::Expect::kAny;
  if (reader.has("part")) {
    std::vector<std::string> objects;
    for (const auto& [name, object] : cell.objects) objects.push_back(name);
    request.part = reader.choice("part", objects);
  }
  request.mass = reader.number("part_mass_kg", 0.0, kNotNegative);
  return request;
}

GripRequest read_release(ObjectReader& reader, const command::Cell& cell) {
  GripRequest request = read_request(reader, cell);
  request.opens = true;
  return request;
}

}  // namespace takt::activity
