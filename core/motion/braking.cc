#include "core/motion/braking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace takt::motion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
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

std::optional<Braking::Bounds> Braking::bounds_from(double s, double direction, double rate, const Motion& now) const {
  const StopTable& table = plan_->table;
  const auto here = std::upper_bound(table.begin(), table.end(), s,
                                     [](double value, const StopCell& cell) { return value < cell.s_end; });
  auto index = std::min(static_cast<std::size_t>(here - table.begin()), table.size() - 1);
  const double strongest = std::abs(now.acceleration), square = rate * rate;
  double deceleration = kInfinity, jerk = kInfinity, by_product = 0.0;
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
    const double begin = index == 0 ? 0.0 : table[index - 1].s_end;
    const bool last = direction > 0.0 ? index + 1 == table.size() : index == 0;
    if (last || reach <= (direction > 0.0 ? cell.s_end - s : s - begin)) return bounds;
    index += direction > 0.0 ? 1 : std::size_t(-1);
  }
}

bool Braking::begins(const ClockState& clock, const LawPoint& at, double direction, const Profile& stop,
                     const ClockBounds& bounds) const {
  const Motion rate{.way = 0.0, .velocity = std::abs(clock.rate), .acceleration = direction * clock.rate_change};
  const auto usual = to_rest(rate, {bounds.acceleration_max, bounds.jerk_max});
  if (!usual) return true;
  const double way = std::abs(plan_->law.at(clock.tau + direction * usual->way).s - at.s);
  return stop.way < way && stop.time <= usual->time;
}

std::optional<double> Braking::time_of(double s, const ClockState& clock, double fastest, double period) const {
  const double steady = clock.tau + fastest * period;
  double low = std::min(clock.tau, steady), high = std::max(clock.tau, steady);
  const double furthest = plan_->law.at(steady).s;
  if (clock.rate > 0.0 ? s > furthest : s < furthest) return std::nullopt;
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
  if (clock.rate == 0.0 || (target != 0.0 && usual)) return leave();
  const LawPoint at = plan_->law.at(clock.tau);
  if (!(at.ds > 0.0)) return leave();
  const double direction = clock.rate < 0.0 ? -1.0 : 1.0, rate = std::abs(clock.rate);
  // A rate that is rising goes on rising for a while, by itself at most that far.
  const double change = direction * clock.rate_change, rising = std::max(0.0, change);
  const double fastest = std::min(1.0, rate + rising * rising / (2.0 * bounds.jerk_max));
  Motion now{.way = 0.0,
             .velocity = at.ds * rate,
             .acceleration = direction * (at.dds * rate * rate + at.ds * clock.rate_change)};
  const auto here = bounds_from(at.s, direction, fastest, now);
  const bool better = here && held_ && here->deceleration >= held_->deceleration && here->jerk >= held_->jerk;
  if (here && (!held_ || better || target != 0.0)) {
    if (!held_ && usual && !begins(clock, at, direction, *to_rest(now, *here), bounds)) return false;
    held_ = here;
  }
  if (!held_) return false;
  const auto stop = to_rest(now, *held_);
  if (!stop) return leave();

  double left = period;
  if (target != 0.0) {
    now.go({period, held_->jerk}, period);
  } else {
    for (const Piece& piece : stop->pieces) {
      const double time = std::min(piece.time, left);
      now.go(piece, time);
      left -= time;
    }
    if (stop->time <= period) now.velocity = now.acceleration = 0.0;
  }
  const auto tau = time_of(at.s + direction * now.way, clock, direction * fastest, period);
  if (tau) {
    const LawPoint there = plan_->law.at(*tau);
    if (!(now.velocity > 0.0) || !(there.ds > 0.0)) {
      clock = {.tau = *tau};
      held_.reset();
      return true;
    }
    const double rate_then = now.velocity / there.ds;
    const double change_then = (now.acceleration - direction * there.dds * rate_then * rate_then) / there.ds;
    if (rate_then <= fastest && change_then <= std::max(0.0, change - bounds.jerk_max * period)) {
      clock = {.tau = *tau, .rate = direction * rate_then, .rate_change = direction * change_then};
      return true;
    }
  }
  if (change > 0.0) return leave();  // the clock by itself is no slower to turn the rate
  // The law itself is slowing down at least as hard: the rate gets steady.
  clock.tau += period * (clock.rate + period / 3 * clock.rate_change);
  clock.rate = direction * std::max(0.0, rate + direction * period / 2 * clock.rate_change);
  clock.rate_change = 0.0;
  return true;
}

}  // namespace takt::motion
