#include "cell/build/cell_frames.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "cell/build/arm_kind.h"
#include "cell/build/cell_models.h"
#include "core/device/base_description.h"
#include "core/device/conveyor.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/link_path.h"

namespace takt::cell {
namespace {

using Eigen::Isometry3d;
using world::Relation;

Relation fixed_in(const std::string& parent, const Isometry3d& X_PF) { return {.parent = parent, .X_PF = X_PF}; }

Relation on_flange(const std::string& arm, const Isometry3d& X_FM) {
  return {.kind = Relation::Kind::kFlange, .parent = arm, .X_PF = X_FM, .source = arm};
}

Relation on_link(const std::string& arm, const std::string& link) {
  return {.kind = Relation::Kind::kLink, .parent = arm, .source = arm, .link = link};
}

/// The flange of an arm, or the body of a base, in its base frame at the start.
Isometry3d start_of_flange(const LoadedDevice& arm) {
  return arm.as<device::ArmDescription>()->chain->forward(start_of(arm));
}

}  // namespace

std::map<std::string, Isometry3d, std::less<>> tcps_of(const LoadedDevice& device) {
  std::map<std::string, Isometry3d, std::less<>> tcps = device.entry->tcps;
  if (const auto own = device.kind->tcp(*device.model))
    tcps.try_emplace(std::string(expression::MountedTool::kOwnTcp), *own);
  return tcps;
}

CellFrames::CellFrames(const Description& description, LoadedDevices devices, Diagnostics& diagnostics) {
  want_devices(description, devices);
  for (const FrameEntry& frame : description.frames)
    want("/frames" + pointer_segment(frame.name), frame.name, frame.at, frame.at.X);
  want_objects(description);
  place_all(diagnostics);
}

void CellFrames::want_devices(const Description& description, LoadedDevices devices) {
  for (const auto& device : devices) {
    if (device->as<device::BaseDescription>()) bases_[device->entry->name] = start_of_flange(*device);
  }
  for (const DeviceEntry& device : description.devices) {
    if (device.at) want("/devices" + pointer_segment(device.name) + "/at", device.name, *device.at, device.at->X);
  }
  for (const auto& device : devices) {
    if (device->on) want_mounted(*device);
    if (device->as<device::ArmDescription>()) want_arm(*device);
    if (device->as<device::ConveyorDescription>()) want_belt(*device);
  }
}

void CellFrames::want_arm(const LoadedDevice& arm) {
  const std::string& name = arm.entry->name;
  wanted_.push_back({arm.pointer(), expression::flange_frame(name), "", on_flange(name, Isometry3d::Identity()),
                     fixed_in(name, start_of_flange(arm))});
  const auto description = arm.as<device::ArmDescription>();
  for (const std::string& link : description->links->names()) {
    if (link == description->flange_link || expression::link_frame(name, link) == expression::flange_frame(name))
      continue;
    wanted_.push_back({arm.pointer(), expression::link_frame(name, link), "", on_link(name, link),
                       fixed_in(name, description->links->find(link)->pose(start_of(arm)))});
  }
}

/// It goes with the belt, where its encoder says; at the start it is where the belt begins.
void CellFrames::want_belt(const LoadedDevice& conveyor) {
  namespace terminal = device::conveyor_terminal;
  const std::string& name = conveyor.entry->name;
  Relation moving{.kind = Relation::Kind::kChannel, .parent = name, .source = name + "/" + terminal::kPose};
  moving.X_seen = conveyor.as<device::ConveyorDescription>()->X_MB;
  wanted_.push_back({conveyor.pointer(), name + "/" + terminal::kBelt, "", moving, fixed_in(name, *moving.X_seen)});
}

/// What is mounted rides on the flange of the arm that carries it: an arm with its base, a tool with its mount frame
/// and its tool centre points. What is mounted on a tool side goes with that one, wherever it is.
void CellFrames::want_mounted(const LoadedDevice& device) {
  const LoadedDevice* carrier = carrying_arm(device);
  const std::string& name = device.entry->name;
  if (const LoadedDevice* side = tool_side_under(device)) {
    const std::string& below = side->entry->name;
    wanted_.push_back({device.pointer(), name, "/on", fixed_in(below, pose_on_side(device)),
                       fixed_in(below, pose_on_side(device, MountAs::kTrue))});
  } else if (carrier) {
    const std::string& arm = carrier->entry->name;
    wanted_.push_back({device.pointer(), name, "/on", on_flange(arm, pose_on_arm(device)),
                       fixed_in(expression::flange_frame(arm), pose_on_arm(device, MountAs::kTrue))});
  } else {
    return;
  }
  for (const auto& [tcp, X_MT] : tcps_of(device)) {
    const Relation relation = fixed_in(name, X_MT);
    wanted_.push_back({device.pointer(), name + "/" + tcp, "", relation, relation});
  }
}

void CellFrames::want_objects(const Description& description) {
  for (const ObjectEntry& object : description.objects) {
    const std::string pointer = "/objects" + pointer_segment(object.name);
    want(pointer + "/at", object.name, object.at, drawn_pose(object, description.seed));
    for (const auto& [grasp, X_OG] : object.grasps) {
      const Relation relation = fixed_in(object.name, X_OG);
      wanted_.push_back({pointer + "/grasps", object.name + "/" + grasp, "", relation, relation});
    }
  }
}

/// What is placed on a base rides on its body.
void CellFrames::want(std::string pointer, const std::string& name, const Placement& at, const Isometry3d& drawn) {
  const auto base = bases_.find(at.in);
  const bool rides = base != bases_.end();
  const std::string parent = standing_frame(at.in);
  const Isometry3d X_FB = rides ? base->second.inverse() : Isometry3d::Identity();
  wanted_.push_back({std::move(pointer), name, "/in", fixed_in(parent, X_FB * at.X), fixed_in(parent, X_FB * drawn)});
}

std::string CellFrames::standing_frame(const std::string& name) const {
  return bases_.contains(name) ? expression::flange_frame(name) : name;
}

void CellFrames::place_all(Diagnostics& diagnostics) {
  for (bool progress = true; progress;) {
    progress = false;
    for (Wanted& one : wanted_) {
      if (one.placed || !believed.contains(one.believed.parent) || !truth.contains(one.truth.parent)) continue;
      diagnostics.append(believed.set(one.name, one.believed), one.pointer);
      (void)truth.set(one.name, one.truth);
      one.placed = progress = true;
    }
  }
  report_unplaced(diagnostics);
}

/// What depends on something unknown is a consequence; only where nothing is unknown do frames depend on each other in
/// a circle.
void CellFrames::report_unplaced(Diagnostics& diagnostics) const {
  std::vector<std::string> names{"world"};
  for (const Wanted& one : wanted_) names.push_back(one.name);
  const auto unknown = [&](const Wanted& one) { return std::ranges::find(names, one.believed.parent) == names.end(); };
  const bool circle = std::ranges::none_of(wanted_, unknown);
  for (const Wanted& one : wanted_) {
    if (one.placed || !(circle || unknown(one))) continue;
    const std::string& parent = one.believed.parent;
    diagnostics.error(Code::kInvalidValue, one.pointer + one.in_pointer,
                      circle ? fmt::format("the frame of '{}' has no known pose", parent)
                             : fmt::format("there is no frame '{}'", parent),
                      circle ? "Use frames that end at 'world'" : nearest_choice(parent, names));
  }
}

}  // namespace takt::cell
