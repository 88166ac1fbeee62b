#pragma once

#include <cstdint>
#include <memory>

#include "core/motion/limits.h"

namespace takt::motion {

/// Jerk-limited motion towards a target that may change in every cycle, for 1 to kMaxJoints axes at once, in the
/// shortest time from whatever state there is. The profiles are computed by Ruckig (Berscheid, Kroeger, RSS 2021).
///
/// Owned by one net, called once a cycle. Realtime: cyclic but for the constructor; bounded, no allocation.
class OnlineGenerator {
 public:
  enum class Status : std::uint8_t {
    kMoving,
    kArrived,    ///< on the target, with the target's velocity
    kBadInput,   ///< sizes differ, a limit is not in [kLeast, kMost], a number is beyond kMost, or the target's
                 ///< velocity is beyond the limit
    kNoSolution  ///< the solver found no profile
  };
  /// How the axes of one motion belong together.
  enum class Synchronization : std::uint8_t {
    kTime,   ///< all arrive at one time
    kPhase,  ///< on a straight line wherever the state allows it, else as kTime
    kNone    ///< each as fast as it can
  };
  /// The numbers within which profiles are computed.
  static constexpr double kLeast = 1e-6, kMost = 1e9;

  struct State {
    JointVector q, dq, ddq;
  };
  /// Of each axis, > 0. The velocity limit is not looked at by follow_velocity().
  struct Limits {
    JointVector velocity, acceleration, jerk;
  };

  /// @param axes  1 to kMaxJoints. Realtime: setup.
  OnlineGenerator(int axes, Synchronization synchronization);
  ~OnlineGenerator();
  OnlineGenerator(OnlineGenerator&&) noexcept;
  OnlineGenerator& operator=(OnlineGenerator&&) noexcept;

  /// Begins here. q, dq and ddq have one number per axis.
  void start(const State& state);
  /// One period (s) on the way to a position, to be passed with a velocity. On kBadInput and kNoSolution the state
  /// stays.
  Status follow_position(const JointVector& target, const JointVector& target_velocity, const Limits& limits,
                         double period);
  /// One period on the way to a velocity.
  Status follow_velocity(const JointVector& target, const Limits& limits, double period);

  [[nodiscard]] const State& state() const;
  /// Time to the target from now on, s; 0 once it is reached.
  [[nodiscard]] double time_left() const;

  struct Impl;  ///< for the .cc alone

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::motion
