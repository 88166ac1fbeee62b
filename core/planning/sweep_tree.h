#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/collision/swept_space.h"

namespace takt::planning {

/// The poses that a body sweeps, as a tree: of each part of them one pose stands for all, with how far the others are
/// from it. So what is far away is known after one look, and only what is near is looked at pose by pose.
/// Thread: any. Realtime: setup.
class SweepTree {
 public:
  /// @param poses  one at least   @param centre, radius  of the ball that holds the body, in its frame, m
  SweepTree(std::vector<collision::SweptPose> poses, const Eigen::Vector3d& centre, double radius);

  [[nodiscard]] const collision::SweptPose& pose(std::size_t i) const { return poses_[i]; }

  /// What a look is worth, m.
  struct Limits {
    double enough = 0.0;  ///< more is not needed: balls will do
    double worth = 0.0;   ///< more of several poses at once is not worth a look at each
    double least = -std::numeric_limits<double>::infinity();  ///< less is not needed either: the search ends
  };
  /// The least distance of another body from all poses, from below, m. What is above `least` may be up to a half more.
  /// @param p, radius  the ball that holds that body, in the world, m
  /// @param distance   (pose, within) -> m: the distance from a pose, less `within`
  /// @param[out] nearest  the pose of the least distance; untouched where no pose was looked at
  template <class Distance>
  [[nodiscard]] double least(const Eigen::Vector3d& p, double radius, const Limits& limits, Distance&& distance,
                             std::size_t& nearest) const {
    // What is proven of the poses that were looked at, and of the nearest of them alone.
    double best = std::numeric_limits<double>::infinity(), single = best;
    std::vector<Range> open{{0, 0, poses_.size()}};
    while (!open.empty() && best >= limits.least) {
      const Range range = open.back();
      open.pop_back();
      const Node& node = nodes_[range.node];
      const double bound = (node.centre - p).norm() - node.radius - radius;
      if (bound >= best) continue;
      if (bound > limits.enough) {
        best = bound;
        continue;
      }
      const bool alone = range.end - range.begin == 1;
      const double apart = distance(middle(range), node.within);
      if (alone && apart < single) single = apart, nearest = middle(range);
      // Many poses are about as far away, as of a link that turns about itself: they are not worth a look at each.
      if (alone || apart >= limits.worth || apart - limits.least > kShare * (single - limits.least)) {
        best = std::min(best, apart);
        continue;
      }
      // The nearer half is looked at first: it may spare the other.
      auto [first, second] = halves(range);
      const auto away = [&](const Range& half) { return (nodes_[half.node].centre - p).squaredNorm(); };
      if (away(first) < away(second)) std::swap(first, second);
      open.push_back(first);
      open.push_back(second);
    }
    return best;
  }

 private:
  static constexpr double kShare = 0.5;

  struct Node {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the ball that holds the body at all poses
    double radius = 0.0;
    double within = 0.0;  ///< m: no point of the body is further from where the pose in the middle has it
  };
  /// Poses [begin, end) under a node. Its first half lies behind it, then the second.
  struct Range {
    std::size_t node, begin, end;
  };
  [[nodiscard]] static std::size_t middle(const Range& range) { return (range.begin + range.end) / 2; }
  [[nodiscard]] static std::pair<Range, Range> halves(const Range& range) {
    const std::size_t at = middle(range);
    return {{range.node + 1, range.begin, at}, {range.node + 2 * (at - range.begin), at, range.end}};
  }
  void build(const Range& range, const Eigen::Vector3d& centre, double radius);
  void hold(const Node& first, const Node& second, Node& both) const;

  std::vector<collision::SweptPose> poses_;
  std::vector<Node> nodes_;
};

}  // namespace takt::planning
