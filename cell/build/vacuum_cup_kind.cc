// Kind "vacuum_cup": a tool that holds by suction. Its terminals are canonical signals of their own, "DEVICE/suction".
#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "core/device/device_file.h"
#include "core/device/signal.h"
#include "core/device/vacuum_cup.h"
#include "sim/machines/vacuum_cup.h"

namespace takt::cell {
namespace {

namespace cup_terminal = device::cup_terminal;
using device::VacuumCupDescription;

std::string at_cup(const std::string& name, const char* terminal) { return name + "/" + terminal; }

class VacuumCupKind final : public DeviceKind {
 public:
  VacuumCupKind() : DeviceKind("vacuum_cup") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_vacuum_cup(folder);
  }
  bool needs_arm() const override { return true; }
  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const VacuumCupDescription&>(model).X_MT;
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.digital_outputs[at_cup(entry.name, cup_terminal::kSuction)];
    cell.digital_inputs[at_cup(entry.name, cup_terminal::kHolding)];
    cell.analog_inputs[at_cup(entry.name, cup_terminal::kVacuum)];
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto cup = device.as<VacuumCupDescription>();
    const std::string& name = device.entry->name;
    world.devices.push_back({.name = name,
                             .pointer = device.pointer(),
                             .extend = {},
                             .make = [cup, name](const mjModel_& model, const sim::WorldDescription&) {
                               return sim::SimVacuumCup::make(model, name, *cup);
                             }});
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const auto cup = device.as<VacuumCupDescription>();
    const std::string& name = device.entry->name;
    auto* machine = dynamic_cast<sim::SimVacuumCup*>(built.world->device(name));
    add_valve(at_cup(name, cup_terminal::kSuction), *machine, built);
    const auto input = [&]<class T>(T, const char* which, const char* unit, sim::SimGauge& gauge) {
      device::SignalInputDescription<T> description{.unit = unit, .sample_age_max = cup->sample_age_max};
      return &built.core->add(std::make_unique<device::SignalInput<T>>(
          at_cup(name, which), std::move(description),
          built.commands->samples().tap<T>(at_cup(name, which),
                                           built.borrowed<device::SignalInputBackend<T>>(&gauge))));
    };
    built.cell.digital_inputs[at_cup(name, cup_terminal::kHolding)] =
        input(bool{}, cup_terminal::kHolding, "", machine->holding);
    built.cell.analog_inputs[at_cup(name, cup_terminal::kVacuum)] =
        input(double{}, cup_terminal::kVacuum, "Pa", machine->vacuum);
  }

 private:
  /// What it was set to last it keeps, whatever stops: a part that hangs on it is not dropped.
  static void add_valve(const std::string& name, sim::SimVacuumCup& machine, BuiltCell& built) {
    device::SignalOutputDescription<bool> description;
    description.initial = false;
    built.cell.digital_outputs[name] = &built.core->add(std::make_unique<device::SignalOutput<bool>>(
        name, description,
        built.commands->tap(name, built.borrowed<device::SignalOutputBackend<bool>>(&machine.suction)),
        built.core->period()));
  }
};

}  // namespace

std::unique_ptr<DeviceKind> vacuum_cup_kind() { return std::make_unique<VacuumCupKind>(); }

}  // namespace takt::cell
