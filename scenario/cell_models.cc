#include "scenario/cell_models.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::scenario {
namespace {

template <class Model>
bool take(Result<Model> read, const std::string& pointer, Findings& findings, DeviceModel& model) {
  if (!read) {
    findings.append(read.error(), read.error().list().front().file.empty() ? pointer : "");
    return false;
  }
  model = std::move(*read);
  return true;
}

bool load_model(const DeviceEntry& entry, const device::ModelLibrary& models, Findings& findings, DeviceModel& model) {
  const std::string pointer = "/devices" + pointer_segment(entry.name) + "/model";
  const auto folder = models.find(entry.model, pointer);
  if (!folder) {
    findings.append(folder.error());
    return false;
  }
  const auto kind = device::read_device_kind(*folder);
  if (!kind) {
    findings.append(kind.error());
    return false;
  }
  if (*kind == "arm") return take(device::read_arm(*folder), pointer, findings, model);
  if (*kind == "force_torque_sensor") return take(device::read_force_torque_sensor(*folder), pointer, findings, model);
  if (*kind == "tool") return take(device::read_tool(*folder), pointer, findings, model);
  findings.error(pointer, fmt::format("model '{}' is of kind '{}', which is no device of a cell", entry.model, *kind),
                 "arm, force_torque_sensor, tool");
  return false;
}

}  // namespace

std::vector<std::unique_ptr<LoadedDevice>> load_devices(const Description& description,
                                                        const device::ModelLibrary& models, Findings& findings) {
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
      auto device = std::make_unique<LoadedDevice>(LoadedDevice{entry, {}, on});
      if (load_model(*entry, models, findings, device->model)) {
        if (on && std::holds_alternative<ToolModel>(on->model)) {
          findings.error("/devices" + pointer_segment(entry->name) + "/on",
                         fmt::format("'{}' is a tool and carries nothing", entry->on), "an arm or a sensor");
        }
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
    if (exists && !findings.has_errors()) {
      findings.error("/devices" + pointer_segment(entry->name) + "/on", "devices hang on each other in a circle");
    } else if (!exists) {
      findings.error("/devices" + pointer_segment(entry->name) + "/on",
                     fmt::format("there is no device '{}'", entry->on), nearest_choice(entry->on, names));
    }
  }
  return loaded;
}

const LoadedDevice* carrying_arm(const LoadedDevice& device) {
  const LoadedDevice* carrier = device.on;
  while (carrier && !std::holds_alternative<ArmModel>(carrier->model)) carrier = carrier->on;
  return carrier;
}

Eigen::Isometry3d flange_of(const LoadedDevice& device) {
  if (const auto* sensor = std::get_if<SensorModel>(&device.model)) return (*sensor)->X_MT;
  return Eigen::Isometry3d::Identity();
}

std::shared_ptr<const kinematics::RobotModel> robot_of(const DeviceModel& model) {
  return std::visit([](const auto& description) { return description->robot; }, model);
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

}  // namespace takt::scenario
