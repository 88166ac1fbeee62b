#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/world/bore.h"
#include "core/world/revolved.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;

/// Solids that MuJoCo has no shape for: boxes and cylinders with bores, cylinders with chamfers. MuJoCo sees the convex
/// solid without them and finds the pairs that may touch; where one of a pair reaches into a bore, the contacts are
/// computed here, from exact surfaces. Idea and equations: docs/bores.md.
namespace takt::sim {

/// A bore as the narrow phase needs it. G: frame of the geom, B: of the bore.
struct DrilledBore {
  Pose X_GB = Pose::Identity(), X_BG = Pose::Identity();
  double radius = 0.0, chamfer = 0.0;  ///< m
  double length = 0.0;                 ///< m, from the mouth to the bottom or the other mouth
  bool through = false;
  world::Revolved material;  ///< around it, in B
};

/// What a geom is beyond its MuJoCo shape.
struct Solid {
  double chamfer = 0.0;  ///< m, of a cylinder
  std::vector<DrilledBore> bores;
};

/// The convex hull of a mesh, in the frame of its geom.
struct MeshHull {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector4d> planes;  ///< unit normal n, outwards, and d: n x <= d inside
};

/// A contact between two solids.
struct Touch {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in the middle of the overlap, world, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();   ///< from the first solid to the second
  double depth = 0.0;                                  ///< m
  double weight = 0.0;     ///< share of the spring's stiffness; 0: the points of a group share it by their depths
  std::uint8_t group = 0;  ///< the spring
};

/// The name of the geom of shape number `index` of an object, or of a link ("ROBOT/LINK").
[[nodiscard]] std::string solid_name(const std::string& body, std::size_t index);

/// A shape as the narrow phase needs it. The thickness below each bore is that of the shape. Realtime: setup.
[[nodiscard]] Solid make_solid(const ObjectShape& shape, double chamfer, const std::vector<world::Bore>& bores);

/// Chamfer and bores of a shape: sizes, and that each mouth is on a flat face. Realtime: setup.
/// @param at  JSON pointer of the shape
void check_solid(const ObjectGeometry& part, const std::string& at, Diagnostics& diagnostics);

/// The solids of one world by geom, and which of their contacts belong together. Owned by the world; one thread.
class Solids {
 public:
  Solids() = default;
  /// Realtime: setup.
  Solids(const mjModel_& model, const WorldDescription& description);
  [[nodiscard]] bool empty() const { return solids_.empty(); }
  [[nodiscard]] const Solid* find(int geom) const;
  [[nodiscard]] const MeshHull& hull(int mesh) const { return hulls_[static_cast<std::size_t>(mesh)]; }
  /// Of the cylinder that a geom is, about its z axis.
  [[nodiscard]] const world::Revolved& outline(int geom) const { return outlines_[static_cast<std::size_t>(geom)]; }

  /// As mj_collision, with the contacts of the solids. Realtime: cyclic.
  void search(const mjModel_& model, mjData_& data);

  /// A screw and its thread: the two shapes touch nowhere but at the bottom of the bore. Realtime: cyclic.
  void join(int shank, int drilled);
  void part(int shank);
  [[nodiscard]] bool joined(int geom1, int geom2) const;

  /// Keeps the contacts of two geoms until the search is over. Realtime: cyclic.
  void keep(int geom1, int geom2, std::span<const Touch> touches);
  /// Contacts of two geoms with the same number share one spring; each number has its own (docs/bores.md, "Springs").
  /// @param contact  its number in the list. Realtime: cyclic.
  [[nodiscard]] int group(int contact) const;
  /// Touch::weight of a contact. Realtime: cyclic.
  [[nodiscard]] double weight(int contact) const;

 private:
  static constexpr std::size_t kKept = 512;  ///< contacts in one step; what is beyond is dropped
  struct Kept {
    int geom1 = 0, geom2 = 0;
    Touch touch;
  };
  class Active;
  void add(const mjModel_& model, const std::string& name, Solid solid);
  /// After the search: puts what was kept behind the contacts that MuJoCo has found, pair by pair.
  void add_contacts(const mjModel_& model, mjData_& data);

  std::vector<int> solid_of_;     ///< by geom; -1: none
  std::vector<int> joined_with_;  ///< by geom of a shank: the geom with its thread; -1: none
  std::vector<Solid> solids_;
  std::vector<MeshHull> hulls_;            ///< by mesh
  std::vector<world::Revolved> outlines_;  ///< by geom; empty but for cylinders
  std::vector<Kept> kept_;
  int first_kept_ = 0;  ///< number of the first of them in the list of contacts
};

/// Puts our narrow phase before MuJoCo's, once in the process. Realtime: setup.
void install_solid_contacts();

}  // namespace takt::sim
