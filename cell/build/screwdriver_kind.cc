// Kind "screwdriver": a tool that turns screws. Its terminals are canonical signals of their own, "DEVICE/turn".
#include <algorithm>

#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/file/shape_file.h"
#include "core/device/device_file.h"
#include "core/device/screw_thread.h"
#include "core/device/screwdriver.h"
#include "core/device/signal.h"
#include "sim/machines/screwdriver.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::ScrewdriverDescription;

constexpr double kKeyPlay = 0.96;  // of a key in its socket
constexpr const char* kTurnOutputs[] = {"turn", "reverse"};
constexpr const char* kSetOutputs[] = {"speed", "torque_limit"};
constexpr const char* kStateInputs[] = {"clutch", "turning", "screw"};
constexpr const char* kDriverReadings[] = {"torque", "peak_torque", "angle", "measured_speed"};

/// What the scenario says of one screwdriver: the size of its bit.
std::optional<double> bit_radius(const LoadedDevice& driver, Diagnostics& diagnostics) {
  SettingsReader from(driver, diagnostics);
  const std::string size = from.text("bit");
  if (size.empty()) return std::nullopt;
  const auto threads = device::read_threads(device::ModelLibrary({driver.model->folder.parent_path()}));
  if (!threads) {
    diagnostics.append(threads.error());
    return std::nullopt;
  }
  const device::ScrewThread* thread = find_thread(*threads, size, from.at("bit"), diagnostics);
  return thread ? std::optional(0.5 * kKeyPlay * thread->socket_width) : std::nullopt;
}

/// The model with a bit of this radius.
std::shared_ptr<const kinematics::RobotModel> with_bit(const ScrewdriverDescription& driver, double radius) {
  auto robot = std::make_shared<kinematics::RobotModel>(*driver.robot);
  const auto link = std::ranges::find(robot->links, driver.bit, &kinematics::Link::name);
  for (auto* shapes : {&link->collisions, &link->visuals}) {
    for (kinematics::Geometry& geometry : *shapes) {
      if (auto* cylinder = std::get_if<kinematics::Cylinder>(&geometry.shape)) cylinder->radius = radius;
    }
  }
  return robot;
}

class ScrewdriverKind final : public DeviceKind {
 public:
  ScrewdriverKind()
      : DeviceKind("screwdriver",
                   {.doc = "A tool that turns screws.",
                    .keys = {text_key("bit", "Size of the screws that its bit fits, a name of models/threads.json.")
                                 .optional("that of the model")}}) {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override {
    return device::read_screwdriver(folder);
  }
  bool needs_arm() const override { return true; }
  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const ScrewdriverDescription&>(model).X_MT;
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const override {
    for (const char* name : kTurnOutputs) cell.digital_outputs[entry.name + "/" + name];
    for (const char* name : kSetOutputs) cell.analog_outputs[entry.name + "/" + name];
    for (const char* name : kStateInputs) cell.digital_inputs[entry.name + "/" + name];
    for (const char* name : kDriverReadings) cell.analog_inputs[entry.name + "/" + name];
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)bit_radius(device, diagnostics);
  }

  sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const override {
    Diagnostics ignored;  // checked before
    const auto driver = device.as<ScrewdriverDescription>();
    const auto radius = bit_radius(device, ignored);
    sim::RobotDescription robot =
        sim::plain_body(device.entry->name, radius ? with_bit(*driver, *radius) : driver->robot, std::move(mount));
    robot.joints.push_back({.joint = driver->spindle, .armature = driver->spindle_inertia});
    robot.bits.insert(driver->bit);
    robot.chamfers[driver->bit] = radius.value_or(0.002) * 0.2;
    return robot;
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto driver = device.as<ScrewdriverDescription>();
    const std::string& name = device.entry->name;
    world.devices.push_back({.name = name,
                             .pointer = device.pointer(),
                             .extend = {},
                             .make = [driver, name](const mjModel_& model, const sim::WorldDescription& description) {
                               return sim::SimScrewdriver::make(model, description, name, *driver);
                             }});
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const auto driver = device.as<ScrewdriverDescription>();
    const std::string& name = device.entry->name;
    auto* machine = dynamic_cast<sim::SimScrewdriver*>(built.world->device(name));
    add_outputs(name, *driver, *machine, built);
    add_inputs(name, *driver, *machine, built);
  }

 private:
  template <class T>
  static device::SignalOutput<T>& add_output(const std::string& name, device::SignalOutputDescription<T> description,
                                             sim::SimOutput& wire, BuiltCell& built) {
    return built.core->add(std::make_unique<device::SignalOutput<T>>(
        name, std::move(description), built.commands->tap(name, built.borrowed<device::SignalOutputBackend<T>>(&wire)),
        built.core->period()));
  }

  static void add_outputs(const std::string& name, const ScrewdriverDescription& driver, sim::SimScrewdriver& machine,
                          BuiltCell& built) {
    const auto digital = [&](const char* what, sim::SimOutput& wire) {
      device::SignalOutputDescription<bool> description;
      description.stop = false;
      built.cell.digital_outputs[name + "/" + what] = &add_output<bool>(name + "/" + what, description, wire, built);
    };
    digital("turn", machine.turn);
    digital("reverse", machine.reverse);
    const auto analog = [&](const char* what, const char* unit, double low, double high, sim::SimOutput& wire) {
      device::SignalOutputDescription<double> description;
      description.unit = unit;
      description.initial = high;
      description.lower = low;
      description.upper = high;
      built.cell.analog_outputs[name + "/" + what] = &add_output<double>(name + "/" + what, description, wire, built);
    };
    analog("speed", "rad/s", driver.speed_min, driver.speed_max, machine.speed);
    analog("torque_limit", "Nm", driver.torque_min, driver.torque_max, machine.torque_limit);
  }

  static void add_inputs(const std::string& name, const ScrewdriverDescription& driver, sim::SimScrewdriver& machine,
                         BuiltCell& built) {
    const auto add = [&]<class T>(T, const char* what, const char* unit, sim::SimGauge& gauge) {
      device::SignalInputDescription<T> description{.unit = unit, .sample_age_max = driver.sample_age_max};
      return &built.core->add(std::make_unique<device::SignalInput<T>>(
          name + "/" + what, std::move(description),
          built.commands->samples().tap<T>(name + "/" + what, built.borrowed<device::SignalInputBackend<T>>(&gauge))));
    };
    built.cell.digital_inputs[name + "/clutch"] = add(bool{}, "clutch", "", machine.clutch);
    built.cell.digital_inputs[name + "/turning"] = add(bool{}, "turning", "", machine.turning);
    built.cell.digital_inputs[name + "/screw"] = add(bool{}, "screw", "", machine.screw_present);
    built.cell.analog_inputs[name + "/torque"] = add(double{}, "torque", "Nm", machine.torque);
    built.cell.analog_inputs[name + "/peak_torque"] = add(double{}, "peak_torque", "Nm", machine.peak_torque);
    built.cell.analog_inputs[name + "/angle"] = add(double{}, "angle", "rad", machine.angle);
    built.cell.analog_inputs[name + "/measured_speed"] =
        add(double{}, "measured_speed", "rad/s", machine.measured_speed);
  }
};

}  // namespace

std::unique_ptr<DeviceKind> screwdriver_kind() { return std::make_unique<ScrewdriverKind>(); }

}  // namespace takt::cell
