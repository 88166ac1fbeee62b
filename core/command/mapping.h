#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/command/command.h"
#include "core/net/description.h"
#include "core/rcc/control_core.h"

namespace takt::command {

/// The path clock of a planned motion in its net: ports that the mapping shows.
struct ClockPorts {
  std::string time;             ///< Real, s of path time; null while the motion does not run
  std::string rate;             ///< Real, 1: seconds of path time per second
  std::string rate_derivative;  ///< Real, 1/s

  /// @param clock  id of the primitive in the flat net
  [[nodiscard]] static ClockPorts of(const std::string& clock) {
    return {.time = clock + ".time", .rate = clock + ".rate", .rate_derivative = clock + ".rate_derivative"};
  }
};

/// What the net of a command shows of it.
struct CommandPorts {
  std::string path;                 ///< names from the root, "/screwing/insert"
  std::optional<ClockPorts> clock;  ///< of a planned motion
};

/// An external effect in a net.
struct ExternalPort {
  std::string name;
  std::string port;  ///< Integer: how often it has happened
  ExternalHandler handler;
};

/// A value of the net that shows what went on: a state, a set point, the state of an event.
struct TracedPort {
  std::string name;  ///< for people: "/screwing/insert active"
  std::string port;
};

/// An event of sensors that cancels a planned motion, and where to see when the motion begins to brake.
struct BrakePorts {
  std::string name;                  ///< of the handler, for people: "/screwing/insert/handlers/0"
  std::string event;                 ///< Boolean: the state of the handler
  std::string fragment;              ///< of the command that is cancelled
  ClockPorts clock;                  ///< its path clock
  std::vector<std::string> sources;  ///< primitives that read what the event depends on
};

/// A command as one net.
struct MappedCommand {
  net::NetDescription net;
  rcc::LoadOptions options;  ///< how it takes devices over and leaves them, as far as that is certain
  std::map<std::string, std::string> observed;  ///< name of an observation, port
  std::vector<ExternalPort> externals;
  std::vector<TracedPort> traced;
  std::vector<BrakePorts> brakes;
  std::vector<CommandPorts> commands;  ///< in the order of the tree
};

/// The one mapping from a command to a net (docs/command-layer.md): knows neither robots nor motions. Every action must
/// be planned (plan() of actions/motion_action.h).
/// @return the net, or all that check() finds. Realtime: setup, deterministic.
[[nodiscard]] Result<MappedCommand> map(const Command& command, Nanoseconds period = kMillisecond);

}  // namespace takt::command
