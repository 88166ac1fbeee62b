#pragma once

#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/force/pressing.h"

/// "press": touches along a direction and holds a force. Realtime: setup.
namespace takt::operations {

struct PressParameters {
  std::string arm = {}, sensor = {};  ///< empty: the only one
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in = "tcp";                                ///< whose axes the direction is along
  double force = 10.0, approach = 0.002, travel = 0.05;  ///< N, m/s, m
  /// For which the force is held once it is there, s. Without it and without `until` as a step for half a second, in a
  /// transaction until it is cancelled.
  std::optional<double> seconds = {};
  std::optional<expression::StateSource> until = {};
  std::optional<ComplianceParameters> compliance = {};
  double tolerance = 0.1;                                ///< share of the force: so far off counts as at force
  std::optional<double> depth = {};                      ///< m beyond the touch at most
  std::optional<double> lateral = {};                    ///< N across the direction at most
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};

[[nodiscard]] const ParameterTable<PressParameters>& press_parameters();
/// As an activity: without `seconds` and `until` for half a second, as a step.
[[nodiscard]] std::unique_ptr<OperationCommand> press_command(const PressParameters& parameters);
[[nodiscard]] inline OperationForm<PressParameters> form_of(const PressParameters&) {
  return {"press", press_parameters, &PressParameters::arm, press_command};
}
[[nodiscard]] Operation press_operation();

}  // namespace takt::operations
