// Kind "force_torque_sensor".
#include "cell/build/built_cell.h"
#include "cell/build/cell_frames.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/build/faulty_readings.h"
#include "cell/build/site_devices.h"
#include "core/device/device_file.h"
#include "core/device/force_torque_sensor.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::ForceTorqueDescription;

/// All that hangs on the measuring side of a sensor, in its measuring frame.
device::PayloadSetting measured_mass(const LoadedDevice& sensor, LoadedDevices all) {
  const auto model = sensor.as<ForceTorqueDescription>();
  device::PayloadSetting sum = mass_below(*model->robot, model->measuring_link);
  for (const auto& device : all) {
    if (device->on != &sensor) continue;
    const Eigen::Isometry3d X_SM = model->X_MS.inverse() * model->X_MT * device->entry->mount;
    sum = device::combine(sum, device::transform(X_SM, device::rigid_payload(*device->model->robot)));
  }
  return sum;
}

/// What may hold parts on its measuring side, directly or through others: grippers and other tools.
std::vector<std::string> grippers_on(const LoadedDevice& sensor, LoadedDevices all) {
  std::vector<std::string> names;
  for (const auto& device : all) {
    if (tool_side_under(*device)) continue;  // what a changer couples comes and goes (Cell::changers)
    const LoadedDevice* carrier = device->on;
    while (carrier != nullptr && carrier != &sensor) carrier = carrier->on;
    if (carrier == &sensor && !tcps_of(*device).empty()) names.push_back(device->entry->name);
  }
  return names;
}

class ForceTorqueKind final : public DeviceKind {
 public:
  ForceTorqueKind() : DeviceKind("force_torque_sensor") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_force_torque_sensor(folder);
  }
  bool needs_arm() const override { return true; }
  bool has_backend() const override { return true; }

  std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override {
    const auto& sensor = dynamic_cast<const ForceTorqueDescription&>(model);
    return MountPlace{sensor.measuring_link, sensor.X_MS.inverse() * sensor.X_MT, sensor.X_MT};
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.sensors[entry.name];
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    world.force_torque_sensors.push_back(sim::simulated_force_torque(name, name, *device.as<ForceTorqueDescription>()));
    world.force_torque_sensors.back().pointer = device.pointer();
  }

  void add(const LoadedDevice& device, LoadedDevices all, BuiltCell& built) const override {
    const auto model = device.as<ForceTorqueDescription>();
    const std::string& name = device.entry->name;
    auto backend = built.borrowed<device::ForceTorqueBackend>(built.world->force_torque(name));
    if (device.entry->may_fail) backend = built.with_faults<FaultySensor>(name, std::move(backend));
    auto wired = built.site->wire(device, std::move(backend));
    auto& sensor = built.core->add(std::make_unique<device::ForceTorqueSensor>(
        name, wired.description, built.commands->samples().tap(name, std::move(wired.backend))));
    const LoadedDevice* arm = carrying_arm(device);
    const device::PayloadSetting tool = measured_mass(device, all);
    built.cell.sensors[name] = {&sensor,   arm ? arm->entry->name : "", pose_on_arm(device) * model->X_MS, tool.mass,
                                tool.p_FC, grippers_on(device, all)};
  }
};

}  // namespace

std::unique_ptr<DeviceKind> force_torque_kind() { return std::make_unique<ForceTorqueKind>(); }

}  // namespace takt::cell
