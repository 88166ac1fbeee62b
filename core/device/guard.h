#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/device/backend.h"
#include "core/motion/limits.h"
#include "core/net/value.h"

namespace takt::device {

/// What the guard refused: which rule, which joint, how much and what was allowed.
struct Violation {
  enum class Rule : std::uint8_t {
    kMissing,       ///< a net holds the moving arm and gave no set point in this cycle
    kSize,          ///< not one entry per joint
    kNotFinite,     ///< NaN or infinity in q, dq or ddq
    kPosition,      ///< outside the joint's range, or the fastest stop from here ends outside
    kVelocity,      ///< difference of what was sent, the field dq, or what ddq will bring
    kAcceleration,  ///< second difference of what was sent, or the field ddq
    kJerk,          ///< third difference of what was sent, or the step of ddq
    kInconsistent,  ///< q, dq, ddq do not belong to one motion
    kSideways,      ///< a base whose wheels do not move sideways would
    kStart          ///< the first set point of a net is not where the arm is (row S5); limit = where the arm is
  };
  Rule rule = Rule::kMissing;
  int joint = -1;      ///< -1: the arm as a whole
  double value = 0.0;  ///< rad, rad/s, ... or the same in m
  double limit = 0.0;
};

[[nodiscard]] std::string_view name_of(Violation::Rule rule);

/// The last code before the wire (row S2). It trusts no net and no planner: it forms the differences of the set points
/// that were really sent and holds them, and the derivatives that come with them, to the limits of the joints. It
/// refuses, it never changes a set point. It lets pass only what can still be stopped within the limits of velocity,
/// acceleration and jerk and inside the range, so the stop reaction that follows a trip keeps them too.
///
/// Tolerances against rounding, not slack for planners: kShare of a limit, and what kPositionNoise in q does to the
/// differences. One guard per arm, used by the cycle thread only.
class Guard {
 public:
  static constexpr double kShare = 1e-3;
  static constexpr double kPositionNoise = 1e-11;  ///< rad or m: what inverse kinematics leaves open

  /// @param period  of the core, s. Realtime: setup.
  Guard(const motion::JointLimits& limits, double period);

  /// Starts a new history: the arm has been at rest at `q` for ever. Realtime: cyclic.
  void rest_at(const JointVector& q);

  /// Would this set point be right after those that were sent? Changes nothing. Realtime: cyclic, O(n).
  /// @return what is wrong first, or nothing.
  [[nodiscard]] std::optional<Violation> check(const ArmSetPoint& set_point) const;

  /// The set point was sent: it is the newest of the history. Realtime: cyclic.
  void sent(const ArmSetPoint& set_point);

  /// The newest that was sent, with its derivatives.
  [[nodiscard]] const ArmSetPoint& last() const { return last_; }
  /// True if the newest that was sent neither moves nor accelerates (1e-6 rad/s, 1e-3 rad/s^2, or in m).
  [[nodiscard]] bool at_rest() const { return rests(last_); }
  [[nodiscard]] static bool rests(const ArmSetPoint& set_point);
  [[nodiscard]] const motion::JointLimits& limits() const { return limits_; }

 private:
  [[nodiscard]] std::optional<Violation> check_joint(const ArmSetPoint& next, int joint) const;
  /// The fields dq and ddq; `d1` is the step in q.
  [[nodiscard]] std::optional<Violation> check_derivatives(const ArmSetPoint& next, int joint, double d1) const;
  /// A base that cannot go sideways: differences of what was sent, and the field dq.
  [[nodiscard]] std::optional<Violation> check_rolling(const ArmSetPoint& next) const;
  /// From here the arm can still be stopped inside its limits.
  [[nodiscard]] std::optional<Violation> check_future(const ArmSetPoint& next, int joint) const;

  motion::JointLimits limits_;
  double period_;
  ArmSetPoint last_;
  std::array<JointVector, 2> older_;  ///< q one and two cycles before last_
};

/// "joint A3: velocity 2.31 > 1.92" for people; `joint_names` may be empty. Realtime: cyclic.
[[nodiscard]] net::Text describe(const Violation& violation, const std::vector<std::string>& joint_names);

}  // namespace takt::device
