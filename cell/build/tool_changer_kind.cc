// Kinds "tool_changer" and "tool_side": the two halves of a tool changer. The terminals of the first are canonical
// signals of their own, "DEVICE/lock".
#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "core/device/signal.h"
#include "core/device/tool_changer.h"
#include "sim/machines/tool_changer.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::ToolChangerDescription;
using device::ToolSideDescription;
namespace terminal = device::changer_terminal;

constexpr double kMostToolSides = 255;  // that the coding of a plug tells apart, a byte
constexpr const char* kLockInputs[] = {terminal::kLocked, terminal::kUnlocked, terminal::kReadyToLock,
                                       terminal::kCoupled};

std::string terminal_name(const std::string& device, const char* which) { return device + "/" + which; }

/// The tool side that is mounted on a changer in the file; null: none is.
const LoadedDevice* side_on(const LoadedDevice& changer, LoadedDevices all) {
  for (const auto& device : all)
    if (device->on == &changer && device->as<ToolSideDescription>()) return device.get();
  return nullptr;
}

class ToolChangerKind final : public DeviceKind {
 public:
  ToolChangerKind() : DeviceKind("tool_changer") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_tool_changer(folder);
  }
  bool needs_arm() const override { return true; }
  std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override {
    const auto& changer = dynamic_cast<const ToolChangerDescription&>(model);
    return MountPlace{.link = changer.coupling_link, .X_LP = Eigen::Isometry3d::Identity(), .X_MP = changer.X_MC};
  }
  /// Where it couples: motions to a tool side name the changer as their tool.
  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const ToolChangerDescription&>(model).X_MC;
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.changers[entry.name];
    cell.digital_outputs[terminal_name(entry.name, terminal::kLock)];
    for (const char* name : kLockInputs) cell.digital_inputs[terminal_name(entry.name, name)];
    cell.analog_inputs[terminal_name(entry.name, terminal::kToolNumber)];
  }

  /// The tool side that hangs on it at the start adds its name.
  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto model = device.as<ToolChangerDescription>();
    const std::string& name = device.entry->name;
    world.tool_changers.push_back({.name = name,
                                   .pointer = device.pointer(),
                                   .body = name + "/" + model->coupling_link,
                                   .X_LC = sim::Pose::Identity(),
                                   .size = model->size,
                                   .tolerance = model->tolerance,
                                   .lock_time = model->lock_time,
                                   .coupled = {},
                                   .period = model->cycle});
  }

  void add(const LoadedDevice& device, LoadedDevices all, BuiltCell& built) const override {
    const auto model = device.as<ToolChangerDescription>();
    const std::string& name = device.entry->name;
    sim::SimToolChanger& machine = *built.world->tool_changer(name);
    add_lock(name, side_on(device, all) != nullptr, machine, built);
    add_inputs(name, *model, machine, built);
    built.cell.changers[name] = {.arm = carrying_arm(device)->entry->name,
                                 .X_FC = pose_on_arm(device) * model->X_MC,
                                 .size = model->size,
                                 .tolerance = model->tolerance,
                                 .lock_time = model->lock_time};
  }

 private:
  /// A valve with two coils: what it was set to last it keeps, whatever stops.
  static void add_lock(const std::string& name, bool locked, sim::SimToolChanger& machine, BuiltCell& built) {
    const std::string full = terminal_name(name, terminal::kLock);
    device::SignalOutputDescription<bool> description;
    description.initial = locked;
    built.cell.digital_outputs[full] = &built.core->add(std::make_unique<device::SignalOutput<bool>>(
        full, description, built.commands->tap(full, built.borrowed<device::SignalOutputBackend<bool>>(&machine.lock)),
        built.core->period()));
  }

  static void add_inputs(const std::string& name, const ToolChangerDescription& model, sim::SimToolChanger& machine,
                         BuiltCell& built) {
    const auto add = [&]<class T>(T, const char* which, const char* unit, sim::SimGauge& gauge) {
      device::SignalInputDescription<T> description{.unit = unit, .sample_age_max = model.sample_age_max};
      return &built.core->add(std::make_unique<device::SignalInput<T>>(
          terminal_name(name, which), std::move(description),
          built.commands->samples().tap<T>(terminal_name(name, which),
                                           built.borrowed<device::SignalInputBackend<T>>(&gauge))));
    };
    sim::SimGauge* const gauges[] = {&machine.locked, &machine.unlocked, &machine.ready_to_lock, &machine.coupled};
    for (std::size_t i = 0; i < std::size(kLockInputs); ++i)
      built.cell.digital_inputs[terminal_name(name, kLockInputs[i])] = add(bool{}, kLockInputs[i], "", *gauges[i]);
    built.cell.analog_inputs[terminal_name(name, terminal::kToolNumber)] =
        add(double{}, terminal::kToolNumber, "1", machine.tool_number);
  }
};

/// The number that its plug is coded with.
int number_of(const LoadedDevice& side, Diagnostics& diagnostics) {
  return static_cast<int>(SettingsReader(side, diagnostics).integer("number"));
}

class ToolSideKind final : public DeviceKind {
 public:
  ToolSideKind()
      : DeviceKind("tool_side", {.doc = "The half of a tool changer at the tool.",
                                 .keys = {integer_key("number", {.low = 1, .high = kMostToolSides},
                                                      "Number that its plug is coded with.")}}) {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_tool_side(folder);
  }
  std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override {
    const auto& side = dynamic_cast<const ToolSideDescription&>(model);
    return MountPlace{.link = side.tool_link, .X_LP = Eigen::Isometry3d::Identity(), .X_MP = side.X_ST};
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    cell.tool_sides[entry.name];
    cell.objects[entry.name];
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)number_of(device, diagnostics);
    if (!device.on) return;
    if (!device.entry->mount.isApprox(Eigen::Isometry3d::Identity()))
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/mount", "a tool side is where its changer locks it",
                        "Remove 'mount'");
    const auto changer = device.on->as<ToolChangerDescription>();
    const std::string& size = device.as<ToolSideDescription>()->size;
    if (!changer)
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/on",
                        fmt::format("'{}' is no tool changer", device.entry->on),
                        "Name a tool changer, or give \"at\": a dock");
    if (changer && changer->size != size)
      diagnostics.error(Code::kIncompatible, device.pointer() + "/on",
                        fmt::format("a tool side of size '{}' on a changer of size '{}'", size, changer->size),
                        "Use two halves of the same size");
  }

  /// A body of its own, wherever it is: a lock holds it, or it lies there.
  sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const override {
    sim::RobotDescription robot = sim::plain_body(device.entry->name, device.model->robot, std::move(mount));
    robot.free = true;
    return robot;
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    Diagnostics ignored;  // checked before
    const auto model = device.as<ToolSideDescription>();
    const std::string& name = device.entry->name;
    world.tool_sides.push_back({.name = name,
                                .pointer = device.pointer(),
                                .body = name + "/" + model->coupling_link,
                                .size = model->size,
                                .number = number_of(device, ignored)});
    if (!device.on) return;
    for (sim::SimToolChangerDescription& changer : world.tool_changers)
      if (changer.name == device.entry->on) changer.coupled = name;
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    Diagnostics ignored;  // checked before
    built.cell.tool_sides[device.entry->name] = {.size = device.as<ToolSideDescription>()->size,
                                                 .number = number_of(device, ignored)};
  }
};

}  // namespace

std::unique_ptr<DeviceKind> tool_changer_kind() { return std::make_unique<ToolChangerKind>(); }
std::unique_ptr<DeviceKind> tool_side_kind() { return std::make_unique<ToolSideKind>(); }

}  // namespace takt::cell
