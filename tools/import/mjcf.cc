// MuJoCo's compiled model as links and joints.
#include "tools/import/mjcf.h"

#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/model/mujoco_errors.h"
#include "tools/import/mjcf_notes.h"
#include "tools/import/mjcf_shapes.h"
#include "tools/import/mjcf_source.h"

namespace takt::tools {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Deleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using OwnedSpec = std::unique_ptr<mjSpec, Deleter>;
using OwnedModel = std::unique_ptr<mjModel, Deleter>;

/// Of a link between two joints of one body: nothing is there, but a simulated joint has to move something.
constexpr double kBetweenMass = 1e-4;     // kg
constexpr double kBetweenInertia = 1e-7;  // kg m^2

Vector3d vector_at(const double* values) { return Eigen::Map<const Vector3d>(values); }

/// The links and joints of a model.
class Bodies {
 public:
  Bodies(const mjModel& model, Draft& draft) : model_(model), draft_(draft), shapes_(model, draft) {}

  void convert() {
    draft_.robot.name = "robot";
    links_.push_back(add_link("world"));
    // Each body comes after the one that carries it.
    for (int body = 1; body < model_.nbody; ++body) add_body(body);
    for (int site = 0; site < model_.nsite; ++site) add_site(site);
    shapes_.note_world();
  }

 private:
  std::string unique(std::string name) {
    for (int k = 2; !names_.insert(name).second; ++k) name = fmt::format("{}_{}", name, k);
    return name;
  }

  std::string name_of(mjtObj type, int id, const char* otherwise) const {
    const char* name = mj_id2name(&model_, type, id);
    return name != nullptr && *name != '\0' ? name : fmt::format("{}_{}", otherwise, id);
  }

  std::string add_link(const std::string& wanted) {
    const std::string name = unique(wanted);
    Node link{"link", {{"name", name}}, {}};
    draft_.robot.children.push_back(std::move(link));
    return name;
  }

  Node& add_joint(const std::string& name, const char* type, const std::string& parent, const std::string& child,
                  const Isometry3d& X) {
    Node joint{"joint", {{"name", name}, {"type", type}}, {}};
    set_pose(joint, X);
    joint.add("parent").set("link", parent);
    joint.add("child").set("link", child);
    draft_.robot.children.push_back(std::move(joint));
    return draft_.robot.children.back();
  }

  void add_body(int body) {
    const std::string name = unique(name_of(mjOBJ_BODY, body, "body"));
    std::string parent = links_[static_cast<std::size_t>(model_.body_parentid[body])];
    Isometry3d X = pose_at(model_.body_pos + 3 * body, model_.body_quat + 4 * body);
    const int first = model_.body_jntadr[body], end = first + model_.body_jntnum[body];
    bool placed = false;
    for (int joint = first; joint < end; ++joint) {
      const Vector3d anchor = is_hinge(joint) ? vector_at(model_.jnt_pos + 3 * joint) : Vector3d::Zero();
      const bool last = joint + 1 == end && anchor.isZero(0.0);
      const std::string child = last ? name : add_between(name, name_of(mjOBJ_JOINT, joint, "joint"), joint + 1 == end);
      if (last) draft_.robot.children.push_back({"link", {{"name", name}}, {}});
      X = X * at_zero(joint, anchor);
      add_movable(joint, parent, child, X);
      X = Isometry3d(Eigen::Translation3d(-anchor));
      parent = child;
      placed = last;
    }
    if (!placed) {
      draft_.robot.children.push_back({"link", {{"name", name}}, {}});
      add_joint(unique_joint("fixed_" + name), "fixed", parent, name, X);
    }
    links_.push_back(name);
    Node* link = draft_.link(name);
    add_inertia(*link, body);
    shapes_.add(*link, body);
  }

  bool is_hinge(int joint) const { return model_.jnt_type[joint] == mjJNT_HINGE; }

  /// The joint's frame where its position is zero: MuJoCo counts from a reference.
  Isometry3d at_zero(int joint, const Vector3d& anchor) const {
    Isometry3d X(Eigen::Translation3d{anchor});
    const double reference = model_.qpos0[model_.jnt_qposadr[joint]];
    const Vector3d axis = vector_at(model_.jnt_axis + 3 * joint);
    if (is_hinge(joint) && reference != 0.0) X.rotate(AngleAxisd(-reference, axis));
    if (model_.jnt_type[joint] == mjJNT_SLIDE) X.translate(-reference * axis);
    return X;
  }

  /// @param last  what is fixed to it has the mass
  std::string add_between(const std::string& body, const std::string& joint, bool last) {
    const std::string name = add_link(fmt::format("{}_{}", body, joint));
    if (last) return name;
    Node& inertial = draft_.link(name)->add("inertial");
    inertial.add("mass").set("value", kBetweenMass);
    Node& inertia = inertial.add("inertia");
    for (const char* key : {"ixx", "iyy", "izz"}) inertia.set(key, kBetweenInertia);
    for (const char* key : {"ixy", "ixz", "iyz"}) inertia.set(key, 0.0);
    draft_.note(fmt::format("link '{}'", name), fmt::format("added, {:g} kg", kBetweenMass),
                fmt::format("body '{}' has several joints", body));
    return name;
  }

  std::string unique_joint(std::string name) {
    for (int k = 2; !joint_names_.insert(name).second; ++k) name = fmt::format("{}_{}", name, k);
    return name;
  }

  void add_movable(int joint, const std::string& parent, const std::string& child, const Isometry3d& X) {
    const std::string name = unique_joint(name_of(mjOBJ_JOINT, joint, "joint"));
    const int type = model_.jnt_type[joint];
    const bool limited = model_.jnt_limited[joint] != 0;
    const char* word = type == mjJNT_FREE    ? "floating"
                       : type == mjJNT_BALL  ? "spherical"
                       : type == mjJNT_SLIDE ? "prismatic"
                       : limited             ? "revolute"
                                             : "continuous";
    Node& made = add_joint(name, word, parent, child, X);
    if (type == mjJNT_FREE)
      draft_.note(fmt::format("joint '{}'", name), "taken as fixed to where it is mounted",
                  fmt::format("body '{}' moves freely in the file", child));
    if (type == mjJNT_FREE || type == mjJNT_BALL) return;
    made.add("axis").set("xyz", exact(vector_at(model_.jnt_axis + 3 * joint)));
    Node& limit = made.add("limit");
    if (limited) {
      limit.set("lower", exact(model_.jnt_range[2 * joint]));
      limit.set("upper", exact(model_.jnt_range[2 * joint + 1]));
    }
    const JointDrive drive = drive_of(model_, joint);
    if (drive.velocity > 0.0) limit.set("velocity", exact(drive.velocity));
    if (drive.effort > 0.0) limit.set("effort", exact(drive.effort));
    const int dof = model_.jnt_dofadr[joint];
    if (model_.dof_damping[dof] > 0.0 || model_.dof_frictionloss[dof] > 0.0) {
      Node& dynamics = made.add("dynamics");
      dynamics.set("damping", exact(model_.dof_damping[dof]));
      dynamics.set("friction", exact(model_.dof_frictionloss[dof]));
    }
    JointExtras& extras = draft_.extras[name];
    if (model_.dof_armature[dof] > 0.0) extras.armature = model_.dof_armature[dof];
    add_mimic(joint, made);
  }

  /// A joint that an equality makes a linear function of another one.
  void add_mimic(int joint, Node& made) const {
    for (int eq = 0; eq < model_.neq; ++eq) {
      if (model_.eq_type[eq] != mjEQ_JOINT || model_.eq_obj1id[eq] != joint || model_.eq_active0[eq] == 0) continue;
      if (model_.eq_obj2id[eq] < 0) continue;
      Node& mimic = made.need("mimic");
      mimic.set("joint", name_of(mjOBJ_JOINT, model_.eq_obj2id[eq], "joint"));
      mimic.set("offset", model_.eq_data[mjNEQDATA * eq]);
      mimic.set("multiplier", model_.eq_data[mjNEQDATA * eq + 1]);
    }
  }

  void add_inertia(Node& link, int body) const {
    if (!(model_.body_mass[body] > 0.0)) return;
    Node& inertial = link.add("inertial");
    set_pose(inertial, pose_at(model_.body_ipos + 3 * body, model_.body_iquat + 4 * body));
    inertial.add("mass").set("value", exact(model_.body_mass[body]));
    Node& inertia = inertial.add("inertia");
    constexpr std::array<const char*, 3> kKeys = {"ixx", "iyy", "izz"};
    for (std::size_t i = 0; i < kKeys.size(); ++i)
      inertia.set(kKeys[i], exact(model_.body_inertia[3 * body + static_cast<int>(i)]));
    for (const char* key : {"ixy", "ixz", "iyz"}) inertia.set(key, 0.0);
  }

  void add_site(int site) {
    const std::string name = add_link(name_of(mjOBJ_SITE, site, "site"));
    add_joint(unique_joint("fixed_" + name), "fixed", links_[static_cast<std::size_t>(model_.site_bodyid[site])], name,
              pose_at(model_.site_pos + 3 * site, model_.site_quat + 4 * site));
  }

  const mjModel& model_;
  Draft& draft_;
  MjcfShapes shapes_;
  std::vector<std::string> links_;  ///< by number of the body
  std::set<std::string> names_, joint_names_;
};

/// The keyframe "home", or the first one.
void take_home(const mjModel& model, Draft& draft) {
  if (model.nkey == 0) return;
  const int named = mj_name2id(&model, mjOBJ_KEY, "home"), key = named >= 0 ? named : 0;
  const char* name = mj_id2name(&model, mjOBJ_KEY, key);
  draft.home = name != nullptr && *name != '\0' ? fmt::format("keyframe '{}'", name) : "the first keyframe";
  for (int joint = 0; joint < model.njnt; ++joint) {
    const char* joint_name = mj_id2name(&model, mjOBJ_JOINT, joint);
    const auto found = draft.extras.find(joint_name != nullptr && *joint_name != '\0' ? std::string(joint_name)
                                                                                      : fmt::format("joint_{}", joint));
    if (found != draft.extras.end()) found->second.home = model.key_qpos[key * model.nq + model.jnt_qposadr[joint]];
  }
}

std::unexpected<Diagnostics> refused(const std::string& text, const MjcfSource& source) {
  Diagnostic diagnostic = mujoco_diagnostic(text);
  source.locate(text, diagnostic);
  Diagnostics diagnostics;
  diagnostics.add(std::move(diagnostic));
  return std::unexpected(std::move(diagnostics));
}

}  // namespace

Result<Draft> read_mjcf(const std::filesystem::path& file) {
  auto source = MjcfSource::scan(file);
  if (!source) return std::unexpected(source.error());
  std::array<char, 2000> error{};
  OwnedSpec spec;
  OwnedModel model;
  const auto compiled = sim::mujoco_call("", [&] {
    spec.reset(mj_parseXML(file.c_str(), nullptr, error.data(), static_cast<int>(error.size())));
    if (!spec) return;
    spec->compiler.usethread = 0;  // an error in another thread could not be caught
    spec->compiler.fusestatic = 0;
    spec->compiler.discardvisual = 0;
    spec->compiler.passthrough = mjPASSTHROUGH_TEXTURES;  // nobody looks at them
    model.reset(mj_compile(spec.get(), nullptr));
  });
  if (!compiled) return refused(compiled.error().list().front().message, *source);
  if (!spec) return refused(error.data(), *source);
  if (!model) return refused(mjs_getError(spec.get()), *source);
  Draft draft;
  Bodies(*model, draft).convert();
  take_home(*model, draft);
  note_unused(*model, *spec, *source, draft);
  return draft;
}

}  // namespace takt::tools
