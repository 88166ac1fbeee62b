#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/online/online.h"

/// "jog": manual control with a dead-man switch. Realtime: setup.
namespace takt::operations {

struct JogParameters {
  std::string arm = {};                                      ///< empty: the only one
  std::optional<expression::StateSource> enabled = {};       ///< "while": the dead-man switch; required
  std::optional<std::string> channel = {};                   ///< of type Twist; else `linear` and `angular`
  std::optional<Eigen::Vector3d> linear = {}, angular = {};  ///< m/s and rad/s, along the axes of `in`
  std::string in = "world";                                  ///< "tcp": along those of the tool
  double linear_max = 0.1, angular_max = 0.5;                ///< of the tool, m/s and rad/s
  std::optional<double> seconds = {};                        ///< s; nothing: until it is cancelled
  std::optional<expression::StateSource> until = {};
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  std::optional<ComplianceParameters> compliance = {};   ///< nothing: as the arm is
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};
[[nodiscard]] const ParameterTable<JogParameters>& jog_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> jog_command(const JogParameters& parameters);
[[nodiscard]] inline OperationForm<JogParameters> form_of(const JogParameters&) {
  return {"jog", jog_parameters, &JogParameters::arm, jog_command};
}
[[nodiscard]] Operation jog_operation();

}  // namespace takt::operations
