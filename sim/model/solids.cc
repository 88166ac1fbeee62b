#include "sim/model/solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/contact/solid_contact.h"

namespace takt::sim {
namespace {

thread_local Solids* active = nullptr;

using CollisionTable = std::array<std::array<mjfCollision, mjNGEOMTYPES>, mjNGEOMTYPES>;
CollisionTable mujocos_own;

std::optional<SolidView::Shape> shape_of(int type) {
  switch (type) {
    case mjGEOM_PLANE:
      return SolidView::Shape::kPlane;
    case mjGEOM_SPHERE:
      return SolidView::Shape::kSphere;
    case mjGEOM_CAPSULE:
      return SolidView::Shape::kCapsule;
    case mjGEOM_CYLINDER:
      return SolidView::Shape::kCylinder;
    case mjGEOM_BOX:
      return SolidView::Shape::kBox;
    case mjGEOM_MESH:
      return SolidView::Shape::kMesh;
    default:
      return std::nullopt;
  }
}

std::optional<SolidView> view_of(const mjModel& model, const mjData& data, int geom) {
  const auto shape = shape_of(model.geom_type[geom]);
  if (!shape) return std::nullopt;
  SolidView view;
  view.shape = *shape;
  view.X_W.translation() = Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom);
  view.X_W.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.geom_xmat + 9 * geom);
  view.size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom);
  view.bound = model.geom_rbound[geom];
  view.solid = active->find(geom);
  if (*shape == SolidView::Shape::kMesh) view.hull = &active->hull(model.geom_dataid[geom]);
  if (*shape == SolidView::Shape::kCylinder) view.outline = &active->outline(geom);
  return view;
}

/// As MuJoCo fills a contact; stiffness, damping and friction are the contact law's.
mjContact contact_of(const mjModel& model, int geom1, int geom2, const Touch& touch) {
  mjContact contact{};
  contact.dist = -touch.depth;
  const Eigen::Vector3d tangent = touch.normal.unitOrthogonal(), other = touch.normal.cross(tangent);
  for (int i = 0; i < 3; ++i) {
    contact.pos[i] = touch.position[i];
    contact.frame[i] = touch.normal[i];
    contact.frame[3 + i] = tangent[i];
    contact.frame[6 + i] = other[i];
  }
  for (int i = 0; i < 5; ++i) {
    constexpr std::array<int, 5> kOfGeom = {0, 0, 1, 2, 2};
    const int k = kOfGeom[static_cast<std::size_t>(i)];
    contact.friction[i] = std::max(model.geom_friction[3 * geom1 + k], model.geom_friction[3 * geom2 + k]);
    contact.friction[i] = std::max(contact.friction[i], static_cast<double>(mjMINMU));
  }
  std::copy_n(model.geom_solref + mjNREF * geom1, mjNREF, contact.solref);
  std::copy_n(model.geom_solimp + mjNIMP * geom1, mjNIMP, contact.solimp);
  contact.dim = std::max(model.geom_condim[geom1], model.geom_condim[geom2]);
  contact.geom1 = contact.geom[0] = geom1;
  contact.geom2 = contact.geom[1] = geom2;
  for (int side = 0; side < 2; ++side) contact.flex[side] = contact.elem[side] = contact.vert[side] = -1;
  contact.efc_address = -1;
  return contact;
}

Touch read(const mjPreContact& contact) {
  return {.position = Eigen::Map<const Eigen::Vector3d>(contact.pos),
          .normal = Eigen::Map<const Eigen::Vector3d>(contact.normal),
          .depth = -contact.dist};
}

/// What MuJoCo finds between two convex solids that rest on each other, but for what hangs over a bore.
void keep_outside_bores(const SolidView& first, const SolidView& second, const mjPreContact* contacts, int count,
                        Touches& touches) {
  for (int i = 0; i < count; ++i) {
    Touch touch = read(contacts[i]);
    if (over_bore(first, touch.position) || over_bore(second, touch.position)) continue;
    touch.group = Touches::flat_group(first.drilled() ? first : second, touch.normal);
    touches.add(touch);
  }
}

int collide(const mjModel* model, mjData* data, mjPreContact* contacts, int geom1, int geom2, mjtNum margin) {
  const auto type = [&](int geom) { return static_cast<std::size_t>(model->geom_type[geom]); };
  const auto own = [&] { return mujocos_own[type(geom1)][type(geom2)](model, data, contacts, geom1, geom2, margin); };
  if (!active || !(active->find(geom1) || active->find(geom2))) return own();
  const auto first = view_of(*model, *data, geom1), second = view_of(*model, *data, geom2);
  if (!first || !second) return own();
  if (!reaches_bore(*first, *second) && !reaches_bore(*second, *first)) return own();

  Touches touches;
  const auto flat_sided = [](const SolidView& view) {
    return view.has_corners() || view.shape == SolidView::Shape::kPlane;
  };
  const bool rests =
      flat_sided(*first) && flat_sided(*second) && !is_in_bore(*first, *second) && !is_in_bore(*second, *first);
  if (rests) {
    keep_outside_bores(*first, *second, contacts, own(), touches);
    touches.find_rims(*first, *second);
  } else {
    touches.find(*first, *second);
  }
  if (active->joined(geom1, geom2)) touches.keep_bottoms(*first, *second);
  touches.sort();
  active->keep(geom1, geom2, touches.all());
  return 0;  // MuJoCo's buffer is as large as its own shapes need: ours are added later
}

/// The hull that MuJoCo has made of a mesh: its graph lists vertices and triangles.
MeshHull hull_of(const mjModel& model, int mesh) {
  MeshHull hull;
  if (model.mesh_graphadr[mesh] < 0) return hull;
  const int* graph = model.mesh_graph + model.mesh_graphadr[mesh];
  const int vertices = graph[0], faces = graph[1];
  const int* ids = graph + 2 + vertices;
  const int* corners = graph + 2 + 3 * vertices + 3 * faces;
  const auto at = [&](int vertex) -> Eigen::Vector3d {
    return Eigen::Map<const Eigen::Vector3f>(model.mesh_vert + 3 * (model.mesh_vertadr[mesh] + vertex)).cast<double>();
  };
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int i = 0; i < vertices; ++i) {
    hull.vertices.push_back(at(ids[i]));
    middle += hull.vertices.back() / vertices;
  }
  for (int i = 0; i < faces; ++i) {
    const Eigen::Vector3d a = at(corners[3 * i]), b = at(corners[3 * i + 1]), c = at(corners[3 * i + 2]);
    Eigen::Vector3d n = (b - a).cross(c - a);
    if (n.norm() < 1e-16) continue;
    n.normalize();
    if (n.dot(middle - a) > 0.0) n = -n;
    hull.planes.emplace_back(n.x(), n.y(), n.z(), n.dot(a));
  }
  return hull;
}

/// How thick a box or cylinder is below the mouth of a bore, m; 0 for other shapes.
double thickness_below(const ObjectShape& shape, const world::Bore& bore) {
  if (const auto* box = std::get_if<kinematics::Box>(&shape)) {
    Eigen::Index axis = 0;
    bore.X_SB.linear().col(2).cwiseAbs().maxCoeff(&axis);
    return box->size[axis];
  }
  const auto* cylinder = std::get_if<kinematics::Cylinder>(&shape);
  return cylinder ? cylinder->length : 0.0;
}

}  // namespace

std::string solid_name(const std::string& body, std::size_t index) { return fmt::format("{}/shape{}", body, index); }

Solid make_solid(const ObjectShape& shape, double chamfer, const std::vector<world::Bore>& bores) {
  Solid solid;
  if (std::holds_alternative<kinematics::Cylinder>(shape)) solid.chamfer = chamfer;
  for (const world::Bore& bore : bores) {
    const double thickness = thickness_below(shape, bore);
    solid.bores.push_back({.X_GB = bore.X_SB,
                           .X_BG = bore.X_SB.inverse(Eigen::Isometry),
                           .radius = bore.radius,
                           .chamfer = bore.chamfer,
                           .length = bore.through() ? thickness : bore.depth,
                           .through = bore.through(),
                           .material = world::material_around(bore, thickness)});
  }
  return solid;
}

Solids::Solids(const mjModel& model, const WorldDescription& description)
    : solid_of_(static_cast<std::size_t>(model.ngeom), -1), joined_with_(solid_of_) {
  bool drilled = false;
  for (const ObjectDescription& object : description.objects) {
    for (std::size_t i = 0; i < object.shapes.size(); ++i) {
      const ObjectGeometry& part = object.shapes[i];
      drilled = drilled || !part.bores.empty();
      if (part.chamfer == 0.0 && part.bores.empty()) continue;
      add(model, solid_name(object.name, i), make_solid(part.shape, part.chamfer, part.bores));
    }
  }
  for (const RobotDescription& robot : description.robots) {
    for (const auto& [link, chamfer] : robot.chamfers) {
      const std::string body = robot.name + "/" + link;
      for (std::size_t i = 0; mj_name2id(&model, mjOBJ_GEOM, solid_name(body, i).c_str()) >= 0; ++i)
        add(model, solid_name(body, i), Solid{.chamfer = chamfer, .bores = {}});
    }
  }
  kept_.reserve(kKept);
  // Chamfers matter in bores only.
  if (!drilled) solids_.clear();
  if (solids_.empty()) return;
  for (int mesh = 0; mesh < model.nmesh; ++mesh) hulls_.push_back(hull_of(model, mesh));
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const Solid* solid = find(geom);
    const double radius = model.geom_size[3 * geom], length = 2.0 * model.geom_size[3 * geom + 1];
    outlines_.push_back(model.geom_type[geom] == mjGEOM_CYLINDER
                            ? world::chamfered_cylinder(radius, length, solid ? solid->chamfer : 0.0)
                            : world::Revolved());
  }
}

void Solids::add(const mjModel& model, const std::string& name, Solid solid) {
  const int geom = mj_name2id(&model, mjOBJ_GEOM, name.c_str());
  if (geom < 0) return;
  solid_of_[static_cast<std::size_t>(geom)] = static_cast<int>(solids_.size());
  solids_.push_back(std::move(solid));
}

const Solid* Solids::find(int geom) const {
  const int index = solid_of_[static_cast<std::size_t>(geom)];
  return index < 0 ? nullptr : &solids_[static_cast<std::size_t>(index)];
}

void Solids::join(int shank, int drilled) { joined_with_[static_cast<std::size_t>(shank)] = drilled; }
void Solids::part(int shank) { joined_with_[static_cast<std::size_t>(shank)] = -1; }

bool Solids::joined(int geom1, int geom2) const {
  return joined_with_[static_cast<std::size_t>(geom1)] == geom2 ||
         joined_with_[static_cast<std::size_t>(geom2)] == geom1;
}

/// While it lives, MuJoCo's search for contacts on this thread knows the solids.
class Solids::Active {
 public:
  explicit Active(Solids& solids) { active = &solids; }
  ~Active() { active = nullptr; }
  Active(const Active&) = delete;
  Active& operator=(const Active&) = delete;
};

void Solids::search(const mjModel& model, mjData& data) {
  if (empty()) return mj_collision(&model, &data);
  kept_.clear();
  {
    const Active known(*this);
    mj_collision(&model, &data);
  }
  add_contacts(model, data);
}

void Solids::keep(int geom1, int geom2, std::span<const Touch> touches) {
  for (const Touch& touch : touches) {
    if (kept_.size() < kKept) kept_.push_back({geom1, geom2, touch});
  }
}

void Solids::add_contacts(const mjModel& model, mjData& data) {
  first_kept_ = data.ncon;
  for (const Kept& kept : kept_) {
    const mjContact contact = contact_of(model, kept.geom1, kept.geom2, kept.touch);
    if (mj_addContact(&model, &data, &contact) != 0) break;
  }
}

int Solids::group(int contact) const {
  if (kept_.empty() || contact < first_kept_) return 0;
  return kept_[static_cast<std::size_t>(contact - first_kept_)].touch.group;
}

double Solids::weight(int contact) const {
  if (kept_.empty() || contact < first_kept_) return 0.0;
  return kept_[static_cast<std::size_t>(contact - first_kept_)].touch.weight;
}

void install_solid_contacts() {
  static std::once_flag once;
  std::call_once(once, [] {
    for (std::size_t a = 0; a < mjNGEOMTYPES; ++a) {
      for (std::size_t b = 0; b < mjNGEOMTYPES; ++b) {
        mujocos_own[a][b] = mjCOLLISIONFUNC[a][b];
        if (mujocos_own[a][b]) mjCOLLISIONFUNC[a][b] = collide;
      }
    }
  });
}

}  // namespace takt::sim
