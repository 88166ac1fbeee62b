#include "cell/build/simulated_cell.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_models.h"
#include "cell/file/degrees.h"
#include "cell/file/threaded_objects.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/device/material.h"
#include "core/device/plant_of_model.h"
#include "core/device/tool_changer.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/chain.h"
#include "sim/film/render_shapes.h"
#include "sim/machines/nominal_payload.h"

namespace takt::cell {
namespace {

std::string object_pointer(const ObjectEntry& object) { return "/objects" + pointer_segment(object.name); }

sim::Mount mount_of(const LoadedDevice& device, const world::FrameGraph& truth) {
  if (!device.on || device.as<device::ToolSideDescription>())
    return {"", truth.pose(device.entry->name).value_or(Eigen::Isometry3d::Identity())};
  const auto place = device.on->kind->mount_place(*device.on->model).value_or(MountPlace{});
  return {device.on->entry->name + "/" + place.link, place.X_LP * device.entry->true_mount};
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

void simulate_device(const LoadedDevice& device, const world::FrameGraph& truth, sim::WorldDescription& world,
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

/// The link of a device that carries the frame, or a body of a free object.
std::string body_of(const std::string& frame, const LoadedCell& loaded) {
  const auto& [description, devices, frames] = loaded;
  for (const std::string_view name : frames.believed.path_to_world(frame)) {
    const auto object = std::ranges::find(description.objects, name, &ObjectEntry::name);
    if (object != description.objects.end() && !object->fixed && object->model.empty()) return object->name;
    const world::Relation& relation = *frames.believed.relation(name);
    const auto device = std::ranges::find(devices, name, [](const auto& one) { return one->entry->name; });
    if (device != devices.end())
      if (const auto side = (*device)->as<device::ToolSideDescription>())
        return (*device)->entry->name + "/" + side->coupling_link;
    if (relation.kind == world::Relation::Kind::kLink) return expression::link_frame(relation.source, relation.link);
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
  return frames.contains(expression::flange_frame(owner)) ? expression::flange_frame(owner) : owner;
}

/// What is placed in a frame rides on whatever the frame rides on: a flange, a base, an object that moves; else it
/// stands in the world.
sim::Mount mount_in(const std::string& frame, const Eigen::Isometry3d& X_W, const LoadedCell& loaded) {
  const std::string body = body_of(loaded.frames.standing_frame(frame), loaded);
  if (body.empty()) return {"", X_W};
  const auto X_WP =
      loaded.frames.truth.pose(moving_frame(body, loaded.frames.truth)).value_or(Eigen::Isometry3d::Identity());
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

sim::CameraDescription simulated_camera(const CameraEntry& entry, const LoadedCell& loaded, Diagnostics& diagnostics) {
  const std::string pointer = "/cameras" + pointer_segment(entry.name);
  sim::CameraDescription camera;
  camera.name = entry.name;
  camera.pointer = pointer;
  camera.vertical_field_of_view = entry.fovy_deg * kDegree;
  const auto pose_of = [&](const Placement& at, const char* key) {
    const auto X_WI = loaded.frames.truth.pose(at.in);
    if (!X_WI) diagnostics.append(X_WI.error(), pointer + key);
    return Eigen::Isometry3d(X_WI.value_or(Eigen::Isometry3d::Identity()) * at.X);
  };
  Eigen::Isometry3d X_WC = pose_of(entry.at, "/at/in");
  if (entry.look_at) X_WC = sim::look_at(X_WC.translation(), pose_of(*entry.look_at, "/look_at/in").translation());
  camera.mount = mount_in(entry.at.in, X_WC, loaded);
  return camera;
}

void add_objects(const LoadedCell& loaded, const device::ModelLibrary& models, SimulatedCell& simulated,
                 Diagnostics& diagnostics) {
  for (const ObjectEntry& entry : loaded.description.objects) {
    const Eigen::Isometry3d X_WO = loaded.frames.truth.pose(entry.name).value_or(Eigen::Isometry3d::Identity());
    world::Object known = known_object(entry);
    // One that is free lies there; it is not fixed to what carries it.
    const sim::Mount mount = entry.fixed ? mount_in(entry.at.in, X_WO, loaded) : sim::Mount{"", X_WO};
    if (entry.model.empty()) {
      simulated.world.objects.push_back(simulated_object(entry, mount));
    } else if (!add_model_object(entry, models, mount, simulated.world, known, diagnostics)) {
      continue;
    }
    simulated.truth_W[entry.name] = X_WO;
    if (!entry.model.empty() && !entry.fixed)
      simulated.true_body[entry.name] = entry.name + "/" + simulated.world.robots.back().model->root().name;
    simulated.objects[entry.name] = std::move(known);
  }
}

/// Tool sides with all that is mounted on them: objects that tool changers carry.
void add_tool_sides(const LoadedCell& loaded, SimulatedCell& simulated) {
  for (const auto& device : loaded.devices) {
    const auto side = device->as<device::ToolSideDescription>();
    if (!side) continue;
    const std::string& name = device->entry->name;
    const device::PayloadSetting whole = device::combine(
        device::rigid_payload(*side->robot), sim::nominal_payload(simulated.world, name, side->coupling_link));
    world::Object& known = simulated.objects[name];
    known.name = name;
    known.mass = {whole.mass, whole.p_FC, whole.I_C};
    known.fixed = false;
    simulated.truth_W[name] = loaded.frames.truth.pose(name).value_or(Eigen::Isometry3d::Identity());
    simulated.true_body[name] = name + "/" + side->coupling_link;
  }
}

}  // namespace

LoadedCell::LoadedCell(const Description& file, const device::ModelLibrary& models, Diagnostics& diagnostics)
    : description(with_threads(file, models, diagnostics)),
      devices(load_devices(description, models, diagnostics)),
      frames(description, devices, diagnostics) {}

std::map<std::string, sim::Mount, std::less<>> mounted_frames(const LoadedCell& loaded) {
  std::map<std::string, sim::Mount, std::less<>> mounts;
  for (const std::string& name : loaded.frames.truth.names())
    if (const auto X_WF = loaded.frames.truth.pose(name); X_WF && name != world::FrameGraph::kWorld)
      mounts[name] = mount_in(name, *X_WF, loaded);
  return mounts;
}

SimulatedCell simulate(const LoadedCell& loaded, const device::ModelLibrary& models, Diagnostics& diagnostics) {
  const Description& description = loaded.description;
  SimulatedCell simulated;
  simulated.world.seed = description.seed;
  simulated.world.physics.plant_mass_scale = description.plant_mass_scale;
  simulated.world.physics.timestep = description.physics_step;
  for (const auto& device : loaded.devices) simulate_device(*device, loaded.frames.truth, simulated.world, diagnostics);
  add_objects(loaded, models, simulated, diagnostics);
  add_tool_sides(loaded, simulated);
  complete_surfaces(description, models, simulated.world, diagnostics);
  for (const FrameEntry& frame : description.frames)
    if (const auto X_WF = loaded.frames.truth.pose(frame.name))
      simulated.frames_on[frame.name] = mount_in(frame.name, *X_WF, loaded);
  for (const CameraEntry& camera : description.cameras)
    simulated.world.cameras.push_back(simulated_camera(camera, loaded, diagnostics));
  return simulated;
}

}  // namespace takt::cell
