#include "core/operations/grip_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/operations/goal.h"

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
                Diagnostics& diagnostics) {
  const auto X_WB = cell.frames.pose(arm);
  if (!X_WB || part.object.empty()) return;
  diagnostics.append(cell.frames.set(part.object, std::string(world::FrameGraph::kWorld),
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
void leave_former(const GripRequest& request, const kinematics::JointVector& q, Context& context,
                  Diagnostics& diagnostics) {
  const auto carried = context.variables.carried.find(request.gripper);
  if (carried == context.variables.carried.end()) return;
  const std::string& arm = context.cell.grippers.find(request.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  leave_part(context.cell, arm, q, carried->second, diagnostics);
  if (carried->second.told && !device.held()) device.set_tool(carried->second.before);
  context.variables.carried.erase(carried);
}

void take(const GripRequest& request, const kinematics::JointVector& q, Context& context) {
  const std::string& arm = context.cell.grippers.find(request.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  CarriedPart part{.object = request.part.value_or(""), .before = device.tool()};
  if (request.part) part.X_TO = part_in_tool(context.cell, arm, q, *request.part);
  // The payload of an arm changes between nets only; one that moves while it grips keeps what it believes.
  part.told = request.mass > 0.0 && !device.held();
  if (part.told) tell_payload(device, part, request.mass);
  context.variables.carried[request.gripper] = part;
}

/// What grip and release have in common.
ParameterTable<GripRequest> common_parameters() {
  ParameterTable<GripRequest> table;
  table.name("gripper", NameOf::kGripper, &GripRequest::gripper, "Gripper that moves.")
      .number("width_m", "m", &GripRequest::width, kNotNegative, "Width to move to: 0 to close, the stroke to open.")
      .number("speed_m_s", "m/s", &GripRequest::speed, kPositive, "Speed of the fingers: a quarter of the fastest.")
      .number("force_N", "N", &GripRequest::force, kPositive, "Gripping force: half of the largest.");
  return table;
}

}  // namespace

command::GripCommand command_of(const GripRequest& request, const device::GripperDescription& gripper) {
  return {.gripper = request.gripper,
          .width = request.width.value_or(request.opens ? gripper.stroke : 0.0),
          .speed = request.speed.value_or(0.25 * gripper.speed_max),
          .force = request.force.value_or(0.5 * gripper.force_max)};
}

bool check_figures(const GripRequest& request, const device::GripperDescription& gripper, const std::string& pointer,
                   Diagnostics& diagnostics) {
  const command::GripCommand command = command_of(request, gripper);
  bool right = true;
  const auto check = [&](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    diagnostics.error(Code::kOutOfRange, pointer + key, fmt::format("{:g} is not for '{}'", value, command.gripper),
                      fmt::format("{:g} to {:g}", low, high));
    right = false;
  };
  check("/width_m", command.width, 0.0, gripper.stroke);
  check("/speed_m_s", command.speed, gripper.speed_min, gripper.speed_max);
  check("/force_N", command.force, gripper.force_min, gripper.force_max);
  return right;
}

Progress note_grip(const GripRequest& request, const GripOutcome& outcome, Context& context, Diagnostics& diagnostics) {
  const auto& [holding, width, q] = outcome;
  if (!holding || !width) {
    diagnostics.error(Code::kSensorSilent, {}, fmt::format("'{}' did not answer", request.gripper),
                      "check its power and its wiring");
    return Progress::kFailed;
  }
  context.event(request.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
  if (request.expect == GripRequest::Expect::kPart && !*holding) {
    diagnostics.error(Code::kConditionNotMet, {},
                      fmt::format("no part was found; the fingers stand {:.1f} mm apart", 1e3 * *width),
                      "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  if (request.expect == GripRequest::Expect::kNothing && *holding) {
    diagnostics.error(Code::kConditionNotMet, {},
                      fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                      "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  leave_former(request, q, context, diagnostics);
  if (*holding && !request.opens) take(request, q, context);
  return Progress::kDone;
}

void rehearse_grip(const GripRequest& request, Rehearsal& rehearsal, Diagnostics& diagnostics) {
  const command::MountedGripper& mounted = rehearsal.cell.grippers.find(request.gripper)->second;
  const device::GripperDescription& gripper = mounted.device->description();
  rehearsal.duration += gripper.stroke / command_of(request, gripper).speed;
  const kinematics::JointVector& q = rehearsal.q[mounted.arm];
  if (const auto carried = rehearsal.carried.find(request.gripper); carried != rehearsal.carried.end()) {
    leave_part(rehearsal.cell, mounted.arm, q, carried->second, diagnostics);
    rehearsal.carried.erase(carried);
  }
  if (request.opens || !request.part) return;
  rehearsal.carried[request.gripper] = {.object = *request.part,
                                        .X_TO = part_in_tool(rehearsal.cell, mounted.arm, q, *request.part)};
}

const ParameterTable<GripRequest>& grip_parameters() {
  using Expect = GripRequest::Expect;
  static const auto table = [] {
    const std::vector<std::pair<std::string, Expect>> words{
        {"part", Expect::kPart}, {"nothing", Expect::kNothing}, {"any", Expect::kAny}};
    return common_parameters()
        .choice("expect", &GripRequest::expect, words, "What has to be between the fingers at the end.")
        .name("part", NameOf::kObject, &GripRequest::part, "Object that is gripped.")
        .number("part_mass_kg", "kg", &GripRequest::mass, kNotNegative, "Mass that the arm is to expect.");
  }();
  return table;
}

const ParameterTable<GripRequest>& release_parameters() {
  static const auto table = common_parameters();
  return table;
}

GripRequest read_grip(ObjectReader& reader, const command::Cell& cell) { return grip_parameters().read(reader, cell); }

GripRequest read_release(ObjectReader& reader, const command::Cell& cell) {
  GripRequest request = release_parameters().read(reader, cell);
  request.opens = true;
  request.expect = GripRequest::Expect::kAny;
  return request;
}

}  // namespace takt::activity
