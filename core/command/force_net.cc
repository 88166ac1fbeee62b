#include "core/command/force_net.h"

#include <array>

#include "core/command/condition_state.h"
#include "core/command/device_sensors.h"
#include "core/command/single_net.h"

namespace takt::command {
namespace {

/// From this share of the wanted force on there is contact; below a third of that there is none any more.
constexpr double kContactShare = 0.3, kReleaseShare = 1.0 / 3.0;
/// The integral acts slowly: it only takes away what the law leaves.
constexpr double kIntegralTime_s = 1.0;
/// Of the approach velocity: how fast the tool may follow a surface that gives way.
constexpr double kMostVelocity = 5.0;
constexpr double kMostAcceleration = 0.5;  ///< m/s^2

}  // namespace

PressWish press_wish(const PressCommand& command, const Cell& cell) {
  PressWish wish{.force = {.force = command.force,
                           .approach_velocity = command.approach,
                           .contact_force = kContactShare * command.force,
                           .release_share = kReleaseShare,
                           // Takes the approach velocity away while the force builds up, whatever the surface is like.
                           .gain = command.approach / command.force,
                           .integral_time = kIntegralTime_s,
                           .velocity_max = kMostVelocity * command.approach,
                           .acceleration_max = kMostAcceleration},
                 .travel = command.travel,
                 .sink = command.drop,
                 .clock = override_of(cell)};
  // The path is written into the net; nothing refers to it afterwards.
  if (command.path != nullptr) wish.path = {command.path, [](const motion::Motion*) {}};
  return wish;
}

net::NetDescription press_net(const PressCommand& command, const Cell& cell, const Biases& biases) {
  const RealSensor pressing = pressing_force(cell, command.sensor, command.direction_B, biases);
  const Action action = press(pressing, command.direction_B, press_wish(command, cell));
  RuntimeCommand pressed("press", arm(cell, command.arm), action);
  pressed.capture("touched", pressing, action.state("touched"));
  /// What ends it is remembered under its name.
  const auto ends = [&](const char* name, const State& state) {
    pressed.on_entered(state, cancel(pressed));
    pressed.capture(name, pressing, state);
  };
  ends("too-far", action.state("too_far"));
  ends("silent", action.state("error"));
  if (command.hold) ends("held", action.state("in_contact").held_for(*command.hold));
  if (command.drop) ends("found", action.state("sunk"));
  if (command.path) pressed.on_entered(action.state("path_ended"), cancel(pressed));
  if (command.until) ends("until", state_of(*command.until, cell, biases));
  return single_net(pressed, command.name).net;
}

}  // namespace takt::command
