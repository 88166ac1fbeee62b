#include "sim/world/spec_builder.h"

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/contact/solid_mesh.h"
#include "sim/machines/tool_changer.h"
#include "sim/model/description_check.h"
#include "sim/model/solids.h"

namespace takt::sim {
namespace {

using kinematics::Geometry;
using kinematics::Joint;
using kinematics::JointType;
using kinematics::Link;

constexpr int kObjectGroup = 1;
constexpr int kVisualGroup = 2;
constexpr int kCollisionGroup = 3;
/// The material of a URDF that burns in a robot that is a lamp.
constexpr const char* kLightMaterial = "light";

// Contact bits: objects have bit 0; each assembly (a robot on the world with all that is mounted on it) has a bit of
// its own, so that it can be told not to touch itself. Past 30 assemblies share bits.
constexpr int kObjectBit = 1;
constexpr int kAllBits = 0x7fffffff;
constexpr int kAssemblyBits = 30;

struct ContactBits {
  int type = kObjectBit;
  int affinity = kAllBits;
};

template <class Element>
void set_pose(Element& element, const Pose& X) {
  const Eigen::Quaterniond r(X.linear());
  const std::array<double, 4> quaternion = {r.w(), r.x(), r.y(), r.z()};
  std::copy(quaternion.begin(), quaternion.end(), element.quat);
  std::copy_n(X.translation().data(), 3, element.pos);
}

void set_rgba(float (&target)[4], const Eigen::Vector4d& rgba) {
  for (int i = 0; i < 4; ++i) target[i] = static_cast<float>(rgba[i]);
}

/// Stiffness, damping and friction come from the contact law in each step; here is only what it starts from.
void set_contact(mjsGeom& geom, const ContactParameters& c, const ContactBits& bits) {
  geom.contype = bits.type;
  geom.conaffinity = bits.affinity;
  geom.condim = c.rolling > 0.0 ? 6 : c.torsion > 0.0 ? 4 : 3;
  geom.friction[0] = c.friction;
  geom.friction[1] = c.torsion * c.friction;
  geom.friction[2] = c.rolling * c.friction;
}

double volume(const ObjectShape& shape) {
  constexpr double pi = std::numbers::pi;
  struct {
    double operator()(const kinematics::Box& s) const { return s.size.prod(); }
    double operator()(const kinematics::Cylinder& s) const { return pi * s.radius * s.radius * s.length; }
    double operator()(const kinematics::Sphere& s) const { return 4.0 / 3.0 * pi * s.radius * s.radius * s.radius; }
    double operator()(const Capsule& s) const { return pi * s.radius * s.radius * (s.length + 4.0 / 3.0 * s.radius); }
    double operator()(const kinematics::Mesh&) const { return 1.0; }  // alone in its object if that is free
  } of;
  return std::visit(of, shape);
}

/// Builds the tree of bodies, each part with what is mounted on it.
class Builder {
 public:
  Builder(const WorldDescription& description, bool visuals, mjSpec& spec)
      : world_(description), visuals_(visuals), spec_(spec) {
    for (std::size_t i = 0; i < world_.robots.size(); ++i) robots_on_[world_.robots[i].mount.parent].push_back(i);
    for (std::size_t i = 0; i < world_.objects.size(); ++i) objects_on_[world_.objects[i].mount.parent].push_back(i);
    for (const auto& arm : world_.arms) driven_.insert(arm.robot);
    if (visuals_) lamps_ = lamp_wires(world_);
  }

  void build() {
    set_options();
    mjsBody* root = mjs_findBody(&spec_, "world");
    mount_on("", root, {}, true);
    for (const auto& camera : world_.cameras) add(camera);
    for (const auto& sensor : world_.force_torque_sensors) add_wrench(sensor.name, sensor.tool_side, sensor.X_LS);
    for (const auto& arm : world_.arms) add_support(arm);
    for (const auto& gripper : world_.grippers) couple(gripper);
    for (const auto& changer : world_.tool_changers) add_locks(changer);
  }

 private:
  void set_options() {
    const Physics& p = world_.physics;
    mjOption& option = spec_.option;
    option.timestep = to_seconds(p.timestep);
    std::copy_n(p.gravity.data(), 3, option.gravity);
    switch (p.integrator) {
      case Integrator::kEuler:
        option.integrator = mjINT_EULER;
        break;
      case Integrator::kImplicitFast:
        option.integrator = mjINT_IMPLICITFAST;
        break;
      case Integrator::kRungeKutta4:
        option.integrator = mjINT_RK4;
        break;
    }
    option.cone = mjCONE_ELLIPTIC;
    option.solver = mjSOL_NEWTON;
    option.jacobian = mjJAC_DENSE;  // until it is known how many bodies there are
    if (!p.islands) option.disableflags |= mjDSBL_ISLAND;
    option.iterations = p.solver_iterations;
    option.tolerance = p.solver_tolerance;
    // A diverged simulation must be seen, not restarted in silence.
    option.disableflags |= mjDSBL_AUTORESET;
    spec_.compiler.degree = 0;
    spec_.compiler.fusestatic = 0;
    spec_.compiler.inertiafromgeom = mjINERTIAFROMGEOM_AUTO;
    if (lamps_.empty()) return;
    spec_.nuserdata = static_cast<int>(lamps_.size());
    spec_.nuser_geom = 1;
  }

  /// @param moving_root  whether the parent is the world itself: each robot on it begins a new assembly
  void mount_on(const std::string& parent, mjsBody* body, const ContactBits& bits, bool on_world) {
    for (const std::size_t i : robots_on_[parent]) add(world_.robots[i], body, on_world ? new_assembly(i) : bits);
    for (const std::size_t i : objects_on_[parent]) {
      add(world_.objects[i], body, on_world ? ContactBits{} : bits);
    }
  }

  ContactBits new_assembly(std::size_t robot) {
    const int bit = kObjectBit << (1 + assemblies_++ % kAssemblyBits);
    return {bit, world_.robots[robot].self_collision ? kAllBits : kAllBits & ~bit};
  }

  void add(const RobotDescription& robot, mjsBody* parent, const ContactBits& bits) {
    std::map<std::string, mjsBody*> bodies;
    const auto& model = *robot.model;
    for (std::size_t i = 0; i < model.links.size(); ++i) {
      const Link& link = model.links[i];
      const Joint* joint = i == 0 ? nullptr : &model.joints[i - 1];
      mjsBody* body = mjs_addBody(joint ? bodies[joint->parent] : parent, nullptr);
      mjs_setName(body->element, (robot.name + "/" + link.name).c_str());
      set_pose(*body, joint ? joint->X_PJ : robot.mount.X_P);
      if (joint && joint->type != JointType::kFixed) add_joint(robot, *joint, body);
      if (i == 0 && robot.free) mjs_setName(mjs_addFreeJoint(body)->element, robot.name.c_str());
      if (link.inertial) set_inertia(*link.inertial, world_.physics.plant_mass_scale, *body);
      if (visuals_) {
        for (const Geometry& geometry : link.visuals) add_visual(robot, geometry, body);
      }
      for (std::size_t k = 0; k < link.collisions.size(); ++k) {
        mjsGeom* geom = add_collision(robot.surface(link.name), link.collisions[k], body, bits);
        if (robot.chamfers.contains(link.name))
          mjs_setName(geom->element, solid_name(robot.name + "/" + link.name, k).c_str());
      }
      if (robot.bits.contains(link.name))
        add_sleeping_weld(robot.name + "/" + link.name + "/drive", robot.name + "/" + link.name);
      bodies[link.name] = body;
    }
    exclude_neighbours_of_base(robot);
    for (const Link& link : model.links) mount_on(robot.name + "/" + link.name, bodies[link.name], bits, false);
  }

  void add_joint(const RobotDescription& robot, const Joint& joint, mjsBody* body) {
    mjsJoint* made = mjs_addJoint(body, nullptr);
    mjs_setName(made->element, (robot.name + "/" + joint.name).c_str());
    made->type = joint.type == JointType::kPrismatic ? mjJNT_SLIDE : mjJNT_HINGE;
    std::copy_n(joint.axis.data(), 3, made->axis);
    made->limited = joint.type == JointType::kContinuous ? mjLIMITED_FALSE : mjLIMITED_TRUE;
    if (made->limited == mjLIMITED_TRUE) {
      made->range[0] = joint.lower - robot.stop_margin;
      made->range[1] = joint.upper + robot.stop_margin;
    }
    const auto figures = std::ranges::find(robot.joints, joint.name, &JointFigures::joint);
    const bool known = figures != robot.joints.end();
    if (known && figures->spring) add_spring(joint, *made, robot.name + "/" + joint.name);
    made->armature = known ? figures->armature : 0.0;
    // The drive of an arm brings its own friction (sim/machines/joint_drive.h).
    if (driven_.contains(robot.name)) return;
    made->frictionloss = known ? figures->coulomb.value_or(joint.friction) : joint.friction;
    made->damping[0] = known ? figures->viscous.value_or(joint.damping) : joint.damping;
  }

  /// A constraint whose row the contact law sets: implicit, so that a light tip on a stiff spring is no trouble. The
  /// range is the spring's travel, with hard stops.
  void add_spring(const Joint& joint, mjsJoint& made, const std::string& name) {
    mjsEquality* spring = mjs_addEquality(&spec_, nullptr);
    mjs_setName(spring->element, name.c_str());
    spring->type = mjEQ_JOINT;
    mjs_setString(spring->name1, name.c_str());
    made.range[0] = joint.lower;
    made.range[1] = joint.upper;
    made.solref_limit[0] = 2.0 * to_seconds(world_.physics.timestep);
    made.solimp_limit[0] = 0.99;
    made.solimp_limit[1] = 0.999;
  }

  static void set_inertia(const kinematics::Inertial& inertial, double scale, mjsBody& body) {
    const Pose& X_LC = inertial.X_LC;
    const Eigen::Matrix3d I = X_LC.linear() * inertial.I_C * X_LC.linear().transpose() * scale;
    body.explicitinertial = 1;
    body.mass = inertial.mass * scale;
    std::copy_n(X_LC.translation().data(), 3, body.ipos);
    const std::array<double, 6> full = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
    std::copy(full.begin(), full.end(), body.fullinertia);
  }

  /// MuJoCo lets bodies fixed to the world touch their movable children: the base of an arm and its first link.
  void exclude_neighbours_of_base(const RobotDescription& robot) {
    const auto& model = *robot.model;
    const auto group = [&](std::string link) {  // the first link of those fixed to each other
      for (const Joint* above = model.joint_above(link); above && above->type == JointType::kFixed;
           above = model.joint_above(link)) {
        link = above->parent;
      }
      return link;
    };
    for (const Link& a : model.links) {
      for (const Link& b : model.links) {
        if (a.collisions.empty() || b.collisions.empty()) continue;
        const Joint* above = model.joint_above(group(b.name));
        if (!above || group(above->parent) != group(a.name)) continue;
        mjsExclude* exclude = mjs_addExclude(&spec_);
        mjs_setString(exclude->bodyname1, (robot.name + "/" + a.name).c_str());
        mjs_setString(exclude->bodyname2, (robot.name + "/" + b.name).c_str());
      }
    }
  }

  mjsGeom* add_geom(mjsBody* body, const ObjectShape& shape, const Pose& X, bool exact_mesh) {
    mjsGeom* geom = mjs_addGeom(body, nullptr);
    set_pose(*geom, X);
    geom->mass = 0.0;
    if (const auto* box = std::get_if<kinematics::Box>(&shape)) {
      geom->type = mjGEOM_BOX;
      for (int i = 0; i < 3; ++i) geom->size[i] = 0.5 * box->size[i];
    } else if (const auto* cylinder = std::get_if<kinematics::Cylinder>(&shape)) {
      geom->type = mjGEOM_CYLINDER;
      geom->size[0] = cylinder->radius;
      geom->size[1] = 0.5 * cylinder->length;
    } else if (const auto* sphere = std::get_if<kinematics::Sphere>(&shape)) {
      geom->type = mjGEOM_SPHERE;
      geom->size[0] = sphere->radius;
    } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
      geom->type = mjGEOM_CAPSULE;
      geom->size[0] = capsule->radius;
      geom->size[1] = 0.5 * capsule->length;
    } else {
      geom->type = mjGEOM_MESH;
      mjs_setString(geom->meshname, mesh_name(std::get<kinematics::Mesh>(shape), exact_mesh).c_str());
    }
    return geom;
  }

  /// Chamfers and bores: the physics finds the geom by its name, pictures have the shape as it is.
  void shape_further(const ObjectGeometry& part, const std::string& name, mjsGeom& geom) {
    mjs_setName(geom.element, name.c_str());
    if (!visuals_) return;
    const PictureMesh picture = picture_of(part.shape, make_solid(part.shape, part.chamfer, part.bores));
    mjsMesh* mesh = mjs_addMesh(&spec_, nullptr);
    mjs_setName(mesh->element, name.c_str());
    mjs_setFloat(mesh->uservert, picture.vertices.data(), static_cast<int>(picture.vertices.size()));
    mjs_setFloat(mesh->usernormal, picture.normals.data(), static_cast<int>(picture.normals.size()));
    mjs_setInt(mesh->userface, picture.corners.data(), static_cast<int>(picture.corners.size()));
    mjs_setInt(mesh->userfacenormal, picture.corners.data(), static_cast<int>(picture.corners.size()));
    mesh->inertia = mjMESH_INERTIA_SHELL;
    geom.type = mjGEOM_MESH;
    mjs_setString(geom.meshname, name.c_str());
  }

  mjsGeom* add_geom(mjsBody* body, const Geometry& geometry) {
    return std::visit([&](const auto& shape) { return add_geom(body, ObjectShape(shape), geometry.X_LG, false); },
                      geometry.shape);
  }

  /// Marks a shape that burns while there is something on the wire.
  void light(mjsGeom& geom, const std::string& wire) {
    const auto lamp = std::ranges::find(lamps_, wire);
    if (wire.empty() || lamp == lamps_.end()) return;
    const double number = 1.0 + static_cast<double>(lamp - lamps_.begin());
    mjs_setDouble(geom.userdata, &number, 1);
  }

  void add_visual(const RobotDescription& robot, const Geometry& geometry, mjsBody* body) {
    mjsGeom* geom = add_geom(body, geometry);
    geom->group = kVisualGroup;
    geom->contype = geom->conaffinity = 0;
    set_rgba(geom->rgba, geometry.rgba);
    if (!geometry.material.empty()) mjs_setString(geom->material, material_name(robot, geometry).c_str());
    if (geometry.material == kLightMaterial) light(*geom, robot.lit_by);
  }

  mjsGeom* add_collision(const ContactParameters& surface, const Geometry& geometry, mjsBody* body,
                         const ContactBits& bits) {
    mjsGeom* geom = add_geom(body, geometry);
    geom->group = kCollisionGroup;
    set_contact(*geom, surface, bits);
    return geom;
  }

  std::string material_name(const RobotDescription& robot, const Geometry& geometry) {
    std::string name = robot.name + "/" + geometry.material;
    if (materials_.insert(name).second) {
      mjsMaterial* material = mjs_addMaterial(&spec_, nullptr);
      mjs_setName(material->element, name.c_str());
      set_rgba(material->rgba, geometry.rgba);
    }
    return name;
  }

  /// One asset for each file and scale. Visual meshes may be open surfaces, so their inertia is that of a shell.
  std::string mesh_name(const kinematics::Mesh& mesh, bool exact) {
    const auto key = std::make_tuple(mesh.path.string(), mesh.scale.x(), mesh.scale.y(), mesh.scale.z(), exact);
    const auto [entry, fresh] = meshes_.emplace(key, fmt::format("{}#{}", mesh.path.stem().string(), meshes_.size()));
    if (fresh) {
      mjsMesh* asset = mjs_addMesh(&spec_, nullptr);
      mjs_setName(asset->element, entry->second.c_str());
      mjs_setString(asset->file, mesh.path.string().c_str());
      std::copy_n(mesh.scale.data(), 3, asset->scale);
      asset->inertia = exact ? mjMESH_INERTIA_EXACT : mjMESH_INERTIA_SHELL;
    }
    return entry->second;
  }

  void add(const ObjectDescription& object, mjsBody* parent, const ContactBits& bits) {
    mjsBody* body = mjs_addBody(parent, nullptr);
    mjs_setName(body->element, object.name.c_str());
    set_pose(*body, object.mount.X_P);
    if (object.free) mjs_setName(mjs_addFreeJoint(body)->element, object.name.c_str());
    if (object.inertial) set_inertia(*object.inertial, 1.0, *body);
    double whole = 0.0, weighed = 0.0;
    for (const auto& part : object.shapes) {
      whole += volume(part.shape);
      weighed += part.mass;
    }
    for (std::size_t i = 0; i < object.shapes.size(); ++i) {
      const ObjectGeometry& part = object.shapes[i];
      mjsGeom* geom = add_geom(body, part.shape, part.X_OG, true);
      const bool shaped = part.chamfer > 0.0 || !part.bores.empty() || (object.screw && object.screw->shank == i);
      if (shaped) shape_further(part, solid_name(object.name, i), *geom);
      geom->mass = weighed > 0.0 ? part.mass : object.mass * volume(part.shape) / whole;
      geom->group = part.visible ? kObjectGroup : kCollisionGroup;
      set_rgba(geom->rgba, part.rgba);
      if (!part.material.empty()) mjs_setString(geom->material, part.material.c_str());
      light(*geom, object.lit_by);
      set_contact(*geom, object.contact, part.solid && !(shaped && visuals_) ? bits : ContactBits{0, 0});
    }
    if (object.screw) add_sleeping_weld(object.name, object.name);
    mount_on(object.name, body, bits, false);
  }

  /// Six rows of a constraint, which the thread law fills while a screw is caught, and the drive law while a bit is in
  /// a socket.
  void add_sleeping_weld(const std::string& name, const std::string& body) {
    mjsEquality* weld = mjs_addEquality(&spec_, nullptr);
    mjs_setName(weld->element, name.c_str());
    weld->type = mjEQ_WELD;
    weld->objtype = mjOBJ_BODY;
    mjs_setString(weld->name1, body.c_str());
    mjs_setString(weld->name2, "world");
    weld->active = 0;
  }

  void add(const CameraDescription& camera) {
    const std::string parent = camera.mount.parent.empty() ? "world" : camera.mount.parent;
    mjsCamera* made = mjs_addCamera(mjs_findBody(&spec_, parent.c_str()), nullptr);
    mjs_setName(made->element, camera.name.c_str());
    set_pose(*made, camera.mount.X_P);
    made->fovy = camera.vertical_field_of_view * 180.0 / std::numbers::pi;
  }

  /// What the floor does to the wheels of a base: all that its joints carry.
  void add_support(const SimArmDescription& arm) {
    if (!arm.drive) return;
    const auto& robot = *std::ranges::find(world_.robots, arm.robot, &RobotDescription::name);
    std::string link = arm.flange_link;
    Pose X_LD = arm.drive->X_FD;
    auto joint = std::ranges::find(robot.model->joints, link, &Joint::child);
    for (; joint != robot.model->joints.end() && joint->type == JointType::kFixed;
         joint = std::ranges::find(robot.model->joints, link, &Joint::child)) {
      X_LD = joint->X_PJ * X_LD;
      link = joint->parent;
    }
    add_wrench(support_sensor(arm.name), robot.name + "/" + link, X_LD);
  }

  /// What the parent of a body does to it.
  void add_wrench(const std::string& name, const std::string& body, const Pose& X_LS) {
    mjsSite* site = mjs_addSite(mjs_findBody(&spec_, body.c_str()), nullptr);
    mjs_setName(site->element, name.c_str());
    set_pose(*site, X_LS);
    site->group = 5;  // never drawn
    for (const auto& [type, suffix] : {std::pair(mjSENS_FORCE, "/force"), std::pair(mjSENS_TORQUE, "/torque")}) {
      mjsSensor* made = mjs_addSensor(&spec_);
      mjs_setName(made->element, (name + suffix).c_str());
      made->type = type;
      made->objtype = mjOBJ_SITE;
      mjs_setString(made->objname, name.c_str());
    }
  }

  /// One drive moves both fingers.
  void couple(const SimGripperDescription& gripper) {
    mjsEquality* equal = mjs_addEquality(&spec_, nullptr);
    equal->type = mjEQ_JOINT;
    mjs_setString(equal->name1, (gripper.robot + "/" + gripper.fingers[0]).c_str());
    mjs_setString(equal->name2, (gripper.robot + "/" + gripper.fingers[1]).c_str());
    equal->data[1] = 1.0;
    // As stiff as the step carries: a rack and pinion does not give way.
    equal->solref[0] = 2.0 * to_seconds(world_.physics.timestep);
    equal->solimp[0] = 0.99;
    equal->solimp[1] = 0.999;
  }

  /// One for each tool side that fits: it holds while the changer has locked that one.
  void add_locks(const SimToolChangerDescription& changer) {
    for (const SimToolSideDescription& side : world_.tool_sides) {
      if (side.size != changer.size) continue;
      mjsEquality* lock = mjs_addEquality(&spec_, nullptr);
      mjs_setName(lock->element, lock_name(changer, side).c_str());
      lock->type = mjEQ_WELD;
      lock->objtype = mjOBJ_BODY;
      mjs_setString(lock->name1, changer.body.c_str());
      mjs_setString(lock->name2, side.body.c_str());
      lock->active = 0;
      std::ranges::fill(lock->data, 0.0);  // the defaults are those of other constraints
      lock->data[6] = 1.0;                 // the pose is set when it locks
      lock->data[10] = 1.0;                // torque for force
      // As stiff as the step carries: steel on steel.
      lock->solref[0] = 2.0 * to_seconds(world_.physics.timestep);
      lock->solimp[0] = 0.99;
      lock->solimp[1] = 0.999;
    }
  }

  const WorldDescription& world_;
  bool visuals_;
  mjSpec& spec_;
  std::map<std::string, std::vector<std::size_t>> robots_on_, objects_on_;  // by name of the parent body
  std::set<std::string> driven_, materials_;
  std::vector<std::string> lamps_;  // wires; only in pictures
  std::map<std::tuple<std::string, double, double, double, bool>, std::string> meshes_;
  int assemblies_ = 0;
};

}  // namespace

std::vector<std::string> lamp_wires(const WorldDescription& description) {
  std::vector<std::string> wires;
  const auto add = [&](const std::string& wire) {
    if (!wire.empty() && std::ranges::find(wires, wire) == wires.end()) wires.push_back(wire);
  };
  for (const RobotDescription& robot : description.robots) add(robot.lit_by);
  for (const ObjectDescription& object : description.objects) add(object.lit_by);
  return wires;
}

void build_spec(const WorldDescription& description, bool visuals, mjSpec& spec) {
  Builder(description, visuals, spec).build();
}

}  // namespace takt::sim
