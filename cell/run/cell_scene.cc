#include "cell/run/cell_scene.h"

#include <algorithm>
#include <map>

#include <mujoco/mujoco.h>

#include "sim/film/render_shapes.h"

namespace takt::cell {
namespace {

constexpr int kDrawnGroups = 3;  ///< geoms of the groups 0 to 2 are drawn, as in films

Eigen::Isometry3d pose_at(const double* position, const double* quaternion) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(position);
  X.linear() = Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).toRotationMatrix();
  return X;
}

std::string name_in(const mjModel& model, int type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name != nullptr ? name : "";
}

/// A material counts where the geom has no colour of its own, as in MuJoCo.
std::array<float, 4> colour_of(const mjModel& model, int geom) {
  constexpr std::array<float, 4> kNone = {0.5F, 0.5F, 0.5F, 1.0F};
  std::array<float, 4> rgba{};
  std::copy_n(model.geom_rgba + 4 * geom, 4, rgba.begin());
  const int material = model.geom_matid[geom];
  if (material >= 0 && rgba == kNone) std::copy_n(model.mat_rgba + 4 * material, 4, rgba.begin());
  return rgba;
}

SceneMesh mesh_of(const sim::Shape& shape) {
  SceneMesh mesh;
  for (const sim::ShapeVertex& vertex : shape.vertices) mesh.points.push_back(vertex.p);
  for (std::size_t i = 0; i + 2 < shape.indices.size(); i += 3)
    mesh.triangles.push_back({shape.indices[i], shape.indices[i + 1], shape.indices[i + 2]});
  return mesh;
}

SceneShape::Kind kind_of(int type) {
  using enum SceneShape::Kind;
  switch (type) {
    case mjGEOM_PLANE:
      return kPlane;
    case mjGEOM_SPHERE:
      return kSphere;
    case mjGEOM_CAPSULE:
      return kCapsule;
    case mjGEOM_ELLIPSOID:
      return kEllipsoid;
    case mjGEOM_CYLINDER:
      return kCylinder;
    case mjGEOM_BOX:
      return kBox;
    default:
      return kMesh;
  }
}

}  // namespace

struct CellScene::State {
  std::shared_ptr<sim::World> world;  ///< keeps the model
  const mjModel& model;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data{mj_makeData(&model), &mj_deleteData};

  void pose() { mj_kinematics(&model, data.get()); }
};

CellScene::CellScene(const BuiltCell& built)
    : state_(std::make_unique<State>(State{.world = built.world, .model = *built.world->model()})) {
  const mjModel& model = state_->model;
  std::copy_n(built.world->positions().data(), model.nq, state_->data->qpos);
  state_->pose();
  for (int body = 0; body < model.nbody; ++body)
    bodies_.push_back({.name = body == 0 ? "world" : name_in(model, mjOBJ_BODY, body),
                       .parent = body == 0 ? -1 : model.body_parentid[body],
                       .X_WB = pose_at(state_->data->xpos + 3 * body, state_->data->xquat + 4 * body),
                       .shapes = {}});
  for (int camera = 0; camera < model.ncam; ++camera) cameras_.push_back(name_in(model, mjOBJ_CAMERA, camera));
  add_shapes();
  std::vector<bool> of_arms(static_cast<std::size_t>(model.njnt));
  for (const auto& [name, arm] : built.cell.arms) {
    ArmPositions& positions = arms_.emplace_back(ArmPositions{.name = name, .addresses = {}});
    for (const std::string& joint : arm.device->description().joint_names) {
      const int id = mj_name2id(&model, mjOBJ_JOINT, (name + "/" + joint).c_str());
      positions.addresses.push_back(id < 0 ? -1 : model.jnt_qposadr[id]);
      if (id >= 0) of_arms[static_cast<std::size_t>(id)] = true;
    }
  }
  find_moving(of_arms);
}

CellScene::~CellScene() = default;

void CellScene::add_shapes() {
  const mjModel& model = state_->model;
  const sim::ShapeLibrary library(&model);
  std::map<const sim::Shape*, int> known;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    SceneShape shape{.kind = kind_of(model.geom_type[geom]), .rgba = colour_of(model, geom)};
    if (model.geom_group[geom] >= kDrawnGroups || shape.rgba[3] <= 0.0F) continue;
    std::copy_n(model.geom_size + 3 * geom, 3, shape.size.begin());
    shape.X_BS = pose_at(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
    if (shape.kind == SceneShape::Kind::kMesh) {
      // The numbers of mjvGeom: a mesh has two, for itself and its hull.
      const bool has_hull = model.geom_type[geom] == mjGEOM_MESH || model.geom_type[geom] == mjGEOM_SDF;
      const int data = (has_hull ? 2 : 1) * model.geom_dataid[geom];
      const sim::Shape* triangles = library.find(model.geom_type[geom], data);
      if (triangles == nullptr || triangles->indices.empty()) continue;
      const auto [found, is_new] = known.emplace(triangles, static_cast<int>(meshes_.size()));
      if (is_new) meshes_.push_back(mesh_of(*triangles));
      shape.mesh = found->second;
    }
    bodies_[static_cast<std::size_t>(model.geom_bodyid[geom])].shapes.push_back(shape);
  }
}

void CellScene::find_moving(const std::vector<bool>& of_arms) {
  const mjModel& model = state_->model;
  std::vector<bool> moved(bodies_.size()), by_arm(bodies_.size());
  for (int body = 1; body < model.nbody; ++body) {
    const auto i = static_cast<std::size_t>(body), parent = static_cast<std::size_t>(model.body_parentid[body]);
    moved[i] = moved[parent] || model.body_jntnum[body] > 0;
    by_arm[i] = by_arm[parent];
    for (int joint = model.body_jntadr[body]; joint < model.body_jntadr[body] + model.body_jntnum[body]; ++joint)
      if (of_arms[static_cast<std::size_t>(joint)]) by_arm[i] = true;
    if (moved[i]) moving_.push_back(body);
    if (by_arm[i]) commanded_.push_back(body);
  }
}

void CellScene::add_poses(const std::vector<int>& bodies) {
  for (const int body : bodies)
    poses_.push_back(pose_at(state_->data->xpos + 3 * body, state_->data->xquat + 4 * body));
}

const std::vector<Eigen::Isometry3d>& CellScene::place(std::span<const double> positions,
                                                       std::span<const CommandedJoints> arms) {
  poses_.clear();
  double* qpos = state_->data->qpos;
  std::ranges::copy(positions.first(std::min(positions.size(), static_cast<std::size_t>(state_->model.nq))), qpos);
  state_->pose();
  add_poses(moving_);
  if (commanded_.empty()) return poses_;
  for (const CommandedJoints& arm : arms) {
    const auto known = std::ranges::find(arms_, arm.arm, &ArmPositions::name);
    if (known == arms_.end() || arm.q.size() != known->addresses.size()) continue;
    for (std::size_t i = 0; i < arm.q.size(); ++i)
      if (known->addresses[i] >= 0) qpos[known->addresses[i]] = arm.q[i];
  }
  state_->pose();
  add_poses(commanded_);
  return poses_;
}

}  // namespace takt::cell
