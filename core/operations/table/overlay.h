#pragma once

#include <optional>
#include <string>

#include "core/command/actions/overlay_action.h"
#include "core/operations/table/parameter_table.h"

/// What a motion of a frame may have laid over it: a weave, a force offset (docs/scenarios.md). Realtime: setup.
namespace takt::operations {

/// A shift of the path, along a direction of the tool, that holds a force.
struct ForceOffsetParameters {
  std::string sensor = {};                               ///< empty: the only one
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of the force, in the axes of the tool
  double reach = 0.005;                                  ///< from the path along the direction at most, m
  std::optional<double> retreat = {};                    ///< against it at most, m; nothing: as `reach`
  double force = 10.0, approach = 0.005;                 ///< N; m/s of the offset until contact
  double velocity_max = 0.02, acceleration_max = 0.3, jerk_max = 10.0;  ///< of the offset, m/s, m/s^2, m/s^3
  double lost_max = 0.5;                                                ///< s without contact, once it has touched
  std::optional<double> off_max = {};  ///< s out of the band of the force; nothing: no matter how long
  /// m/s for each newton that is missing; nothing: from the arm's stiffness and delay (docs/force-control.md).
  std::optional<double> gain = {};

  [[nodiscard]] command::ForceOffsetControlParameters control_parameters(const expression::Cell& cell) const;
  /// With how much force the tool of an arm presses.
  [[nodiscard]] expression::RealSensor pressing(const std::string& arm, const expression::Cell& cell,
                                                const expression::Biases& biases) const;
  bool operator==(const ForceOffsetParameters&) const = default;
};

/// The parameters of the two, as objects of a motion.
[[nodiscard]] const ParameterTable<command::WeaveParameters>& weave_parameters();
[[nodiscard]] const ParameterTable<ForceOffsetParameters>& force_offset_parameters();

}  // namespace takt::operations
