#pragma once

#include <optional>
#include <string>

#include "core/command/actions/online_action.h"
#include "core/operations/parameter_table.h"

/// Parameters of the operations that find their set points in the cycle: hold, jog, follow. Realtime: setup.
namespace takt::activity {

/// What ends them, and how the arm yields meanwhile.
struct OnlineParameters : OperationHead {
  std::string arm;
  std::optional<double> seconds;  ///< s; nothing: until it is cancelled
  std::optional<command::Condition> until;
  std::optional<ComplianceRequest> compliance;  ///< nothing: as the arm is
};

struct JogParameters : OnlineParameters {
  std::optional<std::string> channel;              ///< of type Twist; else `linear` and `angular`
  std::optional<Eigen::Vector3d> linear, angular;  ///< m/s and rad/s, along the axes of `in`
  std::string in = "world";                        ///< "tcp": along those of the tool
  std::optional<command::Condition> enabled;       ///< the dead-man switch; always there after reading
  command::FollowWish bounds;
};

struct FollowParameters : OnlineParameters {
  std::optional<std::string> channel;  ///< of type Frame: pose of the tool in `in`; else the frame `in` itself
  std::string in;                      ///< with a channel, empty means the world
  command::FollowWish bounds;
};

[[nodiscard]] const ParameterTable<OnlineParameters>& hold_parameters();
[[nodiscard]] const ParameterTable<JogParameters>& jog_parameters();
[[nodiscard]] const ParameterTable<FollowParameters>& follow_parameters();

}  // namespace takt::activity
