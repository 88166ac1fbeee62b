// Kind "gripper": a tool that is driven.
#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/build/faulty_machines.h"
#include "cell/build/site_devices.h"
#include "core/device/device_file.h"
#include "core/device/gripper.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::GripperDescription;

/// How far apart the fingers stand at the start, m: what the scenario says, else open.
double start_width(const LoadedDevice& device, Diagnostics& diagnostics) {
  const double stroke = device.as<GripperDescription>()->stroke;
  SettingsReader from(device, diagnostics);
  return from.number_up_to("start_width_m", stroke, stroke);
}

class GripperKind final : public DeviceKind {
 public:
  GripperKind()
      : DeviceKind("gripper",
                   {.doc = "A tool that is driven.",
                    .keys = {number_key("start_width_m", "m", kNotNegative,
                                        "Distance between the fingers at the start, at most the stroke of the model.")
                                 .optional("open")}}) {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_gripper(folder); }
  bool needs_arm() const override { return true; }
  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const GripperDescription&>(model).X_MT;
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.grippers[entry.name];
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)start_width(device, diagnostics);
  }

  sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const override {
    Diagnostics ignored;  // checked before
    return sim::gripper_body(device.entry->name, *device.as<GripperDescription>(), std::move(mount),
                             start_width(device, ignored));
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    world.grippers.push_back(sim::simulated_gripper(name, name, *device.as<GripperDescription>()));
    world.grippers.back().pointer = device.pointer();
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const std::string& name = device.entry->name;
    const LoadedDevice* arm = carrying_arm(device);  // null: it lies in a dock
    auto wired = built.site->wire(device, built.borrowed<device::GripperBackend>(built.world->gripper(name)));
    if (device.entry->may_fail) wired.backend = built.with_faults<FaultyGripper>(name, std::move(wired.backend));
    auto backend = built.commands->tap(name, std::move(wired.backend));
    auto& gripper =
        built.core->add(std::make_unique<device::Gripper>(name, std::move(wired.description), std::move(backend)));
    built.cell.grippers[name] = {&gripper, arm ? arm->entry->name : std::string()};
  }
};

}  // namespace

std::unique_ptr<DeviceKind> gripper_kind() { return std::make_unique<GripperKind>(); }

}  // namespace takt::cell
