// Kind "conveyor": a belt with a drive and an encoder. Its terminals are canonical signals of their own, "DEVICE/run",
// and its belt a frame that a channel moves.
#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "core/device/conveyor.h"
#include "core/device/signal.h"
#include "sim/machines/conveyor.h"

namespace takt::cell {
namespace {

namespace terminal = device::conveyor_terminal;
using device::ConveyorDescription;

std::string at_conveyor(const std::string& name, const char* what) { return name + "/" + what; }

class ConveyorKind final : public DeviceKind {
 public:
  ConveyorKind() : DeviceKind("conveyor") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_conveyor(folder);
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.digital_outputs[at_conveyor(entry.name, terminal::kRun)];
    cell.analog_outputs[at_conveyor(entry.name, terminal::kSpeed)];
    cell.digital_inputs[at_conveyor(entry.name, terminal::kRunning)];
    cell.analog_inputs[at_conveyor(entry.name, terminal::kPosition)];
    cell.channels[at_conveyor(entry.name, terminal::kPose)];
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    if (!device.entry->start_rad.empty())
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/start_deg", "this device has no joints",
                        "Remove start_deg");
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto conveyor = device.as<ConveyorDescription>();
    const std::string& name = device.entry->name;
    world.devices.push_back({.name = name,
                             .pointer = device.pointer(),
                             .extend = {},
                             .make = [conveyor, name](const mjModel_& model, const sim::WorldDescription& whole) {
                               return sim::SimConveyor::make(model, name, *conveyor, whole.seed);
                             }});
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const auto conveyor = device.as<ConveyorDescription>();
    const std::string& name = device.entry->name;
    auto* machine = dynamic_cast<sim::SimConveyor*>(built.world->device(name));
    // An emergency stop stops the belt.
    built.cell.digital_outputs[at_conveyor(name, terminal::kRun)] =
        &output<bool>(at_conveyor(name, terminal::kRun), {.stop = false}, machine->run, built);
    built.cell.analog_outputs[at_conveyor(name, terminal::kSpeed)] = &output<double>(
        at_conveyor(name, terminal::kSpeed),
        {.unit = "m/s", .initial = conveyor->speed, .lower = -conveyor->speed_max, .upper = conveyor->speed_max},
        machine->speed, built);
    built.cell.digital_inputs[at_conveyor(name, terminal::kRunning)] =
        &input<bool>(at_conveyor(name, terminal::kRunning), "", *conveyor, machine->running, built);
    built.cell.analog_inputs[at_conveyor(name, terminal::kPosition)] =
        &input<double>(at_conveyor(name, terminal::kPosition), "m", *conveyor, machine->position, built);
    add_pose(name, *conveyor, *machine, built);
  }

 private:
  template <class T>
  static device::SignalOutput<T>& output(const std::string& name, device::SignalOutputDescription<T> description,
                                         sim::SimOutput& wire, BuiltCell& built) {
    return built.core->add(std::make_unique<device::SignalOutput<T>>(
        name, std::move(description), built.commands->tap(name, built.borrowed<device::SignalOutputBackend<T>>(&wire)),
        built.core->period()));
  }
  template <class T>
  static device::SignalInput<T>& input(const std::string& name, const char* unit, const ConveyorDescription& conveyor,
                                       sim::SimGauge& gauge, BuiltCell& built) {
    device::SignalInputDescription<T> description{.unit = unit, .sample_age_max = conveyor.sample_age_max};
    return built.core->add(std::make_unique<device::SignalInput<T>>(
        name, std::move(description), built.borrowed<device::SignalInputBackend<T>>(&gauge)));
  }
  static void add_pose(const std::string& name, const ConveyorDescription& conveyor, sim::SimConveyor& machine,
                       BuiltCell& built) {
    device::ChannelDescription pose{.name = at_conveyor(name, terminal::kPose),
                                    .type = net::ValueType::kFrame,
                                    .initial = net::Frame(conveyor.X_MB),
                                    .timeout = conveyor.sample_age_max};
    const auto declared = built.core->declare(pose);
    if (!declared) return;  // no name that a file can give is refused
    machine.publish(*declared);
    built.cell.channels[pose.name] = *declared;
  }
};

}  // namespace

std::unique_ptr<DeviceKind> conveyor_kind() { return std::make_unique<ConveyorKind>(); }

}  // namespace takt::cell
