#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/online/online.h"

/// "look_at": a camera on an arm keeps a frame in the middle of its picture. Realtime: setup.
namespace takt::operations {

struct LookAtParameters {
  std::string arm = {};                                    ///< empty: the only one
  std::string at = {};                                     ///< frame whose origin is looked at; required
  std::string in = "world";                                ///< frame whose z is up, and whose x has azimuth 0
  double distance = 0.5;                                   ///< m
  double azimuth = 0.0;                                    ///< rad
  double elevation = std::numbers::pi / 6.0;               ///< rad
  double roll = 0.0;                                       ///< rad
  std::optional<std::string> distance_channel = {};        ///< of type Real, m: in place of `distance`
  std::optional<std::string> azimuth_channel = {};         ///< of type Real, rad
  std::optional<std::string> elevation_channel = {};       ///< of type Real, rad
  double linear_max = 0.25, angular_max = 1.0;             ///< of the tool, m/s and rad/s
  double orbit_linear_max = 0.1, orbit_angular_max = 0.3;  ///< of the distance and of the angles, m/s and rad/s
  bool must_reach = false;                                 ///< out of reach: it fails, else it rests there
  std::optional<double> seconds = {};                      ///< s; nothing: until it is cancelled
  std::optional<expression::StateSource> until = {};
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  std::optional<ComplianceParameters> compliance = {};   ///< nothing: as the arm is
  ToolChoice tool = {};                 ///< of the arm: the camera; default: the one that the cell declares
  std::string name = {}, pointer = {};  ///< for people; in its file
};
[[nodiscard]] const ParameterTable<LookAtParameters>& look_at_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> look_at_command(const LookAtParameters& parameters);
[[nodiscard]] inline OperationForm<LookAtParameters> form_of(const LookAtParameters&) {
  return {"look_at", look_at_parameters, &LookAtParameters::arm, look_at_command};
}
[[nodiscard]] Operation look_at_operation();

}  // namespace takt::operations
