#include "core/collision/motion_check.h"

#include <algorithm>
#include <optional>

#include "core/collision/body_pair.h"
#include "core/collision/motion_samples.h"

namespace takt::collision {
namespace {

constexpr int kFinest = 16;  ///< halvings of a sample step

/// The rules as one number: bodies have to keep `signed distance - least` above `margin`.
struct Keep {
  double least = 0.0;   ///< m
  double margin = 0.0;  ///< m, > 0
};

/// One pair along the motion.
class PairWalk {
 public:
  PairWalk(MotionSamples& samples, const Scene& scene, int a, int b) : samples_(samples), pair_(scene, a, b) {}

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
    return halve(begin, end, k, 0);
  }
  [[nodiscard]] std::optional<Hit> halve(const Place& begin, const Place& end, int k, int level) {
    const double apart = end.time - begin.time;
    const double way = samples_.between(pair_.a(), k, begin.X_A, end.X_A, apart) +
                       samples_.between(pair_.b(), k, begin.X_B, end.X_B, apart);
    // Wherever on its way a point is: it is near one of the ends.
    if (way < begin.room + end.room || level == kFinest) return std::nullopt;
    const double middle = 0.5 * (begin.time + end.time);
    samples_.put_all(middle, q_);
    const Place between = here(middle, room_here(way));
    if (between.room <= keep_.margin) return hit(middle, between.room + keep_.least);
    if (auto first = halve(begin, between, k, level + 1)) return first;
    return halve(between, end, k, level + 1);
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

  MotionSamples& samples_;
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
  MotionSamples samples(scene, state, motion);
  const std::vector<int> movers = movers_of(scene, state, motion);
  const auto mover = [&movers](int body) { return movers[static_cast<std::size_t>(body)]; };
  std::vector<Hit> hits;
  const int n = static_cast<int>(scene.bodies().size());
  for (int a = 0; a < n; ++a) {
    if (!samples.moves(a) || scene.body(a).parts.empty()) continue;
    for (int b = 0; b < n; ++b) {
      if (b == a || mover(a) == mover(b) || (samples.moves(b) && b < a) || scene.never_meet(a, b)) continue;
      if (scene.body(b).parts.empty() || !asked_for(options, a, b)) continue;
      if (scene.least_distance(a, b) > options.margin) continue;
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
