#include "core/planning/free_space.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

namespace takt::planning {
namespace {

using collision::Body;
using collision::PairRule;

/// A stretch is proven to keep what is demanded less this, so that halving ends, m.
constexpr double kSlack = 1e-4;
/// Links of one machine are built near to each other, and where they are is known best, m.
constexpr double kOwnClearance = 5e-4;
/// Pairs in contact at the start have to part by this for each m that they may have moved.
constexpr double kParting = 0.05;
/// The same of an arm that starts within what another one sweeps: it has to leave that soon.
constexpr double kLeaving = 0.3;
/// Bodies that are so near to what is demanded are worth an exact distance, m.
constexpr double kNear = 5e-3;
/// A bound that carries over this share of what is needed is not worth a better one.
constexpr double kWorth = 0.3;
/// Halvings of a stretch; a pair that is still open then follows the border of what is free.
constexpr double kFinest = 1.0 / 16384;

}  // namespace

Stretch straight(const JointVector& from, const JointVector& to) {
  return {.at = [from, to](double u, JointVector& q) { q = from + u * (to - from); },
          .fastest = (to - from).cwiseAbs()};
}

FreeSpace::FreeSpace(const collision::Scene& scene, const collision::State& state, std::vector<int> joints,
                     const FreeSpaceOptions& options)
    : scene_(scene), state_(state), joints_(std::move(joints)), lower_(options.lower), upper_(options.upper) {
  const std::vector<bool> moved = scene.moved_by(state, joints_);
  for (const int body : scene.parents_first(state))
    if (moved[static_cast<std::size_t>(body)]) order_.push_back(body);
  scene.place(state, poses_);
  for (std::size_t i = 0; i < poses_.size(); ++i) centres_.push_back(poses_[i] * scene.bodies()[i].box.center());
  find_pairs(options);
}

// -- What can meet
// ------------------------------------------------------------------------------------------------------

void FreeSpace::find_pairs(const FreeSpaceOptions& options) {
  const std::vector<bool> moved = scene_.moved_by(state_, joints_);
  const auto moves = [&moved](int body) { return moved[static_cast<std::size_t>(body)]; };
  const int n = static_cast<int>(scene_.bodies().size());
  for (const int a : order_) {
    for (int b = 0; b < n; ++b) {
      if (b == a || (moves(b) && b < a) || scene_.never_meet(a, b)) continue;
      if (scene_.body(a).parts.empty() || scene_.body(b).parts.empty()) continue;
      const auto sweep = moves(b) ? std::optional(-1) : sweep_of(b, options);
      if (!sweep) continue;
      const PairRule rule = options.rule ? options.rule(a, b) : PairRule{};
      if (rule.kind != PairRule::Kind::kIgnored) add_pair(a, b, *sweep, rule, options);
    }
  }
}

std::optional<int> FreeSpace::sweep_of(int body, const FreeSpaceOptions& options) {
  if (options.swept == nullptr) return -1;
  const auto swept = options.swept->bodies.find(body);
  if (swept == options.swept->bodies.end()) return -1;
  if (swept->second.empty()) return std::nullopt;
  const auto [found, fresh] = sweep_of_.try_emplace(body, static_cast<int>(sweeps_.size()));
  if (fresh) sweeps_.emplace_back(swept->second, scene_.body(body).box.center(), scene_.body(body).radius);
  return found->second;
}

void FreeSpace::add_pair(int a, int b, int sweep, const PairRule& rule, const FreeSpaceOptions& options) {
  const bool own = scene_.body(a).owner == scene_.body(b).owner;
  Pair pair{.bodies = collision::BodyPair(scene_, a, b),
            .reach = JointVector::Zero(static_cast<Eigen::Index>(joints_.size())),
            .keep = options.margin + (own ? std::min(kOwnClearance, options.clearance) : options.clearance),
            .floor = options.margin,
            .holds = rule.kind == PairRule::Kind::kTouch,
            .parts = rule.may_part,
            .sweep = sweep};
  if (pair.holds) pair.floor = -rule.overlap;
  if (sweep < 0 && scene_.least_distance(a, b) > pair.keep) return;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    // What moves both moves them as one.
    const double of_a = lever_of(a, j), of_b = lever_of(b, j);
    if ((of_a < 0.0) != (of_b < 0.0)) pair.reach[static_cast<Eigen::Index>(j)] = std::max(of_a, of_b);
  }
  if (pair.reach.maxCoeff() > 0.0) pairs_.push_back(std::move(pair));
}

int FreeSpace::parent_of(int body) const {
  const Body& one = scene_.body(body);
  return one.root ? state_.fixings[static_cast<std::size_t>(body)].parent : one.parent;
}

double FreeSpace::longest_slide(const Body& body) const {
  if (!body.prismatic || body.joint < 0) return 0.0;
  const auto own = std::ranges::find(joints_, body.joint);
  if (own == joints_.end()) return std::abs(state_.q[static_cast<std::size_t>(body.joint)]);
  const auto j = static_cast<Eigen::Index>(own - joints_.begin());
  return std::max(std::abs(lower_[j]), std::abs(upper_[j]));
}

double FreeSpace::lever_of(int body, std::size_t joint) const {
  const Body& outer = scene_.body(body);
  double length = outer.radius + outer.box.center().norm();
  for (int at = body; at >= 0; at = parent_of(at)) {
    const Body& one = scene_.body(at);
    if (one.joint == joints_[joint]) return one.prismatic ? 1.0 : length;
    const Eigen::Isometry3d& X = one.root ? state_.fixings[static_cast<std::size_t>(at)].X_P : one.X_PJ;
    length += X.translation().norm() + longest_slide(one);
  }
  return -1.0;
}

// -- One posture
// --------------------------------------------------------------------------------------------------------

bool FreeSpace::in_range(const JointVector& q) {
  if ((q.array() >= lower_.array()).all() && (q.array() <= upper_.array()).all()) return true;
  last_ = {};
  return false;
}

void FreeSpace::put(const JointVector& q) {
  ++looks_;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    state_.q[static_cast<std::size_t>(joints_[j])] = q[static_cast<Eigen::Index>(j)];
  scene_.place_some(state_, order_, poses_);
  for (const int body : order_) {
    const auto i = static_cast<std::size_t>(body);
    centres_[i] = poses_[i] * scene_.body(body).box.center();
  }
}

double FreeSpace::demanded(const Pair& pair, const JointVector& q) const {
  double least = pair.keep;
  for (const Exception& one : pair.exceptions) {
    const double moved = one.slope == 0.0 ? 0.0 : pair.reach.dot((q - one.q).cwiseAbs());
    least = std::min(least, one.least + one.slope * moved);
  }
  return relaxed_ && least > pair.floor ? 0.5 * (least + pair.floor) : least;
}

void FreeSpace::put_swept(const Pair& pair, std::size_t pose) {
  const collision::SweptPose& swept = sweeps_[static_cast<std::size_t>(pair.sweep)].pose(pose);
  const auto b = static_cast<std::size_t>(pair.bodies.b());
  poses_[b] = swept.X_WB;
  centres_[b] = swept.X_WB * scene_.bodies()[b].box.center();
}

double FreeSpace::room(Pair& pair, const JointVector& q, double enough) {
  const double least = demanded(pair, q);
  if (pair.sweep < 0) return room_here(pair, least, enough);
  // Near a start within what is swept less than nothing is demanded, and how deep they would overlap does not count.
  if (-least >= enough) return -least;
  const auto a = static_cast<std::size_t>(pair.bodies.a());
  const double some = std::max(least, 0.0), more = least + enough - some;
  const auto apart_from = [&](std::size_t pose, double within) {
    ++swept_looks_;
    put_swept(pair, pose);
    return room_here(pair, some + within, more) + some;
  };
  const SweepTree& sweep = sweeps_[static_cast<std::size_t>(pair.sweep)];
  const SweepTree::Limits limits{.enough = some + more, .worth = some + kWorth * more, .least = some};
  return std::max(sweep.least(centres_[a], scene_.bodies()[a].radius, limits, apart_from, pair.nearest), 0.0) - least;
}

double FreeSpace::room_here(Pair& pair, double least, double enough) {
  const int a = pair.bodies.a(), b = pair.bodies.b();
  const double balls = (centres_[static_cast<std::size_t>(a)] - centres_[static_cast<std::size_t>(b)]).norm() -
                       scene_.body(a).radius - scene_.body(b).radius;
  if (balls > least + enough) return balls - least;
  const double wanted = std::max(least + enough, 0.0), near = least + std::min(enough, kNear);
  double apart = pair.bodies.bound(poses_, wanted);
  if (apart >= std::max(near, least + kWorth * enough)) return apart - least;
  apart = pair.bodies.distance(poses_, wanted, collision::Effort::kBound);
  if (apart < near) apart = pair.bodies.distance(poses_, wanted);
  if (apart <= 0.0 && least < 0.0) apart = pair.bodies.signed_distance(poses_);
  return apart - least;
}

double FreeSpace::distance_here(Pair& pair, double enough) {
  const double apart = pair.bodies.distance(poses_, enough);
  return apart > 0.0 ? apart : pair.bodies.signed_distance(poses_);
}

double FreeSpace::distance(Pair& pair) {
  if (pair.sweep < 0) return distance_here(pair, pair.keep);
  const auto a = static_cast<std::size_t>(pair.bodies.a());
  const auto apart_from = [&](std::size_t pose, double within) {
    put_swept(pair, pose);
    return distance_here(pair, pair.keep + within) - within;
  };
  const SweepTree& sweep = sweeps_[static_cast<std::size_t>(pair.sweep)];
  const SweepTree::Limits limits{.enough = pair.keep, .worth = pair.keep};
  return sweep.least(centres_[a], scene_.bodies()[a].radius, limits, apart_from, pair.nearest);
}

Obstruction FreeSpace::obstruction(const Pair& pair, double distance) const {
  Obstruction found{.a = pair.bodies.a(), .b = pair.bodies.b(), .distance = distance};
  if (pair.sweep < 0) return found;
  const collision::SweptPose& pose = sweeps_[static_cast<std::size_t>(pair.sweep)].pose(pair.nearest);
  found.source = pose.source;
  found.from = found.to = pose.time;
  return found;
}

void FreeSpace::add_exception(Pair& pair, Exception exception) {
  pair.steepest = std::max(pair.steepest, exception.slope);
  pair.exceptions.push_back(std::move(exception));
}

bool FreeSpace::note_blocked(Pair& pair, double room, const JointVector& q) {
  ++pair.blocked;
  last_ = obstruction(pair, room + demanded(pair, q));
  pair.from = std::fmin(pair.from, last_.from);
  pair.to = std::fmax(pair.to, last_.to);
  return false;
}

bool FreeSpace::is_free(const JointVector& q) {
  if (!in_range(q)) return false;
  put(q);
  for (Pair& pair : pairs_)
    if (const double left = room(pair, q, 0.0); left < 0.0) return note_blocked(pair, left, q);
  return true;
}

std::optional<Obstruction> FreeSpace::admit_start(const JointVector& q) {
  put(q);
  for (Pair& pair : pairs_) {
    const double apart = distance(pair);
    if (apart >= pair.keep) continue;
    const double above = apart - pair.floor;
    if (above > kSlack) {
      add_exception(pair, {apart - std::min(kSlack, above / 3.0), pair.holds ? kParting : 0.0, q});
    } else if (pair.sweep >= 0) {
      add_exception(pair, {apart - kSlack - 0.1 * std::abs(apart), kLeaving, q});
    } else if (pair.parts || apart >= -kStartOverlap) {
      // How deep solids overlap is known from above only.
      add_exception(pair, {apart - kSlack - 0.1 * std::abs(apart), kParting, q});
    } else {
      return obstruction(pair, apart);
    }
  }
  return std::nullopt;
}

std::optional<Obstruction> FreeSpace::admit_goal(const JointVector& q) {
  put(q);
  std::vector<std::pair<Pair*, Exception>> exceptions;
  for (Pair& pair : pairs_) {
    const double apart = distance(pair);
    if (apart >= pair.keep) continue;
    const double above = apart - pair.floor;
    if (above < 3e-6) return obstruction(pair, apart);
    exceptions.emplace_back(&pair, Exception{apart - std::min(kSlack, above / 3.0), pair.holds ? kParting : 0.0, q});
  }
  for (auto& [pair, exception] : exceptions) add_exception(*pair, std::move(exception));
  return std::nullopt;
}

// -- A stretch
// ----------------------------------------------------------------------------------------------------------

double FreeSpace::way_of(const Pair& pair, const Stretch& stretch) const {
  return (1.0 + pair.steepest) * pair.reach.dot(stretch.fastest);
}

std::optional<std::vector<FreeSpace::Open>> FreeSpace::open_at_ends(const Stretch& stretch) {
  std::vector<Open> open;
  JointVector q = lower_;
  stretch.at(0.0, q);
  if (!in_range(q)) return std::nullopt;
  put(q);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const double way = way_of(pairs_[i], stretch), left = room(pairs_[i], q, way);
    if (left < 0.0 && !note_blocked(pairs_[i], left, q)) return std::nullopt;
    if (left <= way) open.push_back({i, left, 0.0});
  }
  stretch.at(1.0, q);
  if (!in_range(q)) return std::nullopt;
  if (open.empty()) return open;
  put(q);
  for (Open& one : open) {
    Pair& pair = pairs_[one.pair];
    one.room_end = room(pair, q, way_of(pair, stretch));
    if (one.room_end < 0.0 && !note_blocked(pair, one.room_end, q)) return std::nullopt;
  }
  std::erase_if(open, [&](const Open& one) {
    return one.room_begin + one.room_end + 2.0 * kSlack > way_of(pairs_[one.pair], stretch);
  });
  return open;
}

bool FreeSpace::halve(const Stretch& stretch, const Gap& gap, Gap& left, Gap& right) {
  const double middle = 0.5 * (gap.begin + gap.end), half = middle - gap.begin;
  JointVector q = lower_;
  stretch.at(middle, q);
  put(q);
  left = {gap.begin, middle, {}};
  right = {middle, gap.end, {}};
  for (const Open& one : gap.open) {
    Pair& pair = pairs_[one.pair];
    const double way = half * way_of(pair, stretch), between = room(pair, q, way);
    if (between < 0.0 || half < kFinest) return note_blocked(pair, between, q);
    if (one.room_begin + between + 2.0 * kSlack <= way) left.open.push_back({one.pair, one.room_begin, between});
    if (between + one.room_end + 2.0 * kSlack <= way) right.open.push_back({one.pair, between, one.room_end});
  }
  return true;
}

bool FreeSpace::is_free(const Stretch& stretch) {
  auto open = open_at_ends(stretch);
  if (!open) return false;
  // Long gaps first: what is in the way is found soon.
  std::deque<Gap> gaps;
  if (!open->empty()) gaps.push_back({0.0, 1.0, std::move(*open)});
  while (!gaps.empty()) {
    Gap left, right;
    if (!halve(stretch, gaps.front(), left, right)) return false;
    gaps.pop_front();
    for (Gap* one : {&left, &right})
      if (!one->open.empty()) gaps.push_back(std::move(*one));
  }
  return true;
}

Obstruction FreeSpace::most_frequent_obstruction() const {
  const auto most = std::ranges::max_element(pairs_, {}, &Pair::blocked);
  if (most == pairs_.end() || most->blocked == 0) return {};
  Obstruction found = obstruction(*most, 0.0);
  found.from = most->from;
  found.to = most->to;
  return found;
}

}  // namespace takt::planning
