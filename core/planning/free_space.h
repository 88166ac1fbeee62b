#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "core/collision/body_pair.h"
#include "core/collision/motion_check.h"
#include "core/collision/swept_space.h"
#include "core/kinematics/types.h"
#include "core/planning/sweep_tree.h"

/// Ways around obstacles (docs/planning.md). Realtime: setup; thread: one at a time.
namespace takt::planning {

using kinematics::JointVector;

/// Two bodies that are too near to each other.
struct Obstruction {
  int a = -1, b = -1;           ///< bodies of the scene
  double distance = 0.0;        ///< m; negative: overlap
  int source = -1;              ///< of what b sweeps: index in SweptSpace::sources; -1: b stands
  double from = 0.0, to = 0.0;  ///< s, SweptPose::time where it does; NaN: not known
};

/// A stretch of a path over u in [0, 1].
struct Stretch {
  std::function<void(double u, JointVector& q)> at;  ///< rad or m; keeps the size of q
  JointVector fastest;                               ///< bound of |dq/du| by joint over the whole stretch
};
/// The straight line between two postures.
[[nodiscard]] Stretch straight(const JointVector& from, const JointVector& to);

struct FreeSpaceOptions {
  double margin = 1e-3;     ///< m: what collision checks demand
  double clearance = 4e-3;  ///< m: what paths keep beyond it, where start and goal do; links of one machine 0.5 mm
  JointVector lower = {}, upper = {};                          ///< finite: a posture outside is not free
  std::function<collision::PairRule(int a, int b)> rule = {};  ///< as in collision::CheckOptions
  /// What others move meanwhile: what they sweep counts in place of where they stand. Null: nothing.
  const collision::SweptSpace* swept = nullptr;
};

/// Where some joints of a scene may be, all else standing still. A stretch that it calls free is proven to be: between
/// two looks at a pair of bodies no point travels further than they are apart. Bodies keep margin and clearance, with
/// these exceptions, which begin with a call of admit():
/// - no pair has to be further apart than it is at an admitted posture;
/// - what is in contact at the start may part, and a held part may be lifted and set down: near such a posture the
///   distance that is demanded grows with the way from there;
/// - a start within what others sweep may be left; the way out of it is not proven: when they come is not known here.
class FreeSpace {
 public:
  /// How deep bodies may overlap at a start that is not meant to touch, m.
  static constexpr double kStartOverlap = 1e-3;

  /// The scene must outlive it. @param joints  numbers in the scene, in the order of the postures
  FreeSpace(const collision::Scene& scene, const collision::State& state, std::vector<int> joints,
            const FreeSpaceOptions& options);

  /// Makes the start of a path free, as far as it may be. @return what makes it impossible; nothing: it is free now
  [[nodiscard]] std::optional<Obstruction> admit_start(const JointVector& q);
  /// The same of a posture at the end of a path.
  [[nodiscard]] std::optional<Obstruction> admit_goal(const JointVector& q);

  [[nodiscard]] bool is_free(const JointVector& q);
  [[nodiscard]] bool is_free(const Stretch& stretch);
  [[nodiscard]] bool is_free_line(const JointVector& from, const JointVector& to) {
    return is_free(straight(from, to));
  }

  /// From now on half of what is kept beyond the margin will do: for what is rounded off a path that was found.
  void relax() { relaxed_ = true; }

  /// What made the last posture or stretch not free; a is -1: the range of a joint.
  [[nodiscard]] const Obstruction& last_obstruction() const { return last_; }
  /// What did so most often; a is -1: nothing yet.
  [[nodiscard]] Obstruction most_frequent_obstruction() const;
  /// How many postures were looked at, and among how much that is swept: a measure of work that does not depend on the
  /// machine.
  [[nodiscard]] std::int64_t looks() const { return looks_ + swept_looks_ / kSweptInALook; }

 private:
  /// A posture near which a pair may be nearer than elsewhere.
  struct Exception {
    double least = 0.0;  ///< m: distance that is demanded there
    double slope = 0.0;  ///< by how much more for each m that the bodies may have moved since
    JointVector q;
  };
  struct Pair {
    collision::BodyPair bodies;
    JointVector reach;   ///< by joint: no point of one moves further against the other than this times the joint, m
    double keep = 0.0;   ///< m
    double floor = 0.0;  ///< m: what collision checks demand
    bool holds = false;  ///< a held part and what it may be set down on
    bool parts = false;  ///< may overlap at the start, however deep
    int sweep = -1;      ///< what b sweeps, in sweeps_; -1: it stands
    std::vector<Exception> exceptions = {};
    double steepest = 0.0;  ///< slope of the exceptions
    std::int64_t blocked = 0;
    std::size_t nearest = 0;  ///< pose of the sweep at the last look
    /// s: first and last pose of the sweep that was in the way; NaN: none, or not known
    double from = std::numeric_limits<double>::quiet_NaN(), to = from;
  };
  /// A pair that is not proven yet between two looks, with its room at both.
  struct Open {
    std::size_t pair;
    double room_begin, room_end;
  };

  /// A part of a stretch that is not proven yet.
  struct Gap {
    double begin, end;
    std::vector<Open> open;
  };

  void find_pairs(const FreeSpaceOptions& options);
  void add_pair(int a, int b, int sweep, const collision::PairRule& rule, const FreeSpaceOptions& options);
  /// Number of what a body sweeps, -1: it stands; nothing: it moves, and what it sweeps does not count.
  [[nodiscard]] std::optional<int> sweep_of(int body, const FreeSpaceOptions& options);
  /// How far a point of a body may be from the axis of a joint that moves it, m; negative: it does not.
  [[nodiscard]] double lever_of(int body, std::size_t joint) const;
  [[nodiscard]] double longest_slide(const collision::Body& body) const;
  [[nodiscard]] int parent_of(int body) const;
  [[nodiscard]] bool in_range(const JointVector& q);
  void put(const JointVector& q);
  /// What is demanded of a pair at a posture, m.
  [[nodiscard]] double demanded(const Pair& pair, const JointVector& q) const;
  /// How much further apart they are than demanded, from below, m; exact where that is little.
  /// @param enough  m: more is not needed
  [[nodiscard]] double room(Pair& pair, const JointVector& q, double enough);
  /// The same where their poses are.
  [[nodiscard]] double room_here(Pair& pair, double least, double enough);
  /// Puts the second body of a pair at a pose of what it sweeps.
  void put_swept(const Pair& pair, std::size_t pose);
  /// Their distance at the posture that was put, exact below what the pair keeps. m
  [[nodiscard]] double distance(Pair& pair);
  [[nodiscard]] double distance_here(Pair& pair, double enough);
  static void add_exception(Pair& pair, Exception exception);
  [[nodiscard]] Obstruction obstruction(const Pair& pair, double distance) const;
  /// By how much room can shrink over a stretch, m.
  [[nodiscard]] double way_of(const Pair& pair, const Stretch& stretch) const;
  bool note_blocked(Pair& pair, double room, const JointVector& q);
  /// The pairs that are not proven by a look at both ends. @return nothing: one of them is too near
  [[nodiscard]] std::optional<std::vector<Open>> open_at_ends(const Stretch& stretch);
  /// Looks at the middle of a gap. @return false: a pair is too near there
  [[nodiscard]] bool halve(const Stretch& stretch, const Gap& gap, Gap& left, Gap& right);

  const collision::Scene& scene_;
  collision::State state_;
  std::vector<int> joints_;
  JointVector lower_, upper_;
  bool relaxed_ = false;
  std::vector<int> order_;  ///< bodies that move, parents first
  collision::Poses poses_;
  std::vector<Eigen::Vector3d> centres_;  ///< of the balls around all bodies, in the world
  std::vector<SweepTree> sweeps_;
  std::map<int, int> sweep_of_;  ///< by body
  std::vector<Pair> pairs_;
  Obstruction last_;
  static constexpr std::int64_t kSweptInALook = 8;  ///< about as much work as a posture among what stands
  std::int64_t looks_ = 0, swept_looks_ = 0;
};

}  // namespace takt::planning
