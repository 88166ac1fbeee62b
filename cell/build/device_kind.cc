#include "cell/build/device_kind.h"

#include <fmt/format.h>

#include "sim/model/from_model.h"

namespace takt::cell {

void DeviceKind::declare(const DeviceEntry&, const device::ModelDescription*, expression::Cell&) const {}

void DeviceKind::check(const LoadedDevice& device, Diagnostics& diagnostics) const {
  if (!device.entry->start_rad.empty())
    diagnostics.error(Code::kInvalidValue, device.pointer() + "/start_deg", "this device has no joints");
  if (!device.entry->settings.empty()) {
    diagnostics.error(Code::kInvalidValue, device.pointer() + "/settings",
                      fmt::format("a device of kind '{}' has no settings", name_));
  }
}

sim::RobotDescription DeviceKind::body(const LoadedDevice& device, sim::Mount mount) const {
  return sim::plain_body(device.entry->name, device.model->robot, std::move(mount));
}

void DeviceKind::simulate(const LoadedDevice&, sim::WorldDescription&) const {}

void DeviceKind::add(const LoadedDevice&, LoadedDevices, BuiltCell&) const {}

}  // namespace takt::cell
