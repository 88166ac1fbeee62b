#include "tools/import/mjcf_shapes.h"

#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "tools/import/triangles.h"

namespace takt::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kShownGroups = 3;          ///< MuJoCo's viewer shows the groups 0 to 2 unless it is told otherwise
constexpr int kRings = 12, kSides = 24;  ///< of an ellipsoid

MeshFile mesh_file(const Triangles& mesh) {
  MeshFile file{obj_of(mesh), ".obj", mesh.faces.size(), {}};
  for (const Vector3d& point : mesh.points) file.box.extend(point);
  return file;
}

Triangles ellipsoid_of(const Vector3d& radii) {
  Triangles mesh;
  for (int ring = 0; ring <= kRings; ++ring) {
    const double up = std::numbers::pi * ring / kRings;
    const int sides = ring == 0 || ring == kRings ? 1 : kSides;
    for (int side = 0; side < sides; ++side) {
      const double around = 2.0 * std::numbers::pi * side / kSides;
      mesh.points.push_back(
          radii.cwiseProduct(Vector3d(std::sin(up) * std::cos(around), std::sin(up) * std::sin(around), std::cos(up))));
    }
  }
  const auto point = [](int ring, int side) {
    return ring == 0 ? 0 : ring == kRings ? 1 + (kRings - 1) * kSides : 1 + (ring - 1) * kSides + side % kSides;
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int side = 0; side < kSides; ++side) {
      const int a = point(ring, side), b = point(ring + 1, side), c = point(ring + 1, side + 1),
                d = point(ring, side + 1);
      if (b != c) mesh.faces.push_back({a, b, c});
      if (a != d) mesh.faces.push_back({a, c, d});
    }
  }
  return mesh;
}

}  // namespace

std::string exact(double value) { return fmt::format("{}", value); }

std::string exact(const Vector3d& value) { return fmt::format("{} {} {}", value.x(), value.y(), value.z()); }

Isometry3d pose_at(const double* position, const double* quaternion) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Eigen::Map<const Vector3d>(position);
  X.linear() =
      Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).normalized().toRotationMatrix();
  return X;
}

void set_pose(Node& node, const Isometry3d& X) {
  Node& origin = node.need("origin");
  origin.set("xyz", exact(Vector3d(X.translation())));
  origin.set("rpy", exact(rpy_of(X.linear())));
}

void MjcfShapes::add(Node& link, int body) {
  for (int i = 0; i < model_.body_geomnum[body]; ++i) {
    const int geom = model_.body_geomadr[body] + i;
    const bool touches = model_.geom_contype[geom] != 0 || model_.geom_conaffinity[geom] != 0;
    const bool seen = model_.geom_group[geom] < kShownGroups && !colour(geom).empty();
    if (seen) add_shape(link, geom, true);
    if (touches) add_shape(link, geom, false);
    if (seen || touches) continue;
    const char* name = mj_id2name(&model_, mjOBJ_GEOM, geom);
    draft_.note(fmt::format("geom '{}' of body '{}'", name != nullptr ? name : std::to_string(geom), link.text("name")),
                "left out", "it is neither seen nor touched; its mass counts");
  }
}

void MjcfShapes::note_world() const {
  if (const int count = model_.body_geomnum[0]; count > 0)
    draft_.note("left out", fmt::format("{} geom{} of the world", count, count == 1 ? "" : "s"),
                "a floor or a room is no part of the robot");
}

std::string MjcfShapes::colour(int geom) const {
  constexpr std::array<float, 4> kNone = {0.5F, 0.5F, 0.5F, 1.0F};
  std::array<float, 4> rgba{};
  std::copy_n(model_.geom_rgba + 4 * geom, 4, rgba.begin());
  const int material = model_.geom_matid[geom];
  if (material >= 0 && rgba == kNone) std::copy_n(model_.mat_rgba + 4 * material, 4, rgba.begin());
  if (rgba[3] <= 0.0F) return {};
  return fmt::format("{:.4g} {:.4g} {:.4g} {:.4g}", rgba[0], rgba[1], rgba[2], rgba[3]);
}

void MjcfShapes::add_shape(Node& link, int geom, bool seen) {
  const Isometry3d X = pose_at(model_.geom_pos + 3 * geom, model_.geom_quat + 4 * geom);
  const double* size = model_.geom_size + 3 * geom;
  const auto part = [&](const Isometry3d& X_LG, const char* shape) -> Node& {
    Node& made = link.add(seen ? "visual" : "collision");
    set_pose(made, X_LG);
    Node& geometry = made.add("geometry").add(shape);
    if (!seen) return geometry;
    Node& material = made.add("material");
    material.set("name", "colour_of_geom_" + std::to_string(geom));
    material.add("color").set("rgba", colour(geom));
    return made.child("geometry")->children.front();
  };
  const int type = model_.geom_type[geom];
  if (type == mjGEOM_BOX) {
    part(X, "box").set("size", exact(Vector3d(2.0 * size[0], 2.0 * size[1], 2.0 * size[2])));
  } else if (type == mjGEOM_SPHERE) {
    part(X, "sphere").set("radius", exact(size[0]));
  } else if (type == mjGEOM_CYLINDER || type == mjGEOM_CAPSULE) {
    Node& cylinder = part(X, "cylinder");
    cylinder.set("radius", exact(size[0]));
    cylinder.set("length", exact(2.0 * size[1]));
    for (const double side : {-1.0, 1.0})
      if (type == mjGEOM_CAPSULE)
        part(X * Eigen::Translation3d(0.0, 0.0, side * size[1]), "sphere").set("radius", exact(size[0]));
  } else if (type == mjGEOM_MESH || type == mjGEOM_ELLIPSOID) {
    const std::string name = type == mjGEOM_MESH ? mesh_of(geom) : ellipsoid({size[0], size[1], size[2]}, geom);
    part(X, "mesh").set("filename", name);
  } else if (seen) {
    draft_.note(fmt::format("geom of body '{}'", link.text("name")), "left out",
                "planes, height fields and signed distance fields are no shapes of a robot");
  }
}

std::string MjcfShapes::mesh_of(int geom) {
  const int mesh = model_.geom_dataid[geom];
  const auto [entry, is_new] = meshes_.try_emplace(mesh);
  if (!is_new) return entry->second;
  const char* name = mj_id2name(&model_, mjOBJ_MESH, mesh);
  entry->second = fmt::format("{}_{}", name != nullptr ? name : "mesh", mesh);
  Triangles triangles;
  const float* points = model_.mesh_vert + 3 * model_.mesh_vertadr[mesh];
  for (int i = 0; i < model_.mesh_vertnum[mesh]; ++i)
    triangles.points.emplace_back(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
  const int* corners = model_.mesh_face + 3 * model_.mesh_faceadr[mesh];
  for (int i = 0; i < model_.mesh_facenum[mesh]; ++i)
    triangles.faces.push_back({corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]});
  draft_.meshes[entry->second] = mesh_file(triangles);
  return entry->second;
}

std::string MjcfShapes::ellipsoid(const Vector3d& radii, int geom) {
  const std::string name = fmt::format("ellipsoid_{}", geom);
  if (draft_.meshes.try_emplace(name, mesh_file(ellipsoid_of(radii))).second)
    draft_.note(fmt::format("geom {}", geom), fmt::format("a mesh of {} triangles", draft_.meshes.at(name).triangles),
                "an ellipsoid");
  return name;
}

}  // namespace takt::tools
