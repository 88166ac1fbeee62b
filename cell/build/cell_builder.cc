#include "cell/build/cell_builder.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_collisions.h"
#include "cell/build/cell_frames.h"
#include "cell/build/cell_models.h"
#include "cell/build/cell_tools.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kind_registry.h"
#include "cell/build/faults.h"
#include "cell/build/site_devices.h"
#include "cell/file/degrees.h"
#include "cell/file/operator.h"
#include "cell/file/threaded_objects.h"
#include "core/activity/runtime.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/device/composed_device.h"
#include "core/device/material.h"
#include "core/device/plant_of_model.h"
#include "core/device/tool_changer.h"
#include "core/expression/moving_frames.h"
#include "core/expression/tool_settings.h"
#include "core/kinematics/chain.h"
#include "core/primitives/cell_solids.h"
#include "sim/film/render_shapes.h"
#include "sim/machines/nominal_payload.h"
#include "sim/model/from_model.h"
#include "sim/world/stage.h"

namespace takt::cell {
namespace {

std::string object_pointer(const ObjectEntry& object) { return "/objects" + pointer_segment(object.name); }

sim::Mount mount_of(const LoadedDevice& device, const world::FrameGraph& truth) {
  if (!device.on || device.as<device::ToolSideDescription>())
    return {"", truth.pose(device.entry->name).value_or(Eigen::Isometry3d::Identity())};
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
  surface.oiled_friction = material->oiled;
}

/// The least friction of all surfaces but one.
double least_friction_beside(const sim::ContactParameters& one, const sim::WorldDescription& world) {
  double least = sim::ContactParameters{}.friction;  // of the floor
  const auto look = [&](const sim::ContactParameters& other) {
    if (&other != &one) least = std::min(least, other.friction);
  };
  for (const sim::RobotDescription& robot : world.robots) {
    look(robot.contact);
    for (const auto& [link, surface] : robot.link_contacts) look(surface);
  }
  for (const sim::ObjectDescription& object : world.objects) look(object.contact);
  return least;
}

/// Of two surfaces the larger friction counts: one that is smoother than all others never decides anything.
void note_idle_friction(const sim::ContactParameters& surface, const sim::WorldDescription& world,
                        const std::string& pointer, Diagnostics& diagnostics) {
  if (!surface.own_friction) return;
  const double least = least_friction_beside(surface, world);
  if (surface.friction >= least) return;
  diagnostics.note(pointer + "/friction",
                   fmt::format("friction {:g} has no effect: of two surfaces the larger one counts, and every other "
                               "one of this cell has {:g} or more",
                               surface.friction, least),
                   "\"friction\" of what touches it, too; or a \"material\" and a rule in \"contacts\"");
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
  for (const sim::RobotDescription& robot : world.robots)
    note_idle_friction(robot.contact, world, robot.pointer, diagnostics);
  for (const sim::ObjectDescription& object : world.objects)
    note_idle_friction(object.contact, world, object.pointer, diagnostics);
  for (const device::MaterialRule& rule : table.rules)
    world.contact_rules.push_back({rule.between, rule.stiffness, rule.damping, rule.friction, rule.oiled});
}

/// Surfaces and springs as the device file says.
void set_plant(const device::PlantDescription& plant, sim::RobotDescription& robot) {
  robot.contact.material = plant.material;
  for (auto& [link, surface] : robot.link_contacts) surface.material = plant.pad_material;
  robot.chamfers.insert(plant.chamfers.begin(), plant.chamfers.end());
  for (const device::SpringJoint& spring : plant.springs) {
    auto joint = std::ranges::find(robot.joints, spring.joint, &sim::JointFigures::joint);
    if (joint == robot.joints.end()) joint = robot.joints.insert(joint, {.joint = spring.joint});
    joint->spring = sim::JointSpring{spring.stiffness, spring.damping, spring.preload};
  }
}

/// What the scenario says of a device's surfaces in place of its model.
void set_surface(const DeviceEntry& entry, sim::ContactParameters& surface) {
  if (!entry.material.empty()) surface.material = entry.material;
  surface.own_friction = entry.friction.has_value();
  surface.friction = entry.friction.value_or(surface.friction);
  surface.oiled = entry.oiled;
}

sim::ContactParameters surface_of(const ObjectEntry& entry) {
  sim::ContactParameters surface;
  surface.material = entry.material.empty() ? "steel" : entry.material;
  surface.own_friction = entry.friction.has_value();
  surface.friction = entry.friction.value_or(surface.friction);
  surface.oiled = entry.oiled;
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
  const LoadedDevice* side = tool_side_under(device);
  if (device.kind->needs_arm() && !carrying_arm(device) && !side) {
    diagnostics.error(Code::kInvalidValue, device.pointer(), "this device has to be mounted on an arm",
                      "Add \"on\": NAME of an arm or sensor");
  }
  if (side && (device.as<device::ForceTorqueDescription>() || device.as<device::ToolChangerDescription>() ||
               device.as<device::ArmDescription>()))
    diagnostics.error(Code::kUnsupported, device.pointer() + "/on",
                      fmt::format("'{}' is a tool side: it carries tools only", side->entry->name),
                      "Mount the tool side between the arm and its tool changer");
  world.robots.push_back(device.kind->body(device, mount_of(device, truth)));
  world.robots.back().pointer = device.pointer();
  auto plant = device::read_plant(*device.model);
  if (!plant) return diagnostics.append(plant.error());
  set_plant(*plant, world.robots.back());
  set_surface(*device.entry, world.robots.back().contact);
  device.kind->simulate(device, world);
}

// -- What rides on what -----------------------------------------------------------------------------------------------

/// All that says on which body something is put.
struct Ground {
  const CellFrames& frames;
  LoadedDevices devices;
  const Description& description;
};

/// The link of a device that carries the frame, or a body of a free object.
std::string body_of(const std::string& frame, const Ground& ground) {
  const auto& [frames, devices, description] = ground;
  for (const std::string_view name : frames.believed.path_to_world(frame)) {
    const auto object = std::ranges::find(description.objects, name, &ObjectEntry::name);
    if (object != description.objects.end() && !object->fixed && object->model.empty()) return object->name;
    const world::Relation& relation = *frames.believed.relation(name);
    const auto device = std::ranges::find(devices, name, [](const auto& one) { return one->entry->name; });
    if (device != devices.end())
      if (const auto side = (*device)->as<device::ToolSideDescription>())
        return (*device)->entry->name + "/" + side->coupling_link;
    if (relation.kind == world::Relation::Kind::kLink) return command::link_frame(relation.source, relation.link);
    if (relation.kind != world::Relation::Kind::kFlange) continue;
    const auto carrier = std::ranges::find(devices, relation.source, [](const auto& one) { return one->entry->name; });
    return relation.source + "/" + (*carrier)->as<device::ArmDescription>()->flange_link;
  }
  return {};
}

/// The frame of a body: an object, a link of an arm, its flange, a tool side.
std::string moving_frame(const std::string& body, const world::FrameGraph& frames) {
  if (frames.contains(body)) return body;
  const std::string owner = body.substr(0, body.find('/'));
  return frames.contains(command::flange_frame(owner)) ? command::flange_frame(owner) : owner;
}

/// What is placed in a frame rides on whatever the frame rides on: a flange, a base, an object that moves; else it
/// stands in the world.
sim::Mount mount_in(const std::string& frame, const Eigen::Isometry3d& X_W, const Ground& ground) {
  const std::string body = body_of(ground.frames.standing_frame(frame), ground);
  if (body.empty()) return {"", X_W};
  const auto X_WP =
      ground.frames.truth.pose(moving_frame(body, ground.frames.truth)).value_or(Eigen::Isometry3d::Identity());
  return {body, X_WP.inverse() * X_W};
}

// -- Objects and cameras ----------------------------------------------------------------------------------------------

sim::ObjectShape simulated_shape(const world::Shape& shape) {
  if (const auto* box = std::get_if<world::Box>(&shape)) return kinematics::Box{box->size};
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return kinematics::Cylinder{cylinder->radius, cylinder->length};
  }
  if (const auto* sphere = std::get_if<world::Sphere>(&shape)) return kinematics::Sphere{sphere->radius};
  const auto& capsule = std::get<world::Capsule>(shape);
  return sim::Capsule{capsule.radius, capsule.length};
}

/// As the file says it, or spread over its parts.
world::MassProperties mass_of(const ObjectEntry& entry) {
  if (entry.inertia_kg_m2)
    return {entry.mass_kg, entry.centre_m.value_or(Eigen::Vector3d::Zero()), *entry.inertia_kg_m2};
  return world::spread_mass(entry.parts, entry.mass_kg, entry.part_masses_kg);
}

sim::ObjectDescription simulated_object(const ObjectEntry& entry, const sim::Mount& mount) {
  const world::MassProperties mass = mass_of(entry);
  sim::ObjectDescription object;
  object.name = entry.name;
  object.pointer = object_pointer(entry);
  object.mount = mount;
  object.free = !entry.fixed;
  object.mass = entry.mass_kg;
  object.contact = surface_of(entry);
  object.lit_by = entry.lit_by;
  for (std::size_t i = 0; i < entry.parts.size(); ++i) {
    const world::Object::Part& part = entry.parts[i];
    object.shapes.push_back({.shape = simulated_shape(part.shape), .X_OG = part.X_OS, .rgba = entry.rgba});
    sim::ObjectGeometry& shape = object.shapes.back();
    shape.chamfer = part.chamfer;
    shape.bores = part.bores;
    shape.pointer = entry.part_pointers[i];
    if (i < entry.part_masses_kg.size()) shape.mass = entry.part_masses_kg[i];
  }
  object.screw = simulated_screw(entry);
  const auto is_cut = [](const world::Object::Part& part) { return part.chamfer > 0.0 || !part.bores.empty(); };
  // MuJoCo knows its own shapes only: it would spread the mass over bores, too.
  if (entry.inertia_kg_m2 || (!entry.fixed && std::ranges::any_of(entry.parts, is_cut))) {
    kinematics::Inertial& inertial = object.inertial.emplace();
    inertial.mass = mass.mass;
    inertial.X_LC.translation() = mass.p_OC;
    inertial.I_C = mass.I_C;
  }
  return object;
}

/// What the application knows of an object that has no model.
world::Object known_object(const ObjectEntry& entry) {
  world::Object known{.name = entry.name, .parts = entry.parts, .grasps = entry.grasps, .fixed = entry.fixed};
  if (!entry.fixed) known.mass = mass_of(entry);
  return known;
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
bool add_model_object(const ObjectEntry& entry, const device::ModelLibrary& models, const sim::Mount& mount,
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
                      "Add <inertial> to the URDF, or set \"fixed\": true");
  }
  if (const auto& inertial = model->root().inertial; inertial && !entry.fixed)
    known.mass = world::transform(inertial->X_LC, {inertial->mass, Eigen::Vector3d::Zero(), inertial->I_C});
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
  robot.mount = mount;
  robot.contact = surface_of(entry);
  if (entry.material.empty()) robot.contact.material = model_material(*folder, diagnostics);
  robot.lit_by = entry.lit_by;
  robot.free = !entry.fixed;
  world.robots.push_back(std::move(robot));
  return true;
}

sim::CameraDescription simulated_camera(const CameraEntry& entry, const Ground& ground, Diagnostics& diagnostics) {
  const std::string pointer = "/cameras" + pointer_segment(entry.name);
  sim::CameraDescription camera;
  camera.name = entry.name;
  camera.pointer = pointer;
  camera.vertical_field_of_view = entry.fovy_deg * kDegree;
  const auto pose_of = [&](const Placement& at, const char* key) {
    const auto X_WI = ground.frames.truth.pose(at.in);
    if (!X_WI) diagnostics.append(X_WI.error(), pointer + key);
    return Eigen::Isometry3d(X_WI.value_or(Eigen::Isometry3d::Identity()) * at.X);
  };
  Eigen::Isometry3d X_WC = pose_of(entry.at, "/at/in");
  if (entry.look_at) X_WC = sim::look_at(X_WC.translation(), pose_of(*entry.look_at, "/look_at/in").translation());
  camera.mount = mount_in(entry.at.in, X_WC, ground);
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

/// Tool sides with all that is mounted on them: objects that tool changers carry.
void add_tool_sides(LoadedDevices devices, const sim::WorldDescription& simulated, const CellFrames& frames,
                    BuiltCell& built) {
  for (const auto& device : devices) {
    const auto side = device->as<device::ToolSideDescription>();
    if (!side) continue;
    const std::string& name = device->entry->name;
    const device::PayloadSetting whole = device::combine(device::rigid_payload(*side->robot),
                                                         sim::nominal_payload(simulated, name, side->coupling_link));
    world::Object& known = built.cell.objects[name];
    known.name = name;
    known.mass = {whole.mass, whole.p_FC, whole.I_C};
    known.fixed = false;
    built.truth_W[name] = frames.truth.pose(name).value_or(Eigen::Isometry3d::Identity());
    built.true_body[name] = name + "/" + side->coupling_link;
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

void check_force_sensor(const FilmEntry& film, const command::Cell& cell, Diagnostics& diagnostics) {
  if (film.force_sensor.empty() || cell.sensors.contains(film.force_sensor)) return;
  std::vector<std::string> names;
  for (const auto& [name, sensor] : cell.sensors) names.push_back(name);
  diagnostics.error(Code::kUnknownName, "/film/force_sensor",
                    fmt::format("there is no force/torque sensor '{}'", film.force_sensor),
                    nearest_choice(film.force_sensor, names));
}

}  // namespace

Result<BuiltCell> build_cell(const Description& file, const device::ModelLibrary& models, bool measure_times,
                             Diagnostics& warnings) {
  Diagnostics diagnostics;
  const Description description = with_threads(file, models, diagnostics);
  const auto devices = load_devices(description, models, diagnostics);
  CellFrames frames(description, devices, diagnostics);
  const Ground ground{frames, devices, description};

  sim::WorldDescription simulated;
  simulated.seed = description.seed;
  simulated.physics.plant_mass_scale = description.plant_mass_scale;
  simulated.physics.timestep = description.physics_step;
  for (const auto& device : devices) simulate(*device, frames.truth, simulated, diagnostics);
  BuiltCell built;
  built.library = models;
  // Of a period of 1 ms half is for the nets; the rest is for the devices, for who looks between cycles, and spare.
  constexpr Nanoseconds kNetBudget = 500'000;
  const rcc::ControlCore::Options options{
      .measure = measure_times, .budget = description.realtime ? kNetBudget : 0, .separate = description.site.separate};
  built.commands = std::make_shared<CommandTape>();
  built.site = std::make_shared<SiteDevices>(description.site, options.period, description.seed);
  built.site->plan(devices, diagnostics);
  for (const ObjectEntry& entry : description.objects) {
    const Eigen::Isometry3d X_WO = frames.truth.pose(entry.name).value_or(Eigen::Isometry3d::Identity());
    world::Object known = known_object(entry);
    // One that is free lies there; it is not fixed to what carries it.
    const sim::Mount mount = entry.fixed ? mount_in(entry.at.in, X_WO, ground) : sim::Mount{"", X_WO};
    if (entry.model.empty()) {
      simulated.objects.push_back(simulated_object(entry, mount));
    } else if (!add_model_object(entry, models, mount, simulated, known, diagnostics)) {
      continue;
    }
    built.truth_W[entry.name] = X_WO;
    if (!entry.model.empty() && !entry.fixed)
      built.true_body[entry.name] = entry.name + "/" + simulated.robots.back().model->root().name;
    built.cell.objects[entry.name] = std::move(known);
  }
  add_tool_sides(devices, simulated, frames, built);
  complete_surfaces(description, models, simulated, diagnostics);
  for (const FrameEntry& frame : description.frames)
    if (const auto X_WF = frames.truth.pose(frame.name))
      built.frames_on[frame.name] = mount_in(frame.name, *X_WF, ground);
  built.beams = simulated.beams;
  for (const CameraEntry& camera : description.cameras) {
    simulated.cameras.push_back(simulated_camera(camera, ground, diagnostics));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  auto world = sim::World::create(simulated, [](mjSpec_& spec) { sim::add_scene_props(&spec, {}); });
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
  built.cell.frames = std::move(frames.believed);
  built.start = std::move(frames.truth);
  for (const bool last : {false, true})
    for (const auto& device : devices)
      if (built.site->wired_last(device->entry->name) == last) device->kind->add(*device, devices, built);
  add_tools(devices, built.cell, diagnostics);
  activity::update_flange_frames(built.cell);
  diagnostics.append(built.site->problems());
  check_own_forces(devices, description.site, diagnostics);
  check_force_sensor(description.film, built.cell, diagnostics);
  diagnostics.append(activity::declare_channels(*built.core, built.cell));
  add_composed(description, built, diagnostics);
  add_emergency_stop(description.faults, built, diagnostics);
  set_tools(simulated, built, diagnostics);
  command::tell_tool_settings(built.cell);  // of arms that have a tool coupled
  built.cell.shapes = cell_shapes(description, simulated, built.cell, diagnostics);
  // No device has such a name.
  built.cell.solids = &built.core->add("cell/solids", std::make_unique<primitives::CellSolids>(built.cell.shapes));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  built.site->add_to(built.core->digest());
  for (const NetEntry& net : description.nets) built.cell.nets[net.name] = net.net;
  warnings.append(diagnostics);
  return built;
}

Diagnostics check_cell_names(const Description& file, const device::ModelLibrary& models) {
  Diagnostics diagnostics;
  const Description description = with_threads(file, models, diagnostics);
  const auto devices = load_devices(description, models, diagnostics);
  (void)CellFrames(description, devices, diagnostics);
  return diagnostics;
}

namespace {

void add_tool_name(const DeviceEntry& device, const DeviceKind& kind, const device::ModelDescription& model,
                   command::Cell& cell) {
  const auto own = kind.tcp(model);
  if (!own && device.tcps.empty()) return;
  command::MountedTool& tool = cell.tools[device.name];
  tool.X_FT = device.tcps;
  if (own) tool.X_FT.try_emplace(std::string(command::MountedTool::kOwnTcp), *own);
}

/// Name of the arm that a device is mounted on, through whatever is between; empty: on none.
std::string arm_below(const Description& description, const DeviceEntry& device, const command::Cell& cell) {
  const DeviceEntry* one = &device;
  for (std::size_t steps = 0; steps < description.devices.size() && !one->on.empty(); ++steps) {
    if (cell.arms.contains(one->on)) return one->on;
    const auto below = std::ranges::find(description.devices, one->on, &DeviceEntry::name);
    if (below == description.devices.end()) break;
    one = &*below;
  }
  return {};
}

void note_carrier(const Description& description, const DeviceEntry& device, command::Cell& cell) {
  const std::string arm = arm_below(description, device, cell);
  if (const auto tool = cell.tools.find(device.name); tool != cell.tools.end()) tool->second.arm = arm;
  if (const auto gripper = cell.grippers.find(device.name); gripper != cell.grippers.end()) gripper->second.arm = arm;
  if (const auto sensor = cell.sensors.find(device.name); sensor != cell.sensors.end()) sensor->second.arm = arm;
  if (const auto changer = cell.changers.find(device.name); changer != cell.changers.end()) changer->second.arm = arm;
}

}  // namespace

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
