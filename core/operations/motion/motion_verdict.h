#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/activity/dual_entry_motion.h"
#include "core/operations/motion/motion.h"

namespace takt::operations {

/// Where a diagnostic of one of several motions belongs.
struct MotionPlace {
  bool has_keys = true;      ///< the keys of this motion can be pointed at
  std::string pointer = {};  ///< of the motion, or of the whole where its keys cannot
  std::string prefix = {};   ///< of the message: which motion is meant; empty: the pointer says it
};
/// @param motion  number; -1: the one that the first goes on with
using MotionPlaces = std::function<MotionPlace(int motion)>;

/// What is wrong with the way in which motions that are one have ended, whoever carries them out: a force or a
/// condition that was not known any more, `abort_if`, a goal that was reached without the touch that was looked for.
/// Realtime: setup.
[[nodiscard]] Diagnostics motion_verdict(const std::vector<MotionTask>& tasks, const activity::GuardedEnd& end,
                                         const MotionPlaces& places);

}  // namespace takt::operations
