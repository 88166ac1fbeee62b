#include "core/motion/path_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/solutions.h"
#include "core/motion/plan_checks.h"
#include "core/motion/time_optimal.h"

namespace takt::motion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const char* word_for(const Geometry& geometry) {
  if (std::holds_alternative<CartesianArc>(geometry)) return "arc";
  return std::holds_alternative<CartesianCurve>(geometry) || std::holds_alternative<JointCurve>(geometry) ? "curve"
                                                                                                          : "line";
}

/// Largest derivatives of each channel over the shape.
struct Extremes {
  Channels first, second;
};

Extremes extremes(const PathShape& shape) {
  Extremes most{Channels::Zero(shape.joint_count + 2), Channels::Zero(shape.joint_count + 2)};
  for (const PathShape::Node& node : shape.nodes) {
    most.first = most.first.max(shape.channels(node.first));
    most.second = most.second.max(shape.channels(node.second));
  }
  return most;
}

/// Limits of s when `tangential` of each acceleration limit goes into speeding up and the rest into the curvature of
/// the path, both at their largest on the path.
RateLimits rate_limits(const Extremes& most, const ShapeLimits& limits, double tangential) {
  RateLimits result{kInfinity, kInfinity, kInfinity};
  for (Eigen::Index i = 0; i < most.first.size(); ++i) {
    result.velocity = std::min(result.velocity, limits.velocity[i] / most.first[i]);
    result.acceleration = std::min(result.acceleration, tangential * limits.acceleration[i] / most.first[i]);
    result.jerk = std::min(result.jerk, tangential * limits.jerk[i] / most.first[i]);
    if (tangential < 1.0) {
      result.velocity =
          std::min(result.velocity, std::sqrt((1 - tangential) * limits.acceleration[i] / most.second[i]));
    }
  }
  return result;
}

/// Rest-to-rest laws of seven segments with the acceleration limits divided in several ways between speeding up and
/// the curvature of the path, each stretched until it just fits; the shortest.
OptimalLaw simple_law(const PathShape& shape) {
  const Extremes most = extremes(shape);
  const bool bends = (most.second > 0.0).any();
  OptimalLaw best;
  std::optional<double> duration;  // of the best
  for (const double tangential : {1.0, 0.75, 0.5}) {
    if (tangential < 1.0 && !bends) break;  // there is no curvature to leave anything for
    RateLimits bounds{kInfinity, kInfinity, kInfinity};
    for (const ShapeLimits& limits : shape.limits) {
      const RateLimits own = rate_limits(most, limits, tangential);
      bounds = {std::min(bounds.velocity, own.velocity), std::min(bounds.acceleration, own.acceleration),
                std::min(bounds.jerk, own.jerk)};
    }
    TimeLaw law = TimeLaw::rest_to_rest(bounds);
    auto loads = loads_if_shorter(shape, law, duration);
    if (!loads) continue;
    duration = law.duration() * loads->largest_stretch;
    best = {.law = std::move(law), .loads = std::move(*loads)};
  }
  return best;
}

/// The optimal law, if it is worth it beside the simple one, which is much less data.
OptimalLaw fastest_law(const PathShape& shape, OptimalLaw simple) {
  constexpr double kWorthIt = 0.99;
  // A single motion is begun while somebody waits; a sequence is worth some milliseconds.
  constexpr std::size_t kManyCells = 48;
  const bool many = shape.cells.size() > kManyCells;
  const TimeOptimalOptions options{.cuts = many ? 1 : 2, .rounds = many ? 2 : 4, .windows = {1.0, 0.6}};
  auto optimal = time_optimal(shape, kWorthIt * simple.law.duration() * simple.loads.largest_stretch, options);
  return optimal ? std::move(*optimal) : std::move(simple);
}

/// The same for a sequence, for which the simple law is hardly ever anything.
OptimalLaw fastest_law_of_sequence(const PathShape& shape) {
  auto optimal = time_optimal(shape, kInfinity);
  return optimal ? std::move(*optimal) : simple_law(shape);
}

/// True if the interpolation between the nodes cannot be off by more than a few per cent of a jerk limit at the speed
/// that the law has there.
bool known_well_enough(const PieceWalk& walk, const PathPiece& piece, const OptimalLaw& law, const JointVector& jerk) {
  constexpr double kShare = 0.02;
  double fastest = 0.0;
  for (const Loads::Instant& instant : law.loads.instants) {
    if (instant.at.s >= piece.s_begin && instant.at.s <= piece.s_end) fastest = std::max(fastest, instant.at.ds);
  }
  fastest /= law.loads.largest_stretch * (piece.s_end - piece.s_begin);
  const JointVector off = walk.roughness() * (fastest * fastest * fastest);
  return (off.array() <= kShare * jerk.array()).all();
}

/// Nodes of a piece to begin with: by its share of the path.
int coarse_steps(const std::vector<PlannedPiece>& pieces, const PathPiece& piece) {
  if (pieces.size() == 1) return 32;
  return std::clamp(static_cast<int>(160.0 * (piece.s_end - piece.s_begin)), 16, 48);
}

/// True where the optimal law gains nothing (all joints in proportion: the simple law is the optimal one) or a
/// hundredth (a straight line of a frame).
bool keeps_simple_law(const Geometry& geometry) {
  return std::holds_alternative<JointLine>(geometry) || std::holds_alternative<CartesianLine>(geometry);
}

std::vector<PieceShares> shares_of(const std::vector<PlannedPiece>& pieces) {
  std::vector<PieceShares> shares;
  for (const PlannedPiece& piece : pieces) shares.push_back(piece.shares);
  return shares;
}

/// How far around a measured peak of the jerk the path is looked at, in s.
constexpr double kReach = 0.02;

/// The loads around s are made to show the jerk that was measured, so that the clock leaves room for it.
void raise_jerk(const PathShape& shape, double s, double share, Loads& loads) {
  for (Loads::Instant& load : loads.instants) {
    if (std::abs(load.at.s - s) > kReach) continue;
    const Channels& jerk = shape.limits[shape.cells[load.cell].limits].hard_jerk;
    const double shown = (load.third / jerk).maxCoeff();
    if (shown > 0.0 && shown < share) load.third *= share / shown;
  }
}

/// Slows the cells around s.
void slow_down_around(const PathShape& shape, double s, double factor, std::vector<double>& slow) {
  for (std::size_t c = 0; c < shape.cells.size(); ++c) {
    const double begin = shape.nodes[shape.cells[c].node].s;
    const double end = begin + shape.cells[c].width;
    if (end >= s - kReach && begin <= s + kReach) slow[c] *= factor;
  }
}

Path as_path(const std::vector<PlannedPiece>& pieces) {
  const PathPiece& first = pieces.front().piece;
  const bool whole = pieces.size() == 1 && first.own_begin == 0.0 && first.own_end == 1.0;
  if (whole) {
    if (const auto* line = std::get_if<JointLine>(&first.geometry)) return *line;
    if (const auto* line = std::get_if<CartesianLine>(&first.geometry)) return *line;
    if (const auto* arc = std::get_if<CartesianArc>(&first.geometry)) return *arc;
  }
  CompositePath path;
  for (const PlannedPiece& piece : pieces) path.pieces.push_back(piece.piece);
  return path;
}

}  // namespace

/// Of the jerk limits, for what is measured of a planned sequence; the rest is for the clock.
constexpr double kMeasuredShareOfJerk = 0.75;
constexpr int kRoundsOfMeasuring = 4;
/// What is still let pass where nothing can be stretched: the clock gets what is left.
constexpr double kMostShareOfJerk = 0.92;
/// The same of what gravity and friction leave of the torques.
constexpr double kMostShareOfTorque = 0.95;

namespace {

using Torques = std::optional<TorqueProfile>;

Diagnostics overloads(const Torques& torques, const std::string& pointer) {
  return torques ? torques->overloads(pointer) : Diagnostics{};
}

TorqueProfile::Need need_of(const Torques& torques, const TimeLaw& law, double share) {
  return torques ? torques->need(law, share) : TorqueProfile::Need{};
}

ClockBounds within_torques(const ClockBounds& clock, const Torques& torques, const TimeLaw& law) {
  if (!torques) return clock;
  ClockBounds both = common(clock, torques->clock(law));
  both.stop = simplified(both.stop);
  return both;
}

}  // namespace

ShapeLimits PathPlanner::limits_of(const PieceShares& shares) const {
  const int n = chain_.joint_count();
  ShapeLimits limits{Channels(n + 2), Channels(n + 2), Channels(n + 2), Channels(n + 2), Channels(n + 2)};
  limits.velocity.head(n) = limits_.velocity.array() * shares.velocity;
  limits.velocity.tail<2>() << std::min(cartesian_.linear_velocity * shares.velocity, shares.linear_velocity),
      cartesian_.angular_velocity * shares.velocity;
  limits.hard_acceleration.head(n) = limits_.acceleration.array();
  limits.hard_acceleration.tail<2>() << cartesian_.linear_acceleration, cartesian_.angular_acceleration;
  limits.hard_jerk.head(n) = limits_.jerk.array();
  limits.hard_jerk.tail<2>() << cartesian_.linear_jerk, cartesian_.angular_jerk;
  limits.velocity *= kLawShareOfVelocity;
  limits.acceleration = kLawShareOfAcceleration * shares.acceleration * limits.hard_acceleration;
  limits.jerk = kLawShareOfJerk * shares.acceleration * limits.hard_jerk;
  return limits;
}

void PathPlanner::check_ranges(const PieceWalk& walk, const char* word, const std::string& pointer,
                               Diagnostics& diagnostics) const {
  // One diagnostic per joint: where it first leaves its range.
  for (int i = 0; i < chain_.joint_count() && !walk.nodes.empty(); ++i) {
    const double begin = walk.nodes.front().q[i];
    const double lower = std::min(limits_.lower[i], begin), upper = std::max(limits_.upper[i], begin);
    for (std::size_t n = 0; n < walk.nodes.size(); ++n) {
      const double q = walk.nodes[n].q[i];
      if (q >= lower - kPathTolerance && q <= upper + kPathTolerance) continue;
      range_diagnostic(chain_, limits_, i, q, pointer, fmt::format(" at {:.0f} % of the {}", 100 * walk.t(n), word),
                       diagnostics);
      break;
    }
  }
}

/// A base that cannot go sideways follows what runs along its own x axis at every place.
void PathPlanner::check_rolling(const PieceWalk& walk, const char* word, const std::string& pointer,
                                Diagnostics& diagnostics) const {
  constexpr double kRounding = 1e-6, kNothing = 1e-9;  // m/m of the way; m
  if (!limits_.nonholonomic) return;
  for (std::size_t n = 0; n < walk.nodes.size(); ++n) {
    const PieceWalk::Node& node = walk.nodes[n];
    const double ahead = node.dq.head<2>().norm(), sideways = sideways_speed(node.q[2], node.dq);
    if (std::abs(sideways) <= kRounding * ahead + kNothing) continue;
    diagnostics.error(
        Code::kUnsupported, pointer,
        fmt::format("the base cannot go sideways: at {:.0f} % of the {} its path is turned by {:.3g} deg against where "
                    "it points",
                    100 * walk.t(n), word,
                    std::asin(std::min(1.0, std::abs(sideways) / ahead)) * 180.0 / std::numbers::pi),
        "straight ahead or back, a turn on the spot, an arc with its tangent, or PTP: it turns, drives and turns");
    return;
  }
}

namespace {

/// @param t  share of the path   @param way  its length, m; 0: the tool only turns
std::string how_far(double t, const char* word, double way) {
  constexpr double kTellable = 5e-4;  // of the path, and of a metre
  if (!(t >= kTellable)) return fmt::format("cannot follow the {} at all from where it begins", word);
  const double left = (1.0 - t) * way;
  const std::string before = left >= kTellable ? fmt::format(", {:.1f} mm before the goal", 1e3 * left) : "";
  return fmt::format("follows to {:.1f} % of the {}{}", 100 * t, word, before);
}

}  // namespace

void PathPlanner::explain_end(const PieceWalk& walk, const PathPiece& piece, const char* word,
                              const std::string& pointer, Diagnostics& diagnostics) const {
  const std::string place = fmt::format("at {:.1f} % of the {}", 100 * walk.t_end, word);
  const double way = walk.nodes.empty() ? 0.0 : walk.nodes.front().dX.head<3>().norm();
  kinematics::SolutionOptions search;
  search.reference = walk.nodes.empty() ? JointVector() : walk.nodes.front().q;
  const Eigen::Isometry3d X_BF = sample(piece.geometry, {.s = piece.own_end}).frame.X_BM * X_FM_.inverse();
  if (inverse_solutions(chain_, X_BF, search).empty()) {
    const bool few = chain_.joint_count() < 6;
    diagnostics.error(
        Code::kUnreachable, pointer,
        fmt::format("the goal is out of reach: the arm {}", how_far(walk.t_end, word, way)),
        few ? fmt::format("an arm of {} joints cannot turn its tool freely: a {} on which it can keep the orientation, "
                          "or PTP",
                          chain_.joint_count(), word)
            : "a goal nearer to the base, or another orientation");
    return;
  }
  switch (walk.end) {
    case WalkEnd::kSingular:
      diagnostics.error(
          Code::kPlanningFailed, pointer,
          fmt::format("the {} comes too near to a singularity {} (measure {:.4f})", word, place, walk.measure),
          fmt::format("a measure of at least {}; another {}, or PTP", kSingularityLeast, word));
      break;
    case WalkEnd::kOtherBranch:
      diagnostics.error(Code::kPlanningFailed, pointer,
                        fmt::format("the {} would change to another branch of the inverse kinematics {}", word, place),
                        fmt::format("another {}, another start configuration, or PTP", word));
      break;
    default:
      diagnostics.error(Code::kPlanningFailed, pointer,
                        fmt::format("the arm cannot follow {} in the configuration of the start", place),
                        "the goal is reachable in another configuration: PTP");
  }
}

WalkedPath PathPlanner::walk(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                             const std::vector<int>& steps, const std::string& pointer) const {
  WalkedPath path;
  JointVector q = q_start;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const PathPiece& piece = pieces[i].piece;
    const PieceWalk* known = pieces[i].known;
    const bool same =
        known != nullptr && known->steps == steps[i] && known->end == WalkEnd::kGoal && known->nodes.front().q == q;
    path.walks.push_back(same ? *known : walk_piece(inverse_, piece, X_FM_, q, steps[i]));
    const PieceWalk& walk = path.walks.back();
    const char* word = word_for(piece.geometry);
    check_ranges(walk, word, pointer, path.diagnostics);
    check_rolling(walk, word, pointer, path.diagnostics);
    if (walk.end != WalkEnd::kGoal) explain_end(walk, piece, word, pointer, path.diagnostics);
    if (path.diagnostics.has_errors()) {
      path.failed_piece = i;
      return path;
    }
    q = walk.nodes.back().q;
  }
  return path;
}

PathShape PathPlanner::shape_of(const std::vector<PlannedPiece>& pieces, const std::vector<PieceWalk>& walks) const {
  const int n = chain_.joint_count();
  PathShape shape;
  shape.joint_count = n;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const PathPiece& piece = pieces[i].piece;
    const double rate = 1.0 / (piece.s_end - piece.s_begin);
    const bool as_before = i > 0 && pieces[i].shares == pieces[i - 1].shares;
    if (!as_before) shape.limits.push_back(limits_of(pieces[i].shares));
    const auto count = static_cast<std::size_t>(walks[i].steps);
    for (std::size_t k = 0; k <= count; ++k) {
      const PieceWalk::Node& node = walks[i].nodes[k];
      const double s = k == count ? piece.s_end : piece.s_begin + (piece.s_end - piece.s_begin) * walks[i].t(k);
      PathShape::Node seen{.s = s, .first = Components(n + 6), .second = Components(n + 6)};
      seen.first << node.dq.array() * rate, node.dX.array() * rate;
      seen.second << node.ddq.array() * (rate * rate), node.ddX.array() * (rate * rate);
      shape.nodes.push_back(std::move(seen));
      if (k > 0) shape.add_cell();
    }
  }
  return shape;
}

std::optional<TorqueProfile> PathPlanner::torques_along(const std::vector<PlannedPiece>& pieces,
                                                        const std::vector<PieceWalk>& walks) const {
  if (load_ == nullptr) return std::nullopt;
  TorqueProfile profile(chain_, *load_);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const PathPiece& piece = pieces[i].piece;
    const double width = piece.s_end - piece.s_begin;
    for (std::size_t k = 0; k < walks[i].nodes.size(); ++k) {
      const PieceWalk::Node& node = walks[i].nodes[k];
      profile.add(piece.s_begin + width * walks[i].t(k), node.q, node.dq / width, node.ddq / (width * width));
    }
  }
  return profile;
}

// s: half the shortest cycle that a device takes.
constexpr double kJerkStep = 0.5e-3;

bool PathPlanner::follow(const Motion& motion, const LawPoint& at, JointVector& q) const {
  const PathSample there = sample(motion.path, {.s = at.s, .ds = at.ds, .dds = at.dds});
  if (!there.cartesian) {
    q = there.joints.q;
    return true;
  }
  // walk() has followed the path; a step that fails here says nothing of its jerk.
  return inverse_->solve(there.frame.X_BM * X_FM_.inverse(), there.held.q, q) == kinematics::IkStatus::kOk;
}

double PathPlanner::jerk_share(const std::array<JointVector, 4>& q) const {
  const JointVector jerk = (q[3] - 3.0 * q[2] + 3.0 * q[1] - q[0]) / (kJerkStep * kJerkStep * kJerkStep);
  return (jerk.cwiseAbs().array() / limits_.jerk.array()).maxCoeff();
}

PathPlanner::JerkPeak PathPlanner::largest_jerk(const Motion& motion) const {
  constexpr double kLong = 60.0;  // s: 120 000 steps, a tenth of a second of planning
  return motion.duration() <= kLong ? largest_jerk_of_each_step(motion) : largest_jerk_along_path(motion);
}

PathPlanner::JerkPeak PathPlanner::largest_jerk_of_each_step(const Motion& motion) const {
  const auto count = static_cast<std::int64_t>(std::ceil(motion.duration() / kJerkStep));
  std::array<JointVector, 4> q;  // the newest last
  q.fill(motion.q_start);
  const std::int64_t known_from = motion.law.begins_in_motion() ? 3 : 1;  // what was before is another plan's
  JerkPeak peak;
  for (std::int64_t k = 1; k <= count; ++k) {
    const LawPoint at = motion.law.at(static_cast<double>(k) * kJerkStep);
    std::ranges::rotate(q, q.begin() + 1);
    q[3] = q[2];
    if (!follow(motion, at, q[3])) continue;
    const double share = jerk_share(q);
    if (k >= known_from && share > peak.share) peak = {.share = share, .s = at.s};
  }
  return peak;
}

/// Of a motion that lasts too long to look at each step: four steps in a row, again and again, with a small part of the
/// path between them. Where the arm is slow, little can happen in it.
PathPlanner::JerkPeak PathPlanner::largest_jerk_along_path(const Motion& motion) const {
  constexpr double kSpacing = 1.0 / 20'000.0;  // of the path
  constexpr double kWindow = 3.0 * kJerkStep;
  std::array<JointVector, 4> q;
  q.fill(motion.q_start);
  JerkPeak peak;
  double jump = kJerkStep;
  for (double t = 0.0; t + kWindow <= motion.duration();) {
    q.fill(q[3]);
    bool known = true;
    for (std::size_t k = 0; k < q.size(); ++k) {
      if (k > 0) q[k] = q[k - 1];
      known = follow(motion, motion.law.at(t + static_cast<double>(k) * kJerkStep), q[k]) && known;
    }
    const double s = motion.law.at(t).s;
    if (const double share = jerk_share(q); known && share > peak.share) peak = {.share = share, .s = s};
    for (jump *= 2.0; jump > kJerkStep && motion.law.at(t + jump).s - s > kSpacing;) jump /= 2.0;
    t += std::max(jump, kJerkStep);
  }
  return peak;
}

/// Nodes of a path that is entered in motion: it is planned while the arm moves, and once.
int steps_in_motion(const PathPiece& piece) {
  return std::clamp(static_cast<int>(200.0 * (piece.s_end - piece.s_begin)), 16, 64);
}

Result<Motion> PathPlanner::plan_in_motion(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                                           const MovingStart& start, const std::string& pointer,
                                           std::size_t& failed_piece) const {
  std::vector<int> steps;
  for (const PlannedPiece& piece : pieces) steps.push_back(steps_in_motion(piece.piece));
  const WalkedPath path = walk(pieces, q_start, steps, pointer);
  failed_piece = path.failed_piece;
  if (path.diagnostics.has_errors()) return std::unexpected(path.diagnostics);
  const auto torques = torques_along(pieces, path.walks);
  if (Diagnostics heavy = overloads(torques, pointer); heavy.has_errors()) return std::unexpected(std::move(heavy));
  const PathShape shape = shape_of(pieces, path.walks);
  Motion motion{.path = as_path(pieces),
                .law = {},
                .clock = {},
                .q_start = q_start,
                .q_goal = path.walks.back().nodes.back().q,
                .shares = shares_of(pieces)};
  std::vector<double> slow(shape.cells.size(), 1.0);
  for (int round = 0; round < kRoundsOfMeasuring; ++round) {
    auto best = time_optimal_in_motion(shape, start, slow);
    if (!best) break;
    motion.law = std::move(best->law);
    const TorqueProfile::Need torque = need_of(torques, motion.law, kMostShareOfTorque);
    if (torque.stretch > 1.0) {
      slow_down_around(shape, torque.s, 1.05 * torque.stretch, slow);
      continue;
    }
    const JerkPeak peak = largest_jerk(motion);
    if (peak.share <= kMostShareOfJerk) {
      raise_jerk(shape, peak.s, peak.share, best->loads);
      motion.clock = clock_for(shape, best->loads, 1.0);
      motion.clock.stop = stop_table_for(shape, motion.law, std::max(peak.share, kMeasuredShareOfJerk));
      motion.clock = within_torques(motion.clock, torques, motion.law);
      return motion;
    }
    slow_down_around(shape, peak.s, 1.05 * std::cbrt(peak.share / kMeasuredShareOfJerk), slow);
  }
  failed_piece = pieces.size() - 1;
  return failure(Code::kLimitExceeded, pointer, "the path bends too early for the speed with which it is entered");
}

Result<FollowedPath> PathPlanner::follow(const Motion& motion, const std::string& pointer) const {
  constexpr int kSteps = 48;
  std::vector<PlannedPiece> pieces;
  for (PathPiece& piece : pieces_of(motion.path)) {
    const std::size_t k = pieces.size();
    pieces.push_back({std::move(piece), k < motion.shares.size() ? motion.shares[k] : PieceShares{}});
  }
  WalkedPath path = walk(pieces, motion.q_start, std::vector<int>(pieces.size(), kSteps), pointer);
  if (path.diagnostics.has_errors()) return std::unexpected(std::move(path.diagnostics));
  auto torques = torques_along(pieces, path.walks);
  if (Diagnostics heavy = overloads(torques, pointer); heavy.has_errors()) return std::unexpected(std::move(heavy));
  return FollowedPath{
      .shape = shape_of(pieces, path.walks), .torques = std::move(torques), .q_goal = path.walks.back().nodes.back().q};
}

PathFit PathPlanner::fit(const FollowedPath& path, const Motion& motion) const {
  Loads loads = loads_of(path.shape, motion.law);
  // As in plan(): only where pieces meet can the joints do more than the nodes show.
  const auto* composite = std::get_if<CompositePath>(&motion.path);
  const bool single = composite == nullptr || composite->pieces.size() == 1;
  const JerkPeak peak = single ? JerkPeak{} : largest_jerk(motion);
  PathFit fit{.stretch = std::max({loads.largest_stretch, std::cbrt(peak.share / kMeasuredShareOfJerk),
                                   need_of(path.torques, motion.law, kLawShareOfAcceleration).stretch}),
              .leaves_room = takt::motion::leaves_room(path.shape, loads) && peak.share <= kMostShareOfJerk &&
                             need_of(path.torques, motion.law, kMostShareOfTorque).stretch <= 1.0,
              .clock = {},
              .q_goal = path.q_goal};
  raise_jerk(path.shape, peak.s, peak.share, loads);
  fit.clock = clock_for(path.shape, loads, 1.0);
  fit.clock.stop = stop_table_for(path.shape, motion.law, single ? 0.0 : std::max(peak.share, kMeasuredShareOfJerk));
  fit.clock = within_torques(fit.clock, path.torques, motion.law);
  return fit;
}

Result<Motion> PathPlanner::plan(const std::vector<PlannedPiece>& pieces, const JointVector& q_start,
                                 const std::string& pointer, std::size_t& failed_piece) const {
  // Coarse first; finer until the joint path is known well enough at the speed that it will be run with.
  constexpr int kFine = 1024;
  std::vector<int> steps;
  for (const PlannedPiece& piece : pieces) steps.push_back(coarse_steps(pieces, piece.piece));
  for (;;) {
    WalkedPath path = walk(pieces, q_start, steps, pointer);
    if (path.diagnostics.has_errors()) {
      failed_piece = path.failed_piece;
      return std::unexpected(std::move(path.diagnostics));
    }
    const PathShape shape = shape_of(pieces, path.walks);
    const bool single = pieces.size() == 1;
    // Whether the nodes are dense enough is asked of a law that is found fast, before it is asked of the best.
    OptimalLaw best = single ? simple_law(shape) : fastest_law_of_sequence(shape);
    if (single && !keeps_simple_law(pieces.front().piece.geometry) &&
        (steps[0] >= kFine || known_well_enough(path.walks[0], pieces[0].piece, best, limits_.jerk))) {
      best = fastest_law(shape, std::move(best));
    }
    bool again = false;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (steps[i] >= kFine || known_well_enough(path.walks[i], pieces[i].piece, best, limits_.jerk)) continue;
      steps[i] *= 2;
      again = true;
    }
    if (again) continue;
    Motion motion{.path = as_path(pieces),
                  .law = {},
                  .clock = {},
                  .q_start = q_start,
                  .q_goal = path.walks.back().nodes.back().q,
                  .shares = shares_of(pieces)};
    const auto torques = torques_along(pieces, path.walks);
    if (Diagnostics heavy = overloads(torques, pointer); heavy.has_errors()) {
      failed_piece = pieces.size() - 1;
      return std::unexpected(std::move(heavy));
    }
    double stretch = best.loads.largest_stretch;
    const auto stretch_law = [&] {
      motion.law = best.law.stretched(stretch);
      motion.clock = clock_for(shape, best.loads, stretch);
    };
    stretch_law();
    const double heavy = need_of(torques, motion.law, kLawShareOfAcceleration).stretch;
    if (heavy > 1.0) {
      stretch *= heavy;
      stretch_law();
    }
    // Where pieces meet, the joints may do between two nodes what no interpolation shows; so it is measured.
    for (int round = 0; !single && round < kRoundsOfMeasuring; ++round) {
      const double share = largest_jerk(motion).share;
      if (share <= kMeasuredShareOfJerk) break;
      stretch *= std::cbrt(share / kMeasuredShareOfJerk);
      stretch_law();
    }
    motion.clock.stop = stop_table_for(shape, motion.law, single ? 0.0 : kMeasuredShareOfJerk);
    motion.clock = within_torques(motion.clock, torques, motion.law);
    return motion;
  }
}

void check_cartesian(const CartesianLimits& limits, Diagnostics& diagnostics) {
  const struct {
    const char* name;
    double value;
  } entries[] = {{"linear_velocity", limits.linear_velocity},
                 {"linear_acceleration", limits.linear_acceleration},
                 {"linear_jerk", limits.linear_jerk},
                 {"angular_velocity", limits.angular_velocity},
                 {"angular_acceleration", limits.angular_acceleration},
                 {"angular_jerk", limits.angular_jerk}};
  for (const auto& [name, value] : entries) {
    if (std::isfinite(value) && value > 0.0) continue;
    diagnostics.error(Code::kOutOfRange, fmt::format("/cartesian_limits/{}", name), fmt::format("limit {}", value),
                      "finite and above 0");
  }
}

}  // namespace takt::motion
