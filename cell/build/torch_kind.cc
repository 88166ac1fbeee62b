// Kind "torch": a tool that welds. Its terminals are canonical signals of their own, "DEVICE/arc".
#include <array>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/build/faulty_readings.h"
#include "core/device/device_file.h"
#include "core/device/link_pose.h"
#include "core/device/signal.h"
#include "core/device/torch.h"
#include "sim/machines/torch.h"

namespace takt::cell {
namespace {

namespace torch_terminal = device::torch_terminal;
using device::TorchDescription;

std::string at_torch(const std::string& name, const char* terminal) { return name + "/" + terminal; }

/// In the world a torch is one body, its first link: all others are fixed to it.
Result<std::unique_ptr<sim::SimDevice>> make_torch(const mjModel& model, const std::string& name,
                                                   const TorchDescription& torch) {
  for (const std::string& link : {torch.tcp_link, torch.mount_link, torch.robot->root().name}) {
    const int body = mj_name2id(&model, mjOBJ_BODY, (name + "/" + link).c_str());
    if (body < 0) continue;
    return std::make_unique<sim::SimTorch>(torch, model, body,
                                           device::pose_between(*torch.robot, link, torch.tcp_link));
  }
  return failure(Code::kUnknownName, "", fmt::format("no link '{}'", torch.tcp_link));
}

class TorchKind final : public DeviceKind {
 public:
  TorchKind() : DeviceKind("torch") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_torch(folder); }
  bool needs_arm() const override { return true; }
  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const TorchDescription&>(model).X_MT;
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    for (const char* output : {torch_terminal::kGas, torch_terminal::kArc, torch_terminal::kWire})
      cell.digital_outputs[at_torch(entry.name, output)];
    cell.digital_inputs[at_torch(entry.name, torch_terminal::kEstablished)];
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto torch = device.as<TorchDescription>();
    const std::string& name = device.entry->name;
    world.devices.push_back({.name = name,
                             .pointer = device.pointer(),
                             .extend = {},
                             .make = [torch, name](const mjModel_& model, const sim::WorldDescription&) {
                               return make_torch(model, name, *torch);
                             }});
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const auto torch = device.as<TorchDescription>();
    const std::string& name = device.entry->name;
    auto* machine = dynamic_cast<sim::SimTorch*>(built.world->device(name));
    for (const auto& [terminal, wire] : {std::pair(torch_terminal::kGas, &machine->gas),
                                         {torch_terminal::kArc, &machine->arc},
                                         {torch_terminal::kWire, &machine->wire}})
      add_output(at_torch(name, terminal), *wire, built);
    const std::string input = at_torch(name, torch_terminal::kEstablished);
    auto backend = built.borrowed<device::SignalInputBackend<bool>>(&machine->established);
    if (device.entry->may_fail) backend = built.with_faults<FaultyInput<bool>>(input, std::move(backend));
    device::SignalInputDescription<bool> description{.sample_age_max = torch->sample_age_max};
    built.cell.digital_inputs[input] = &built.core->add(std::make_unique<device::SignalInput<bool>>(
        input, std::move(description), built.commands->samples().tap<bool>(input, std::move(backend))));
  }

 private:
  /// Whatever stops, it goes off.
  static void add_output(const std::string& name, sim::SimOutput& wire, BuiltCell& built) {
    device::SignalOutputDescription<bool> description;
    description.initial = false;
    description.stop = false;
    built.cell.digital_outputs[name] = &built.core->add(std::make_unique<device::SignalOutput<bool>>(
        name, description, built.commands->tap(name, built.borrowed<device::SignalOutputBackend<bool>>(&wire)),
        built.core->period()));
  }
};

}  // namespace

std::unique_ptr<DeviceKind> torch_kind() { return std::make_unique<TorchKind>(); }

}  // namespace takt::cell
