#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "cell/build/built_cell.h"

/// What a cell looks like, for viewers in other processes: bodies with their shapes once, then poses. Realtime: setup.
namespace takt::cell {

/// Triangles of a shape in its own frame, m, counter-clockwise from outside.
struct SceneMesh {
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// One shape of a body, in the axes of that body.
struct SceneShape {
  enum class Kind { kPlane, kSphere, kCapsule, kEllipsoid, kCylinder, kBox, kMesh };
  Kind kind = Kind::kBox;
  /// Half of the sides (box, plane; 0: without end), radii (ellipsoid), or radius and half of the length along z
  /// (sphere, capsule without its caps, cylinder), m.
  std::array<double, 3> size{};
  int mesh = -1;  ///< index, of a mesh
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  std::array<float, 4> rgba{};  ///< sRGB and opacity, 0 to 1
};

struct SceneBody {
  std::string name;  ///< "ROBOT/LINK" or "OBJECT"; of the first, the world: "world"
  int parent = -1;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();  ///< at the start
  std::vector<SceneShape> shapes;
};

/// Joints of an arm as they are commanded.
struct CommandedJoints {
  std::string_view arm;
  std::span<const double> q;  ///< of size 0: not known, so the measured ones stand for them
};

/// The scene of a cell, and where its bodies are. One thread at a time, which need not be that of the cycle: it has a
/// state of its own.
class CellScene {
 public:
  explicit CellScene(const BuiltCell& built);
  ~CellScene();
  CellScene(const CellScene&) = delete;
  CellScene& operator=(const CellScene&) = delete;

  [[nodiscard]] const std::vector<SceneBody>& bodies() const { return bodies_; }
  [[nodiscard]] const std::vector<SceneMesh>& meshes() const { return meshes_; }
  /// Indices of bodies that may move; and of those among them that arms move, whose set points are known too.
  [[nodiscard]] const std::vector<int>& moving() const { return moving_; }
  [[nodiscard]] const std::vector<int>& commanded() const { return commanded_; }
  [[nodiscard]] const std::vector<std::string>& cameras() const { return cameras_; }

  /// Poses in the world of moving(), then of commanded(), in their order.
  /// @param positions  sim::World::positions() at some time
  [[nodiscard]] const std::vector<Eigen::Isometry3d>& place(std::span<const double> positions,
                                                            std::span<const CommandedJoints> arms);

 private:
  struct ArmPositions {
    std::string name;
    std::vector<int> addresses;  ///< in the positions, of each joint
  };
  void add_shapes();
  void find_moving(const std::vector<bool>& of_arms);
  void add_poses(const std::vector<int>& bodies);

  struct State;
  std::unique_ptr<State> state_;
  std::vector<SceneBody> bodies_;
  std::vector<SceneMesh> meshes_;
  std::vector<int> moving_, commanded_;
  std::vector<std::string> cameras_;
  std::vector<ArmPositions> arms_;
  std::vector<Eigen::Isometry3d> poses_;
};

}  // namespace takt::cell
