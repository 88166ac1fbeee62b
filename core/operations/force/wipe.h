#pragma once

#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/force/pressing.h"

/// "wipe": follows a surface in lanes with a constant force, as in wiping, polishing or sanding. Realtime: setup.
namespace takt::operations {

/// The lanes lie in a rectangle around `centre`, along x of the frame; the force is against its z. The tool keeps its
/// orientation and begins where it is: above the rectangle, so a motion there comes before.
struct WipeParameters {
  std::string arm = {}, sensor = {};                     ///< empty: the only one
  std::string in = {};                                   ///< frame of the surface, its z out of it
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();      ///< of the rectangle in that frame, m
  double length = 0.1, width = 0.1;                      ///< along x and y, m
  double pitch = 0.02;                                   ///< between neighbouring lanes at most, m
  double force = 10.0, approach = 0.002, travel = 0.05;  ///< N; m/s until contact; m along the force, from the start
  double velocity = 0.05;                                ///< along the lanes, m/s
  std::optional<expression::StateSource> until = {};     ///< ends it before its lanes do
  std::optional<ComplianceParameters> compliance = {};
  double tolerance = 0.1;                                ///< share of the force: so far off counts as at force
  std::optional<double> depth = {};                      ///< m beyond the touch at most
  std::optional<double> lateral = {};                    ///< N across the direction at most
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};

[[nodiscard]] const ParameterTable<WipeParameters>& wipe_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> wipe_command(const WipeParameters& parameters);
[[nodiscard]] inline OperationForm<WipeParameters> form_of(const WipeParameters&) {
  return {"wipe", wipe_parameters, &WipeParameters::arm, wipe_command};
}
[[nodiscard]] Operation wipe_operation();

}  // namespace takt::operations
