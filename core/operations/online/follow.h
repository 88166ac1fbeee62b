#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/online/online.h"

/// "follow": the tool follows a moving frame, or the poses of a channel. Realtime: setup.
namespace takt::operations {

struct FollowParameters {
  std::string arm = {};                        ///< empty: the only one
  std::optional<std::string> channel = {};     ///< of type Frame: pose of the tool in `in`; else the frame `in` itself
  std::string in = {};                         ///< with a channel, empty means the world
  double linear_max = 0.1, angular_max = 0.5;  ///< of the tool, m/s and rad/s
  std::optional<double> seconds = {};          ///< s; nothing: until it is cancelled
  std::optional<expression::StateSource> until = {};
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  std::optional<ComplianceParameters> compliance = {};   ///< nothing: as the arm is
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};
[[nodiscard]] const ParameterTable<FollowParameters>& follow_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> follow_command(const FollowParameters& parameters);
[[nodiscard]] inline OperationForm<FollowParameters> form_of(const FollowParameters&) {
  return {"follow", follow_parameters, &FollowParameters::arm, follow_command};
}
[[nodiscard]] Operation follow_operation();

}  // namespace takt::operations
