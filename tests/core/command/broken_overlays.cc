// What is wrong with weaves and force offsets, each once.
#include "core/command/actions/compliance_action.h"
#include "core/command/actions/device_action.h"
#include "core/command/actions/overlay_action.h"
#include "core/command/actions/process_action.h"
#include "tests/core/command/broken_commands.h"

namespace takt::command {
namespace {

/// What a line of 0.1 m to the side is laid under.
Action line(const World& world, double acceleration = 1.0) {
  return lin(world.moved(0, 0.1, 0), {.acceleration = acceleration, .linear_velocity = 0.05});
}
Action offset(const World& world, const Action& motion, const ForceOffsetControlParameters& wish) {
  const Eigen::Isometry3d& X_FT = world.cell.arms.at("arm").X_FT;
  return force_offset(motion, pressing_along(world.cell, "wrist", wish.direction_M, X_FT), wish);
}

/// Weaves that reach so far beside a line that the arm cannot follow, or not so fast.
RuntimeCommand far_weave(const World& world, const Eigen::Vector3d& direction_B, double amplitude, double frequency,
                         double velocity = 0.002) {
  const Eigen::Matrix3d R = world.moved(0, 0, 0).linear();
  return move(
      world,
      weave(lin(world.moved(0, 0.05, 0), {.acceleration = 0.8, .linear_velocity = velocity}),
            {.amplitude = amplitude, .frequency = frequency, .direction_M = R.transpose() * direction_B, .ramp = 2.0}));
}

}  // namespace

std::vector<BrokenCommand> broken_overlays() {
  const WeaveParameters small{.amplitude = 0.001, .frequency = 1.0};
  return {
      {"C8", [](World& world) -> Command { return move(world, weave(ptp(world.joints(0.1)))); }, "/move",
       Code::kConflict},
      {"",
       [](World& world) -> Command {
         return move(world, weave(lin(world.moved(0, 0.1, 0)), {.amplitude = 0.1, .frequency = 50.0}));
       },
       "/move", Code::kOutOfRange},
      {"",
       [](World& world) -> Command {
         return move(world,
                     weave(lin(world.moved(0, 0.1, 0), {.linear_velocity = 0.03}), {.amplitude = 0.002, .ramp = 0.02}));
       },
       "/move/ramp",
       Code::kLimitExceeded,
       {"0.02"}},
      {"",
       [](World& world) -> Command {
         return move(world, weave(lin(world.moved(0, 0.001, 0)), {.amplitude = 0.004, .ramp = 0.02}));
       },
       "/move/ramp",
       Code::kLimitExceeded,
       {"0.02"}},
      {"",
       [](World& world) -> Command { return move(world, weave(lin(world.moved(0, 0.1, 0)), {.amplitude = -0.002})); },
       "/move/amplitude",
       Code::kOutOfRange,
       {"-0.002", "0"}},
      {"",
       [](World& world) -> Command {
         return move(world, weave(lin(world.moved(0, 0.1, 0)), {.direction_M = {0.0, 2.0, 0.0}}));
       },
       "/move/direction",
       Code::kOutOfRange,
       {"2", "1"}},
      {"",
       [small](World& world) -> Command {
         return move(world, weave_each(line(world), {small, std::nullopt}));
       },
       "/move",
       Code::kWrongSize,
       {"2", "1"}},
      {"C8",
       [small](World& world) -> Command {
         const auto line = [&world, goal = world.moved(0, 0.05, 0)](const device::JointVector& q) {
           return motion::lin_leg(expression::planning_model(world.cell.arms.at("arm")), q, goal);
         };
         const auto turn = [&world](device::JointVector q) {
           const device::JointVector q_start = q;
           q[0] += 0.3;
           return motion::ptp_leg(expression::planning_model(world.cell.arms.at("arm")), q_start, q);
         };
         return move(world, weave_each(sequence({{.geometry = line}, {.geometry = turn}}), {std::nullopt, small}));
       },
       "/move/1", Code::kConflict},
      {"",
       [](World& world) -> Command {
         return far_weave(world, {1, 0, 0}, 0.3, 0.04);
       },
       "/move", Code::kUnreachable},
      {"",
       [](World& world) -> Command {
         return far_weave(world, {-1, 0, 0}, 0.3, 0.04);
       },
       "/move",
       Code::kUnreachable,
       {"4"}},
      {"",
       [](World& world) -> Command {
         return far_weave(world, {1, 0, 0}, 0.22, 0.2, 0.02);
       },
       "/move", Code::kLimitExceeded},
      {"C8", [](World& world) -> Command { return move(world, offset(world, ptp(world.joints(0.1)), {})); }, "/move",
       Code::kConflict},
      {"",
       [](World& world) -> Command {
         return move(world, offset(world, line(world, 0.8), {.reach = 0.0, .retreat = 0.0}));
       },
       "/move",
       Code::kOutOfRange,
       {"0"}},
      {"", [](World& world) -> Command { return move(world, offset(world, weave(line(world)), {})); }, "/move",
       Code::kConflict},
      {"", [](World& world) -> Command { return move(world, weave(offset(world, line(world, 0.8), {}))); }, "/move",
       Code::kConflict},
      {"",
       [](World& world) -> Command {
         return move(world, offset(world, line(world, 0.8), {.force = {.acceleration_max = 10.0}}));
       },
       "/move",
       Code::kLimitExceeded,
       {"10"}},
      {"",
       [](World& world) -> Command { return move(world, offset(world, with_compliance(line(world), Stiff{}), {})); },
       "/move",
       Code::kLimitExceeded,
       {"0"}},
      {"C8",
       [](World& world) -> Command { return move(world, while_process(hold(), digital_input(world.cell, "button"))); },
       "/move", Code::kConflict},
      {"",
       [](World& world) -> Command {
         return move(world, while_process(line(world), digital_input(world.cell, "button"), {.start_timeout = -1.0}));
       },
       "/move/start_timeout",
       Code::kOutOfRange,
       {"-1", "0"}},
  };
}

}  // namespace takt::command
