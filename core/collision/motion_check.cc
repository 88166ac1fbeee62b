#include "core/collision/motion_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "core/collision/body_pair.h"

namespace takt::collision {
namespace {

constexpr double kSampleStep = 4e-3;  // s: fine enough that few pairs need more
constexpr int kMostSamples = 4000;
constexpr int kFinest = 16;  ///< halvings of a sample step

/// The rules as one number: bodies have to keep `signed distance - least` above `margin`.
struct Keep {
  double least = 0.0;   ///< m
  double margin = 0.0;  ///< m, > 0
};

/// The motion at equally spaced times: poses of the bodies that move, and how far their points travel.
class Samples {
 public:
  Samples(const Scene& scene, const State& state, const Trajectory& motion)
      : scene_(scene), motion_(motion), state_(state), moved_(scene.moved_by(state, motion.joints)) {
    scene.place(state, poses_);
    const double steps = std::ceil(motion.duration / kSampleStep);
    count_ = std::clamp(static_cast<int>(steps), 1, kMostSamples);
    for (const int body : scene.parents_first(state)) {
      if (!moved_[static_cast<std::size_t>(body)]) continue;
      row_of_.resize(scene.bodies().size(), -1);
      row_of_[static_cast<std::size_t>(body)] = static_cast<int>(order_.size());
      order_.push_back(body);
    }
    row_of_.resize(scene.bodies().size(), -1);
    q_.assign(static_cast<std::size_t>(count_ + 1), state.q);
    for (int k = 0; k <= count_; ++k) motion.at(time(k), joints(k));
    find_curvature();
    sample();
  }

  [[nodiscard]] int count() const { return count_; }  ///< of steps; there is one sample more
  [[nodiscard]] double step() const { return motion_.duration / count_; }
  [[nodiscard]] double time(int k) const { return k == count_ ? motion_.duration : k * step(); }
  [[nodiscard]] bool moves(int body) const { return row_of_[static_cast<std::size_t>(body)] >= 0; }

  /// Puts a body at a sample into the poses; what does not move is there already.
  void put(int body, int k) {
    const int row = row_of_[static_cast<std::size_t>(body)];
    if (row >= 0) poses_[static_cast<std::size_t>(body)] = sampled_[index(row, k)];
  }
  [[nodiscard]] const Poses& poses() const { return poses_; }
  /// No point of a body travels further than this from sample 0 to sample k: grows with k. m
  [[nodiscard]] double travel(int body, int k) const {
    const int row = row_of_[static_cast<std::size_t>(body)];
    return row < 0 ? 0.0 : travel_[index(row, k)];
  }

  /// Puts all that moves to any time, for looks between samples.
  void put_all(double time, std::vector<double>& q) {
    motion_.at(time, q);
    scene_.place_some({.q = q, .fixings = state_.fixings}, order_, poses_);
  }
  /// The same bound as travel(), for two poses of a body that are `apart` s apart.
  [[nodiscard]] double between(int body, const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                               double apart) const {
    const int row = row_of_[static_cast<std::size_t>(body)];
    if (row < 0) return 0.0;
    const Body& one = scene_.body(body);
    const Eigen::Vector3d middle = one.box.center();
    const double shift = (to * middle - from * middle).norm();
    // By how much a turn moves a point at distance 1: 2 sin(angle / 2), from the nine differences.
    const double turn = (to.linear() - from.linear()).norm() / std::numbers::sqrt2;
    // The chord, and twice by how much the path of any point can leave it: away from one end and from the other.
    return shift + one.radius * turn + bend_[static_cast<std::size_t>(row)] * apart * apart / 4.0;
  }
  [[nodiscard]] std::vector<double> q_at(double time) const {
    std::vector<double> q = state_.q;
    motion_.at(time, q);
    return q;
  }

 private:
  [[nodiscard]] std::size_t index(int row, int k) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(count_ + 1) + static_cast<std::size_t>(k);
  }

  [[nodiscard]] std::vector<double>& joints(int k) { return q_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const std::vector<double>& joints(int k) const { return q_[static_cast<std::size_t>(k)]; }

  /// Largest acceleration of any point of each body: joints that accelerate, and turns of what turns.
  void find_curvature() {
    const std::vector<double> fastest = fastest_joints();
    bend_.assign(order_.size(), 0.0);
    for (std::size_t row = 0; row < order_.size(); ++row) {
      double speed = 0.0, turn = 0.0, push = 0.0;
      for (std::size_t j = 0; j < motion_.joints.size(); ++j) {
        const double lever = lever_of(order_[row], motion_.joints[j]);
        if (lever < 0.0) continue;
        const Body& mover = scene_.body(body_of(motion_.joints[j]));
        const double arm = mover.prismatic ? 1.0 : lever;
        push += arm * motion_.acceleration[j];
        speed += arm * fastest[j];
        if (!mover.prismatic) turn += fastest[j];
      }
      bend_[row] = push + 2.0 * turn * speed;
    }
  }

  /// No joint is faster than the fastest of the chords and what it can gain between two samples.
  [[nodiscard]] std::vector<double> fastest_joints() const {
    std::vector<double> fastest(motion_.joints.size(), 0.0);
    if (motion_.duration <= 0.0) return fastest;
    for (int k = 1; k <= count_; ++k) {
      for (std::size_t j = 0; j < motion_.joints.size(); ++j) {
        const auto joint = static_cast<std::size_t>(motion_.joints[j]);
        fastest[j] = std::max(fastest[j], std::abs(joints(k)[joint] - joints(k - 1)[joint]) / step());
      }
    }
    for (std::size_t j = 0; j < fastest.size(); ++j) fastest[j] += motion_.acceleration[j] * step();
    return fastest;
  }

  [[nodiscard]] int body_of(int joint) const {
    const auto& bodies = scene_.bodies();
    return static_cast<int>(std::ranges::find(bodies, joint, &Body::joint) - bodies.begin());
  }
  [[nodiscard]] int parent_of(int body) const {
    return scene_.body(body).root ? state_.fixings[static_cast<std::size_t>(body)].parent : scene_.body(body).parent;
  }
  /// How far a point of a body can be from the axis of a joint below it, in any posture; negative: that joint does not
  /// move it.
  [[nodiscard]] double lever_of(int body, int joint) const {
    const Body& outer = scene_.body(body);
    double length = outer.radius + outer.box.center().norm();
    for (int at = body; at >= 0; at = parent_of(at)) {
      const Body& one = scene_.body(at);
      if (one.joint == joint) return length;
      const Eigen::Isometry3d& X = one.root ? state_.fixings[static_cast<std::size_t>(at)].X_P : one.X_PJ;
      length += X.translation().norm();
      if (one.prismatic && one.joint >= 0) length += range_of(one.joint);
    }
    return -1.0;
  }
  /// How far a sliding joint is out at most.
  [[nodiscard]] double range_of(int joint) const {
    const auto number = static_cast<std::size_t>(joint);
    double most = std::abs(state_.q[number]);
    if (std::ranges::find(motion_.joints, joint) == motion_.joints.end()) return most;
    for (const std::vector<double>& q : q_) most = std::max(most, std::abs(q[number]));
    return most;
  }

  void sample() {
    sampled_.resize(order_.size() * static_cast<std::size_t>(count_ + 1));
    travel_.assign(sampled_.size(), 0.0);
    State state = state_;
    for (int k = 0; k <= count_; ++k) {
      state.q = joints(k);
      scene_.place_some(state, order_, poses_);
      for (std::size_t row = 0; row < order_.size(); ++row) {
        const std::size_t now = index(static_cast<int>(row), k);
        sampled_[now] = poses_[static_cast<std::size_t>(order_[row])];
        if (k == 0) continue;
        travel_[now] = travel_[now - 1] + between(order_[row], sampled_[now - 1], sampled_[now], step());
      }
    }
  }

  const Scene& scene_;
  const Trajectory& motion_;
  State state_;
  std::vector<bool> moved_;
  std::vector<int> order_;   ///< bodies that move, parents first
  std::vector<int> row_of_;  ///< by body: where it is in order_; -1: it does not move
  int count_ = 1;
  std::vector<std::vector<double>> q_;  ///< of all joints, by sample
  Poses poses_;
  std::vector<Eigen::Isometry3d> sampled_;
  std::vector<double> travel_;
  std::vector<double> bend_;  ///< by row: largest acceleration of a point, m/s^2
};

/// One pair along the motion.
class PairWalk {
 public:
  PairWalk(Samples& samples, const Scene& scene, int a, int b) : samples_(samples), pair_(scene, a, b) {}

  /// @return the hit, or nothing
  [[nodiscard]] std::optional<Hit> walk(const PairRule& rule, double margin) {
    int k = 0;
    keep_ = {0.0, margin};
    if (rule.kind == PairRule::Kind::kTouch) keep_ = {-rule.overlap - kResolution, kResolution};
    const bool in_contact = rule.may_part && room_at(0) <= keep_.margin;
    if (rule.kind == PairRule::Kind::kLeave || in_contact) {
      // Until they have parted they may do what they like: where a guarded motion is taken to its end a tool is deep
      // in, or behind, what it would have stopped at. If they do not part, it must not have gone deeper; how deep
      // solids overlap is known from above only.
      const double begin = std::min(signed_at(0), 0.0);
      for (; k <= samples_.count() && signed_at(k) <= margin; ++k) continue;
      if (k > samples_.count())
        return signed_at(k - 1) < 1.5 * begin - margin ? std::optional(hit_at(k - 1)) : std::nullopt;
    }
    while (k <= samples_.count()) {
      const double room = room_at(k);
      if (room <= keep_.margin) return hit_at(k);
      if (k == samples_.count()) return std::nullopt;
      const int next = furthest_within(k, room);
      if (next > k) {
        k = next;
        continue;
      }
      if (const auto hit = within_step(k, room)) return hit;
      ++k;
    }
    return std::nullopt;
  }

 private:
  static constexpr double kResolution = 2e-4;  // m: how near to its limit an overlap may come
  static constexpr int kLook = 4;              // samples: a bound that carries so far need not be sharper

  [[nodiscard]] double travel(int from, int to) const {
    return samples_.travel(pair_.a(), to) - samples_.travel(pair_.a(), from) + samples_.travel(pair_.b(), to) -
           samples_.travel(pair_.b(), from);
  }
  /// The last sample that they cannot reach each other before.
  [[nodiscard]] int furthest_within(int k, double room) const {
    int low = k, high = samples_.count();
    if (travel(k, high) < room) return high;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      (travel(k, middle) < room ? low : high) = middle;
    }
    return low;
  }
  void put(int k) {
    samples_.put(pair_.a(), k);
    samples_.put(pair_.b(), k);
  }
  [[nodiscard]] double signed_at(int k) {
    put(k);
    return pair_.signed_distance(samples_.poses());
  }
  /// By how much they are further apart than they have to be, from below.
  [[nodiscard]] double room_at(int k) {
    put(k);
    return room_here(travel(k, std::min(k + kLook, samples_.count())));
  }
  /// @param enough  m: more than this need not be exact
  [[nodiscard]] double room_here(double enough) {
    const double apart = pair_.distance(samples_.poses(), std::max(enough, keep_.margin) + keep_.least);
    if (apart > 0.0 || keep_.least >= 0.0) return apart - keep_.least;
    return pair_.signed_distance(samples_.poses()) - keep_.least;
  }

  struct Place {
    double time = 0.0, room = 0.0;
    Eigen::Isometry3d X_A, X_B;
  };
  [[nodiscard]] Place here(double time, double room) const {
    return {time, room, samples_.poses()[static_cast<std::size_t>(pair_.a())],
            samples_.poses()[static_cast<std::size_t>(pair_.b())]};
  }
  /// Between sample k and the next one, which they could reach each other before.
  [[nodiscard]] std::optional<Hit> within_step(int k, double room) {
    put(k);
    const Place begin = here(samples_.time(k), room);
    const double room_after = room_at(k + 1);
    if (room_after <= keep_.margin) return hit_at(k + 1);
    const Place end = here(samples_.time(k + 1), room_after);
    if (q_.empty()) q_ = samples_.q_at(0.0);
    return halve(begin, end, 0);
  }
  [[nodiscard]] std::optional<Hit> halve(const Place& begin, const Place& end, int level) {
    const double apart = end.time - begin.time;
    const double way =
        samples_.between(pair_.a(), begin.X_A, end.X_A, apart) + samples_.between(pair_.b(), begin.X_B, end.X_B, apart);
    // Wherever on its way a point is: it is near one of the ends.
    if (way < begin.room + end.room || level == kFinest) return std::nullopt;
    const double middle = 0.5 * (begin.time + end.time);
    samples_.put_all(middle, q_);
    const Place between = here(middle, room_here(way));
    if (between.room <= keep_.margin) return hit(middle, between.room + keep_.least);
    if (auto first = halve(begin, between, level + 1)) return first;
    return halve(between, end, level + 1);
  }

  [[nodiscard]] Hit hit(double time, double distance) const {
    return {.a = pair_.a(), .b = pair_.b(), .time = time, .distance = distance, .q = samples_.q_at(time)};
  }
  /// How deep it gets until they part again.
  [[nodiscard]] Hit hit_at(int k) {
    Hit found = hit(samples_.time(k), signed_at(k));
    for (int after = k + 1; after <= samples_.count(); ++after) {
      const double now = signed_at(after);
      found.distance = std::min(found.distance, now);
      if (now - keep_.least > 2.0 * keep_.margin) break;
    }
    return found;
  }

  Samples& samples_;
  BodyPair pair_;
  Keep keep_;
  std::vector<double> q_;
};

PairRule rule_of(const CheckOptions& options, int a, int b) { return options.rule ? options.rule(a, b) : PairRule{}; }

/// By body: the last of the moved joints on the way to it; bodies of one joint move as one. -1: none moves it.
std::vector<int> movers_of(const Scene& scene, const State& state, const Trajectory& motion) {
  std::vector<int> movers(scene.bodies().size(), -1);
  for (const int number : scene.parents_first(state)) {
    const Body& body = scene.body(number);
    const int parent = body.root ? state.fixings[static_cast<std::size_t>(number)].parent : body.parent;
    const bool own = body.joint >= 0 && std::ranges::find(motion.joints, body.joint) != motion.joints.end();
    movers[static_cast<std::size_t>(number)] = own          ? body.joint
                                               : parent < 0 ? -1
                                                            : movers[static_cast<std::size_t>(parent)];
  }
  return movers;
}

bool asked_for(const CheckOptions& options, int a, int b) {
  if (options.bodies.empty()) return true;
  return options.bodies[static_cast<std::size_t>(a)] || options.bodies[static_cast<std::size_t>(b)];
}

}  // namespace

std::vector<Hit> check_motion(const Scene& scene, const State& state, const Trajectory& motion,
                              const CheckOptions& options) {
  Samples samples(scene, state, motion);
  const std::vector<int> movers = movers_of(scene, state, motion);
  const auto mover = [&movers](int body) { return movers[static_cast<std::size_t>(body)]; };
  std::vector<Hit> hits;
  const int n = static_cast<int>(scene.bodies().size());
  for (int a = 0; a < n; ++a) {
    if (!samples.moves(a) || scene.body(a).parts.empty()) continue;
    for (int b = 0; b < n; ++b) {
      if (b == a || mover(a) == mover(b) || (samples.moves(b) && b < a) || scene.never_meet(a, b)) continue;
      if (scene.body(b).parts.empty() || !asked_for(options, a, b)) continue;
      // Most pairs are further apart than the whole motion is long.
      samples.put(a, 0);
      samples.put(b, 0);
      const int last = samples.count();
      const double reach = samples.travel(a, last) + samples.travel(b, last);
      if (quick_bound(scene, samples.poses(), a, b) > reach + options.margin) continue;
      const PairRule rule = rule_of(options, a, b);
      if (rule.kind == PairRule::Kind::kIgnored) continue;
      PairWalk pair(samples, scene, a, b);
      if (auto hit = pair.walk(rule, options.margin)) hits.push_back(std::move(*hit));
    }
  }
  std::ranges::stable_sort(hits, {}, &Hit::time);
  return hits;
}

std::vector<Hit> check_state(const Scene& scene, const State& state, const std::vector<bool>& moved,
                             const CheckOptions& options) {
  Poses poses;
  scene.place(state, poses);
  std::vector<Hit> hits;
  const int n = static_cast<int>(scene.bodies().size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      const bool either = moved[static_cast<std::size_t>(a)] || moved[static_cast<std::size_t>(b)];
      if (!either || scene.never_meet(a, b) || !asked_for(options, a, b)) continue;
      if (scene.body(a).parts.empty() || scene.body(b).parts.empty()) continue;
      if (quick_bound(scene, poses, a, b) > options.margin) continue;
      BodyPair pair(scene, a, b);
      const PairRule rule = rule_of(options, a, b);
      if (rule.kind == PairRule::Kind::kIgnored || rule.kind == PairRule::Kind::kLeave) continue;
      const double apart = pair.signed_distance(poses);
      const double least = rule.kind == PairRule::Kind::kTouch ? -rule.overlap : options.margin;
      if (apart < least) hits.push_back({.a = a, .b = b, .time = 0.0, .distance = apart, .q = state.q});
    }
  }
  return hits;
}

}  // namespace takt::collision
