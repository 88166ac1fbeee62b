#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/command/actuator.h"
#include "core/expression/cell.h"
#include "core/motion/planner.h"

/// The parts of a fragment that follow a planned motion. Realtime: setup.
namespace takt::command {

/// What acts on a planned motion while it runs, through its path clock (rows P1, P2), beside the speed of its actuator.
struct ClockInputs {
  std::optional<expression::RealSensor> speed = {};  ///< factor of the rate of path time, 0 to 1; null: it stops
  std::optional<expression::State> pause = {};  ///< while it holds the motion stops on its path; null counts as true

  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const;
};

/// The channels in which the motions of an arm show their clock to their successors.
[[nodiscard]] std::string path_time_channel(const std::string& arm);  ///< s
[[nodiscard]] std::string path_rate_channel(const std::string& arm);  ///< 1

/// The rate of a motion: the speed that people want of its actuator, times one of its own. Nothing: neither is there.
[[nodiscard]] std::optional<expression::RealSensor> speed_on(const ActuatorModel& actuator,
                                                             const std::optional<expression::RealSensor>& own);

/// Adds "clock" (PathClock) and "law" (TimeLaw) of a motion. A cancel of the fragment, the speed of the actuator and
/// the inputs are target rates of the clock.
/// @param waits_for  a Boolean in the fragment until which, and without which, the motion rests; empty: nothing
void add_clock(expression::FragmentWriter& fragment, const ActuatorModel& actuator, const motion::Motion& motion,
               const ClockInputs& inputs, const std::string& waits_for = {});

[[nodiscard]] SetPointKind kind_of(const motion::Path& path);
/// Adds a path that follows "law". @return the set point that it gives
[[nodiscard]] SetPoint add_path(expression::FragmentWriter& fragment, const std::string& id, const motion::Path& path,
                                const Eigen::Isometry3d& X_FM);

}  // namespace takt::command
