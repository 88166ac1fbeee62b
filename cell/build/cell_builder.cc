#include "cell/build/cell_builder.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_collisions.h"
#include "cell/build/cell_tools.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kind_registry.h"
#include "cell/build/simulated_cell.h"
#include "cell/build/site_devices.h"
#include "cell/file/operator.h"
#include "core/activity/runtime.h"
#include "core/base/keys_of.h"
#include "core/device/composed_device.h"
#include "core/device/tool_changer.h"
#include "core/expression/moving_frames.h"
#include "core/expression/tool_settings.h"
#include "core/primitives/cell_solids.h"
#include "sim/film/render_shapes.h"
#include "sim/machines/nominal_payload.h"
#include "sim/model/from_model.h"
#include "sim/world/stage.h"

namespace takt::cell {
namespace {

/// The wholes, in the order of the file, so that one may be part of another.
void add_composed(const Description& description, BuiltCell& built, Diagnostics& diagnostics) {
  for (const ComposedEntry& entry : description.composed) {
    std::vector<net::Resource*> parts;
    for (std::size_t i = 0; i < entry.parts.size(); ++i) {
      net::Resource* part = built.core->environment().find(entry.parts[i]);
      if (part) {
        parts.push_back(part);
      } else {
        diagnostics.error(Code::kUnknownName, entry.pointer + pointer_segment(i),
                          fmt::format("there is no device '{}'", entry.parts[i]),
                          nearest_choice(entry.parts[i], built.core->environment().names()));
      }
    }
    if (parts.size() != entry.parts.size()) continue;
    auto whole = device::ComposedDevice::make(entry.name, std::move(parts));
    if (whole) {
      built.core->add(entry.name, std::move(*whole));
    } else {
      diagnostics.append(whole.error(), entry.pointer);
    }
  }
}

/// Tells each arm what it carries, as a technician would enter it: from the data sheets, not from the simulation.
void set_tools(const sim::WorldDescription& simulated, BuiltCell& built, Diagnostics& diagnostics) {
  for (auto& [name, arm] : built.cell.arms) {
    const device::ArmDescription& model = arm.device->description();
    const device::PayloadSetting carried = sim::nominal_payload(simulated, name, model.flange_link);
    arm.unloaded = carried;
    arm.device->set_tool({arm.X_FT, carried});
    const double mass = carried.mass + built.cell.load_of(name).mass;
    if (model.payload_max == 0.0 || mass <= model.payload_max) continue;
    diagnostics.error(
        Code::kLimitExceeded, "/devices" + pointer_segment(name),
        fmt::format("'{}' carries {:.2f} kg, tools and sensors together", name, mass),
        fmt::format("Keep it to at most {:g} kg: 'payload_max_kg' of '{}'", model.payload_max, model.model));
  }
}

/// An arm that feels nothing makes no sensor; what a driver reads of its controller shows in the run.
void check_own_forces(LoadedDevices devices, const Site& site, Diagnostics& diagnostics) {
  for (const auto& device : devices) {
    const auto arm = device->as<device::ArmDescription>();
    const Binding* binding = site.find(device->entry->name);
    if (arm == nullptr || device->entry->own_force.empty() || arm->torque_noise.size() > 0) continue;
    if (binding != nullptr && binding->driver) continue;
    diagnostics.error(Code::kUnsupported, device->pointer() + "/own_force",
                      fmt::format("'{}' is a '{}', which has no torque sensors", device->entry->name, arm->model),
                      "Mount a force/torque sensor on it, or choose an arm with torque sensors");
  }
}

void check_force_sensor(const FilmEntry& film, const expression::Cell& cell, Diagnostics& diagnostics) {
  if (film.force_sensor.empty() || cell.sensors.contains(film.force_sensor)) return;
  diagnostics.error(Code::kUnknownName, "/film/force_sensor",
                    fmt::format("there is no force/torque sensor '{}'", film.force_sensor),
                    nearest_choice(film.force_sensor, keys_of(cell.sensors)));
}

/// The world and the core, still without devices. False: with diagnostics.
bool make_core(const Description& description, const SimulatedCell& simulated, const rcc::ControlCore::Options& options,
               BuiltCell& built, Diagnostics& diagnostics) {
  auto world = sim::World::create(simulated.world, [](mjSpec_& spec) { sim::add_scene_props(&spec, {}); });
  if (!world) {
    diagnostics = std::move(world.error());
    return false;
  }
  built.world = std::make_shared<sim::World>(std::move(*world));
  built.triangles = sim::triangle_count(built.world->model());
  built.core = std::make_unique<rcc::ControlCore>(options);
  std::vector<device::ChannelDescription> channels = description.channels;
  channels.push_back(
      {.name = std::string(Operator::kOverride), .unit = "1", .initial = net::Real{built.site->speed_override()}});
  for (const device::ChannelDescription& channel : channels) {
    auto declared = built.core->declare(channel);
    if (!declared) {
      diagnostics = std::move(declared.error());
      return false;
    }
    built.cell.channels[channel.name] = *declared;
  }
  built.cell.override_channel = Operator::kOverride;
  return true;
}

/// What stage two knows, for the program, for expectations and films.
void hand_over(LoadedCell& loaded, SimulatedCell& simulated, BuiltCell& built) {
  built.truth_W = std::move(simulated.truth_W);
  built.true_body = std::move(simulated.true_body);
  built.frames_on = std::move(simulated.frames_on);
  built.beams = simulated.world.beams;
  built.cell.objects = std::move(simulated.objects);
  built.cell.frames = std::move(loaded.frames.believed);
  built.start = std::move(loaded.frames.truth);
  for (const auto& device : loaded.devices) {
    const DeviceEntry& entry = *device->entry;
    if (!device->on || entry.true_mount.matrix() == entry.mount.matrix()) continue;
    built.true_mounts[entry.name] =
        tool_side_under(*device) ? pose_on_side(*device, MountAs::kTrue) : pose_on_arm(*device, MountAs::kTrue);
  }
  for (const NetEntry& net : loaded.description.nets) built.cell.nets[net.name] = net.net;
}

void add_devices(const LoadedCell& loaded, BuiltCell& built, Diagnostics& diagnostics) {
  const Description& description = loaded.description;
  for (const bool last : {false, true})
    for (const auto& device : loaded.devices)
      if (built.site->wired_last(device->entry->name) == last) device->kind->add(*device, loaded.devices, built);
  add_tools(loaded.devices, built.cell, diagnostics);
  expression::update_flange_frames(built.cell);
  diagnostics.append(built.site->problems());
  check_own_forces(loaded.devices, description.site, diagnostics);
  check_force_sensor(description.film, built.cell, diagnostics);
  diagnostics.append(activity::declare_channels(*built.core, built.cell));
  add_composed(description, built, diagnostics);
}

}  // namespace

Result<BuiltCell> build_cell(const Description& file, const device::ModelLibrary& models, bool measure_times,
                             Diagnostics& warnings) {
  Diagnostics diagnostics;
  LoadedCell loaded(file, models, diagnostics);
  const Description& description = loaded.description;
  SimulatedCell simulated = simulate(loaded, models, diagnostics);

  BuiltCell built;
  built.library = models;
  // Of a period of 1 ms half is for the nets; the rest is for the devices, for who looks between cycles, and spare.
  constexpr Nanoseconds kNetBudget = 500'000;
  const rcc::ControlCore::Options options{
      .measure = measure_times, .budget = description.realtime ? kNetBudget : 0, .separate = description.site.separate};
  built.commands = std::make_shared<CommandTape>();
  built.site = std::make_shared<SiteDevices>(description.site, options.period, description.seed);
  built.site->plan(loaded.devices, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  if (!make_core(description, simulated, options, built, diagnostics)) return std::unexpected(std::move(diagnostics));
  hand_over(loaded, simulated, built);
  add_devices(loaded, built, diagnostics);
  set_tools(simulated.world, built, diagnostics);
  expression::tell_tool_settings(built.cell);  // of arms that have a tool coupled
  built.cell.shapes = cell_shapes(description, simulated.world, built.cell, diagnostics);
  // No device has such a name.
  built.cell.solids = &built.core->add("cell/solids", std::make_unique<primitives::CellSolids>(built.cell.shapes));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  built.site->add_to(built.core->digest());
  warnings.append(diagnostics);
  return built;
}

Diagnostics check_cell_names(const Description& file, const device::ModelLibrary& models) {
  Diagnostics diagnostics;
  (void)LoadedCell(file, models, diagnostics);
  return diagnostics;
}

namespace {

void add_tool_name(const DeviceEntry& device, const DeviceKind& kind, const device::ModelDescription& model,
                   expression::Cell& cell) {
  const auto own = kind.tcp(model);
  if (!own && device.tcps.empty()) return;
  expression::MountedTool& tool = cell.tools[device.name];
  tool.X_FT = device.tcps;
  if (own) tool.X_FT.try_emplace(std::string(expression::MountedTool::kOwnTcp), *own);
}

/// Name of the arm that a device is mounted on, through whatever is between; empty: on none.
std::string arm_below(const Description& description, const DeviceEntry& device, const expression::Cell& cell) {
  const DeviceEntry* one = &device;
  for (std::size_t steps = 0; steps < description.devices.size() && !one->on.empty(); ++steps) {
    if (cell.arms.contains(one->on)) return one->on;
    const auto below = std::ranges::find(description.devices, one->on, &DeviceEntry::name);
    if (below == description.devices.end()) break;
    one = &*below;
  }
  return {};
}

void note_carrier(const Description& description, const DeviceEntry& device, expression::Cell& cell) {
  const std::string arm = arm_below(description, device, cell);
  if (const auto tool = cell.tools.find(device.name); tool != cell.tools.end()) tool->second.arm = arm;
  if (const auto gripper = cell.grippers.find(device.name); gripper != cell.grippers.end()) gripper->second.arm = arm;
  if (const auto sensor = cell.sensors.find(device.name); sensor != cell.sensors.end()) sensor->second.arm = arm;
  if (const auto changer = cell.changers.find(device.name); changer != cell.changers.end()) changer->second.arm = arm;
}

}  // namespace

expression::Cell names_of_cell(const Description& description, const device::ModelLibrary& models) {
  expression::Cell cell;
  for (const DeviceEntry& device : description.devices) {
    const auto folder = models.find(device.model);
    const auto name = folder ? device::read_device_kind(*folder) : Result<std::string>(std::unexpected(Diagnostics{}));
    const DeviceKinds& kinds = DeviceKinds::global();
    const DeviceKind* kind = name ? kinds.find(*name) : nullptr;
    const auto model = kind ? kind->read(*folder) : Result<ModelPointer>(std::unexpected(Diagnostics{}));
    if (!kind) kind = kinds.find(device.on.empty() ? "arm" : "force_torque_sensor");
    kind->declare(device, model ? model->get() : nullptr, cell);
    if (model) add_tool_name(device, *kind, **model, cell);
  }
  for (const DeviceEntry& device : description.devices) {
    const auto tool = cell.tools.find(device.name);
    if (tool != cell.tools.end() && cell.tool_sides.contains(device.on)) tool->second.side = device.on;
    note_carrier(description, device, cell);
  }
  for (const ObjectEntry& object : description.objects) cell.objects[object.name];
  for (const NetEntry& net : description.nets) cell.nets[net.name] = net.net;
  for (const device::ChannelDescription& channel : description.channels) cell.channels[channel.name];
  return cell;
}

}  // namespace takt::cell
