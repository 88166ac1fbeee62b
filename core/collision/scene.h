#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/collision/convex.h"
#include "core/kinematics/robot_model.h"
#include "core/world/object.h"

/// The solids of a cell and how they move: links, tools, objects. Nothing here knows devices or programs.
namespace takt::collision {

/// A convex solid on a body.
struct Part {
  Convex solid;
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();  ///< its frame in that of the body, m
};

/// A rigid body: a link of a robot or an object.
struct Body {
  std::string name;   ///< "ROBOT/LINK", or the name of an object
  std::string owner;  ///< the robot or object that it belongs to
  std::vector<Part> parts;
  int parent = -1;                                         ///< the body that carries it; -1: the world
  Eigen::Isometry3d X_PJ = Eigen::Isometry3d::Identity();  ///< at zero of its joint, in the parent, m
  int joint = -1;                                          ///< number of its joint; -1: fixed to its parent
  bool prismatic = false;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the joint, in J
  bool root = false;                                ///< first body of its robot, or an object: it can be put elsewhere
  Eigen::AlignedBox3d box;                          ///< holds all parts, axes of the body, m
  double radius = 0.0;                              ///< of the ball about the middle of the box that holds all parts, m
};

/// Where a root body is fixed.
struct Fixing {
  int parent = -1;  ///< body; -1: the world
  Eigen::Isometry3d X_P = Eigen::Isometry3d::Identity();
};

/// All that changes: joint values (rad or m) and where the root bodies are fixed.
struct State {
  std::vector<double> q;        ///< by number of the joint
  std::vector<Fixing> fixings;  ///< by number of the body; of bodies that are no root not looked at
};

/// Poses of all bodies in the world, by number.
using Poses = std::vector<Eigen::Isometry3d>;

/// The bodies of a cell. Built once, then read only. Thread: any, while nobody adds.
class Scene {
 public:
  /// Adds the links of a robot, its root link at X_P on a body. Movable joints become joints "ROBOT/JOINT".
  /// @param parent  number of a body; -1: the world   @param q  start of the movable joints in the order of the model;
  /// missing ones are 0
  /// @return diagnostics of its meshes. Realtime: setup.
  [[nodiscard]] Diagnostics add_robot(const std::string& name, const kinematics::RobotModel& model, int parent,
                                      const Eigen::Isometry3d& X_P, std::span<const double> q = {});
  /// Adds an object of several shapes. Realtime: setup.
  void add_object(const std::string& name, const std::vector<world::Object::Part>& parts, int parent,
                  const Eigen::Isometry3d& X_P);

  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }
  [[nodiscard]] const Body& body(int number) const { return bodies_[static_cast<std::size_t>(number)]; }
  /// Number of a body by its name; -1: there is none.
  [[nodiscard]] int find(std::string_view name) const;
  /// Number of the root body of a robot or object by its name; -1: there is none.
  [[nodiscard]] int root_of(std::string_view owner) const;
  /// Number of a joint "ROBOT/JOINT"; -1: there is none.
  [[nodiscard]] int find_joint(std::string_view name) const;
  [[nodiscard]] const std::vector<std::string>& joints() const { return joints_; }

  /// As it was added.
  [[nodiscard]] const State& start() const { return start_; }
  /// Realtime: setup (`poses` is resized).
  void place(const State& state, Poses& poses) const;
  /// All bodies, each behind what carries it. Realtime: setup.
  [[nodiscard]] std::vector<int> parents_first(const State& state) const;
  /// Places these bodies only, in this order; `poses` has those that carry them. Realtime: cyclic.
  void place_some(const State& state, std::span<const int> order, Poses& poses) const;
  /// True for each body that a change of one of these joints moves.
  [[nodiscard]] std::vector<bool> moved_by(const State& state, std::span<const int> joints) const;

  /// Two bodies that are never checked against each other: their robot is built so. Joined by at most one joint, in
  /// contact in every posture, or accepted as built.
  [[nodiscard]] bool never_meet(int a, int b) const {
    return never_[static_cast<std::size_t>(a) * bodies_.size() + static_cast<std::size_t>(b)];
  }
  /// Two bodies are never nearer to each other than this, in any posture within the ranges of the joints, m: proven of
  /// links of one robot with at most two joints between them. 0: not known.
  [[nodiscard]] double least_distance(int a, int b) const {
    return apart_[static_cast<std::size_t>(a) * bodies_.size() + static_cast<std::size_t>(b)] ? kProvenApart : 0.0;
  }
  /// Finds these pairs; to be called once, when all is added. Realtime: setup, deterministic.
  void find_pairs_that_never_meet();
  /// The same for bodies of one machine, and of what it carries, that are as near as `near` (m) in a posture that is
  /// known to be possible: their solids are larger than they are. Realtime: setup.
  void accept_as_built(const State& state, double near);

 private:
  /// m: more than is kept between links of one machine
  static constexpr double kProvenApart = 2e-3;

  void add_body(Body body, const Fixing& fixing);
  void never(int a, int b);
  void find_proven_apart();
  [[nodiscard]] bool always_in_contact(int a, int b) const;
  /// The body at the root of all that is mounted on each other.
  [[nodiscard]] int assembly_of(int body) const;

  std::vector<Body> bodies_;
  std::vector<std::string> joints_;
  std::vector<double> lower_, upper_;  ///< of the joints
  State start_;
  std::vector<bool> never_;
  std::vector<bool> apart_;  ///< proven to be
};

/// The distance of two bodies at these poses: certified, as of separation(). Realtime: any thread.
[[nodiscard]] double distance(const Scene& scene, const Poses& poses, int a, int b);
/// Positive: as distance(); else minus how deep they overlap, m.
[[nodiscard]] double signed_distance(const Scene& scene, const Poses& poses, int a, int b);

}  // namespace takt::collision
