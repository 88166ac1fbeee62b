#include "core/motion/time_optimal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// The window that keeps the jerk of every channel where the law's acceleration jumps; `before` the law it is that.
double window_for_jumps(const PathShape& shape, const AccelerationLaw& law, double before = 0.0) {
  double window = 0.0;
  for (std::size_t i = 0; i <= law.dds.size(); ++i) {
    const double dds = i < law.dds.size() ? law.dds[i] : 0.0;
    const std::size_t cell = law.cell[std::min(i, law.dds.size() - 1)];
    const Channels jump = shape.channels(shape.derivatives(cell, law.s[i]).first * (dds - before));
    window = std::max(window, (jump / shape.limits[shape.cells[cell].limits].jerk).maxCoeff());
    before = dds;
  }
  return window;
}

}  // namespace

ReachabilityPlanner::ReachabilityPlanner(const PathShape& shape, int cuts) : shape_(shape) {
  pieces_.reserve(shape.cells.size() * static_cast<std::size_t>(cuts));
  for (std::size_t cell = 0; cell < shape.cells.size(); ++cell) {
    const double s0 = shape.nodes[shape.cells[cell].node].s;
    const double width = shape.cells[cell].width;
    const ShapeLimits& limits = shape.limits[shape.cells[cell].limits];
    PathShape::Derivatives begin = shape.derivatives(cell, s0);
    for (int cut = 0; cut < cuts; ++cut) {
      PathShape::Derivatives end = shape.derivatives(cell, s0 + width * (cut + 1) / cuts);
      Piece piece{.width = width / cuts,
                  .s_begin = s0 + width * cut / cuts,
                  .cell = cell,
                  .first_row = rows_.size(),
                  .last_row = 0,
                  .x_most = kUnbounded,
                  .y_most = kUnbounded,
                  .x_most_by_acceleration = kUnbounded};
      const Channels v0 = shape.channels(begin.first);
      const Channels v1 = shape.channels(end.first);
      for (Eigen::Index i = 0; i < v0.size(); ++i) {
        piece.x_most = std::min(piece.x_most, std::pow(limits.velocity[i] / v0[i], 2));
        piece.y_most = std::min(piece.y_most, std::pow(limits.velocity[i] / v1[i], 2));
      }
      add_rows(begin, limits, false, piece);
      add_rows(end, limits, true, piece);
      piece.last_row = rows_.size();
      pieces_.push_back(piece);
      begin = std::move(end);
    }
  }
}

void ReachabilityPlanner::add_row(double a, double b, double limit, Piece& piece) {
  // |a y + b x| <= limit.
  constexpr double kNothing = 1e-12;
  if (std::abs(a) <= kNothing * std::abs(b) || a == 0.0) {
    if (b != 0.0) piece.x_most_by_acceleration = std::min(piece.x_most_by_acceleration, limit / std::abs(b));
    return;
  }
  rows_.push_back({.m = -b / a, .r = limit / std::abs(a), .c = 0.0});
}

void ReachabilityPlanner::add_rows(const PathShape::Derivatives& d, const ShapeLimits& limits, bool at_end,
                                   Piece& piece) {
  // With u = (y - x) / (2 h): first u + second x (at the begin) or y (at the end).
  const double half = 1.0 / (2.0 * piece.width);
  const Components a = at_end ? Components(half * d.first + d.second) : Components(half * d.first);
  const Components b = at_end ? Components(-half * d.first) : Components(d.second - half * d.first);
  const int n = shape_.joint_count;
  for (Eigen::Index i = 0; i < n; ++i) add_row(a[i], b[i], limits.acceleration[i], piece);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const Eigen::Vector3d va = a.segment<3>(n + 3 * k).matrix();
    const Eigen::Vector3d vb = b.segment<3>(n + 3 * k).matrix();
    const double limit = limits.acceleration[n + k];
    const double size = va.norm();
    if (size == 0.0) {
      if (vb.norm() > 0.0) piece.x_most_by_acceleration = std::min(piece.x_most_by_acceleration, limit / vb.norm());
      continue;
    }
    const double c = va.cross(vb).norm() / (size * size);
    const double r = limit / size;
    rows_.push_back({.m = -va.dot(vb) / (size * size), .r = r, .c = c});
    if (c > 0.0) piece.x_most_by_acceleration = std::min(piece.x_most_by_acceleration, r / c);
  }
}

ReachabilityPlanner::Interval ReachabilityPlanner::interval(const Piece& piece, double x, double scale) const {
  Interval result{-kUnbounded, kUnbounded, 0.0, 0.0};
  for (std::size_t i = piece.first_row; i < piece.last_row; ++i) {
    const Row& row = rows_[i];
    const double r = row.r * scale;
    double g = r;
    double slope = 0.0;
    if (row.c != 0.0) {
      const double cx = row.c * x;
      g = std::sqrt(std::max(0.0, r * r - cx * cx));
      // At the edge of the disc it falls straight down. Zero would send Newton's method far beyond the solution.
      slope = g > 0.0 ? -row.c * cx / g : -kUnbounded;
    }
    const double middle = row.m * x;
    if (middle - g > result.low) {
      result.low = middle - g;
      result.low_slope = row.m - slope;
    }
    if (middle + g < result.high) {
      result.high = middle + g;
      result.high_slope = row.m + slope;
    }
  }
  return result;
}

double ReachabilityPlanner::largest_begin(const Piece& piece, double x_most, double y_most, double scale) const {
  // The room for y is concave in x: Newton's method from the right meets its zero from the right.
  double x = x_most;
  for (int i = 0; i < 40; ++i) {
    const Interval y = interval(piece, x, scale);
    const double high = std::min(y.high, y_most);
    const double low = std::max(y.low, 0.0);
    const double room = high - low;
    if (room >= 0.0) return x;
    const double slope = (y.high < y_most ? y.high_slope : 0.0) - (y.low > 0.0 ? y.low_slope : 0.0);
    if (!(slope < 0.0)) return 0.0;
    // A hair further: the zero itself may miss by rounding for ever.
    x = std::max(0.0, (x - room / slope) * (1.0 - 1e-12));
  }
  return x;
}

double ReachabilityPlanner::scale_of(const Piece& piece, const std::vector<double>& slow) {
  return slow.empty() ? 1.0 : 1.0 / (slow[piece.cell] * slow[piece.cell]);
}

std::vector<double> ReachabilityPlanner::reachable(const std::vector<double>& slow, std::size_t first) const {
  const std::size_t n = pieces_.size();
  std::vector<double> most(n + 1, kUnbounded);
  for (std::size_t i = 0; i < n; ++i) {
    const double k = scale_of(pieces_[i], slow);
    most[i] = std::min({most[i], k * pieces_[i].x_most, k * pieces_[i].x_most_by_acceleration});
    most[i + 1] = std::min(most[i + 1], k * pieces_[i].y_most);
  }
  most[n] = 0.0;
  for (std::size_t i = n; i-- > first;) {
    if (!std::isfinite(most[i])) return {};
    most[i] = largest_begin(pieces_[i], most[i], most[i + 1], scale_of(pieces_[i], slow));
  }
  return most;
}

bool ReachabilityPlanner::append(AccelerationLaw& law, const Piece& piece, double x, double y) {
  const double rates = std::sqrt(x) + std::sqrt(y);
  if (!(rates > 0.0)) return false;
  law.dds.push_back((y - x) / (2.0 * piece.width));
  law.time.push_back(law.time.back() + 2.0 * piece.width / rates);
  law.s.push_back(piece.s_begin);
  law.cell.push_back(piece.cell);
  return true;
}

std::optional<AccelerationLaw> ReachabilityPlanner::plan(const std::vector<double>& slow) const {
  const std::size_t n = pieces_.size();
  const auto scale = [&](const Piece& piece) { return scale_of(piece, slow); };
  const std::vector<double> most = reachable(slow, 1);
  if (most.empty()) return std::nullopt;
  AccelerationLaw law;
  law.time.reserve(n + 1);
  law.dds.reserve(n);
  law.cell.reserve(n);
  law.s.reserve(n + 1);
  law.time.push_back(0.0);
  double x = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Piece& piece = pieces_[i];
    const double y = std::clamp(interval(piece, x, scale(piece)).high, 0.0, most[i + 1]);
    if (!append(law, piece, x, y)) return std::nullopt;
    x = y;
  }
  law.s.push_back(1.0);
  return law;
}

std::optional<AccelerationLaw> ReachabilityPlanner::plan_from(const LawPoint& start,
                                                              const std::vector<double>& slow) const {
  const std::size_t n = pieces_.size();
  if (!(start.s < 1.0 && start.ds > 0.0)) return std::nullopt;
  std::size_t first = 0;
  while (first < n && pieces_[first].s_begin <= start.s) ++first;
  if (first == n) return std::nullopt;
  const std::vector<double> most = reachable(slow, first);
  if (most.empty()) return std::nullopt;
  // To the next node as it comes; from there on by the limits.
  const double way = pieces_[first].s_begin - start.s;
  double x = start.ds * start.ds + 2.0 * start.dds * way;
  if (!(x > 0.0)) return std::nullopt;
  const double first_time = 2.0 * way / (start.ds + std::sqrt(x));
  AccelerationLaw law{
      .time = {0.0, first_time}, .dds = {start.dds}, .s = {start.s}, .cell = {pieces_[first > 0 ? first - 1 : 0].cell}};
  for (std::size_t i = first; i < n; ++i) {
    const Piece& piece = pieces_[i];
    // Too fast for what comes: it brakes by the limits as they are, or, where they allow nothing, in the middle.
    const bool too_fast = x > most[i] * (1.0 + 1e-9);
    const Interval y_may = interval(piece, x, too_fast ? 1.0 : scale_of(piece, slow));
    const double slowest = y_may.low <= y_may.high ? y_may.low : 0.5 * (y_may.low + y_may.high);
    const double y = std::max(0.0, std::max(std::min(y_may.high, most[i + 1]), slowest));
    if (!append(law, piece, x, y)) return std::nullopt;
    x = y;
  }
  law.s.push_back(1.0);
  if (x > 0.0) return std::nullopt;  // it could not even stop at the end
  return law;
}

LawPoint MovingStart::after_lead() const {
  LawPoint at{.s = 0.0, .ds = begin.ds, .dds = begin.dds, .ddds = 0.0};
  for (const auto& [duration, jerk] : lead) {
    at.ddds = jerk;
    at = advanced(at, duration);
  }
  return at;
}

LawPoint mean_start(const LawPoint& at, double window) {
  return {.s = at.s + 0.5 * window * at.ds + window * window / 12.0 * at.dds,
          .ds = at.ds + 0.5 * window * at.dds,
          .dds = at.dds,
          .ddds = 0.0};
}

namespace {

/// Pieces of constant jerk of the mean of a law over a window; `before` the law its s'' has always been that.
std::vector<TimeLaw::Segment> mean_pieces(const AccelerationLaw& law, double window, double before_law) {
  const std::vector<double>& t = law.time;
  const std::size_t n = law.dds.size();
  std::vector<double> knots;
  knots.reserve(2 * t.size());
  for (std::size_t i = 0, j = 0; i < t.size() || j < t.size();) {
    const bool first = i < t.size() && t[i] <= t[j] + window;
    knots.push_back(first ? t[i++] : t[j++] + window);
  }
  std::vector<TimeLaw::Segment> segments;
  segments.reserve(knots.size());
  const auto dds = [&](double at, std::size_t& guess) {
    if (at < 0.0) return before_law;
    if (at >= t.back()) return 0.0;
    while (guess + 1 < n && at >= t[guess + 1]) ++guess;
    return law.dds[guess];
  };
  // Knots nearer than this (a part of the whole) are one: what a jerk does in between is rounding.
  const double least = 1e-12 * (t.back() + window);
  std::size_t now = 0;
  std::size_t before = 0;
  double begin = 0.0;
  for (std::size_t k = 1; k < knots.size(); ++k) {
    if (knots[k] - begin <= least) continue;
    const double middle = 0.5 * (begin + knots[k]);
    const double jerk = (dds(middle, now) - dds(middle - window, before)) / window;
    segments.push_back({.duration_s = knots[k] - begin, .jerk = jerk});
    begin = knots[k];
  }
  return segments;
}

}  // namespace

TimeLaw averaged(const AccelerationLaw& law, double window, const MovingStart& start) {
  std::vector<TimeLaw::Segment> segments = start.lead;
  const auto mean = mean_pieces(law, window, start.after_lead().dds);
  segments.insert(segments.end(), mean.begin(), mean.end());
  return TimeLaw::create(std::move(segments), start.begin).value_or(TimeLaw());
}

TimeLaw averaged(const AccelerationLaw& law, double window) {
  std::vector<TimeLaw::Segment> segments = mean_pieces(law, window, 0.0);
  // Rounding of the sums: scaled to end at exactly 1 as far as it can be.
  double s = 0.0;
  double ds = 0.0;
  double dds_now = 0.0;
  for (const auto& [d, j] : segments) {
    s += d * (ds + d / 2 * (dds_now + d / 3 * j));
    ds += d * (dds_now + d / 2 * j);
    dds_now += d * j;
  }
  for (TimeLaw::Segment& segment : segments) segment.jerk /= s;
  return TimeLaw::create(std::move(segments)).value_or(TimeLaw());
}

namespace {

/// One window: plan, average, slow down where the average breaks a limit, again.
class WindowSearch {
 public:
  WindowSearch(const PathShape& shape, const ReachabilityPlanner& planner, double window, std::vector<double> slow = {})
      : shape_(shape), planner_(planner), window_(window), slow_(std::move(slow)) {
    if (slow_.empty()) slow_.assign(shape.cells.size(), 1.0);
    least_slow_ = slow_;
  }

  /// As run(), of a law that begins in motion and so must fit as it is.
  void run_in_motion(const MovingStart& start, std::optional<OptimalLaw>& best) {
    constexpr int kRounds = 16;
    double lead = 0.0;
    for (const TimeLaw::Segment& segment : start.lead) lead += segment.duration_s;
    for (int round = 0; round < kRounds; ++round) {
      const auto raw = planner_.plan_from(mean_start(start.after_lead(), window_), slow_);
      if (!raw || (best && lead + raw->duration() + window_ >= best->law.duration())) return;
      TimeLaw law = averaged(*raw, window_, start);
      if (law.segments().empty()) return;
      Loads loads = loads_of(shape_, law);
      const double excess = loads.largest_stretch;
      const bool good = excess <= kGoodEnough;
      if (!good) slow_down(*raw, loads, kBold, lead);
      if (leaves_room(shape_, loads)) best = OptimalLaw{.law = std::move(law), .loads = std::move(loads)};
      if (good) return;
    }
  }

  void run(int rounds, std::optional<OptimalLaw>& best, double& best_duration) {
    double own_best = kUnbounded;
    int idle = 0;
    for (int round = 0; round < rounds && idle < kIdleRounds; ++round) {
      const auto raw = planner_.plan(slow_);
      // Averaging only adds to it.
      if (!raw || raw->duration() + window_ >= best_duration) return;
      TimeLaw law = averaged(*raw, window_);
      if (law.segments().empty()) return;
      Loads loads = loads_of(shape_, law);
      const double duration = law.duration() * loads.largest_stretch;
      const double excess = loads.largest_stretch;
      if (round + 1 < rounds && excess > kGoodEnough) slow_down(*raw, loads, kCareful);
      idle = duration < kProgress * own_best ? 0 : idle + 1;
      own_best = std::min(own_best, duration);
      if (duration < best_duration) {
        best_duration = duration;
        best = OptimalLaw{.law = std::move(law), .loads = std::move(loads)};
      }
      if (excess <= kGoodEnough) return;
    }
  }

 private:
  static constexpr double kGoodEnough = 1.003;
  /// Given up after so many rounds in a row without as much progress.
  static constexpr int kIdleRounds = 4;
  static constexpr double kProgress = 0.998;
  /// How far a cell is slowed in one round: careful where the rest is stretched away, bold where all must fit.
  struct Pace {
    double step, power;
  };
  static constexpr Pace kCareful{1.2, 0.5}, kBold{1.6, 0.8};

  /// Each cell is slowed by what is needed while the window covers it; where it was slowed for nothing it is sped up.
  /// @param lead  s: by how much the law begins earlier than `raw`
  void slow_down(const AccelerationLaw& raw, const Loads& loads, const Pace& pace, double lead = 0.0) {
    std::vector<double> needed(slow_.size(), 0.0);
    std::size_t first = 0;
    for (std::size_t i = 0; i < loads.instants.size(); ++i) {
      const double until = loads.instants[i].tau - lead;
      while (first + 1 < raw.dds.size() && raw.time[first + 1] < until - window_) ++first;
      for (std::size_t k = first; k < raw.dds.size() && raw.time[k] <= until; ++k) {
        needed[raw.cell[k]] = std::max(needed[raw.cell[k]], loads.stretch[i]);
      }
    }
    for (std::size_t c = 0; c < slow_.size(); ++c) {
      slow_[c] =
          std::max(least_slow_[c], slow_[c] * std::pow(std::clamp(needed[c], 1.0 / pace.step, pace.step), pace.power));
    }
  }

  const PathShape& shape_;
  const ReachabilityPlanner& planner_;
  double window_;
  std::vector<double> slow_, least_slow_;
};

}  // namespace

std::optional<OptimalLaw> time_optimal(const PathShape& shape, double shorter_than, const TimeOptimalOptions& options) {
  ReachabilityPlanner planner(shape, options.cuts);
  std::optional<OptimalLaw> best;
  double best_duration = shorter_than;
  const auto raw = planner.plan({});
  if (!raw) return best;
  const double window = window_for_jumps(shape, *raw);
  for (const double factor : options.windows) {
    WindowSearch(shape, planner, factor * window).run(options.rounds, best, best_duration);
  }
  return best;
}

std::optional<OptimalLaw> time_optimal_in_motion(const PathShape& shape, const MovingStart& start,
                                                 const std::vector<double>& slow) {
  constexpr int kCuts = 2;
  const ReachabilityPlanner planner(shape, kCuts);
  const LawPoint from = start.after_lead();
  const auto raw = planner.plan_from(from, slow);
  if (!raw) return std::nullopt;
  const double window = window_for_jumps(shape, *raw, from.dds);
  std::optional<OptimalLaw> best;
  for (const double factor : {1.0, 0.7, 0.5})
    WindowSearch(shape, planner, factor * window, slow).run_in_motion(start, best);
  return best;
}

}  // namespace takt::motion
