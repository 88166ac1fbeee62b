#pragma once

#include <optional>
#include <vector>

#include "core/command/action.h"
#include "core/expression/cell.h"
#include "core/motion/path_clock.h"

/// When weaves are laid over a planned motion, and how its arm keeps its limits with them (docs/motion.md).
/// Realtime: setup.
namespace takt::command {

/// Of the limits of acceleration and jerk, for a path that something is laid over: the rest is for that.
inline constexpr double kShareWithOverlay = 0.8;

/// A sine beside the path, over path time: it stops while the motion is paused, and slows down with it.
struct WeaveParameters {
  double amplitude = 0.002;                                ///< m
  double frequency = 2.0;                                  ///< Hz
  Eigen::Vector3d direction_M = Eigen::Vector3d::UnitY();  ///< in the axes of the frame that moves; length 1
  double ramp = 0.5;  ///< path time in which it grows from the start and fades to the end, s

  bool operator==(const WeaveParameters&) const = default;
};

/// Of motions that are blended into each other, one by one; nothing: that motion has none.
using Weaves = std::vector<std::optional<WeaveParameters>>;

/// One weave on the path clock of the whole: it grows from `begin` and has faded at `end`.
struct WeaveWindow {
  WeaveParameters weave;
  double begin = 0.0, end = 0.0;  ///< s
  std::size_t motion = 0;         ///< the first of the motions that have it
};

struct WeavePlan {
  std::vector<WeaveWindow> windows;  ///< one after the other, apart
  motion::ClockBounds clock;         ///< what path and weaves together allow
};

/// Figures that are none, at "/amplitude", "/frequency", "/ramp", "/direction".
[[nodiscard]] Diagnostics check_figures(const WeaveParameters& weave);
/// What a weave needs all the time, whatever it is laid over, against what plans leave of the limits of the tool.
[[nodiscard]] Diagnostics check_alone(const WeaveParameters& weave, const motion::CartesianLimits& limits);

/// Places weaves on a planned motion. Neighbours with the same one share it: it goes on through their blend. Otherwise
/// it has faded in the middle of the blend, from where the next one grows; where a blend turns into joints, at its end
/// on the side of the frame.
///
/// The set points of path and weaves together are checked joint by joint, and of the tool, in steps of 1 ms or less:
/// what they need at full rate has to leave the path clock room, and the clock gets what room there is.
/// @param weaves  one for each of its motions, or a single one for the whole; figures that check_figures() lets pass
/// @return diagnostics "/1/ramp", "/1" (index of the motion): moves joints, grows too fast, leaves a range, is too
/// fast.
[[nodiscard]] Result<WeavePlan> plan_weaves(const expression::MountedArm& arm, const ActionModel::PlannedPath& path,
                                            const Weaves& weaves);

}  // namespace takt::command
