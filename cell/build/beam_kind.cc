// Kinds "light_barrier" and "range_finder": a digital and an analog input with a beam in the simulation.
#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/device_kinds.h"
#include "cell/build/signal_devices.h"
#include "core/device/device_file.h"
#include "core/device/signal.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::BeamDescription;

class LightBarrierKind final : public DeviceKind {
 public:
  LightBarrierKind()
      : DeviceKind("light_barrier", {.doc = "A digital input with a beam.",
                                     .keys = {number_key("distance_m", "m", kPositive,
                                                         "Distance of the reflector, at most the range of the model.")
                                                  .optional("the range of the model")}}) {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_light_barrier(folder);
  }
  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.digital_inputs[entry.name];
  }
  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)distance_of(device, diagnostics);
  }
  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    Diagnostics ignored;  // checked before
    world.beams.push_back(sim::simulated_beam(name, name, *device.as<BeamDescription>()));
    world.beams.back().pointer = device.pointer();
    world.beams.back().range_max = distance_of(device, ignored);
  }
  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const std::string& name = device.entry->name;
    const auto age_max = device.as<BeamDescription>()->sample_age_max;
    built.cell.digital_inputs[name] = &add_input<bool>(name, "", age_max, device.entry->may_fail, built);
  }

 private:
  /// To the reflector, m.
  static double distance_of(const LoadedDevice& device, Diagnostics& diagnostics) {
    const double range = device.as<BeamDescription>()->range_max;
    SettingsReader from(device, diagnostics);
    return from.number_up_to("distance_m", range, range);
  }
};

class RangeFinderKind final : public DeviceKind {
 public:
  RangeFinderKind() : DeviceKind("range_finder") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_range_finder(folder);
  }
  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.analog_inputs[entry.name];
  }
  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    world.beams.push_back(sim::simulated_beam(name, name, *device.as<BeamDescription>()));
    world.beams.back().pointer = device.pointer();
  }
  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const std::string& name = device.entry->name;
    const auto age_max = device.as<BeamDescription>()->sample_age_max;
    built.cell.analog_inputs[name] = &add_input<double>(name, "m", age_max, device.entry->may_fail, built);
  }
};

}  // namespace

std::unique_ptr<DeviceKind> light_barrier_kind() { return std::make_unique<LightBarrierKind>(); }
std::unique_ptr<DeviceKind> range_finder_kind() { return std::make_unique<RangeFinderKind>(); }

}  // namespace takt::cell
