#include "core/planning/sweep_tree.h"

#include <algorithm>
#include <numbers>

namespace takt::planning {
namespace {

/// No point of a body is further from where the other pose has it. @param centre, radius  of the ball that holds it
double apart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& centre, double radius) {
  const double shift = (a * centre - b * centre).norm();
  // By how much a turn moves a point at distance 1: 2 sin(angle / 2), from the nine differences.
  const double turn = (a.linear() - b.linear()).norm() / std::numbers::sqrt2;
  return shift + radius * turn;
}

}  // namespace

SweepTree::SweepTree(std::vector<collision::SweptPose> poses, const Eigen::Vector3d& centre, double radius)
    : poses_(std::move(poses)), nodes_(2 * poses_.size() - 1) {
  build({0, 0, poses_.size()}, centre, radius);
}

void SweepTree::build(const Range& range, const Eigen::Vector3d& centre, double radius) {
  Node& node = nodes_[range.node];
  const collision::SweptPose& representative = poses_[middle(range)];
  for (std::size_t i = range.begin; i < range.end; ++i)
    node.within = std::max(node.within, apart(representative.X_WB, poses_[i].X_WB, centre, radius) + poses_[i].within);
  if (range.end - range.begin == 1) {
    node.centre = representative.X_WB * centre;
    node.radius = radius + representative.within;
    return;
  }
  const auto [first, second] = halves(range);
  build(first, centre, radius);
  build(second, centre, radius);
  hold(nodes_[first.node], nodes_[second.node], node);
}

/// The ball that holds both balls.
void SweepTree::hold(const Node& first, const Node& second, Node& both) const {
  const Eigen::Vector3d way = second.centre - first.centre;
  const double length = way.norm();
  const Node& larger = first.radius > second.radius ? first : second;
  both.centre = larger.centre;
  both.radius = larger.radius;
  if (length + std::min(first.radius, second.radius) <= larger.radius) return;
  both.radius = 0.5 * (length + first.radius + second.radius);
  both.centre = first.centre + (both.radius - first.radius) / length * way;
}

}  // namespace takt::planning
