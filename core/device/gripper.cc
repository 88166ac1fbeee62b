#include "core/device/gripper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/net/format_text.h"

namespace takt::device {

namespace {

/// Against rounding where a command stands exactly on a limit.
constexpr double kLimitTolerance = 1e-9;
/// m: fingers that have left a part by less are taken to have it still; as far as pads give way.
constexpr double kHardlyLeft = 1.5e-3;

bool inside(double value, double low, double high) {
  return value >= low - kLimitTolerance && value <= high + kLimitTolerance;
}

}  // namespace

std::string_view name_of(GripperState state) {
  switch (state) {
    case GripperState::kIdle:
      return "idle";
    case GripperState::kMoving:
      return "moving";
    case GripperState::kHolding:
      return "holding";
    case GripperState::kLost:
      return "lost";
  }
  return "";
}

void Gripper::propose(double width, double speed, double force) {
  if (!held_) return;
  proposal_.width = width;
  proposal_.speed = speed;
  proposal_.force = force;
  proposed_ = true;
}

void Gripper::begin_cycle(std::int64_t, Nanoseconds time) {
  proposed_ = false;
  const bool failed = failed_before();
  has_sample_ = at_border([this] { return backend_->read(sample_); }) && !failed && std::isfinite(sample_.width) &&
                std::isfinite(sample_.speed) && std::isfinite(sample_.force);
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_->sample_age_max) has_sample_ = false;
  if (!answered() || sample_.state == GripperState::kMoving) return;
  const bool holding = sample_.state == GripperState::kHolding;
  grip_ = holding ? sent_ : GripperSetPoint{};
  grip_width_ = sample_.width;
}

void Gripper::add_state(StateWords& words) const {
  words.add(std::uint64_t{has_sample_} | std::uint64_t{held_} << 1 | std::uint64_t{sample_.ready} << 2 |
            static_cast<std::uint64_t>(sample_.state) << 8 | std::uint64_t{sample_.fault} << 32);
  if (has_sample_) {
    words.add(sample_.sequence);
    words.add(sample_.stamp);
    words.add(sample_.command);
    for (const double x : {sample_.width, sample_.speed, sample_.force}) words.add(x);
  }
  words.add(sent_.sequence);
  for (const double x : {sent_.width, sent_.speed, sent_.force}) words.add(x);
}

net::Text Gripper::fault() const {
  if (exception()) return *exception();
  return net::format_text("{}: not ready, fault {}", name(), sample_.fault);
}

std::optional<net::Text> Gripper::refusal() const {
  if (!ready()) return net::format_text("{}: not ready", name());
  return std::nullopt;
}

void Gripper::release() {
  held_ = false;
  releasing_ = true;
}

void Gripper::stop() {
  held_ = false;
  proposed_ = false;
  stopping_ = !at_rest();
}

std::optional<net::Text> Gripper::check() {
  if (!proposed_) return std::nullopt;
  const GripperDescription& d = *description_;
  std::optional<net::Text> trip;
  if (!std::isfinite(proposal_.width) || !std::isfinite(proposal_.speed) || !std::isfinite(proposal_.force)) {
    trip = net::format_text("{}: the command is not finite", name());
  } else if (!inside(proposal_.width, 0.0, d.stroke)) {
    trip = net::format_text("{}: width {:.4g} outside [0, {:.4g}] m", name(), proposal_.width, d.stroke);
  } else if (!inside(proposal_.speed, d.speed_min, d.speed_max)) {
    trip = net::format_text("{}: speed {:.4g} outside [{:.4g}, {:.4g}] m/s", name(), proposal_.speed, d.speed_min,
                            d.speed_max);
  } else if (!inside(proposal_.force, d.force_min, d.force_max)) {
    trip = net::format_text("{}: force {:.4g} outside [{:.4g}, {:.4g}] N", name(), proposal_.force, d.force_min,
                            d.force_max);
  }
  if (trip) stop();
  return trip;
}

void Gripper::hand_over() {
  if (proposed_) send(proposal_.width, proposal_.speed, proposal_.force);
  // A net that ends while the fingers are on their way leaves a device that moves: then the stop reaction runs (L5).
  if (std::exchange(releasing_, false)) stopping_ = !at_rest();
  // One that is not ready stops as soon as it is again: what it was told before does not go on.
  if (stopping_ && ready()) keep_grip();
  if (ready()) stopping_ = false;
  if (sent_.sequence > 0) call_border([this] { backend_->write(sent_); });
}

void Gripper::keep_grip() {
  const bool hardly_left = grip_.sequence > 0 && std::abs(sample_.width - grip_width_) < kHardlyLeft;
  if (hardly_left) return send(grip_.width, grip_.speed, grip_.force);
  send(std::clamp(sample_.width, 0.0, description_->stroke), sent_.speed, sent_.force);
}

void Gripper::send(double width, double speed, double force) {
  const bool same = sent_.sequence > 0 && width == sent_.width && speed == sent_.speed && force == sent_.force;
  if (same) return;
  sent_ = {.sequence = sent_.sequence + 1, .width = width, .speed = speed, .force = force};
}

}  // namespace takt::device
