#include "cell/build/cell_models.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "cell/build/device_kind_registry.h"
#include "core/device/tool_changer.h"

namespace takt::cell {
namespace {

bool load_model(const DeviceEntry& entry, const device::ModelLibrary& models, Diagnostics& diagnostics,
                LoadedDevice& device) {
  const std::string pointer = "/devices" + pointer_segment(entry.name) + "/model";
  const auto folder = models.find(entry.model, pointer);
  if (!folder) {
    diagnostics.append(folder.error());
    return false;
  }
  auto read = read_model(*folder, pointer);
  if (!read) {
    diagnostics.append(read.error());
    return false;
  }
  device.kind = read->kind;
  device.model = std::move(read->model);
  return true;
}

/// The one who carries it is no carrier.
void check_carrier(const LoadedDevice& device, Diagnostics& diagnostics) {
  if (!device.on || device.on->kind->mount_place(*device.on->model)) return;
  diagnostics.error(Code::kInvalidValue, device.pointer() + "/on",
                    fmt::format("'{}' is of kind '{}' and carries nothing", device.entry->on, device.on->kind->name()),
                    "Mount it on an arm or a sensor");
}

}  // namespace

std::vector<std::unique_ptr<LoadedDevice>> load_devices(const Description& description,
                                                        const device::ModelLibrary& models, Diagnostics& diagnostics) {
  std::vector<std::unique_ptr<LoadedDevice>> loaded;
  std::vector<const DeviceEntry*> waiting;
  for (const DeviceEntry& entry : description.devices) waiting.push_back(&entry);
  const auto find = [&](const std::string& name) {
    const auto found = std::ranges::find(loaded, name, [](const auto& device) { return device->entry->name; });
    return found == loaded.end() ? nullptr : found->get();
  };
  // Each pass takes those whose carrier is there; what remains hangs on nothing or in a circle.
  for (bool progress = true; progress;) {
    progress = false;
    for (auto& entry : waiting) {
      const LoadedDevice* on = entry ? find(entry->on) : nullptr;
      if (!entry || (!entry->on.empty() && !on)) continue;
      auto device = std::make_unique<LoadedDevice>(LoadedDevice{entry, nullptr, {}, on});
      if (load_model(*entry, models, diagnostics, *device)) {
        check_carrier(*device, diagnostics);
        loaded.push_back(std::move(device));
      }
      entry = nullptr;
      progress = true;
    }
  }
  std::vector<std::string> names;
  for (const DeviceEntry& entry : description.devices) names.push_back(entry.name);
  for (const DeviceEntry* entry : waiting) {
    if (!entry) continue;
    const bool exists = std::ranges::find(names, entry->on) != names.end();
    if (exists && !diagnostics.has_errors()) {
      diagnostics.error(Code::kInvalidValue, "/devices" + pointer_segment(entry->name) + "/on",
                        "devices are mounted on each other in a loop");
    } else if (!exists) {
      diagnostics.error(Code::kUnknownName, "/devices" + pointer_segment(entry->name) + "/on",
                        fmt::format("there is no device '{}'", entry->on), nearest_choice(entry->on, names));
    }
  }
  return loaded;
}

const LoadedDevice* carrying_arm(const LoadedDevice& device) {
  const LoadedDevice* carrier = device.on;
  while (carrier && !carrier->as<device::ArmDescription>()) carrier = carrier->on;
  return carrier;
}

const LoadedDevice* tool_side_under(const LoadedDevice& device) {
  const LoadedDevice* carrier = device.on;
  while (carrier && !carrier->as<device::ToolSideDescription>()) carrier = carrier->on;
  return carrier;
}

namespace {

/// Pose of a device's mount frame in the mount frame of the first device below it of one of these models.
template <class Model>
Eigen::Isometry3d pose_on(const LoadedDevice& device, MountAs as) {
  const auto mount = [as](const LoadedDevice& one) {
    return as == MountAs::kTrue ? one.entry->true_mount : one.entry->mount;
  };
  Eigen::Isometry3d X = mount(device);
  for (const LoadedDevice* carrier = device.on; carrier; carrier = carrier->on) {
    const auto place = carrier->kind->mount_place(*carrier->model);
    X = place.value_or(MountPlace{}).X_MP * X;
    if (carrier->as<Model>()) break;
    X = mount(*carrier) * X;
  }
  return X;
}

}  // namespace

Eigen::Isometry3d pose_on_arm(const LoadedDevice& device, MountAs as) {
  return pose_on<device::ArmDescription>(device, as);
}
Eigen::Isometry3d pose_on_side(const LoadedDevice& device, MountAs as) {
  return pose_on<device::ToolSideDescription>(device, as);
}

device::PayloadSetting mass_below(const kinematics::RobotModel& model, const std::string& link) {
  // Links come parents first, so one pass knows the pose of every link below.
  std::map<std::string, Eigen::Isometry3d> poses{{link, Eigen::Isometry3d::Identity()}};
  device::PayloadSetting sum;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const kinematics::Link& body = model.links[i];
    if (i > 0) {
      const kinematics::Joint& joint = model.joints[i - 1];
      const auto parent = poses.find(joint.parent);
      if (parent != poses.end()) poses[body.name] = parent->second * joint.X_PJ;
    }
    const auto pose = poses.find(body.name);
    if (pose == poses.end() || !body.inertial) continue;
    sum = device::combine(sum, {body.inertial->mass, pose->second * body.inertial->X_LC.translation()});
  }
  return sum;
}

}  // namespace takt::cell
