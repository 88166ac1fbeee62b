#include "sim/plain/plain_model.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/base/xml_text.h"
#include "core/kinematics/chain.h"
#include "sim/model/mujoco_errors.h"
#include "sim/plain/mjcf_text.h"
#include "sim/world/model_compiler.h"
#include "sim/world/spec_builder.h"
#include "sim/world/stage.h"
#include "sim/world/world.h"

namespace takt::sim {
namespace {

constexpr int kSolidGroup = 3;            ///< what collides and is not seen
constexpr double kDefaultFrequency = 60;  ///< rad/s, of an arm's controller (ArmControlParameters)
constexpr double kFingerFrequency = 60;   ///< rad/s, of the servo of a gripper
constexpr double kOverlap = 1e-3;         ///< m: bodies that overlap more at the start belong into each other

std::string name_of(mjsElement* element) {
  const char* name = mjs_getString(mjs_getName(element));
  return name != nullptr ? name : "";
}

std::vector<mjsElement*> all_of(mjSpec& spec, mjtObj type) {
  std::vector<mjsElement*> found;
  for (mjsElement* at = mjs_firstElement(&spec, type); at != nullptr; at = mjs_nextElement(&spec, at))
    found.push_back(at);
  return found;
}

/// "a, b and 3 more".
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 8;
  const std::size_t shown = std::min(names.size(), kMost);
  std::string text =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
  return names.size() > shown ? fmt::format("{} and {} more", text, names.size() - shown) : text;
}

/// Changes the specification of the pictures into one that runs on its own.
class Plain {
 public:
  Plain(const WorldDescription& world, const World& start, const PlainOptions& options, mjSpec& spec)
      : world_(world), start_(start), options_(options), spec_(spec) {}

  Result<PlainModel> make() {
    set_options();
    restore_solids();
    loosen();
    for (const auto& [name, mount] : options_.frames) add_site(name, mount);
    auto placed = place();
    if (!placed) return std::unexpected(placed.error());
    support_arms(placed->model.get());
    for (const auto& arm : world_.arms)
      if (auto added = add_servos(arm, *placed); !added) return std::unexpected(added.error());
    for (const auto& gripper : world_.grippers) add_servo(gripper, *placed);
    exclude_overlaps(*placed);
    add_key(*placed);
    return write();
  }

 private:
  struct Placed {
    Owned<mjModel_> model;
    Owned<mjData_> data;
  };

  void set_options() {
    mjOption& option = spec_.option;
    option.integrator = mjINT_IMPLICITFAST;  // servos are stiff
    option.jacobian = mjJAC_AUTO;
    option.iterations = 100;
    option.tolerance = 1e-8;
    option.disableflags &= ~(mjDSBL_AUTORESET | mjDSBL_ISLAND);
    mjs_setString(spec_.modelname, options_.name.c_str());
    mjs_setString(spec_.compiler.meshdir, "assets");
    spec_.compiler.usethread = 0;
    // The wires of our lamps.
    spec_.nuserdata = spec_.nuser_geom = 0;
    for (mjsElement* geom : all_of(spec_, mjOBJ_GEOM)) mjs_setDouble(mjs_asGeom(geom)->userdata, nullptr, 0);
  }

  /// Shapes with chamfers and bores are meshes without contact in pictures: the solids of the physics are put beside
  /// them, with their mass.
  void restore_solids() {
    const Owned<mjSpec_> physics(mj_makeSpec());
    build_spec(world_, false, *physics);
    for (mjsElement* element : all_of(*physics, mjOBJ_GEOM)) {
      const std::string name = name_of(element);
      const mjsGeom& solid = *mjs_asGeom(element);
      mjsElement* seen_element = name.empty() ? nullptr : mjs_findElement(&spec_, mjOBJ_GEOM, name.c_str());
      mjsGeom* seen = seen_element != nullptr ? mjs_asGeom(seen_element) : nullptr;
      if (seen == nullptr || seen->type == solid.type) continue;
      mjsGeom& made = *mjs_addGeom(mjs_getParent(seen_element), nullptr);
      mjs_setName(made.element, (name + "/solid").c_str());
      made.type = solid.type;
      std::copy_n(solid.size, 3, made.size);
      std::copy_n(solid.pos, 3, made.pos);
      std::copy_n(solid.quat, 4, made.quat);
      std::copy_n(solid.friction, 3, made.friction);
      made.contype = solid.contype;
      made.conaffinity = solid.conaffinity;
      made.condim = solid.condim;
      made.mass = std::exchange(seen->mass, 0.0);
      made.group = kSolidGroup;
      shaped_.push_back(name);
    }
  }

  /// Constraints whose rows our laws set: springs of joints become MuJoCo's, welds that hold at the start stay.
  void loosen() {
    for (const RobotDescription& robot : world_.robots) {
      for (const JointFigures& figures : robot.joints) {
        if (!figures.spring) continue;
        const std::string name = robot.name + "/" + figures.joint;
        if (mjsElement* law = mjs_findElement(&spec_, mjOBJ_EQUALITY, name.c_str())) mjs_delete(&spec_, law);
        mjsJoint& joint = *mjs_asJoint(mjs_findElement(&spec_, mjOBJ_JOINT, name.c_str()));
        joint.stiffness[0] = figures.spring->stiffness;
        joint.damping[0] = figures.spring->damping;
      }
    }
    const mjModel& model = *start_.physics_model();
    for (mjsElement* element : all_of(spec_, mjOBJ_EQUALITY)) {
      mjsEquality& weld = *mjs_asEquality(element);
      if (weld.type != mjEQ_WELD) continue;
      const int id = mj_name2id(&model, mjOBJ_EQUALITY, name_of(element).c_str());
      if (id < 0 || start_.physics_data()->eq_active[id] == 0) {
        mjs_delete(&spec_, element);
        continue;
      }
      weld.active = 1;
      std::copy_n(model.eq_data + mjNEQDATA * id, mjNEQDATA, weld.data);
    }
  }

  void add_site(const std::string& name, const Mount& mount) {
    mjsBody* body = mjs_findBody(&spec_, mount.parent.empty() ? "world" : mount.parent.c_str());
    if (body == nullptr) return;
    mjsSite& site = *mjs_addSite(body, nullptr);
    mjs_setName(site.element, ("frame/" + name).c_str());
    const Eigen::Quaterniond q(mount.X_P.linear());
    const double quaternion[4] = {q.w(), q.x(), q.y(), q.z()};
    std::copy_n(mount.X_P.translation().data(), 3, site.pos);
    std::copy_n(quaternion, 4, site.quat);
    site.size[0] = 0.005;
    site.group = 4;  // seen when it is asked for
  }

  [[nodiscard]] std::unexpected<Diagnostics> refused() const {
    return failure(Code::kSystem, "", fmt::format("MuJoCo cannot build the plain model: {}", mjs_getError(&spec_)));
  }

  /// Compiled, and everything where it is at the start.
  Result<Placed> place() {
    Placed placed;
    const auto done = mujoco_call("", [&] {
      placed.model.reset(mj_compile(&spec_, nullptr));
      if (!placed.model) return;
      placed.data.reset(mj_makeData(placed.model.get()));
      std::ranges::copy(start_.positions(), placed.data->qpos);
      mj_forward(placed.model.get(), placed.data.get());
    });
    if (!done) return std::unexpected(done.error());
    if (!placed.model) return refused();
    return placed;
  }

  /// Arms carry themselves and what is mounted on them.
  void support_arms(const mjModel* model) {
    std::vector<bool> carried(static_cast<std::size_t>(model->nbody));
    for (int body = 1; body < model->nbody; ++body) {
      const char* name = mj_id2name(model, mjOBJ_BODY, body);
      const std::string owner = name != nullptr ? std::string(name).substr(0, std::string(name).find('/')) : "";
      const bool of_arm = std::ranges::find(world_.arms, owner, &SimArmDescription::robot) != world_.arms.end();
      const auto i = static_cast<std::size_t>(body);
      carried[i] = of_arm || carried[static_cast<std::size_t>(model->body_parentid[body])];
      if (carried[i] && name != nullptr) mjs_findBody(&spec_, name)->gravcomp = 1.0;
    }
  }

  /// A servo that holds a joint where it is at the start.
  /// @param inertia  that it moves, kg m^2 or kg
  void add_servo(const std::string& joint, double inertia, double frequency, double damping_ratio, double most,
                 const Placed& placed) {
    const int id = mj_name2id(placed.model.get(), mjOBJ_JOINT, joint.c_str());
    if (id < 0) return;
    mjsActuator& servo = *mjs_addActuator(&spec_, nullptr);
    mjs_setName(servo.element, joint.c_str());
    servo.trntype = mjTRN_JOINT;
    mjs_setString(servo.target, joint.c_str());
    double kv = 2.0 * damping_ratio * frequency * inertia;
    mjs_setToPosition(&servo, inertia * frequency * frequency, &kv, nullptr, nullptr, 0.0);
    if (placed.model->jnt_limited[id] != 0) {
      servo.ctrllimited = mjLIMITED_TRUE;
      std::copy_n(placed.model->jnt_range + 2 * id, 2, servo.ctrlrange);
    }
    if (std::isfinite(most) && most > 0.0) {
      servo.forcelimited = mjLIMITED_TRUE;
      servo.forcerange[0] = -most;
      servo.forcerange[1] = most;
    }
    control_.push_back(placed.data->qpos[placed.model->jnt_qposadr[id]]);
  }

  Result<void> add_servos(const SimArmDescription& arm, const Placed& placed) {
    const auto& robot = *std::ranges::find(world_.robots, arm.robot, &RobotDescription::name);
    std::vector<std::string> rolling = arm.drive ? arm.drive->wheels : std::vector<std::string>();
    const auto chain = kinematics::Chain::create(*robot.model, arm.base_link, arm.flange_link, rolling);
    if (!chain) return std::unexpected(chain.error());
    const int nv = placed.model->nv;
    Eigen::MatrixXd M(nv, nv);
    mj_fullM(placed.model.get(), placed.data.get(), M.data());
    for (int i = 0; i < chain->joint_count(); ++i) {
      const std::string joint = arm.robot + "/" + chain->joint_names()[static_cast<std::size_t>(i)];
      const int id = mj_name2id(placed.model.get(), mjOBJ_JOINT, joint.c_str());
      const int dof = placed.model->jnt_dofadr[id];
      const auto of = [i](const JointVector& values, double otherwise) {
        return values.size() > i ? values[i] : otherwise;
      };
      add_servo(joint, M(dof, dof), of(arm.control.natural_frequency, kDefaultFrequency),
                of(arm.control.damping_ratio, 1.0), chain->effort_limit()[i], placed);
    }
    return {};
  }

  void add_servo(const SimGripperDescription& gripper, const Placed& placed) {
    // One drive moves both fingers, which an equality couples.
    add_servo(gripper.robot + "/" + gripper.fingers[0], 2.0 * (gripper.finger_mass + gripper.finger_inertia),
              kFingerFrequency, 1.0, gripper.force_max, placed);
  }

  /// A screw in its bore, a part in its hole: solids without holes would burst apart.
  void exclude_overlaps(const Placed& placed) {
    std::set<std::pair<int, int>> pairs;
    for (int i = 0; i < placed.data->ncon; ++i) {
      const mjContact& contact = placed.data->contact[i];
      if (contact.dist > -kOverlap) continue;
      const int a = placed.model->geom_bodyid[contact.geom[0]], b = placed.model->geom_bodyid[contact.geom[1]];
      pairs.emplace(std::min(a, b), std::max(a, b));
    }
    for (const auto& [a, b] : pairs) {
      const char *first = mj_id2name(placed.model.get(), mjOBJ_BODY, a),
                 *second = mj_id2name(placed.model.get(), mjOBJ_BODY, b);
      if (first == nullptr || second == nullptr) continue;
      mjsExclude* exclude = mjs_addExclude(&spec_);
      mjs_setString(exclude->bodyname1, first);
      mjs_setString(exclude->bodyname2, second);
      overlaps_.push_back(fmt::format("{} with {}", first, second));
    }
  }

  void add_key(const Placed& placed) {
    mjsKey& key = *mjs_addKey(&spec_);
    mjs_setName(key.element, "start");
    mjs_setDouble(key.qpos, placed.data->qpos, placed.model->nq);
    mjs_setDouble(key.ctrl, control_.data(), static_cast<int>(control_.size()));
  }

  [[nodiscard]] std::vector<std::string> lacks() const {
    std::vector<std::string> text = {
        "Controllers: each joint of an arm and each gripper has a position servo of about the same stiffness; "
        "impedance, force control, limits, guard and brakes are not there. Gravity on arms is compensated (gravcomp).",
        "The contact law: stiffness and damping are MuJoCo's own; friction is that of each surface, not of the pair.",
        "Noise, delay and resolution of sensors; friction of the drives of arms; the program; faults."};
    const auto add = [&](const char* what, const std::vector<std::string>& names) {
      if (!names.empty()) text.push_back(fmt::format("{}: {}.", what, listed(names)));
    };
    std::vector<std::string> screws, changers, signals, others, wheels;
    for (const auto& object : world_.objects)
      if (object.screw) screws.push_back(object.name);
    for (const auto& changer : world_.tool_changers) changers.push_back(changer.name);
    for (const auto& one : world_.outputs) signals.push_back(one.name);
    for (const auto& one : world_.inputs) signals.push_back(one.name);
    for (const auto& one : world_.beams) signals.push_back(one.name);
    for (const auto& one : world_.devices) others.push_back(one.name);
    for (const auto& arm : world_.arms)
      if (arm.drive) wheels.push_back(arm.name);
    add("Threads", screws);
    add("Bores and chamfers, which are seen and do not collide: a solid without them does", shaped_);
    add("Bodies that overlap at the start, and do not collide therefore", overlaps_);
    add("Locks of tool changers, but for what hangs on them at the start", changers);
    add("Inputs, outputs and beams", signals);
    add("Devices of their own", others);
    add("Wheels, which turn freely: servos move the base", wheels);
    return text;
  }

  static std::string comment(const std::vector<std::string>& lines) {
    std::string text = "<!-- Written by takt export. What this model has not, and the cell has:\n";
    for (std::string line : lines) {
      // No two hyphens in a comment.
      for (std::size_t at = 0; (at = line.find("--", at)) != std::string::npos;) line.replace(at, 2, "- -");
      text += "     - " + line + "\n";
    }
    return text + "-->\n";
  }

  Result<PlainModel> write() {
    auto last = place();
    if (!last) return std::unexpected(last.error());
    auto text = mjcf_text(spec_);
    if (!text) return std::unexpected(text.error());
    PlainModel made;
    made.lacks = lacks();
    std::map<std::string, std::string> names;  // by file
    for (mjsElement* element : all_of(spec_, mjOBJ_MESH)) {
      const std::filesystem::path file = mjs_getString(mjs_asMesh(element)->file);
      if (file.empty() || names.contains(file.string())) continue;
      std::string name = file.filename().string();
      for (int k = 2; made.assets.contains(name); ++k)
        name = fmt::format("{}_{}{}", file.stem().string(), k, file.extension().string());
      made.assets.emplace(name, file);
      names.emplace(file.string(), name);
    }
    for (const auto& [file, name] : names) {
      const std::string before = fmt::format("file=\"{}\"", xml_text(file)), after = fmt::format("file=\"{}\"", name);
      for (std::size_t at = 0; (at = text->find(before, at)) != std::string::npos; at += after.size())
        text->replace(at, before.size(), after);
    }
    made.mjcf = comment(made.lacks) + *text;
    return made;
  }

  const WorldDescription& world_;
  const World& start_;
  const PlainOptions& options_;
  mjSpec& spec_;
  std::vector<double> control_;
  std::vector<std::string> shaped_, overlaps_;
};

}  // namespace

Result<PlainModel> plain_model(const WorldDescription& description, const PlainOptions& options) {
  install_mujoco_handlers();
  const auto start = World::create(description, [](mjSpec_& spec) { add_scene_props(&spec, {}); });
  if (!start) return std::unexpected(start.error());
  const Owned<mjSpec_> spec(mj_makeSpec());
  build_spec(description, true, *spec);
  for (const SimDeviceDescription& device : description.devices)
    if (device.extend) device.extend(*spec);
  add_scene_props(spec.get(), {});
  return Plain(description, *start, options, *spec).make();
}

}  // namespace takt::sim
