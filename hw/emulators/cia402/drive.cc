#include "hw/emulators/cia402/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace takt::hw::cia402 {
namespace {

using Access = Dictionary::Access;

constexpr double kSpeedMargin = 1.1;  // of the velocity limit: a set point that is farther is a step
constexpr int kPhaseFilter = 256;     // share of SYNC's jitter that the drive's own time takes over

/// From one point to another in `h` s by the cubic that has position and velocity of both; beyond the end with the
/// acceleration that it has there.
AxisPoint along(const AxisPoint& a, const AxisPoint& b, double h, double t) {
  const double way = b.q - a.q, c2 = (3.0 * way / h - 2.0 * a.dq - b.dq) / h,
               c3 = (a.dq + b.dq - 2.0 * way / h) / (h * h);
  if (t <= h)
    return {a.q + t * (a.dq + t * (c2 + t * c3)), a.dq + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3};
  const double ddq = 2.0 * c2 + 6.0 * h * c3, late = t - h;
  return {b.q + late * (b.dq + 0.5 * late * ddq), b.dq + late * ddq, ddq};
}

std::int32_t rounded(double value) {
  return static_cast<std::int32_t>(std::llround(std::clamp(value, -2147483648.0, 2147483647.0)));
}
std::uint32_t bits_of(std::int32_t value) { return static_cast<std::uint32_t>(value); }

}  // namespace

Drive::Drive(Dictionary& objects, const DriveOptions& options) : objects_(objects), options_(options) {
  const auto constant = [&](const ObjectId& id, std::uint32_t value) {
    objects.add(id, {.access = Access::kConstant, .value = value});
  };
  constant(kEncoderIncrements, options.encoder_increments);
  constant(kEncoderTurns, 1);
  constant(kGearMotorTurns, options.gear);
  constant(kGearShaftTurns, 1);
  constant(kRatedTorque, options.rated_torque_mNm);
  constant(kSupportedModes, kHasCyclicPosition);
  const double scale = increments_per_rad();
  constant(kLowestPosition, bits_of(rounded(options.lower * scale)));
  constant(kHighestPosition, bits_of(rounded(options.upper * scale)));
  const auto value = [&](const ObjectId& id, std::uint8_t size, Access access, std::int64_t low, std::int64_t high,
                         std::uint32_t initial) {
    objects.add(id, {size, access, false, low, high, initial});
  };
  value(kAbortOption, 2, Access::kReadWrite, 0, 3, 3);
  value(kQuickStopOption, 2, Access::kReadWrite, 2, 2, 2);
  value(kFaultReactionOption, 2, Access::kReadWrite, 2, 2, 2);
  value(kQuickStopRamp, 4, Access::kReadWrite, 1, UINT32_MAX, bits_of(rounded(10.0 * scale)));
  value(kCyclePeriod, 1, Access::kReadWrite, 1, 100, 4);
  value(kCycleExponent, 1, Access::kReadWrite, -3, -3, 0xFD);
  value(kErrorCode, 2, Access::kReadOnly, 0, UINT16_MAX, 0);
  const auto process = [&](const ObjectId& id, std::uint8_t size, Access access, std::int64_t low, std::int64_t high) {
    objects.add(id, {size, access, true, low, high, 0});
  };
  process(kControlWord, 2, Access::kReadWrite, 0, UINT16_MAX);
  process(kTargetPosition, 4, Access::kReadWrite, INT32_MIN, INT32_MAX);
  process(kVelocityOffset, 4, Access::kReadWrite, INT32_MIN, INT32_MAX);
  process(kMode, 1, Access::kReadWrite, 0, kCyclicPosition);
  process(kStatusWord, 2, Access::kReadOnly, 0, UINT16_MAX);
  process(kModeDisplay, 1, Access::kReadOnly, INT8_MIN, INT8_MAX);
  process(kPosition, 4, Access::kReadOnly, INT32_MIN, INT32_MAX);
  process(kVelocity, 4, Access::kReadOnly, INT32_MIN, INT32_MAX);
  process(kTorque, 2, Access::kReadOnly, INT16_MIN, INT16_MAX);
}

double Drive::increments_per_rad() const {
  return static_cast<double>(options_.encoder_increments) * options_.gear / (2.0 * std::numbers::pi);
}

Nanoseconds Drive::period() const { return objects_.value(kCyclePeriod) * kMillisecond; }

// -- The machine's side
// ---------------------------------------------------------------------------------------------

void Drive::measure(const AxisPoint& measured, double torque, bool powered) {
  measured_ = measured;
  torque_ = torque;
  powered_ = powered;
  // Where it moves nothing it begins where the joint is.
  if (!powered || !has_measured_) hold(measured.q);
  has_measured_ = true;
}

AxisPoint Drive::at(Nanoseconds now) const {
  const double t = to_seconds(now - begin_);
  if (enabled()) return along(from_, to_, to_seconds(period()), std::max(0.0, t));
  if (!braking()) return {from_.q, 0.0, 0.0};
  const double ramp = objects_.value(kQuickStopRamp) / increments_per_rad(), part = std::clamp(t, 0.0, ramp_time());
  const double ddq = std::copysign(ramp, -from_.dq);
  const bool moves = t < ramp_time();
  return {from_.q + part * (from_.dq + 0.5 * part * ddq), moves ? from_.dq + part * ddq : 0.0, moves ? ddq : 0.0};
}

AxisPoint Drive::end_of_cycle() const {
  const double h = to_seconds(period());
  return {to_.q, to_.dq, along(from_, to_, h, h).ddq};
}

bool Drive::take_brakes() { return std::exchange(brakes_, false); }

void Drive::hold(double q) {
  from_ = to_ = {q, 0.0, 0.0};
  missing_ = missing_sync_ = 0;
}

// -- Time
// ------------------------------------------------------------------------------------------------------------

void Drive::begin_cycle(Nanoseconds now) {
  pass(now);
  missing_sync_ = 0;
  const Nanoseconds expected = begin_ + period(), error = now - expected;
  if (!braking()) {
    in_step_ = in_step_ && std::abs(error) <= period() / 2;
    if (enabled() && in_step_) {
      const Nanoseconds begins = expected + error / kPhaseFilter;
      from_ = at(begins);
      begin_ = begins;
    } else {
      if (enabled()) from_ = at(now);
      begin_ = now;
    }
    in_step_ = true;
  }
  next_set_point(now);
  follow_control(now);
  objects_.set(kModeDisplay, objects_.value(kMode));
}

void Drive::pass(Nanoseconds now) {
  if (braking() && now - begin_ >= static_cast<Nanoseconds>(ramp_time() * kSecond)) end_ramp(now);
  const bool moves = enabled() || braking();
  if (moves && has_measured_ && !powered_) {
    fail(kErrorPower, now);
    enter(DriveState::kFault, now);
    return;
  }
  while (enabled() && in_step_ && now > begin_ + period() + period() / 2) {
    if (++missing_sync_ > options_.bridged) return fail(kErrorSync, now);
    from_ = end_of_cycle();
    begin_ += period();
    next_set_point(now);
  }
}

void Drive::next_set_point(Nanoseconds now) {
  const bool fresh = std::exchange(fresh_, false);
  if (!enabled()) return;
  fresh ? take_set_point(now) : bridge();
  if (enabled() && missing_ > options_.bridged) fail(kErrorOutputsMissing, now);
}

void Drive::suspend(Nanoseconds now) { begin_ = std::max(begin_, now - period()); }

/// What it must not follow it does not begin to follow: it goes on as it was until the fault reaction.
void Drive::take_set_point(Nanoseconds now) {
  const double scale = increments_per_rad();
  const bool follows = objects_.value(kMode) == static_cast<std::uint32_t>(kCyclicPosition);
  AxisPoint wanted{from_.q, 0.0, 0.0};
  if (follows)
    wanted = {objects_.signed_value(kTargetPosition) / scale, objects_.signed_value(kVelocityOffset) / scale, 0.0};
  const double most = kSpeedMargin * options_.velocity * to_seconds(period());
  const bool fast = std::abs(wanted.q - from_.q) > most || std::abs(wanted.dq) > kSpeedMargin * options_.velocity;
  const bool outside = wanted.q < options_.lower - most || wanted.q > options_.upper + most;
  if (fast || outside) {
    bridge();
    return fail(fast ? kErrorVelocity : kErrorPosition, now);
  }
  to_ = wanted;
  missing_ = 0;
}

/// A cycle without a set point: on with the acceleration that it had.
void Drive::bridge() {
  const double h = to_seconds(period());
  to_ = {from_.q + h * (from_.dq + 0.5 * h * from_.ddq), from_.dq + h * from_.ddq, from_.ddq};
  ++missing_;
}

// -- States
// ----------------------------------------------------------------------------------------------------------

void Drive::follow_control(Nanoseconds now) {
  const auto control = static_cast<std::uint16_t>(objects_.value(kControlWord));
  const DriveState next = next_state(state_, control, std::exchange(control_before_, control));
  const bool up =
      next == DriveState::kReadyToSwitchOn || next == DriveState::kSwitchedOn || next == DriveState::kOperationEnabled;
  waits_ = next != state_ && up && !powered_;
  if (next == state_ || waits_) return;
  if (state_ == DriveState::kFault) {
    objects_.set(kErrorCode, 0);
    error_ = std::uint16_t{0};
  }
  enter(next, now);
}

void Drive::enter(DriveState state, Nanoseconds now) {
  if (state == state_) return;
  const AxisPoint here = at(now);
  const bool had_power = enabled() || braking();
  const bool stops = state == DriveState::kQuickStopActive || state == DriveState::kFaultReactionActive;
  if (stops) {
    from_ = here;
    begin_ = now;
  } else {
    brakes_ = brakes_ || (had_power && here.dq != 0.0);
    hold(here.q);
    in_step_ = in_step_ && !had_power;
  }
  state_ = state;
}

void Drive::fail(std::uint16_t code, Nanoseconds now) {
  if (state_ == DriveState::kFault || state_ == DriveState::kFaultReactionActive) return;
  objects_.set(kErrorCode, code);
  error_ = code;
  enter(enabled() || braking() ? DriveState::kFaultReactionActive : DriveState::kFault, now);
}

std::optional<std::uint16_t> Drive::take_error() { return std::exchange(error_, std::nullopt); }

double Drive::ramp_time() const {
  return std::abs(from_.dq) * increments_per_rad() / std::max(1u, objects_.value(kQuickStopRamp));
}

void Drive::end_ramp(Nanoseconds now) {
  enter(state_ == DriveState::kFaultReactionActive ? DriveState::kFault : DriveState::kSwitchOnDisabled, now);
}

void Drive::report() {
  const double scale = increments_per_rad();
  std::uint16_t status = static_cast<std::uint16_t>(status_of(state_) | kRemote);
  if (powered_) status |= kVoltageEnabled;
  if (enabled() && objects_.value(kMode) == static_cast<std::uint32_t>(kCyclicPosition)) status |= kFollowsTarget;
  objects_.set(kStatusWord, status);
  objects_.set(kPosition, bits_of(rounded(measured_.q * scale)));
  objects_.set(kVelocity, bits_of(rounded(measured_.dq * scale)));
  const double motor_torque = torque_ / options_.gear;
  const double permille = std::clamp(1e6 * motor_torque / options_.rated_torque_mNm, -32768.0, 32767.0);
  objects_.set(kTorque, bits_of(rounded(permille)));
}

}  // namespace takt::hw::cia402
