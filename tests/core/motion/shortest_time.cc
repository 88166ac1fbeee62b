#include "tests/core/motion/shortest_time.h"

#include <gtest/gtest.h>
#include <ruckig/ruckig.hpp>

namespace takt::motion::test {
namespace {

/// All members set: the generator leaves its own uninitialised.
ruckig::InputParameter<1> at_rest(const AxisLimits& limits) {
  ruckig::InputParameter<1> input;
  input.current_position = input.current_velocity = input.current_acceleration = {0.0};
  input.target_position = input.target_velocity = input.target_acceleration = {0.0};
  input.max_velocity = {limits.velocity};
  input.max_acceleration = {limits.acceleration};
  input.max_jerk = {limits.jerk};
  return input;
}

double duration(const ruckig::InputParameter<1>& input) {
  ruckig::Ruckig<1> generator;
  ruckig::Trajectory<1> trajectory;
  EXPECT_EQ(generator.calculate(input, trajectory), ruckig::Result::Working);
  return trajectory.get_duration();
}

}  // namespace

double shortest_time(const AxisLimits& limits, double way) {
  auto input = at_rest(limits);
  input.target_position = {way};
  return duration(input);
}

double shortest_time_to_velocity(const AxisLimits& limits, double velocity, double acceleration,
                                 double target_velocity) {
  auto input = at_rest(limits);
  input.control_interface = ruckig::ControlInterface::Velocity;
  input.current_velocity = {velocity};
  input.current_acceleration = {acceleration};
  input.target_velocity = {target_velocity};
  return duration(input);
}

}  // namespace takt::motion::test
