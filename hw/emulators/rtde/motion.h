#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/motion/path.h"
#include "core/motion/time_law.h"
#include "hw/emulators/rtde/tool_kinematics.h"

namespace takt::hw::rtde {

/// A motion from rest to rest: to joint positions, or of the tool to a pose, on a line or an arc.
struct MoveRequest {
  enum class Kind : std::uint8_t { kJoints, kLine, kArc };
  Kind kind = Kind::kJoints;
  JointVector q_goal;                                           ///< kJoints
  Eigen::Isometry3d X_BT_goal = Eigen::Isometry3d::Identity();  ///< else
  Eigen::Isometry3d X_BT_via = Eigen::Isometry3d::Identity();   ///< kArc
  double velocity = 0.0, acceleration = 0.0;                    ///< of the leading axis, or of the tool; at most
  double time = 0.0;                                            ///< s; if > 0 it decides, as far as the joints can
  double blend_radius = 0.0;  ///< m; the next motion may begin that far before the end
};

/// Compliance of the tool: what force_mode() asks for, and freedrive.
struct ForceTask {
  Eigen::Isometry3d X_BTask = Eigen::Isometry3d::Identity();  ///< axes of the task; only the turn counts
  bool in_tool_axes = false;                                  ///< the axes turn with the tool
  std::array<bool, 6> compliant{};
  Vector6 wrench = Vector6::Zero();  ///< that the tool is to exert along compliant axes, N and Nm
  Vector6 limits = Vector6::Zero();  ///< speed along compliant axes, m/s and rad/s
  double gain = 1.0;                 ///< of force_mode_set_gain_scaling()
};
/// Freedrive: the tool goes where a hand leads it.
[[nodiscard]] ForceTask led_by_hand();

/// What the controller tells its joints: a position for each control cycle, made of what programs ask for. One thread.
///
/// The order of what counts: a stop, then the newest command. Moves are planned from rest with bounded jerk; blended
/// ones overlap. servoj() follows its goal with a first-order lag, T = lookahead * 300 / gain: in one cycle h a share
/// of 1 - exp(-h / T) of the distance. Velocities of joints keep the limits of the model; a position outside of its
/// range is a fault.
class Motion {
 public:
  /// @param period  of the control cycle, s
  Motion(std::shared_ptr<const device::ArmDescription> arm, double period);

  [[nodiscard]] ToolKinematics& kinematics() { return kinematics_; }
  [[nodiscard]] const ToolKinematics& kinematics() const { return kinematics_; }

  /// The newest position, rad, and its mean velocity since the one before.
  [[nodiscard]] const JointVector& q() const { return q_; }
  [[nodiscard]] const JointVector& dq() const { return dq_; }
  [[nodiscard]] bool at_rest() const;
  /// The same, but for what compliance adds.
  [[nodiscard]] bool commands_rest() const;

  /// Holds the joints there; all commands are dropped.
  void rest_at(const JointVector& q);

  // -- Commands ------------------------------------------------------------------------------------------------------
  /// @return why it cannot be, or nothing.
  [[nodiscard]] std::optional<std::string> move(const MoveRequest& request);
  /// The move is over, or so near to its end that the next one may begin.
  [[nodiscard]] bool move_done() const;
  void servo(const JointVector& goal, double lookahead, double gain);
  void speed_joints(const JointVector& dq, double acceleration);
  /// @param V_BT_B  of the tool @param acceleration  m/s^2
  void speed_tool(const Vector6& V_BT_B, double acceleration);
  /// Brakes every joint, in proportion. @param deceleration  of the fastest joint, rad/s^2
  void stop(double deceleration);
  /// @param deceleration  of the tool, m/s^2
  void stop_tool(double deceleration);
  void set_force_task(const std::optional<ForceTask>& task);
  [[nodiscard]] bool has_force_task() const { return force_task_.has_value(); }
  /// As fast as the limits of the model allow; moves are kept and go on when it is over (pause, protective stop).
  void halt(bool on) { halted_ = on; }

  /// The next cycle. @param speed  share of the speed slider, 0..1 @param wrench_B  measured at the tool
  /// @return what went wrong, or nothing; the motion has stopped then.
  [[nodiscard]] std::optional<std::string> step(double speed, const Vector6& wrench_B);

  /// Deceleration of programs that leave without a stop, rad/s^2.
  static constexpr double kDeceleration = 4.0;

 private:
  /// A planned move and how far it is.
  struct Track {
    std::variant<motion::JointLine, motion::CartesianLine, motion::CartesianArc> geometry;
    motion::TimeLaw law;
    double time = 0.0;
    JointVector q, q_goal;  // now and at the end
    double blend_time = 0.0;
    [[nodiscard]] bool over() const { return time >= law.duration(); }
  };
  struct Idle {};
  struct Servo {
    JointVector goal;
    double share = 0.0;
  };
  struct Speed {
    JointVector dq;
    double acceleration = 0.0;
  };
  struct ToolSpeed {
    Vector6 V_BT_B;
    double acceleration = 0.0;
  };
  struct Stop {
    double share = 0.0;  // of the velocity at its begin that is lost in a cycle
    JointVector dq;
  };
  using Activity = std::variant<Idle, Servo, Speed, ToolSpeed, Stop>;

  std::optional<std::string> begin(const MoveRequest& request);
  [[nodiscard]] std::optional<std::string> plan(const MoveRequest& request, Track& track) const;
  void plan_joints(const MoveRequest& request, Track& track) const;
  void plan_tool(const MoveRequest& request, Track& track, double length, double angle) const;
  [[nodiscard]] double time_of_blend(const Track& track, double length, double radius) const;
  [[nodiscard]] bool stretch_to_limits(Track& track) const;
  [[nodiscard]] bool advance(Track& track, double time) const;
  [[nodiscard]] bool sample(const Track& track, double time, JointVector& q) const;
  bool step_tracks(double time, JointVector& q);
  void begin_stop(double share);
  void fold();
  [[nodiscard]] JointVector next_velocity(double speed);
  [[nodiscard]] JointVector servo_velocity(const Servo& servo) const;
  [[nodiscard]] JointVector towards(const JointVector& dq, double acceleration) const;
  [[nodiscard]] JointVector limited(JointVector dq) const;
  [[nodiscard]] JointVector force_velocity(const ForceTask& task, const Vector6& wrench_B) const;
  void step_force(const Vector6& wrench_B);
  [[nodiscard]] std::optional<std::string> check() const;

  ToolKinematics kinematics_;
  const motion::JointLimits limits_;
  double period_;
  JointVector q_, dq_;
  Activity activity_;
  std::vector<Track> tracks_;           // the newest last; the others are being blended out
  std::optional<MoveRequest> waiting_;  // for rest
  std::optional<ForceTask> force_task_;
  JointVector force_dq_, offset_;  // of the force task: its velocity, and what it has added
  bool halted_ = false;
  double rate_ = 1.0;  // of the tracks' time
};

}  // namespace takt::hw::rtde
