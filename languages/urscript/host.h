#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "core/base/text_location.h"
#include "core/kinematics/types.h"

namespace takt::languages::urscript {

/// Where a motion goes: joint positions, or a pose of the flange in the base of the arm.
struct MotionGoal {
  kinematics::JointVector q;  ///< rad or m; empty: the pose
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
};

/// A force along one axis, which the arm exerts while it stands or moves.
struct ForceCommand {
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< of unit length
  bool in_tool = false;                      ///< its axes: those of the tool, else of the base
  double force = 0.0;                        ///< N, > 0
  double velocity = 0.0;                     ///< m/s, > 0: the largest along the direction
};

/// One motion, complete.
struct MotionCommand {
  enum class Kind : std::uint8_t { kJoints, kLine, kArc };
  Kind kind = Kind::kJoints;
  MotionGoal via = {}, goal = {};  ///< via: of an arc
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  double acceleration = 0.0;  ///< > 0; rad/s^2 or m/s^2
  double velocity = 0.0;      ///< > 0; rad/s or m/s
  double time = 0.0;          ///< s; 0: as velocity and acceleration say
  double radius = 0.0;        ///< m; 0: no blend
  bool tangential = false;    ///< the tool turns with the arc
  std::optional<ForceCommand> force = {};
  std::string word = {};
  TextLocation at = {};
};

/// What the arm does until something else is commanded.
struct LastingCommand {
  enum class Kind : std::uint8_t { kServo, kSpeed, kFreedrive, kForce };
  Kind kind = Kind::kServo;
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();   ///< of kServo
  kinematics::Vector6 twist = kinematics::Vector6::Zero();  ///< of kSpeed: of the tool, in axes of the base
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  ForceCommand force = {};  ///< of kForce
  double seconds = 0.0;     ///< until the next one of its kind is meant to come
  TextLocation at = {};
};

/// Kinds of signals.
enum class Signal : std::uint8_t { kDigitalIn, kDigitalOut, kAnalogIn, kAnalogOut };

/// What a program runs on: an arm with its signals, or a test. What cannot be is told as a text; empty: all is well.
class Host {
 public:
  virtual ~Host() = default;
  /// Seconds since something, never falling; and those between two cycles.
  [[nodiscard]] virtual double now() const = 0;
  [[nodiscard]] virtual double cycle() const = 0;
  /// All motions that were given are over, and the arm rests, or does what lasts.
  [[nodiscard]] virtual bool settled() = 0;
  /// Motions that were given and are not over.
  [[nodiscard]] virtual int unfinished() = 0;
  [[nodiscard]] virtual std::string move(MotionCommand motion) = 0;
  /// Begins what lasts, or changes it while it does. Motions that were given are over.
  [[nodiscard]] virtual std::string last(const LastingCommand& command) = 0;
  /// Something lasts.
  [[nodiscard]] virtual bool lasts() const = 0;
  /// Brakes on the path, and forgets what was given.
  virtual void stop() = 0;
  /// @param beside  at once, beside the motions; else after all that was given
  [[nodiscard]] virtual std::string write(Signal output, int number, double value, bool beside,
                                          const TextLocation& at) = 0;
  /// @return nothing: there is no such signal
  [[nodiscard]] virtual std::optional<double> read(Signal signal, int number) = 0;
  /// Carries out a call of the map, after all that was given.
  virtual void call(const std::string& name, const TextLocation& at) = 0;
  /// Sets the force/torque sensor to zero, after all that was given.
  [[nodiscard]] virtual std::string tare(const TextLocation& at) = 0;
  virtual void message(const std::string& title, const std::string& text, const TextLocation& at) = 0;
  /// Where the arm is, rad or m: as it is sent, or as it is measured.
  [[nodiscard]] virtual kinematics::JointVector joints(bool measured) = 0;
  [[nodiscard]] virtual Eigen::Isometry3d flange(const kinematics::JointVector& q) = 0;
  /// Joint positions with this pose of the flange, the nearest ones; nothing: it is out of reach.
  [[nodiscard]] virtual std::optional<kinematics::JointVector> solve(const Eigen::Isometry3d& X_BF,
                                                                     const kinematics::JointVector& near) = 0;
  /// Tool centre point in the flange at the beginning.
  [[nodiscard]] virtual Eigen::Isometry3d tool() const = 0;
};

}  // namespace takt::languages::urscript
