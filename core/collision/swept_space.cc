#include "core/collision/swept_space.h"

#include <algorithm>

#include "core/collision/motion_samples.h"

namespace takt::collision {
namespace {

/// From sample `from` the last one that no point of the body travels further to; the next one at least.
int last_within(const MotionSamples& samples, int body, int from, double spacing) {
  int to = from + 1;
  while (to < samples.count() && samples.travel(body, to + 1) - samples.travel(body, from) <= spacing) ++to;
  return to;
}

bool same_pose(const SweptPose& a, const SweptPose& b) {
  return a.X_WB.matrix() == b.X_WB.matrix() && a.within == b.within;
}

}  // namespace

int SweptSpace::source(const std::string& name) {
  const auto found = std::ranges::find(sources, name);
  const auto number = static_cast<int>(found - sources.begin());
  if (found == sources.end()) sources.push_back(name);
  return number;
}

void add_swept(const Scene& scene, const State& state, const Trajectory& motion, std::span<const int> bodies,
               double spacing, double begin, int source, SweptSpace& swept) {
  MotionSamples samples(scene, state, motion);
  for (const int body : bodies) {
    std::vector<SweptPose>& poses = swept.bodies[body];
    double before = 0.0;  // what is travelled between the pose before and this one
    for (int k = 0; k <= samples.count();) {
      const bool last = k == samples.count() || !samples.moves(body);
      const int next = last ? samples.count() + 1 : last_within(samples, body, k, spacing);
      const double after = last ? 0.0 : samples.travel(body, next) - samples.travel(body, k);
      samples.put(body, k);
      // A point between two poses is within half of the way of one of them.
      const SweptPose pose{.X_WB = samples.poses()[static_cast<std::size_t>(body)],
                           .within = 0.5 * std::max(before, after),
                           .time = begin + samples.time(k),
                           .source = source};
      const bool known = !poses.empty() && same_pose(poses.back(), pose);
      if (!known) poses.push_back(pose);
      before = after;
      k = next;
    }
  }
}

bool same_space(const SweptSpace& a, const SweptSpace& b) {
  return std::ranges::equal(a.bodies, b.bodies, [](const auto& one, const auto& other) {
    return one.first == other.first && std::ranges::equal(one.second, other.second, same_pose);
  });
}

}  // namespace takt::collision
