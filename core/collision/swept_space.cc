#include "core/collision/swept_space.h"

#include <algorithm>

#include "core/collision/motion_samples.h"

namespace takt::collision {
namespace {

/// A body in the samples of a motion, from wherever it is seen.
class SeenBody {
 public:
  SeenBody(const MotionSamples& samples, int body, const Viewpoint* view)
      : samples_(samples), body_(body), view_(view), moves_(samples.moves(body)) {
    if (view == nullptr || !samples.moves(view->body)) return;
    moves_ = true;
    travel_.push_back(0.0);
    for (int k = 0; k < samples.count(); ++k)
      travel_.push_back(travel_.back() + samples.travel_seen_from(view->body, body, k));
  }

  [[nodiscard]] bool moves() const { return moves_; }
  [[nodiscard]] Eigen::Isometry3d pose(int k) const {
    const Eigen::Isometry3d X_WB = samples_.pose(body_, k);
    return view_ == nullptr ? X_WB : view_->X_WB * samples_.pose(view_->body, k).inverse() * X_WB;
  }
  /// No point travels further than this from sample 0 to sample k, m.
  [[nodiscard]] double travel(int k) const {
    return travel_.empty() ? samples_.travel(body_, k) : travel_[static_cast<std::size_t>(k)];
  }
  /// From sample `from` the last one that no point travels further to; the next one at least.
  [[nodiscard]] int last_within(int from, double spacing) const {
    int to = from + 1;
    while (to < samples_.count() && travel(to + 1) - travel(from) <= spacing) ++to;
    return to;
  }

 private:
  const MotionSamples& samples_;
  int body_;
  const Viewpoint* view_;
  bool moves_;
  std::vector<double> travel_ = {};  ///< until each sample, where what it is seen from moves
};

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
               double spacing, double begin, int source, SweptSpace& swept, const Viewpoint* view) {
  const MotionSamples samples(scene, state, motion);
  for (const int body : bodies) {
    const SeenBody seen(samples, body, view);
    std::vector<SweptPose>& poses = swept.bodies[body];
    double before = 0.0;  // what is travelled between the pose before and this one
    for (int k = 0; k <= samples.count();) {
      const bool last = k == samples.count() || !seen.moves();
      const int next = last ? samples.count() + 1 : seen.last_within(k, spacing);
      const double after = last ? 0.0 : seen.travel(next) - seen.travel(k);
      // A point between two poses is within half of the way of one of them.
      const SweptPose pose{.X_WB = seen.pose(k),
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
