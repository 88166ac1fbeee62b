#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/motion/leg.h"
#include "core/motion/path_shape.h"
#include "core/motion/piece_walk.h"
#include "core/motion/planner.h"
#include "core/motion/time_optimal.h"
#include "core/motion/torque_profile.h"

namespace takt::motion {

/// A piece of a path that is to be planned, with what its motion may do.
struct PlannedPiece {
  PathPiece piece;
  PieceShares shares = {};
  /// A walk of this piece, if there is one already: taken where it begins at the same joints and has as many steps.
  const PieceWalk* known = nullptr;
};

/// A path seen in joints, piece by piece; or where the first piece ended that cannot be followed.
struct WalkedPath {
  std::vector<PieceWalk> walks;
  Diagnostics diagnostics;       ///< joints outside their range, and why a walk ended
  std::size_t failed_piece = 0;  ///< the first piece with a diagnostic
};

/// A path as one arm follows it: what any number of laws over it can be judged by.
struct FollowedPath {
  PathShape shape;
  std::optional<TorqueProfile> torques;  ///< nothing: torques are not looked at
  JointVector q_goal;
};

/// How a law suits an arm that it was not made for.
struct PathFit {
  double stretch = 1.0;      ///< by how much it must be stretched so that the arm keeps what a law may use
  bool leaves_room = false;  ///< as it is, it keeps the limits and leaves a clock something
  ClockBounds clock;         ///< that law and arm allow, as it is
  JointVector q_goal;
};

/// Plans the time of a path that is known in pieces: what LIN, CIRC, splines and blended sequences share. Keeps
/// references to its arguments. Realtime: setup, deterministic.
class PathPlanner {
 public:
  /// @param inverse  may be null if no piece is Cartesian   @param X_FM  the frame that Cartesian pieces move
  /// @param load  what the motors move; null: torques are not looked at
  PathPlanner(const kinematics::Chain& chain, const kinematics::InverseKinematics* inverse, const JointLimits& limits,
              const CartesianLimits& cartesian, const Eigen::Isometry3d& X_FM, const DriveLoad* load)
      : chain_(chain), inverse_(inverse), limits_(limits), cartesian_(cartesian), X_FM_(X_FM), load_(load) {}
  /// Keeps references into the model.
  explicit PathPlanner(const ArmModel& arm)
      : PathPlanner(arm.chain, arm.inverse, arm.limits, arm.cartesian, arm.X_FM, arm.drive_load()) {}

  /// Diagnostics at `pointer`, in which a place is "% of the line" (the word for the piece).
  [[nodiscard]] WalkedPath walk(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                                const std::vector<int>& steps, const std::string& pointer) const;
  /// The law with which the pieces (from s = 0 to 1, rest to rest) are run in the shortest time, and its clock.
  /// @return diagnostics of walk()   @param[out] failed_piece  set with diagnostics
  [[nodiscard]] Result<Motion> plan(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                                    const std::string& pointer, std::size_t& failed_piece) const;
  /// The path of a motion as this arm follows it, from its q_start on; its law is not looked at.
  /// @return diagnostics of walk().
  [[nodiscard]] Result<FollowedPath> follow(const Motion& motion, const std::string& pointer) const;
  /// What a motion with a law of its own asks of this arm. @param path  what follow() gave for the motion's path
  [[nodiscard]] PathFit fit(const FollowedPath& path, const Motion& motion) const;
  /// The same for a path that is entered in motion. A diagnostic if there is no law within the limits: then the path
  /// bends too early for the speed. Realtime: setup, deterministic.
  [[nodiscard]] Result<Motion> plan_in_motion(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                                              const MovingStart& start, const std::string& pointer,
                                              std::size_t& failed_piece) const;

 private:
  void check_ranges(const PieceWalk& walk, const char* word, const std::string& pointer,
                    Diagnostics& diagnostics) const;
  void check_rolling(const PieceWalk& walk, const char* word, const std::string& pointer,
                     Diagnostics& diagnostics) const;
  void explain_end(const PieceWalk& walk, const PathPiece& piece, const char* word, const std::string& pointer,
                   Diagnostics& diagnostics) const;
  [[nodiscard]] PathShape shape_of(const std::vector<PlannedPiece>& pieces, const std::vector<PieceWalk>& walks) const;
  [[nodiscard]] ShapeLimits limits_of(const PieceShares& shares) const;
  /// Nothing if torques are not looked at.
  [[nodiscard]] std::optional<TorqueProfile> torques_along(const std::vector<PlannedPiece>& pieces,
                                                           const std::vector<PieceWalk>& walks) const;
  struct JerkPeak {
    double share = 0.0;  ///< of the limit
    double s = 0.0;      ///< where
  };
  /// The largest third difference of the joints over the whole motion.
  [[nodiscard]] JerkPeak largest_jerk(const Motion& motion) const;
  [[nodiscard]] JerkPeak largest_jerk_of_each_step(const Motion& motion) const;
  [[nodiscard]] JerkPeak largest_jerk_along_path(const Motion& motion) const;
  /// @param[in,out] q  joints one step before; unchanged if the posture is not found. @return whether it is
  [[nodiscard]] bool follow(const Motion& motion, const LawPoint& at, JointVector& q) const;
  [[nodiscard]] double jerk_share(const std::array<JointVector, 4>& q) const;

  const kinematics::Chain& chain_;
  const kinematics::InverseKinematics* inverse_;
  const JointLimits& limits_;
  const CartesianLimits& cartesian_;
  Eigen::Isometry3d X_FM_;
  const DriveLoad* load_;
};

/// Diagnostics for Cartesian limits that are not finite or not > 0.
void check_cartesian(const CartesianLimits& limits, Diagnostics& diagnostics);

}  // namespace takt::motion
