// Bodies: meshes, shapes, masses.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "tools/import/convex_parts.h"
#include "tools/import/draft.h"
#include "tools/import/triangles.h"

namespace takt::tools {
namespace {

/// A robot's link is mostly housing: light metal with much air, kg/m^3 of the box around it.
constexpr double kDensity = 600.0;
constexpr double kLeastMass = 0.2;     // kg
constexpr double kNoMass = 1e-6;       // kg: less is a placeholder, and no simulator moves it
constexpr double kNoInertia = 1e-12;   // kg m^2
constexpr double kLimbRadius = 0.045;  // m, of links that are drawn as limbs

Node* shape_of(Node& part) {
  Node* geometry = part.child("geometry");
  return geometry != nullptr && !geometry->children.empty() ? &geometry->children.front() : nullptr;
}

std::string unused_name(const Draft& draft, const std::filesystem::path& file, const std::string& extension) {
  std::string stem;
  for (const char c : file.stem().string()) stem += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  std::string name = fmt::format("meshes/{}{}", stem, extension);
  for (int k = 2; draft.mesh_files.contains(name); ++k) name = fmt::format("meshes/{}_{}{}", stem, k, extension);
  return name;
}

/// Meshes already gathered, by the name in the URDF: the new name and the box around it, or why there is none.
class Meshes {
 public:
  Meshes(Draft& draft, const MeshPaths& paths) : draft_(draft), paths_(paths) {}

  struct Entry {
    std::string name;  ///< empty: not usable
    std::string why;
    std::filesystem::path file = {};
    std::vector<MeshFile::Coloured> colours = {};
    std::vector<std::string> coloured = {};  ///< files of `colours`, once somebody wants them
    double size = 0.0;                       ///< the diagonal of its box, in its unit
  };

  /// The mesh by its colours: names of files and colours; one file of all if there is one colour. Empty: the file says
  /// none.
  std::vector<std::pair<std::string, std::string>> coloured(const std::string& name) {
    Entry& entry = entries_.at(name);
    if (entry.colours.size() == 1) return {{entry.name, entry.colours.front().rgba}};
    std::vector<std::pair<std::string, std::string>> files;
    for (std::size_t i = 0; i < entry.colours.size(); ++i) {
      if (entry.coloured.size() == i) {
        entry.coloured.push_back(unused_name(draft_, entry.file, ".obj"));
        draft_.mesh_files.emplace(entry.coloured.back(), std::move(entry.colours[i].content));
      }
      files.emplace_back(entry.coloured[i], entry.colours[i].rgba);
    }
    return files;
  }

  const Entry& get(const std::string& name) {
    const auto known = entries_.find(name);
    if (known != entries_.end()) return known->second;
    return entries_[name] = gather(name);
  }

 private:
  /// A mesh that came with the tree, or that of a file.
  Result<MeshFile> read(const std::string& name, const std::optional<std::filesystem::path>& file) {
    const auto own = draft_.meshes.find(name);
    if (own == draft_.meshes.end()) return read_mesh(*file);
    if (own->second.triangles > kMostTriangles) return too_many_triangles(own->second.triangles);
    return std::move(own->second);
  }

  Entry gather(const std::string& name) {
    const auto file = draft_.meshes.contains(name) ? std::optional<std::filesystem::path>(name) : paths_.find(name);
    if (!file) return {{}, "there is no such file; --packages DIR says where packages are"};
    auto mesh = read(name, file);
    if (!mesh) {
      const Diagnostic& diagnostic = mesh.error().list().front();
      return {{}, diagnostic.message + (diagnostic.hint.empty() ? "" : ", allowed: " + diagnostic.hint)};
    }
    // What collides is the hull, and a mesh in one plane has none.
    const auto surface = triangles_of(*mesh);
    if (!surface) return {{}, surface.error().list().front().message};
    const auto volume = hull_volume(*surface);
    const double side = mesh->box.diagonal().norm();
    if (!volume || !(*volume > 1e-9 * side * side * side)) return {{}, "its corners lie in one plane"};
    const std::string own = unused_name(draft_, *file, mesh->extension);
    draft_.mesh_files.emplace(own, std::move(mesh->content));
    return {own, {}, *file, std::move(mesh->colours), {}, side};
  }

  Draft& draft_;
  const MeshPaths& paths_;
  std::map<std::string, Entry> entries_;
};

/// A primitive without extent, as files have it to please some reader, or no shape at all.
bool is_empty(Node& part) {
  const Node* shape = shape_of(part);
  if (shape == nullptr) return true;
  const Eigen::Vector3d size = shape->vector("size", Eigen::Vector3d::Ones());
  return (shape->name == "box" && size.minCoeff() == 0.0) || shape->number("radius").value_or(1.0) == 0.0 ||
         shape->number("length").value_or(1.0) == 0.0;
}

/// True if the part keeps a shape: a primitive, or a mesh that is a file of the model now.
bool adopt(Node& part, Meshes& meshes, std::vector<std::pair<std::string, std::string>>& lost) {
  if (is_empty(part)) {
    lost.emplace_back("", "a shape without extent");
    return false;
  }
  Node* shape = shape_of(part);
  if (shape->name != "mesh") return true;
  const std::string name = shape->text("filename");
  const auto& entry = meshes.get(name);
  if (entry.name.empty()) {
    lost.emplace_back(name, entry.why);
    return false;
  }
  constexpr double kLeastSize = 1e-4;  // m, of a mesh: a scale that was meant for another unit
  const Eigen::Vector3d scale = shape->vector("scale", Eigen::Vector3d::Ones());
  if (scale.cwiseAbs().minCoeff() * entry.size < kLeastSize) {
    lost.emplace_back(name, "scaled to less than 0.1 mm");
    return false;
  }
  shape->set("filename", entry.name);
  return true;
}

/// Name of the robot's material that has this colour. One that there is none for goes to `made`: the robot's elements
/// stay where they are while its links are gone through.
std::string material_of(Draft& draft, const std::string& rgba, std::vector<Node>& made) {
  std::vector<Node*> materials = draft.robot.all("material");
  for (Node& one : made) materials.push_back(&one);
  for (const Node* material : materials)
    if (const Node* colour = material->child("color"); colour != nullptr && colour->text("rgba") == rgba)
      return material->text("name");
  Node material{"material", {{"name", fmt::format("colour_{}", materials.size() + 1)}}, {}};
  material.add("color").set("rgba", rgba);
  made.push_back(material);
  return material.text("name");
}

/// A visual of a mesh that has colours of its own, and to which the URDF gives none: one visual per colour.
std::vector<Node> by_colour(Draft& draft, const Node& part, const std::string& mesh, Meshes& meshes,
                            std::vector<Node>& materials) {
  const bool plain = part.name != "visual" || mesh.empty() || part.child("material") != nullptr;
  const auto files = plain ? decltype(meshes.coloured(mesh)){} : meshes.coloured(mesh);
  if (files.empty()) return {part};
  std::vector<Node> parts;
  for (const auto& [file, rgba] : files) {
    parts.push_back(part);
    shape_of(parts.back())->set("filename", file);
    if (!rgba.empty()) parts.back().add("material").set("name", material_of(draft, rgba, materials));
  }
  return parts;
}

Node as_visual(const Node& collision) {
  Node visual = collision;
  visual.name = "visual";
  return visual;
}

/// A visual whose mesh was lost is replaced by what the link collides with.
/// @param materials  gets those that are new
void gather_link(Draft& draft, Node& link, Meshes& meshes, std::vector<Node>& materials) {
  std::vector<std::pair<std::string, std::string>> lost;
  for (const char* kind : {"collision", "visual"}) {
    std::vector<Node> kept;
    bool lost_here = false;
    for (Node* part : link.all(kind)) {
      const Node* shape = shape_of(*part);
      const std::string mesh = shape != nullptr && shape->name == "mesh" ? shape->text("filename") : "";
      const bool usable = adopt(*part, meshes, lost);
      if (usable) std::ranges::move(by_colour(draft, *part, mesh, meshes, materials), std::back_inserter(kept));
      lost_here = lost_here || !usable;
    }
    link.drop_children(kind);
    if (std::string_view(kind) == "visual" && kept.empty() && lost_here) {
      for (const Node* collision : link.all("collision")) kept.push_back(as_visual(*collision));
    }
    link.children.insert(link.children.end(), kept.begin(), kept.end());
  }
  const bool seen = !link.all("visual").empty();
  for (const auto& [name, why] : lost) {
    draft.note(fmt::format("link '{}' {}", link.text("name"), name.empty() ? "shape" : fmt::format("mesh '{}'", name)),
               seen ? "its other shapes are used" : "left out", why);
  }
}

// --- shapes and masses -----------------------------------------------------------------------------------------------

/// The box around a link's shapes in its frame; meshes by their corners.
Eigen::AlignedBox3d box_of(Draft& draft, Node& link) {
  Eigen::AlignedBox3d whole;
  for (const char* kind : {"collision", "visual"}) {
    if (!whole.isEmpty()) break;
    for (Node* part : link.all(kind)) {
      const Node* shape = shape_of(*part);
      if (shape == nullptr) continue;
      Eigen::AlignedBox3d box;
      if (shape->name == "mesh") {
        // Kept content is known to be readable: the box follows from it again.
        const Eigen::Vector3d scale = shape->vector("scale", Eigen::Vector3d::Ones());
        box = mesh_box(draft.mesh_files.at(shape->text("filename")), shape->text("filename"));
        if (!box.isEmpty()) {
          const Eigen::Vector3d a = box.min().cwiseProduct(scale), b = box.max().cwiseProduct(scale);
          box = Eigen::AlignedBox3d(a.cwiseMin(b), a.cwiseMax(b));
        }
      } else {
        const double r = shape->number("radius").value_or(0.0), length = shape->number("length").value_or(2 * r);
        const Eigen::Vector3d half = shape->name == "box"
                                         ? Eigen::Vector3d(0.5 * shape->vector("size", Eigen::Vector3d::Zero()))
                                         : Eigen::Vector3d(r, r, 0.5 * length);
        box = Eigen::AlignedBox3d(-half, half);
      }
      if (!box.isEmpty()) whole.extend(box.transformed(part->origin()));
    }
  }
  return whole;
}

/// A cylinder from the link's joint to a place in it, where no shape tells what it looks like. It is only seen: a shape
/// that nobody knows must not stop an arm.
void add_limb(Node& link, const Eigen::Vector3d& to) {
  const double length = std::max(to.norm(), 0.02);
  const Eigen::Vector3d along = to.norm() > 1e-6 ? Eigen::Vector3d(to.normalized()) : Eigen::Vector3d::UnitZ();
  Node& part = link.add("visual");
  // Turned so that z of the cylinder lies along: pitch, then yaw.
  part.set_origin(0.5 * to, {0.0, std::acos(std::clamp(along.z(), -1.0, 1.0)), std::atan2(along.y(), along.x())});
  Node& cylinder = part.add("geometry").add("cylinder");
  cylinder.set("radius", kLimbRadius);
  cylinder.set("length", length);
}

Eigen::Vector3d end_of(Draft& draft, const std::string& link) {
  Eigen::Vector3d farthest = Eigen::Vector3d::Zero();
  for (const Node* joint : draft.joints_below(link)) {
    const Eigen::Vector3d at = joint->origin().translation();
    if (at.norm() > farthest.norm()) farthest = at;
  }
  return farthest;
}

/// Nothing is seen of a link whose next joint is in its own place, or that carries a body in its stead.
bool is_between(Draft& draft, const Node& link) {
  return std::ranges::any_of(draft.joints_below(link.text("name")), [&](const Node* joint) {
    const Node* child = draft.link(child_of(*joint));
    if (is_movable(*joint)) return joint->origin().translation().norm() < 1e-6;
    return child != nullptr && (child->child("visual") != nullptr || child->child("collision") != nullptr);
  });
}

/// Simulation takes the convex hull of a mesh: near enough to what is seen.
void add_collisions(Node& link) {
  std::vector<Node> made;
  for (const Node* visual : link.all("visual")) {
    made.push_back(*visual);
    made.back().name = "collision";
    made.back().drop_children("material");
  }
  link.children.insert(link.children.end(), made.begin(), made.end());
}

/// A uniform box of that mass.
void set_inertia(Node& inertial, double mass, const Eigen::Vector3d& size) {
  const Eigen::Vector3d s = size.cwiseMax(0.03).cwiseAbs2() * (mass / 12.0);
  Node& inertia = inertial.need("inertia");
  const std::pair<const char*, double> entries[] = {
      {"ixx", s.y() + s.z()}, {"iyy", s.x() + s.z()}, {"izz", s.x() + s.y()}, {"ixy", 0.0}, {"ixz", 0.0}, {"iyz", 0.0}};
  for (const auto& [key, value] : entries) inertia.set(key, value);
}

/// Whether the tensor belongs to a body; true also where it cannot be read, which the checker shall say.
bool is_inertia(const Node& inertial) {
  const Node* inertia = inertial.child("inertia");
  if (inertia == nullptr) return false;
  Eigen::Matrix3d I;
  const auto at = [&](const char* key) { return inertia->number(key); };
  const auto xx = at("ixx"), yy = at("iyy"), zz = at("izz"), xy = at("ixy"), xz = at("ixz"), yz = at("iyz");
  if (!xx || !yy || !zz || !xy || !xz || !yz) return true;
  I << *xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz;
  const Eigen::Vector3d m = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
  return m[0] > kNoInertia && m[0] + m[1] >= m[2] * (1.0 - 1e-9);
}

/// Mass of the link, or of what is fixed to it: then it needs none of its own.
bool has_body(Draft& draft, const std::string& name) {
  std::vector<std::string> open{name};
  for (std::size_t i = 0; i < open.size() && open.size() <= 1000; ++i) {
    const Node* link = draft.link(open[i]);
    const Node* inertial = link != nullptr ? link->child("inertial") : nullptr;
    const Node* mass = inertial != nullptr ? inertial->child("mass") : nullptr;
    if (mass != nullptr && mass->number("value").value_or(0.0) >= kNoMass) return true;
    for (const Node* joint : draft.joints_below(open[i]))
      if (!is_movable(*joint)) open.push_back(child_of(*joint));
  }
  return false;
}

/// Something with mass is needed on every joint that moves; frames that are fixed to a body need none.
void complete_mass(Draft& draft, Node& link, const Eigen::AlignedBox3d& box, bool needed) {
  const std::string who = fmt::format("link '{}'", link.text("name"));
  Node* inertial = link.child("inertial");
  const Node* mass_node = inertial != nullptr ? inertial->child("mass") : nullptr;
  const auto mass = mass_node != nullptr ? mass_node->number("value") : std::nullopt;
  const bool none = inertial == nullptr || (mass && *mass >= 0.0 && *mass < kNoMass);
  if (none && !needed) return link.drop_children("inertial");
  const Eigen::Vector3d size = box.isEmpty() ? Eigen::Vector3d::Constant(0.1) : Eigen::Vector3d(box.sizes());
  if (none) {
    link.drop_children("inertial");
    const double guess = std::max(kLeastMass, kDensity * size.prod());
    Node& made = link.add("inertial");
    made.set_origin(box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center()), Eigen::Vector3d::Zero());
    made.add("mass").set("value", guess);
    set_inertia(made, guess, size);
    draft.note(who + " mass", fmt::format("{:.3g} kg", guess),
               mass && *mass > 0.0
                   ? fmt::format("the file has {:g} kg, which is none; from the box around its shape", *mass)
                   : "the file has none; from the box around its shape");
    return;
  }
  if (is_inertia(*inertial) || !mass || *mass < 0.0) return;
  set_inertia(*inertial, *mass, size);
  draft.note(who + " inertia", "of a uniform box of its size", "the file has none that a body could have");
}

}  // namespace

void gather_meshes(Draft& draft, const MeshPaths& paths) {
  Meshes meshes(draft, paths);
  std::vector<Node> materials;
  for (Node* link : draft.robot.all("link")) gather_link(draft, *link, meshes, materials);
  draft.robot.children.insert(draft.robot.children.begin(), materials.begin(), materials.end());
}

void complete_bodies(Draft& draft) {
  for (Node* link : draft.robot.all("link")) {
    const std::string name = link->text("name");
    const Node* above = draft.joint_above(name);
    const bool moves = above != nullptr && is_movable(*above);
    const bool bare = link->all("visual").empty() && link->all("collision").empty();
    if (bare && (moves || name == draft.base) && !is_between(draft, *link)) {
      add_limb(*link, end_of(draft, name));
      draft.note(fmt::format("link '{}' shape", name), "a cylinder to the next joint",
                 "the file has none that can be read");
    }
    const Eigen::AlignedBox3d box = box_of(draft, *link);
    if (link->all("visual").empty()) {
      std::vector<Node> made;
      for (const Node* collision : link->all("collision")) made.push_back(as_visual(*collision));
      link->children.insert(link->children.end(), made.begin(), made.end());
    }
    if (link->all("collision").empty() && !bare && !link->all("visual").empty()) {
      add_collisions(*link);
      draft.note(fmt::format("link '{}' collision", name), "the hull of what is seen",
                 "the file has none that can be read");
    }
    complete_mass(draft, *link, box, moves && !has_body(draft, name));
  }
}

}  // namespace takt::tools
