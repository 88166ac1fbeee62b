#include "scenario/cell_builder.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/runtime.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/device/composed_device.h"
#include "core/device/material.h"
#include "core/device/plant_file.h"
#include "core/kinematics/chain.h"
#include "scenario/cell_models.h"
#include "scenario/degrees.h"
#include "scenario/faults.h"
#include "scenario/operator.h"
#include "sim/from_model.h"
#include "sim/nominal_payload.h"
#include "sim/render_shapes.h"
#include "sim/stage.h"

namespace takt::scenario {
namespace {

std::string object_pointer(const ObjectEntry& object) { return "/objects" + pointer_segment(object.name); }

/// The cell's frames: as the application believes them (nominal), and as they are (truth). Entries may name each other
/// in any order.
class Frames {
 public:
  Frames(const Description& description, Diagnostics& diagnostics) {
    for (const FrameEntry& frame : description.frames) {
      want("/frames" + pointer_segment(frame.name), frame.name, frame.at, frame.at.X);
    }
    for (const DeviceEntry& device : description.devices) {
      if (device.at) want("/devices" + pointer_segment(device.name) + "/at", device.name, *device.at, device.at->X);
    }
    for (const ObjectEntry& object : description.objects) {
      want(object_pointer(object) + "/at", object.name, object.at, drawn_pose(object, description.seed));
    }
    place_all(diagnostics);
  }

  world::FrameGraph nominal, truth;

 private:
  struct Wanted {
    std::string pointer, name;
    Placement at;
    Eigen::Isometry3d drawn;
    bool placed = false;
  };

  void want(std::string pointer, const std::string& name, const Placement& at, const Eigen::Isometry3d& drawn) {
    wanted_.push_back({std::move(pointer), name, at, drawn});
  }

  void place_all(Diagnostics& diagnostics) {
    for (bool progress = true; progress;) {
      progress = false;
      for (Wanted& one : wanted_) {
        if (one.placed || !nominal.contains(one.at.in)) continue;
        diagnostics.append(nominal.add(one.name, one.at.in, one.at.X), one.pointer);
        (void)truth.add(one.name, one.at.in, one.drawn);
        one.placed = progress = true;
      }
    }
    std::vector<std::string> names{"world"};
    for (const Wanted& one : wanted_) names.push_back(one.name);
    // What hangs on something unknown is a consequence; only where nothing is unknown do frames hang in a circle.
    const auto unknown = [&](const Wanted& one) { return std::ranges::find(names, one.at.in) == names.end(); };
    const bool circle = std::ranges::none_of(wanted_, unknown);
    for (const Wanted& one : wanted_) {
      if (one.placed || !(circle || unknown(one))) continue;
      diagnostics.error(Code::kInvalidValue, one.pointer + "/in",
                        circle ? fmt::format("the frame of '{}' has no known pose", one.at.in)
                               : fmt::format("there is no frame '{}'", one.at.in),
                        circle ? "frames that end at 'world'" : nearest_choice(one.at.in, names));
    }
  }

  std::vector<Wanted> wanted_;
};

sim::Mount mount_of(const LoadedDevice& device, const world::FrameGraph& truth) {
  if (!device.on) return {"", truth.pose(device.entry->name).value_or(Eigen::Isometry3d::Identity())};
  const auto place = device.on->kind->mount_place(*device.on->model).value_or(MountPlace{});
  return {device.on->entry->name + "/" + place.link, place.X_LP * device.entry->mount};
}

// -- Surfaces ---------------------------------------------------------------------------------------------------------

/// The materials of the models folder and those of the scenario.
device::MaterialTable materials_of(const Description& description, const device::ModelLibrary& models,
                                   Diagnostics& diagnostics) {
  auto table = device::read_materials(models);
  if (!table) {
    diagnostics.append(table.error());
    return {};
  }
  table->read(&description.materials, &description.contacts, "", diagnostics);
  return std::move(*table);
}

/// Puts in what the material says and the surface does not say by itself.
void complete(sim::ContactParameters& surface, const device::MaterialTable& table, const std::string& pointer,
              Diagnostics& diagnostics) {
  // Without any table, as for a library of models without materials, all is of steel.
  if (table.materials.empty() && surface.material == "steel") return;
  const device::Material* material = table.find(surface.material, pointer, diagnostics);
  if (!material) return;
  if (!surface.own_stiffness) {
    surface.stiffness = material->stiffness;
    surface.damping = material->damping;
  } else if (surface.damping < 0.0) {
    surface.damping = material->damping * surface.stiffness / material->stiffness;
  }
  if (!surface.own_friction) surface.friction = material->friction;
  surface.torsion = material->torsion;
  surface.rolling = material->rolling;
}

void complete_surfaces(const Description& description, const device::ModelLibrary& models, sim::WorldDescription& world,
                       Diagnostics& diagnostics) {
  const device::MaterialTable table = materials_of(description, models, diagnostics);
  for (sim::RobotDescription& robot : world.robots) {
    complete(robot.contact, table, robot.pointer + "/material", diagnostics);
    for (auto& [link, surface] : robot.link_contacts) complete(surface, table, robot.pointer, diagnostics);
  }
  for (sim::ObjectDescription& object : world.objects)
    complete(object.contact, table, object.pointer + "/material", diagnostics);
  for (const device::MaterialRule& rule : table.rules)
    world.contact_rules.push_back({rule.between, rule.stiffness, rule.damping, rule.friction});
}

/// Surfaces and springs as the device file says.
void set_plant(const device::PlantDescription& plant, sim::RobotDescription& robot) {
  robot.contact.material = plant.material;
  for (auto& [link, surface] : robot.link_contacts) surface.material = plant.pad_material;
  for (const device::SpringJoint& spring : plant.springs) {
    auto joint = std::ranges::find(robot.joints, spring.joint, &sim::JointFigures::joint);
    if (joint == robot.joints.end()) joint = robot.joints.insert(joint, {.joint = spring.joint});
    joint->spring = sim::JointSpring{spring.stiffness, spring.damping, spring.preload};
  }
}

sim::ContactParameters surface_of(const ObjectEntry& entry) {
  sim::ContactParameters surface;
  surface.material = entry.material.empty() ? "steel" : entry.material;
  surface.own_friction = entry.friction.has_value();
  surface.friction = entry.friction.value_or(surface.friction);
  surface.own_stiffness = entry.stiffness_N_m.has_value();
  if (surface.own_stiffness) {
    surface.stiffness = *entry.stiffness_N_m;
    surface.damping = entry.damping_N_s_m.value_or(-1.0);  // complete() knows
  }
  return surface;
}

void simulate(const LoadedDevice& device, const world::FrameGraph& truth, sim::WorldDescription& world,
              Diagnostics& diagnostics) {
  device.kind->check(device, diagnostics);
  if (device.kind->needs_arm() && !carrying_arm(device)) {
    diagnostics.error(Code::kInvalidValue, device.pointer(), "this device has to be mounted on an arm",
                      "\"on\": NAME of an arm or sensor");
  }
  world.robots.push_back(device.kind->body(device, mount_of(device, truth)));
  world.robots.back().pointer = device.pointer();
  auto plant = device::read_plant(*device.model);
  if (!plant) return diagnostics.append(plant.error());
  set_plant(*plant, world.robots.back());
  device.kind->simulate(device, world);
}

// -- Objects and cameras
// -----------------------------------------------------------------------------------------------

sim::ObjectShape simulated_shape(const world::Shape& shape) {
  if (const auto* box = std::get_if<world::Box>(&shape)) return kinematics::Box{box->size};
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return kinematics::Cylinder{cylinder->radius, cylinder->length};
  }
  if (const auto* sphere = std::get_if<world::Sphere>(&shape)) return kinematics::Sphere{sphere->radius};
  const auto& capsule = std::get<world::Capsule>(shape);
  return sim::Capsule{capsule.radius, capsule.length};
}

sim::ObjectDescription simulated_object(const ObjectEntry& entry, const Eigen::Isometry3d& X_WO) {
  sim::ObjectDescription object;
  object.name = entry.name;
  object.pointer = object_pointer(entry);
  object.mount = {"", X_WO};
  object.free = !entry.fixed;
  object.mass = entry.mass_kg;
  object.contact = surface_of(entry);
  object.lit_by = entry.lit_by;
  for (std::size_t i = 0; i < entry.parts.size(); ++i) {
    const world::Object::Part& part = entry.parts[i];
    object.shapes.push_back({.shape = simulated_shape(part.shape), .X_OG = part.X_OS, .rgba = entry.rgba});
    if (i < entry.part_masses_kg.size()) object.shapes.back().mass = entry.part_masses_kg[i];
  }
  if (entry.inertia_kg_m2) {
    kinematics::Inertial& inertial = object.inertial.emplace();
    inertial.mass = entry.mass_kg;
    inertial.X_LC.translation() = entry.centre_m.value_or(Eigen::Vector3d::Zero());
    inertial.I_C = *entry.inertia_kg_m2;
  }
  return object;
}

/// What the device file of an object says of its surface.
std::string model_material(const std::filesystem::path& folder, Diagnostics& diagnostics) {
  const auto file = folder / "device.json";
  const auto json = read_json(file);
  Diagnostics own;
  std::string material = "steel";
  if (json) material = ObjectReader(*json, "", own).text("material", material);
  own.set_file(file.string());
  diagnostics.append(own);
  return material;
}

/// An object that is a model: its URDF stands in the world; its collision shapes are what the application knows.
bool add_model_object(const ObjectEntry& entry, const device::ModelLibrary& models, const Eigen::Isometry3d& X_WO,
                      sim::WorldDescription& world, world::Object& known, Diagnostics& diagnostics) {
  const std::string pointer = object_pointer(entry) + "/model";
  const auto folder = models.find(entry.model, pointer);
  if (!folder) {
    diagnostics.append(folder.error());
    return false;
  }
  auto model = kinematics::RobotModel::load(*folder / (entry.model + ".urdf"));
  if (!model) {
    diagnostics.append(model.error(), "", "");
    return false;
  }
  if (!entry.fixed && !model->root().inertial) {
    diagnostics.error(Code::kMissing, object_pointer(entry) + "/fixed",
                      fmt::format("link '{}' of the model has no mass", model->root().name),
                      "<inertial> in the URDF, or \"fixed\": true");
  }
  for (const kinematics::Geometry& geometry : model->root().collisions) {
    if (const auto* box = std::get_if<kinematics::Box>(&geometry.shape)) {
      known.parts.push_back({world::Box{box->size}, geometry.X_LG});
    } else if (const auto* cylinder = std::get_if<kinematics::Cylinder>(&geometry.shape)) {
      known.parts.push_back({world::Cylinder{cylinder->radius, cylinder->length}, geometry.X_LG});
    } else if (const auto* sphere = std::get_if<kinematics::Sphere>(&geometry.shape)) {
      known.parts.push_back({world::Sphere{sphere->radius}, geometry.X_LG});
    }
  }
  sim::RobotDescription robot;
  robot.name = entry.name;
  robot.pointer = pointer;
  robot.model = std::make_shared<const kinematics::RobotModel>(std::move(*model));
  robot.mount = {"", X_WO};
  robot.contact = surface_of(entry);
  if (entry.material.empty()) robot.contact.material = model_material(*folder, diagnostics);
  robot.lit_by = entry.lit_by;
  robot.free = !entry.fixed;
  world.robots.push_back(std::move(robot));
  return true;
}

/// The body that a camera rides on: a device's flange or an object moves with it, a plain frame stands in the world.
sim::CameraDescription simulated_camera(const CameraEntry& entry, const world::FrameGraph& truth,
                                        Diagnostics& diagnostics) {
  const std::string pointer = "/cameras" + pointer_segment(entry.name);
  sim::CameraDescription camera;
  camera.name = entry.name;
  camera.pointer = pointer;
  camera.vertical_field_of_view = entry.fovy_deg * kDegree;
  const auto X_WI = truth.pose(entry.at.in);
  if (!X_WI) diagnostics.append(X_WI.error(), pointer + "/at/in");
  const Eigen::Isometry3d X_WC = X_WI.value_or(Eigen::Isometry3d::Identity()) * entry.at.X;
  if (!entry.look_at) {
    camera.mount = {"", X_WC};
    return camera;
  }
  const auto X_WL = truth.pose(entry.look_at->in);
  if (!X_WL) {
    diagnostics.append(X_WL.error(), pointer + "/look_at/in");
    return camera;
  }
  camera.mount = {"", sim::look_at(X_WC.translation(), *X_WL * entry.look_at->X.translation())};
  return camera;
}

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
    arm.device->set_tool({arm.X_FT, carried});
    if (model.payload_max == 0.0 || carried.mass <= model.payload_max) continue;
    diagnostics.error(Code::kLimitExceeded, "/devices" + pointer_segment(name),
                      fmt::format("'{}' carries {:.2f} kg, tools and sensors together", name, carried.mass),
                      fmt::format("at most {:g} kg: 'payload_max_kg' of '{}'", model.payload_max, model.model));
  }
}

}  // namespace

Result<BuiltCell> build_cell(const Description& description, const device::ModelLibrary& models, bool measure_times,
                             Diagnostics& warnings) {
  Diagnostics diagnostics;
  const auto devices = load_devices(description, models, diagnostics);
  const Frames frames(description, diagnostics);

  sim::WorldDescription simulated;
  simulated.seed = description.seed;
  simulated.physics.plant_mass_scale = description.plant_mass_scale;
  for (const auto& device : devices) simulate(*device, frames.truth, simulated, diagnostics);
  BuiltCell built;
  // Of a period of 1 ms half is for the nets; the rest is for the devices, for who looks between cycles, and spare.
  constexpr Nanoseconds kNetBudget = 500'000;
  const rcc::ControlCore::Options options{.measure = measure_times, .budget = description.realtime ? kNetBudget : 0};
  built.site = std::make_unique<SiteDevices>(description.site, options.period, description.seed);
  built.site->plan(devices, diagnostics);
  for (const ObjectEntry& entry : description.objects) {
    const Eigen::Isometry3d X_WO = frames.truth.pose(entry.name).value_or(Eigen::Isometry3d::Identity());
    world::Object known{entry.name, entry.parts};
    if (entry.model.empty()) {
      simulated.objects.push_back(simulated_object(entry, X_WO));
    } else if (!add_model_object(entry, models, X_WO, simulated, known, diagnostics)) {
      continue;
    }
    built.truth_W[entry.name] = X_WO;
    if (!entry.model.empty() && !entry.fixed)
      built.true_body[entry.name] = entry.name + "/" + simulated.robots.back().model->root().name;
    built.cell.objects[entry.name] = std::move(known);
  }
  complete_surfaces(description, models, simulated, diagnostics);
  for (const CameraEntry& camera : description.cameras) {
    simulated.cameras.push_back(simulated_camera(camera, frames.truth, diagnostics));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  auto world = sim::World::create(simulated, [](mjSpec_& spec) { sim::dress_stage(&spec, {}); });
  if (!world) return std::unexpected(std::move(world.error()));
  built.world = std::make_shared<sim::World>(std::move(*world));
  built.triangles = sim::triangle_count(built.world->model());
  built.core = std::make_unique<rcc::ControlCore>(options);
  for (const device::ChannelDescription& channel : description.channels) {
    auto declared = built.core->declare(channel);
    if (!declared) return std::unexpected(std::move(declared.error()));
    built.cell.channels[channel.name] = *declared;
  }
  const device::ChannelDescription speed{
      .name = std::string(Operator::kOverride), .unit = "1", .initial = net::Real{built.site->speed_override()}};
  const auto override_channel = built.core->declare(speed);
  if (!override_channel) return std::unexpected(override_channel.error());
  built.cell.channels[speed.name] = *override_channel;
  built.cell.override_channel = speed.name;
  built.cell.frames = frames.nominal;
  for (const auto& device : devices) device->kind->add(*device, devices, built);
  diagnostics.append(built.site->problems());
  diagnostics.append(activity::declare_channels(*built.core, built.cell));
  add_composed(description, built, diagnostics);
  add_emergency_stop(description, built, diagnostics);
  set_tools(simulated, built, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  built.site->add_to(built.core->digest());
  for (const NetEntry& net : description.nets) built.cell.nets[net.name] = net.net;
  warnings.append(diagnostics);
  return built;
}

Diagnostics check_cell_names(const Description& description, const device::ModelLibrary& models) {
  Diagnostics diagnostics;
  (void)load_devices(description, models, diagnostics);
  (void)Frames(description, diagnostics);
  return diagnostics;
}

command::Cell names_of_cell(const Description& description, const device::ModelLibrary& models) {
  command::Cell cell;
  for (const DeviceEntry& device : description.devices) {
    const auto folder = models.find(device.model);
    const auto name = folder ? device::read_device_kind(*folder) : Result<std::string>(std::unexpected(Diagnostics{}));
    const DeviceKinds& kinds = DeviceKinds::global();
    const DeviceKind* kind = name ? kinds.find(*name) : nullptr;
    const auto model = kind ? kind->read(*folder) : Result<ModelPointer>(std::unexpected(Diagnostics{}));
    if (!kind) kind = kinds.find(device.on.empty() ? "arm" : "force_torque_sensor");
    kind->declare(device, model ? model->get() : nullptr, cell);
  }
  for (const ObjectEntry& object : description.objects) cell.objects[object.name];
  for (const NetEntry& net : description.nets) cell.nets[net.name] = net.net;
  for (const device::ChannelDescription& channel : description.channels) cell.channels[channel.name];
  return cell;
}

}  // namespace takt::scenario
