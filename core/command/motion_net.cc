#include "core/command/motion_net.h"

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "core/command/condition_state.h"
#include "core/command/device_sensors.h"
#include "core/command/motion_action.h"
#include "core/command/single_net.h"
#include "core/motion/path_clock.h"

namespace takt::command {
namespace {

/// A sensor that has been silent for so long is not waited for.
constexpr double kSilence_s = 0.5;

/// Averages readings of a sensor from the first cycle on. @param output  of the primitive: "bias", "done"
ExpressionPtr tare_of(net::ValueType type, const WrenchSensor& wrench, std::int64_t cycles, const char* output) {
  return named(
      apply(type, "Tare", {{"wrench", {.node = wrench.node()}}}, {{"cycles", cycles}, {"trigger", true}}, output),
      "tare");
}

}  // namespace

net::NetDescription motion_net(const MotionCommand& command, const Cell& cell, const Biases& biases) {
  // The plan is written into the net; nothing refers to it afterwards.
  const std::shared_ptr<const motion::Motion> motion(command.motion, [](const motion::Motion*) {});
  const Action action = planned(
      {.motion = motion, .X_FM = command.X_FM, .handed_over = {command.until_from}, .clock = override_of(cell)});
  RuntimeCommand moved("motion", arm(cell, command.arm), action);
  if (command.until) {
    State until = state_of(*command.until, cell, biases);
    if (command.until_from > 0.0) until = until && action.via_passed(0);
    moved.on_entered(until, cancel(moved));
    // A sensor that is silent stops the arm, but it has not felt anything.
    moved.capture("touch", tool_pose(cell, command.arm), until);
  }
  return single_net(moved, command.name).net;
}

std::int64_t cancel_bound_cycles(const motion::Motion& motion, Nanoseconds period) {
  const double stop_s = motion::PathClock(motion.clock, motion.duration(), false).stop_time_bound();
  // The net hears of the cancel one cycle after it was asked for, and the clock stands at the end of a whole cycle.
  return static_cast<std::int64_t>(std::ceil(stop_s / to_seconds(period))) + 2;
}

WaitCommand tare_command(const std::string& sensor, std::int64_t cycles, const Cell& cell) {
  const WrenchSensor wrench = compensated_wrench(cell, sensor);
  const State done(tare_of(net::ValueType::kBoolean, wrench, cycles, "done"));
  // Null readings are not averaged, so a dead sensor would keep the net for ever.
  const State silent = is_null(force(wrench)).held_for(kSilence_s);
  WaitCommand tared("taring", done || silent);
  tared.observe("bias", WrenchSensor(tare_of(net::ValueType::kWrench, wrench, cycles, "bias")));
  return tared;
}

net::NetDescription tare_net(const std::string& sensor, std::int64_t cycles, const Cell& cell) {
  return single_net(tare_command(sensor, cycles, cell), "tare " + sensor).net;
}

}  // namespace takt::command
