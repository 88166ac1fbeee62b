#pragma once

#include <optional>

#include "core/command/actions/compliance_action.h"
#include "core/command/actions/planned_path.h"
#include "core/expression/state.h"
#include "core/motion/leg.h"

/// How planned motions are carried out. Realtime: setup.
namespace takt::activity {

/// Where a motion may be left for the next one: at a share of its time, or of its path.
struct BlendingCondition {
  std::optional<double> time_share = {};  ///< 0.7: when 70 % of its time have passed; [0.5, 1)
  motion::Blend along_path = {};          ///< a distance from its goal, or a share of its path

  BlendingCondition() = default;
  BlendingCondition(double share) : time_share(share) {}  // NOLINT: reads as in the paper: {.blend = 0.7}
  explicit BlendingCondition(const motion::Blend& blend) : along_path(blend) {}
  [[nodiscard]] static BlendingCondition at_distance(double metres);
  [[nodiscard]] bool wanted() const { return time_share || along_path.kind != motion::Blend::Kind::kNone; }
  /// The blend inside of one plan, which has no time yet: a share of the time counts as one of the path.
  [[nodiscard]] motion::Blend inside() const;
};

/// What an activity of a motion needs beside its plan; programs and files have MotionParameters
/// (core/operations/motion/motion.h).
struct MotionOptions {
  BlendingCondition blend = {};  ///< into the motion after it; not with `until`
  /// The arm brakes on its path when this holds (or is unknown, row N3): a guarded motion.
  std::optional<expression::State> until = {};
  bool must_touch = true;  ///< it fails where it comes to its goal and `until` has not held
  /// Compliance of the arm meanwhile; it has to be in that control mode. Default: as the arm is.
  std::optional<command::SpringParameters> compliance = {};
};

using command::path_rate_channel;
using command::path_time_channel;
using command::speed_channel;

}  // namespace takt::activity
