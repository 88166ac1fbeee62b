#include "sim/machines/gripper.h"

#include <algorithm>
#include <cmath>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

using device::GripperState;

constexpr double kFrequency = 100.0;          // rad/s of the width's position loop: a tenth of what a 1 ms step carries
constexpr double kAtGoal = 3e-4;              // m: nearer than this the goal is reached
constexpr double kFingersAtRest = 2e-3;       // m/s
constexpr double kStallTime = 0.03;           // s: longer than the start of any motion takes to pass kFingersAtRest
constexpr double kPartLostDistance = 1.5e-3;  // m: farther than pads give way
constexpr double kOpenSpeed = 1e-6;           // m/s: below it a profile has arrived

double sign_of(double x) { return x < 0.0 ? -1.0 : 1.0; }

}  // namespace

bool SimGripper::read(device::GripperSample& sample) {
  sample = sample_;
  return sample_.sequence > 0;
}

void SimGripper::write(const device::GripperSetPoint& set_point) {
  if (set_point.sequence == command_.sequence && commanded_) return;
  // Another force on the same part: it is still held, and what happens to it now is its loss.
  const bool presses_on = state_ == GripperState::kHolding &&
                          (set_point.width - held_width_) * (command_.width - held_width_) > 0.0 &&
                          std::abs(set_point.width - held_width_) > kPartLostDistance;
  command_ = set_point;
  commanded_ = true;
  if (presses_on) return;
  state_ = GripperState::kMoving;
  still_ = 0.0;
  width_reference_ = width_;
  speed_reference_ = speed_;
}

void SimGripper::start(const mjData_& data) {
  gather(data);
  // Before the first command it holds where it stands, as weakly as it can.
  command_ = {.sequence = 0, .width = width_, .speed = figures_.speed_max, .force = figures_.force_min};
  width_reference_ = width_;
}

void SimGripper::gather(const mjData_& data) {
  width_ = speed_ = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    width_ += data.qpos[plant_.position_address[i]];
    speed_ += data.qvel[plant_.velocity_address[i]];
  }
}

void SimGripper::follow_profile(double duration) {
  const double way = command_.width - width_reference_;
  // As fast as it may be and still stop at the goal.
  const double wanted = sign_of(way) * std::min(command_.speed, std::sqrt(2.0 * figures_.acceleration * std::abs(way)));
  const double change = figures_.acceleration * duration;
  const double step = std::clamp(wanted - speed_reference_, -change, change);
  speed_reference_ += step;
  acceleration_reference_ = step / duration;
  width_reference_ += speed_reference_ * duration;
  const bool arrived = std::abs(command_.width - width_reference_) < kOpenSpeed ||
                       sign_of(command_.width - width_reference_) != sign_of(way);
  if (arrived && std::abs(speed_reference_) <= 2.0 * change) {
    width_reference_ = command_.width;
    speed_reference_ = acceleration_reference_ = 0.0;
  }
  // Blocked fingers are not left behind farther than it takes for the full force.
  const double lead = 2.0 * figures_.force_max / (finger_mass() * kFrequency * kFrequency);
  width_reference_ = std::clamp(width_reference_, width_ - lead, width_ + lead);
}

void SimGripper::watch(double duration) {
  const double to_go = command_.width - width_;
  const bool at_goal = std::abs(to_go) < kAtGoal;
  if (state_ == GripperState::kHolding) {
    if ((width_ - held_width_) * sign_of(command_.width - held_width_) < kPartLostDistance) return;
    state_ = GripperState::kLost;
    width_reference_ = width_;
    speed_reference_ = speed_;
    return;
  }
  if (state_ != GripperState::kMoving) return;
  const bool still = std::abs(speed_) < std::min(kFingersAtRest, 0.4 * command_.speed);
  still_ = still ? still_ + duration : 0.0;
  if (at_goal && still) {
    state_ = GripperState::kIdle;
  } else if (!at_goal && still_ >= kStallTime) {
    state_ = GripperState::kHolding;
    held_width_ = width_;
  }
}

double SimGripper::drive_force() const {
  const double mass = finger_mass();
  if (state_ == GripperState::kHolding) {
    return sign_of(command_.width - held_width_) * command_.force - mass * kFrequency * speed_;
  }
  const double acceleration = acceleration_reference_ + kFrequency * kFrequency * (width_reference_ - width_) +
                              2.0 * kFrequency * (speed_reference_ - speed_);
  return std::clamp(mass * acceleration, -command_.force, command_.force);
}

void SimGripper::actuate(mjData_& data, const Substep& step) {
  if (step.number > 0) gather(data);
  watch(step.duration);
  if (state_ != GripperState::kHolding) follow_profile(step.duration);
  force_ = drive_force();
  for (std::size_t i = 0; i < 2; ++i) data.qfrc_applied[plant_.velocity_address[i]] = 0.5 * force_;
}

void SimGripper::measure(const mjData_& data, Nanoseconds now) {
  gather(data);
  if (now % figures_.period != 0) return;
  const double step = figures_.width_resolution;
  ++sample_.sequence;
  sample_.stamp = now;
  sample_.width = step > 0.0 ? std::round(width_ / step) * step : width_;
  sample_.speed = speed_;
  sample_.force = -force_;
  sample_.state = state_;
  sample_.command = command_.sequence;
  sample_.ready = true;
}

void SimGripper::stream(StateStream& state) {
  for (double* value :
       {&command_.width, &command_.speed, &command_.force, &width_, &speed_, &width_reference_, &speed_reference_,
        &acceleration_reference_, &force_, &held_width_, &still_, &sample_.width, &sample_.speed, &sample_.force}) {
    state(*value);
  }
  for (device::GripperState* one : {&state_, &sample_.state}) {
    auto word = static_cast<std::uint64_t>(*one);
    state(word);
    *one = static_cast<device::GripperState>(word);
  }
  for (std::uint64_t* word : {&command_.sequence, &sample_.sequence, &sample_.command}) state(*word);
  state(sample_.stamp);
  state(commanded_);
  state(sample_.ready);
}

}  // namespace takt::sim
