#pragma once

#include <string>
#include <vector>

#include "core/activity/activity.h"

/// Activities made of activities: each is one command in one real-time context, and says of its actuators what its
/// parts say (docs/activity-layer.md). Their parts may be composed again. Throw ActivityError for parts of several
/// runtimes, and where what runs together shares an actuator. Realtime: setup.
namespace takt::activity {

/// One after the other, in the cycle after the end of the one before. Motions of one arm with a blend between them
/// become one motion.
[[nodiscard]] Activity sequence(const std::vector<Activity>& parts);
/// All begin in the same cycle; over when all are. Their actuators are disjoint.
[[nodiscard]] Activity parallel(const std::vector<Activity>& parts);
/// Which of the two is begun is decided in the first cycle. Null of the condition counts as not holding.
[[nodiscard]] Activity conditional(const expression::State& condition, const Activity& then, const Activity& otherwise);

/// What must not hold while it runs, whatever it is: it is cancelled then, so its arms come to rest, and the run fails
/// (RunFailure::kAborted); the same when it is unknown (row N3). What follows begins at its end: of motions that are to
/// be blended MotionParameters::abort_if is the one.
[[nodiscard]] Activity abort_if(const Activity& activity, const expression::State& state);

/// Something that begins at a condition while the main task runs.
struct Subtask {
  Activity activity;
  /// Share of the path of the main task, which is one motion; or
  std::optional<double> at_share = {};
  /// a state of the cell.
  std::optional<expression::State> when = {};
};
/// Over when the main task and all subtasks that were begun are.
[[nodiscard]] Activity with_subtasks(const Activity& main, const std::vector<Subtask>& subtasks);

}  // namespace takt::activity
