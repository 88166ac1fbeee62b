#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/command/action.h"
#include "core/command/actions/planned_path.h"
#include "core/command/command.h"
#include "core/command/start_positions.h"
#include "core/motion/leg.h"
#include "core/motion/planner.h"

/// Motions that are planned before they are carried out (docs/motion.md). Realtime: setup.
namespace takt::command {

/// A second arm on the same law and clock.
struct PlannedPartner {
  std::shared_ptr<const motion::Motion> motion;  ///< its law does not count
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();
};

/// A motion that is planned already, of one arm or of two (arm_pair()).
struct PlannedMotion {
  std::shared_ptr<const motion::Motion> motion;
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();  ///< the frame that Cartesian pieces move, in the flange
  std::vector<double> handed_over = {};                    ///< path time at which each via point is passed, s
  ClockInputs clock = {};
  std::string name = "motion";  ///< for people
  /// Of a motion that goes on with another one: path time (s, of its own) and rate with which its clock begins; null or
  /// not given: 0 and 1.
  struct ClockBegin {
    std::optional<expression::RealSensor> time = {}, rate = {};
  } clock_initial = {};
  /// Channels in which it shows where its clock is, for its successor; empty: it does not.
  struct ClockChannels {
    std::string time = {}, rate = {};
  } clock_outputs = {};
  std::optional<PlannedPartner> partner = {};
  /// How far before its goal another motion may go on with it. It shows its clock then.
  struct BlendWindow {
    motion::Blend blend = {};
    std::optional<expression::State> abort_if = {};  ///< must not hold on what is left of it
    int abort_handlers = 0;                          ///< its first event handlers, which cancel it where that holds
  };
  std::optional<BlendWindow> leaving = {};
  std::optional<expression::State> begins_there = {};  ///< must hold in its first cycle, or its net fails
};
[[nodiscard]] Action planned(PlannedMotion motion);

/// What motions may be asked for. Shares are of the limits of the arm.
struct PlanParameters {
  double velocity = 1.0;                       ///< (0, 1]
  double acceleration = 1.0;                   ///< (0, 1]
  std::optional<double> linear_velocity = {};  ///< of the tool centre point, m/s
  std::optional<Eigen::Isometry3d> X_FM = {};  ///< the frame that moves; default: the arm's tool centre point
  ClockInputs clock = {};
  /// Where it begins, rad or m of each joint, so that it can be planned and loaded before the arm is there
  /// (scheduleAfter of the papers). START checks whether the arm is there; inside of a transaction the net fails if it
  /// is not. Default: where the arm is then, as far as that is known.
  std::optional<kinematics::JointVector> from = {};
  /// How far before its goal the motion that follows the whole command may go on with it, where all else is over by
  /// then (TreeEnd). The cell declares the channels of its arms (activity::declare_channels()).
  motion::Blend blend = {};
};

// Motions from where the arm is when its command is planned. Goals of frames are in the arm's base, m. They offer
// `at_path`, `via_passed`, `progress`, `error` (no joints for a pose). A single joint() takes a PTP with a goal of its
// own.
[[nodiscard]] Action ptp(const kinematics::JointVector& q_goal, const PlanParameters& parameters = {});
[[nodiscard]] Action lin(const Eigen::Isometry3d& X_BM_goal, const PlanParameters& parameters = {});
[[nodiscard]] Action circ(const motion::ArcThrough& arc, const PlanParameters& parameters = {});
[[nodiscard]] Action circ(const motion::ArcAbout& arc, const PlanParameters& parameters = {});
[[nodiscard]] Action spline(const std::vector<Eigen::Isometry3d>& poses_BM, const PlanParameters& parameters = {});
[[nodiscard]] Action spline(const std::vector<kinematics::JointVector>& points, const PlanParameters& parameters = {});

/// A motion of a sequence, and how it is blended into the next one.
struct SequencePart {
  motion::LegMaker geometry;
  PlanParameters parameters = {};
  motion::Blend blend = {};
};
/// Several motions as one (docs/motion.md); via_passed(i) holds from the middle of blend i on. The frame that moves,
/// the inputs of the clock and the start are those of the first; PlanParameters::blend counts at the last.
[[nodiscard]] Action sequence(std::vector<SequencePart> parts);

/// Plans a motion from where its arm, or its two arms, will be (Places as ActionModel::plan() has them).
using MotionPlanner = std::function<Result<PlannedMotion>(const expression::Places& q_start)>;
/// A motion with a planner of its own.
/// @param name   for people
/// @param gives  kPath of one arm, kPair of two as one
[[nodiscard]] Action planned_by(std::string name, SetPointKind gives, MotionPlanner planner);

/// How a tree of commands leaves the arms that it drives.
struct TreeEnd {
  expression::Places rest = {};  ///< arms of which it is certain before the run where they are when all has ended
  /// The command of a motion that may be left for the one that follows the tree (PlannedMotion::leaving): all other
  /// commands are over before it begins, and nothing waits for its end. Null: there is none. Of the command.
  const CommandNode* left = nullptr;
};

/// Plans every action of the tree that needs it: from where its arm will be when what starts before it on that arm has
/// come to its natural end; the first one from the arm's set point. An action that is cancelled ends elsewhere: a
/// planned motion that could follow it then is refused.
/// @return diagnostics with paths in the tree. Realtime: setup, deterministic.
[[nodiscard]] Diagnostics plan(const Command& command);
/// The same from other positions than the set points of now.
/// @param[in,out] places  where arms are; then where they are when all has come to its natural end
/// @param[out] end        how the command leaves its arms; may be null
[[nodiscard]] Diagnostics plan(const Command& command, expression::Places& places, TreeEnd* end = nullptr);

}  // namespace takt::command
