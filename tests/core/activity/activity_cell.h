#pragma once

#include <algorithm>
#include <vector>

#include "app/interfaces/actuator_interfaces.h"
#include "core/activity/composition.h"
#include "tests/core/command/command_cell.h"

namespace takt::test {

/// The fake cell of the commands with the channels that activities use, and the loop of a program.
class ActivityCell : public CommandCell {
 public:
  ActivityCell()
      : CommandCell([](CommandCell& own) {
          const Diagnostics diagnostics = activity::declare_channels(own.core, own.cell);
          EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
        }) {}

  activity::Runtime program{core, cell, [this] { step(); }};
  app::Actuator robot{program, "arm"};
  app::MotionInterface motion = robot.use<app::MotionInterface>();

  /// Cycles, from the first set point of `from` to the last of `to`, in which the arm stood.
  int cycles_at_rest(std::int64_t from, std::int64_t to) const {
    return static_cast<int>(std::ranges::count_if(backend->sent, [&](const device::ArmSetPoint& sent) {
      return sent.cycle >= from && sent.cycle <= to && sent.dq.cwiseAbs().maxCoeff() < 1e-6;
    }));
  }
  /// The tool's nearest way to a point over all that was sent, m.
  double nearest_to(const Eigen::Vector3d& p_B) const {
    double nearest = 1e9;
    for (const auto& sent : backend->sent) {
      const Eigen::Isometry3d X_BT = arm->chain->forward(sent.q) * cell.arms.at("arm").X_FT;
      nearest = std::min(nearest, (X_BT.translation() - p_B).norm());
    }
    return nearest;
  }
};

}  // namespace takt::test
