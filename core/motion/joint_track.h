#pragma once

#include <optional>
#include <vector>

#include "core/motion/leg.h"

namespace takt::motion {

/// The joints of one arm along a planned motion, prepared to be asked for at many times. Joint pieces are exact.
/// Cartesian pieces are followed once by inverse kinematics, on the branch of the plan, and interpolated between nodes
/// with position, velocity and acceleration (quintic), which is exact to well below a micrometre at the tool.
/// Immutable; refers to nothing. Thread: any.
class JointTrack {
 public:
  /// @return nothing where a piece cannot be followed, which no plan lets happen. Realtime: setup, deterministic.
  [[nodiscard]] static std::optional<JointTrack> follow(const ArmModel& arm, const Motion& motion);
  /// The same for an arm that follows the path of another one, with that one's law: of two arms that move as one.
  [[nodiscard]] static std::optional<JointTrack> follow(const ArmModel& arm, const Motion& motion, const TimeLaw& law);

  [[nodiscard]] double duration() const { return law_.duration(); }  ///< s
  /// Joint positions at path time tau (s), rad or m. Realtime: cyclic, O(log pieces).
  [[nodiscard]] JointVector at(double tau) const;
  /// No joint accelerates more between two path times (s), rad/s^2 or m/s^2: from the largest derivatives of the path
  /// at its nodes, with a quarter of reserve for what is between them, and the rates of the law. Realtime: setup.
  [[nodiscard]] JointVector largest_acceleration(double from, double to) const;

 private:
  struct Node {
    JointVector q, dq, ddq;  ///< derivatives by t, which runs from 0 to 1 over the piece
  };
  struct Piece {
    double s_begin = 0.0, s_end = 1.0;
    PathPiece path;
    std::vector<Node> nodes = {};         ///< equally spaced in t; of a Cartesian piece
    JointVector first = {}, second = {};  ///< largest derivatives by s
  };
  [[nodiscard]] static JointVector between(const std::vector<Node>& nodes, double t);
  static void find_derivatives(Piece& piece);

  TimeLaw law_;
  std::vector<Piece> pieces_;
};

}  // namespace takt::motion
