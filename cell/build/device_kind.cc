#include "cell/build/device_kind.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/model/from_model.h"

namespace takt::cell {

void DeviceKind::declare(const DeviceEntry&, const device::ModelDescription*, expression::Cell&) const {}

void DeviceKind::check(const LoadedDevice& device, Diagnostics& diagnostics) const {
  if (!device.entry->start_rad.empty()) {
    std::vector<std::string> keys;
    for (const Key& key : settings_.keys) keys.push_back(fmt::format("\"{}\"", key.name));
    diagnostics.error(Code::kInvalidValue, device.pointer() + "/start_deg", "this device has no joints",
                      keys.empty() ? "Remove it" : fmt::format("Give {} in \"settings\"", fmt::join(keys, ", ")));
  }
  if (settings_.keys.empty() && !settings_.others && !device.entry->settings.empty()) {
    diagnostics.error(Code::kInvalidValue, device.pointer() + "/settings",
                      fmt::format("a device of kind '{}' has no settings", name_), "Remove them");
  }
}

sim::RobotDescription DeviceKind::body(const LoadedDevice& device, sim::Mount mount) const {
  return sim::plain_body(device.entry->name, device.model->robot, std::move(mount));
}

void DeviceKind::simulate(const LoadedDevice&, sim::WorldDescription&) const {}

void DeviceKind::add(const LoadedDevice&, LoadedDevices, BuiltCell&) const {}

}  // namespace takt::cell
