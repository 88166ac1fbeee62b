#include "core/activity/grip_step.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/goal.h"
#include "core/activity/net_run.h"
#include "core/base/object_reader.h"
#include "core/command/device_net.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// What a grip or release step says, in numbers. Absent figures are those of the gripper.
struct GripRequest {
  std::string gripper;
  bool opens = false;
  std::optional<double> width, speed, force;
  enum class Expect { kPart, kNothing, kAny } expect = Expect::kAny;
  std::string part;   ///< object that the arm now carries; empty: none that matters
  double mass = 0.0;  ///< kg of the part, told to the arm; 0: the arm is told nothing
};

command::GripCommand command_of(const GripRequest& request, const device::GripperDescription& gripper) {
  return {.gripper = request.gripper,
          .width = request.width.value_or(request.opens ? gripper.stroke : 0.0),
          .speed = request.speed.value_or(0.25 * gripper.speed_max),
          .force = request.force.value_or(0.5 * gripper.force_max)};
}

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

class GripRun final : public OneNetRun {
 public:
  explicit GripRun(const GripRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const auto& gripper = context.cell.grippers.find(request_.gripper)->second.device->description();
    return load(context, command::grip_net(command_of(request_, gripper), context.cell), findings);
  }

  Progress finish(Context& context, Findings& findings) override {
    const auto holding = value_of<net::Boolean>(command::grip_ports::kHolding);
    const auto width = value_of<net::Real>(command::grip_ports::kWidth);
    if (!holding || !width) {
      findings.error({}, fmt::format("'{}' did not answer", request_.gripper), "its power and its wires");
      return Progress::kFailed;
    }
    context.event(request_.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
    if (request_.expect == GripRequest::Expect::kPart && !*holding) {
      findings.error({}, fmt::format("no part was found; the fingers stand {:.1f} mm apart", 1e3 * *width),
                     "\"expect\": \"any\", where that is no fault");
      return Progress::kFailed;
    }
    if (request_.expect == GripRequest::Expect::kNothing && *holding) {
      findings.error({}, fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                     "\"expect\": \"any\", where that is no fault");
      return Progress::kFailed;
    }
    leave_former(context, findings);
    if (*holding && !request_.opens) take(context);
    return Progress::kDone;
  }

  /// Whatever it carried before, it has let go.
  void leave_former(Context& context, Findings& findings) {
    const auto carried = context.variables.carried.find(request_.gripper);
    if (carried == context.variables.carried.end()) return;
    const std::string& arm = context.cell.grippers.find(request_.gripper)->second.arm;
    device::Arm& device = *context.cell.arms.find(arm)->second.device;
    leave_part(context.cell, arm, device.set_point().q, carried->second, findings);
    if (carried->second.told && !device.held()) device.set_tool(carried->second.before);
    context.variables.carried.erase(carried);
  }

  void take(Context& context) {
    const std::string& arm = context.cell.grippers.find(request_.gripper)->second.arm;
    device::Arm& device = *context.cell.arms.find(arm)->second.device;
    CarriedPart part{.object = request_.part, .before = device.tool()};
    if (!request_.part.empty()) part.X_TO = part_in_tool(context.cell, arm, device.set_point().q, request_.part);
    // The payload of an arm changes between nets only; one that moves while it grips keeps what it believes.
    part.told = request_.mass > 0.0 && !device.held();
    if (part.told) tell_payload(device, part, request_.mass);
    context.variables.carried[request_.gripper] = part;
  }

  const GripRequest& request_;
};

class GripStep final : public Step {
 public:
  explicit GripStep(GripRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    const command::MountedGripper& mounted = rehearsal.cell.grippers.find(request_.gripper)->second;
    const device::GripperDescription& gripper = mounted.device->description();
    const command::GripCommand command = command_of(request_, gripper);
    if (!check_figures(command, gripper, pointer, findings)) return;
    rehearsal.duration += gripper.stroke / command.speed;
    rehearse_net(command::grip_net(command, rehearsal.cell), rehearsal, pointer, findings);
    const kinematics::JointVector& q = rehearsal.q[mounted.arm];
    if (const auto carried = rehearsal.carried.find(request_.gripper); carried != rehearsal.carried.end()) {
      leave_part(rehearsal.cell, mounted.arm, q, carried->second, findings);
      rehearsal.carried.erase(carried);
    }
    if (request_.opens || request_.part.empty()) return;
    rehearsal.carried[request_.gripper] = {.object = request_.part,
                                           .X_TO = part_in_tool(rehearsal.cell, mounted.arm, q, request_.part)};
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<GripRun>(request_); }

 private:
  static bool check_figures(const command::GripCommand& command, const device::GripperDescription& gripper,
                            const std::string& pointer, Findings& findings) {
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

  GripRequest request_;
};

GripRequest read_request(ObjectReader& reader, const command::Cell& cell) {
  GripRequest request;
  (void)reader.text("do");
  (void)reader.text("name", "");
  std::vector<std::string> names;
  for (const auto& [name, gripper] : cell.grippers) names.push_back(name);
  request.gripper = reader.choice("gripper", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  if (reader.has("width_m")) request.width = reader.number("width_m", {}, kNotNegative);
  if (reader.has("speed_m_s")) request.speed = reader.number("speed_m_s", {}, kPositive);
  if (reader.has("force_N")) request.force = reader.number("force_N", {}, kPositive);
  return request;
}

}  // namespace

std::unique_ptr<Step> parse_grip(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Findings& findings) {
  ObjectReader reader(json, pointer, findings);
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
  reader.finish();
  return std::make_unique<GripStep>(std::move(request));
}

std::unique_ptr<Step> parse_release(const Json& json, const std::string& pointer, const command::Cell& cell,
                                    Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  GripRequest request = read_request(reader, cell);
  request.opens = true;
  reader.finish();
  return std::make_unique<GripStep>(std::move(request));
}

}  // namespace takt::activity
