#pragma once

#include <string>

#include "core/command/mapping.h"
#include "serve/served_cell.h"

namespace takt::serve {

/// How an arm is moved by hand.
struct JogRequest {
  std::string arm;
  bool joints = false;       ///< single joints by their rates; else the tool by its velocity
  std::string in = "world";  ///< a frame of the cell along whose axes the velocity is; "tcp": those of the tool
  std::int64_t timeout_cycles = 100;
  double linear_max = 0.1, angular_max = 0.5;  ///< of the tool, m/s and rad/s
};

/// The net that moves the arm by what comes through its jog channel. When nothing has come for the cycles of the
/// timeout, counted in the net, the arm comes to rest within its limits and the net ends; likewise when it is
/// cancelled.
/// @return the net, or what is wrong with the request: an unknown frame, an arm without inverse kinematics. Realtime:
/// setup.
[[nodiscard]] Result<command::MappedCommand> jog_net(const ServedCell& cell, const JogRequest& request);

}  // namespace takt::serve
