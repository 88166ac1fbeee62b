#include "core/motion/braking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace takt::motion {
namespace {

constexpr double kNeverEnds = std::numeric_limits<double>::infinity();
/// Relative: what rounding may add to a state that is about to land.
constexpr double kRounding = 1e-9;

/// True if the clock could be here by its own bounds, so that it can go on by them.
bool is_usual(const ClockState& clock, const ClockBounds& bounds, double lowest) {
  const double to_rate_bound = clock.rate_change < 0.0 ? clock.rate - lowest : 1.0 - clock.rate;
  const double room = std::min(1.0 - std::abs(clock.rate), to_rate_bound);
  const double change = std::abs(clock.rate_change);
  return change <= bounds.acceleration_max * (1.0 + kRounding) &&
         change * change <= 2.0 * bounds.jerk_max * room * (1.0 + kRounding);
}

}  // namespace

struct Braking::Profile {
  std::array<Piece, 3> pieces;
  double time = 0.0;
  double way = 0.0;
};

Braking::Braking(TimeLaw law, StopTable table)
    : plan_(std::make_shared<const Plan>(Plan{std::move(law), std::move(table)})) {}

void Braking::Motion::go(const Piece& piece, double time) {
  way += time * (velocity + time / 2 * (acceleration + time / 3 * piece.jerk));
  velocity += time * (acceleration + time / 2 * piece.jerk);
  acceleration += time * piece.jerk;
}

std::optional<Braking::Profile> Braking::to_rest(const Motion& now, const Bounds& bounds) {
  const auto [most, jerk] = bounds;
  const double v = now.velocity, from = -now.acceleration;  // decelerations are positive
  if (from > 0.0 && from * from > 2.0 * jerk * v * (1.0 + kRounding)) return std::nullopt;
  double peak = std::max(from, std::sqrt(std::max(0.0, jerk * v + from * from / 2)));
  double hold = 0.0;
  if (peak > most) {
    const double lost = from > most ? from * from : 2.0 * most * most - from * from;  // 2 jerk times the velocity
    peak = most;
    hold = std::max(0.0, (v - lost / (2.0 * jerk)) / most);
  }
  Profile profile{.pieces = {Piece{std::abs(peak - from) / jerk, peak >= from ? -jerk : jerk}, Piece{hold, 0.0},
                             Piece{peak / jerk, jerk}}};
  Motion then = now;
  for (const Piece& piece : profile.pieces) {
    then.go(piece, piece.time);
    profile.time += piece.time;
  }
  profile.way = then.way - now.way;
  return profile;
}

std::optional<Braking::Bounds> Braking::bounds_from(double s, double rate, const Motion& now) const {
  const StopTable& table = plan_->table;
  const auto here = std::upper_bound(table.begin(), table.end(), s,
                                     [](double value, const StopCell& cell) { return value < cell.s_end; });
  auto index = std::min(static_cast<std::size_t>(here - table.begin()), table.size() - 1);
  const double strongest = std::abs(now.acceleration), square = rate * rate;
  double deceleration = kNeverEnds, jerk = kNeverEnds, by_product = 0.0;
  for (;;) {
    const StopCell& cell = table[index];
    const double least = cell.deceleration - (cell.deceleration - cell.deceleration_at_full_rate) * square;
    deceleration = std::min({deceleration, least, cell.product / rate});
    jerk = std::min(jerk, cell.jerk - cell.jerk_by_cube * square * rate);
    by_product = std::max(by_product, cell.jerk_by_product * rate);
    // Where curvature takes jerk from a stop, braking less hard leaves more of it.
    if (by_product > 0.0) deceleration = std::min(deceleration, jerk / (2.0 * by_product));
    const Bounds bounds{deceleration, jerk - by_product * std::max(deceleration, strongest)};
    if (!(bounds.deceleration > 0.0 && bounds.jerk > 0.0) || strongest * rate > cell.product) return std::nullopt;
    const auto stop = to_rest(now, bounds);
    if (!stop) return std::nullopt;
    // A stop that is eased at its worst moment loses its deceleration an eighth of D^3 / J^2 further on than it ends.
    const double D = bounds.deceleration, J = bounds.jerk;
    const double reach = stop->way + D * D * D / (8.0 * J * J);
    if (index + 1 == table.size() || reach <= cell.s_end - s) return bounds;
    ++index;
  }
}

bool Braking::begins(const ClockState& clock, const LawPoint& at, const Profile& stop,
                     const ClockBounds& bounds) const {
  const Motion rate{.way = 0.0, .velocity = clock.rate, .acceleration = clock.rate_change};
  const auto usual = to_rest(rate, {bounds.acceleration_max, bounds.jerk_max});
  if (!usual) return true;
  const double way = plan_->law.at(clock.tau + usual->way).s - at.s;
  return stop.way < way && stop.time <= usual->time;
}

std::optional<double> Braking::time_of(double s, const ClockState& clock, double fastest, double period) const {
  double low = clock.tau, high = clock.tau + fastest * period;
  if (s > plan_->law.at(high).s) return std::nullopt;
  double tau = std::clamp(clock.tau + period * (clock.rate + period / 2 * clock.rate_change), low, high);
  constexpr int kMost = 40;
  for (int i = 0; i < kMost; ++i) {
    const LawPoint at = plan_->law.at(tau);
    const double off = at.s - s;
    (off < 0.0 ? low : high) = tau;
    double next = tau - off / at.ds;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (next == tau || std::abs(next - tau) <= 1e-15 * tau) break;
    tau = next;
  }
  return tau;
}

bool Braking::leave() {
  held_.reset();
  return false;
}

bool Braking::advance(ClockState& clock, double target, double period, const ClockBounds& bounds, double lowest) {
  const bool usual = is_usual(clock, bounds, lowest);
  if (!(clock.rate > 0.0) || (target != 0.0 && usual)) return leave();
  const LawPoint at = plan_->law.at(clock.tau);
  if (!(at.ds > 0.0)) return leave();
  const double rate = clock.rate, change = clock.rate_change, rising = std::max(0.0, change);
  // A rate that is rising goes on rising for a while, by itself at most that far.
  const double fastest = std::min(1.0, rate + rising * rising / (2.0 * bounds.jerk_max));
  Motion now{.way = 0.0, .velocity = at.ds * rate, .acceleration = at.dds * rate * rate + at.ds * change};
  const auto here = bounds_from(at.s, fastest, now);
  const auto before = held_ ? to_rest(now, *held_) : std::nullopt;
  auto stop = here ? to_rest(now, *here) : std::nullopt;
  if (!before && stop && usual && !begins(clock, at, *stop, bounds)) return leave();
  if (stop && before && target == 0.0 && !(stop->way < before->way && stop->time <= before->time)) stop.reset();
  if (stop)
    held_ = here;
  else
    stop = before;
  if (!stop) return leave();
  if (target != 0.0) {
    now.go({period, held_->jerk}, period);
  } else {
    double left = period;
    for (const Piece& piece : stop->pieces) {
      const double time = std::min(piece.time, left);
      now.go(piece, time);
      left -= time;
    }
    if (stop->time <= period) now.velocity = now.acceleration = 0.0;
  }
  return move(clock, at.s + now.way, now, {.fastest = fastest, .jerk_max = bounds.jerk_max, .period = period});
}

bool Braking::move(ClockState& clock, double s, const Motion& then, const Step& step) {
  const double change = clock.rate_change;
  if (const auto tau = time_of(s, clock, step.fastest, step.period)) {
    const LawPoint there = plan_->law.at(*tau);
    if (!(then.velocity > 0.0) || !(there.ds > 0.0)) {
      clock = {.tau = *tau};
      return !leave();
    }
    const double rate = then.velocity / there.ds;
    const double change_then = (then.acceleration - there.dds * rate * rate) / there.ds;
    if (rate <= step.fastest && change_then <= std::max(0.0, change - step.jerk_max * step.period)) {
      clock = {.tau = *tau, .rate = rate, .rate_change = change_then};
      return true;
    }
  }
  if (change > 0.0) return leave();  // the clock by itself is no slower to turn the rate
  // The law itself is slowing down at least as hard: the rate gets steady.
  clock.tau += step.period * (clock.rate + step.period / 3 * change);
  clock.rate = std::max(0.0, clock.rate + step.period / 2 * change);
  clock.rate_change = 0.0;
  return true;
}

}  // namespace takt::motion
