#include "core/motion/path_clock.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::motion {

ClockBounds common(const ClockBounds& a, const ClockBounds& b) {
  return {.acceleration_max = std::min(a.acceleration_max, b.acceleration_max),
          .jerk_max = std::min(a.jerk_max, b.jerk_max),
          .stop = common(a.stop, b.stop)};
}

PathPoint follow(const TimeLaw& law, const ClockState& clock) {
  const LawPoint at = law.at(clock.tau);
  return {.s = at.s, .ds = at.ds * clock.rate, .dds = at.dds * clock.rate * clock.rate + at.ds * clock.rate_change};
}

PathClock::PathClock(const ClockBounds& bounds, double duration, bool retraceable, bool in_motion)
    : bounds_{.acceleration_max = bounds.acceleration_max, .jerk_max = bounds.jerk_max},
      duration_(duration),
      lowest_(retraceable && !in_motion ? -1.0 : 0.0),
      in_motion_(in_motion) {
  if (in_motion_) state_.rate = 1.0;
}

PathClock::PathClock(const ClockBounds& bounds, const TimeLaw& law, bool retraceable, bool in_motion)
    : PathClock(bounds, law.duration(), retraceable, in_motion) {
  if (!bounds.stop.empty()) braking_.emplace(law, bounds.stop);
}

void PathClock::reset(const ClockState& state) {
  state_.tau = std::clamp(state.tau, 0.0, duration_);
  state_.rate = std::clamp(state.rate, lowest_, 1.0);
  state_.rate_change = std::clamp(state.rate_change, -bounds_.acceleration_max, bounds_.acceleration_max);
}

void PathClock::advance(double rate_jerk, double time) {
  ClockState& s = state_;
  s.tau += time * (s.rate + time / 2 * (s.rate_change + time / 3 * rate_jerk));
  s.rate += time * (s.rate_change + time / 2 * rate_jerk);
  s.rate_change += time * rate_jerk;
}

bool PathClock::stays(double target) {
  const bool stays_at_end = at_end() && target >= 0.0;
  const bool rests_at_start = at_start() && !in_motion_;
  const bool stays_at_start = rests_at_start && target <= 0.0;
  if (stays_at_end || stays_at_start) {
    state_.rate = 0.0;
    state_.rate_change = 0.0;
    return true;
  }
  if (at_end() || rests_at_start) {  // the law is at rest here: the rate may jump
    state_.rate = target;
    state_.rate_change = 0.0;
  }
  return false;
}

const ClockState& PathClock::update(double target_rate, double period) {
  const double target = std::isnan(target_rate) ? 0.0 : std::clamp(target_rate, lowest_, 1.0);
  if (!(period > 0.0) || stays(target)) return state_;
  if (!braking_ || !braking_->advance(state_, target, period, bounds_, lowest_)) follow_target(target, period);
  const bool back_at_start = state_.tau <= 0.0 && !in_motion_;
  if (state_.tau >= duration_ || back_at_start) {
    state_.tau = back_at_start ? 0.0 : duration_;
    state_.rate = 0.0;
    state_.rate_change = 0.0;
  }
  return state_;
}

void PathClock::follow_target(double target, double period) {
  // Shortest profile of the rate: rate_change rises to a peak, stays there if that is the bound, and falls to 0 on the
  // target. `sign` turns the way to go into the positive direction.
  const double a = bounds_.acceleration_max, j = bounds_.jerk_max;
  const double v0 = state_.rate_change;
  const double rate_if_relaxed = state_.rate + v0 * std::abs(v0) / (2 * j);
  // A rate that is about to land misses its target by rounding only: it must not turn round for that.
  constexpr double kLanding = 1e-14;
  const double miss = target - rate_if_relaxed;
  const double sign = std::copysign(1.0, std::abs(miss) > kLanding ? miss : v0);
  const double way = sign * (target - state_.rate);
  const double v = sign * v0;
  double peak = std::sqrt(std::max(0.0, j * way + v * v / 2));
  double hold = 0.0;
  if (peak > a) {
    peak = a;
    hold = std::max(0.0, (way - (2 * a * a - v * v) / (2 * j)) / a);
  }
  const double rise = std::max(0.0, (peak - v) / j);
  const double fall = peak / j;

  double left = period;
  const struct {
    double time;
    double jerk;
  } pieces[] = {{rise, sign * j}, {hold, 0.0}, {fall, -sign * j}};
  for (const auto& piece : pieces) {
    const double time = std::min(piece.time, left);
    advance(piece.jerk, time);
    left -= time;
    if (left <= 0.0) break;
  }
  if (left > 0.0 || rise + hold + fall <= period) {
    state_.rate = target;
    state_.rate_change = 0.0;
    advance(0.0, left);
  }
  if (v >= 0.0 && way >= 0.0 && sign * (target - state_.rate) < 0.0) state_.rate = target;  // rounding
  state_.rate = std::clamp(state_.rate, lowest_, 1.0);
}

double PathClock::stop_time_bound() const {
  const double a = bounds_.acceleration_max, j = bounds_.jerk_max;
  // Worst state: still speeding up as hard as can be, on the way to full rate; then from full rate to rest.
  const double speeding = std::min(a, std::sqrt(j * (1.0 - lowest_))) / j;
  const double from_full_rate = a * a < j ? a / j + 1.0 / a : 2.0 / std::sqrt(j);
  return speeding + from_full_rate;
}

nlohmann::ordered_json to_json(const ClockBounds& bounds) {
  nlohmann::ordered_json json = {{"acceleration_max", bounds.acceleration_max}, {"jerk_max", bounds.jerk_max}};
  if (!bounds.stop.empty()) json["stop"] = to_json(bounds.stop);
  return json;
}

Result<ClockBounds> clock_bounds_from_json(const nlohmann::ordered_json& json, const std::string& pointer) {
  Diagnostics diagnostics;
  ObjectReader reader(json, pointer, diagnostics);
  ClockBounds bounds;
  bounds.acceleration_max = reader.number("acceleration_max", {}, kPositive);
  bounds.jerk_max = reader.number("jerk_max", {}, kPositive);
  if (const auto* table = reader.has("stop") ? reader.array("stop") : nullptr) {
    auto stop = stop_table_from_json(*table, reader.at("stop"));
    if (stop)
      bounds.stop = std::move(*stop);
    else
      diagnostics.append(stop.error(), "");
  }
  reader.finish();
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return bounds;
}

}  // namespace takt::motion
