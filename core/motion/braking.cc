#include "core/motion/braking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

constexpr double kNeverEnds = std::numeric_limits<double>::infinity();
/// Relative: what rounding may add to a state that is about to land.
constexpr double kRounding = 1e-9;
constexpr double kLeastRate = 1e-6;
/// Of the least s' that is seen at instants of a law: for what it is between them.
constexpr double kShareOfSlowest = 0.99;

/// True if the clock could be here by its own bounds, so that it can go on by them.
bool is_usual(const ClockState& clock, const ClockBounds& bounds, double lowest) {
  const double to_rate_bound = clock.rate_change < 0.0 ? clock.rate - lowest : 1.0 - clock.rate;
  const double room = std::min(1.0 - std::abs(clock.rate), to_rate_bound);
  const double change = std::abs(clock.rate_change);
  return change <= bounds.acceleration_max * (1.0 + kRounding) &&
         change * change <= 2.0 * bounds.jerk_max * room * (1.0 + kRounding);
}

/// Least s' of a law in each cell of a table.
std::vector<double> slowest_in(const TimeLaw& law, const StopTable& table) {
  constexpr int kParts = 16;  // of each segment
  std::vector<double> slowest(table.size(), kNeverEnds);
  const std::vector<LawPoint> points = instants(law, kParts);
  std::size_t cell = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const LawPoint &from = points[i - 1], &to = points[i];
    const double least = kShareOfSlowest * std::min(from.ds, to.ds);
    for (std::size_t k = cell; k < table.size(); ++k) {
      slowest[k] = std::min(slowest[k], least);
      if (to.s <= table[k].s_end) break;
      cell = k + 1;
    }
  }
  return slowest;
}

/// Largest deceleration in a cell at a rate.
double deceleration_at(const StopCell& cell, double rate) {
  const double by_path = cell.deceleration - (cell.deceleration - cell.deceleration_at_full_rate) * rate * rate;
  return std::min(by_path, cell.product / rate);
}

/// Largest third derivative in a cell at a rate and a deceleration.
double jerk_at(const StopCell& cell, double rate, double deceleration) {
  return cell.jerk - cell.jerk_by_cube * rate * rate * rate - cell.jerk_by_product * rate * deceleration;
}

}  // namespace

struct Braking::Profile {
  std::array<Piece, 3> pieces;
  double time = 0.0;
  double way = 0.0;
};

/// Points that a stop passes, in order.
struct Braking::Course {
  static constexpr int kParts = 4;  ///< of each piece
  std::array<Motion, 3 * kParts + 1> points;

  Course(const Motion& now, const Profile& profile) {
    points.front() = now;
    points.front().way = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Piece& piece = profile.pieces[(i - 1) / kParts];
      points[i] = points[i - 1];
      points[i].go(piece, piece.time / kParts);
    }
  }
  /// The fastest and the hardest that it is between two ways.
  struct Maximum {
    double velocity = 0.0, deceleration = 0.0, acceleration = 0.0;  ///< of the last one either way
  };
  [[nodiscard]] Maximum between(double from, double to) const {
    Maximum most;
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (points[i].way < from) continue;
      most.velocity = std::max({most.velocity, points[i - 1].velocity, points[i].velocity});
      most.deceleration = std::max({most.deceleration, -points[i - 1].acceleration, -points[i].acceleration});
      most.acceleration =
          std::max({most.acceleration, std::abs(points[i - 1].acceleration), std::abs(points[i].acceleration)});
      if (points[i].way > to) break;
    }
    return most;
  }
};

Braking::Braking(TimeLaw law, StopTable table) {
  auto slowest = slowest_in(law, table);
  plan_ = std::make_shared<const Plan>(Plan{std::move(law), std::move(table), std::move(slowest)});
}

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

std::size_t Braking::cell_at(double s) const {
  const StopTable& table = plan_->table;
  const auto here = std::ranges::upper_bound(table, s, {}, &StopCell::s_end);
  return std::min(static_cast<std::size_t>(here - table.begin()), table.size() - 1);
}

std::optional<Braking::Found> Braking::stop_from(double s, double rate, const Motion& now) const {
  // Where curvature takes jerk from a stop, braking less hard leaves more of it.
  constexpr std::array kShares = {1.0, 0.7, 0.5, 0.3};
  const StopCell& here = plan_->table[cell_at(s)];
  if (std::abs(now.acceleration) * rate > here.product) return std::nullopt;
  const double most = std::min(here.deceleration, deceleration_at(here, rate));
  std::optional<Found> shortest;
  for (const double share : kShares) {
    const auto found = stop_within(share * most, s, rate, now);
    if (found && (!shortest || found->way < shortest->way)) shortest = found;
  }
  return shortest;
}

std::optional<Braking::Found> Braking::stop_within(double deceleration, double s, double rate,
                                                   const Motion& now) const {
  constexpr int kRounds = 20;
  Bounds bounds{deceleration,
                jerk_at(plan_->table[cell_at(s)], rate, std::max(deceleration, std::abs(now.acceleration)))};
  for (int round = 0; round < kRounds; ++round) {
    const Bounds before = bounds;
    if (!lower(s, rate, now, bounds)) return std::nullopt;
    if (bounds.deceleration != before.deceleration || bounds.jerk != before.jerk) continue;
    const auto stop = to_rest(now, bounds);
    return stop ? std::optional(Found{bounds, stop->way, stop->time}) : std::nullopt;
  }
  return std::nullopt;
}

bool Braking::lower(double s, double rate, const Motion& now, Bounds& bounds) const {
  if (!(bounds.deceleration > 0.0 && bounds.jerk > 0.0)) return false;
  const auto stop = to_rest(now, bounds);
  if (!stop) return false;
  const Course course(now, *stop);
  // A stop that is eased at its worst moment loses its deceleration an eighth of D^3 / J^2 further on than it ends.
  const double D = std::max(bounds.deceleration, -now.acceleration), J = bounds.jerk;
  const double end = s + stop->way + D * D * D / (8.0 * J * J);
  double begin = s;
  for (std::size_t i = cell_at(s); i < plan_->table.size() && begin < end; ++i) {
    const StopCell& cell = plan_->table[i];
    const auto [velocity, deceleration, hardest] = course.between(begin - s, cell.s_end - s);
    const double own = std::max(std::min(rate, velocity / plan_->slowest[i]), kLeastRate);
    const double most = std::min(cell.deceleration, deceleration_at(cell, own));
    // It cannot be eased in time.
    if (begin > s && deceleration > std::max(most, bounds.deceleration) * (1.0 + kRounding)) return false;
    bounds.deceleration = std::min(bounds.deceleration, most);
    bounds.jerk = std::min(bounds.jerk, jerk_at(cell, own, hardest));
    begin = cell.s_end;
  }
  return bounds.deceleration > 0.0 && bounds.jerk > 0.0;
}

double Braking::strongest_jerk(double s, const Step& step, const Motion& now) const {
  const std::size_t last = cell_at(s + now.velocity * step.period);
  double jerk = kNeverEnds;
  for (int round = 0; round < 2; ++round) {  // by what it is now, then by what it may be after the cycle
    const double then = round == 0 ? now.acceleration : now.acceleration - jerk * step.period;
    const double hardest = std::max(std::abs(now.acceleration), std::abs(then));
    for (std::size_t i = cell_at(s); i <= last; ++i)
      jerk = std::min(jerk, jerk_at(plan_->table[i], step.fastest, hardest));
  }
  double most = kNeverEnds;
  for (std::size_t i = cell_at(s); i <= last; ++i)
    most = std::min(most, deceleration_at(plan_->table[i], step.fastest));
  return std::min(jerk, (now.acceleration + most) / step.period);
}

std::optional<Braking::Bounds> Braking::harder_cycle(double s, const Step& step, const Profile& stop,
                                                     Motion& now) const {
  constexpr std::array kShares = {1.0, 0.6, 0.3};
  const double strongest = strongest_jerk(s, step, now);
  if (!(strongest > 0.0 && std::isfinite(strongest))) return std::nullopt;
  for (const double share : kShares) {
    Motion then = now;
    then.go({step.period, -share * strongest}, step.period);
    if (!(then.velocity > 0.0)) continue;
    const auto rest = stop_from(s + then.way, step.fastest, then);
    if (!rest || !(then.way + rest->way < stop.way * (1.0 - kRounding)) || step.period + rest->time > stop.time)
      continue;
    now = then;
    return rest->bounds;
  }
  return std::nullopt;
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

void Braking::follow(const Profile& stop, double period, Motion& now) {
  double left = period;
  for (const Piece& piece : stop.pieces) {
    const double time = std::min(piece.time, left);
    now.go(piece, time);
    left -= time;
  }
  if (stop.time <= period) now.velocity = now.acceleration = 0.0;
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
  const Step step{.fastest = fastest, .jerk_max = bounds.jerk_max, .period = period};
  const auto here = stop_from(at.s, fastest, now);
  const auto before = held_ ? to_rest(now, *held_) : std::nullopt;
  auto stop = here ? to_rest(now, here->bounds) : std::nullopt;
  if (!before && stop && usual && !begins(clock, at, *stop, bounds)) return leave();
  if (stop && before && target == 0.0 && !(stop->way < before->way && stop->time <= before->time)) stop.reset();
  if (stop)
    held_ = here->bounds;
  else
    stop = before;
  if (!stop) return leave();
  if (target != 0.0) {
    now.go({period, held_->jerk}, period);
  } else if (const auto harder = harder_cycle(at.s, step, *stop, now)) {
    held_ = harder;
  } else {
    follow(*stop, period, now);
  }
  return move(clock, at.s + now.way, now, step);
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
