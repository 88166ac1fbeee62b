#include "core/collision/body_pair.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/collision/narrow_phase.h"

namespace takt::collision {
namespace {

/// From below: two solids by the balls and boxes around them.
double bound_of(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB) {
  const Eigen::Vector3d b_in_a = X_AB * b.centre();
  return std::max((b_in_a - a.centre()).norm() - a.radius(), a.box().exteriorDistance(b_in_a)) - b.radius();
}

/// The same for two bodies.
double bound_of(const Body& a, const Body& b, const Eigen::Isometry3d& X_AB) {
  const Eigen::Vector3d middle_a = a.box.center(), middle_b = b.box.center();
  const Eigen::Vector3d b_in_a = X_AB * middle_b;
  const double balls = (b_in_a - middle_a).norm() - a.radius - b.radius;
  const double box_a = a.box.exteriorDistance(b_in_a) - b.radius;
  const Eigen::Vector3d a_in_b = X_AB.linear().transpose() * (middle_a - X_AB.translation());
  const double box_b = b.box.exteriorDistance(a_in_b) - a.radius;
  return std::max({balls, box_a, box_b});
}

}  // namespace

double quick_bound(const Scene& scene, const Poses& poses, int a, int b) {
  return bound_of(scene.body(a), scene.body(b),
                  poses[static_cast<std::size_t>(a)].inverse() * poses[static_cast<std::size_t>(b)]);
}

BodyPair::BodyPair(const Scene& scene, int a, int b) : body_a_(&scene.body(a)), body_b_(&scene.body(b)), a_(a), b_(b) {
  axes_.assign(body_a_->parts.size() * body_b_->parts.size(), Eigen::Vector3d::UnitX());
}

Eigen::Isometry3d BodyPair::between(const Poses& poses) const {
  return poses[static_cast<std::size_t>(a_)].inverse() * poses[static_cast<std::size_t>(b_)];
}

double BodyPair::distance(const Poses& poses, double enough, Effort effort) {
  const Eigen::Isometry3d X_AB = between(poses);
  if (const double quick = bound_of(*body_a_, *body_b_, X_AB); quick > enough) return quick;
  double best = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  for (const Part& part_a : body_a_->parts) {
    const Eigen::Isometry3d X_SB = part_a.X_BS.inverse() * X_AB;
    for (const Part& part_b : body_b_->parts) {
      Eigen::Vector3d& axis = axes_[at++];
      const Eigen::Isometry3d X_ST = X_SB * part_b.X_BS;
      const double quick = bound_of(part_a.solid, part_b.solid, X_ST);
      if (quick >= best) continue;
      if (quick > enough) {
        best = quick;
        continue;
      }
      const Separation parted = separation(part_a.solid, part_b.solid, X_ST, axis, std::min(best, enough), effort);
      axis = parted.axis_A;
      best = std::min(best, parted.distance);
      if (best <= 0.0) return 0.0;
    }
  }
  return best;
}

double BodyPair::bound(const Poses& poses, double enough) const {
  const Eigen::Isometry3d X_AB = between(poses);
  const double whole = bound_of(*body_a_, *body_b_, X_AB);
  if (whole > enough) return whole;
  double least = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  for (const Part& part_a : body_a_->parts) {
    const Eigen::Isometry3d X_SB = part_a.X_BS.inverse() * X_AB;
    for (const Part& part_b : body_b_->parts) {
      const Eigen::Vector3d& axis = axes_[at++];
      const Eigen::Isometry3d X_ST = X_SB * part_b.X_BS;
      double apart = bound_of(part_a.solid, part_b.solid, X_ST);
      if (apart <= enough) apart = std::max(apart, gap_along(part_a.solid, part_b.solid, X_ST, axis));
      least = std::min(least, apart);
    }
  }
  return std::max(whole, least);
}

NearestPair::NearestPair(const Scene& scene, std::vector<BodyPair> pairs) : pairs_(std::move(pairs)) {
  std::map<int, std::size_t> places;
  const auto place_of = [&](int body) {
    const auto [found, fresh] = places.emplace(body, balls_.size());
    if (fresh) balls_.push_back({body, scene.body(body).box.center(), {}});
    return found->second;
  };
  for (const BodyPair& pair : pairs_)
    coarse_.push_back(
        {place_of(pair.a()), place_of(pair.b()), scene.body(pair.a()).radius + scene.body(pair.b()).radius});
}

double NearestPair::distance(const Poses& poses) {
  double best = std::numeric_limits<double>::infinity();
  if (!pairs_.empty()) best = pairs_[nearest_].distance(poses, best, Effort::kCyclic);
  for (Ball& ball : balls_) ball.at = poses[static_cast<std::size_t>(ball.body)] * ball.middle;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    // Balls first: one norm.
    const double least = best + coarse_[i].radii;
    if ((balls_[coarse_[i].a].at - balls_[coarse_[i].b].at).squaredNorm() > least * least) continue;
    const double apart = pairs_[i].distance(poses, best, Effort::kCyclic);
    if (apart >= best) continue;
    best = apart;
    nearest_ = i;
  }
  return best;
}

double BodyPair::signed_distance(const Poses& poses) {
  const double apart = distance(poses, std::numeric_limits<double>::infinity());
  if (apart > 0.0) return apart;
  const Eigen::Isometry3d X_AB = between(poses);
  double deepest = 0.0;
  std::size_t at = 0;
  for (const Part& part_a : body_a_->parts) {
    for (const Part& part_b : body_b_->parts) {
      const Eigen::Vector3d& axis = axes_[at++];
      const Eigen::Isometry3d X_ST = part_a.X_BS.inverse() * X_AB * part_b.X_BS;
      if (bound_of(part_a.solid, part_b.solid, X_ST) >= 0.0) continue;
      // Of two that are apart the depth is no more than a bound: pieces around a bore are near to what stands in it.
      if (separation(part_a.solid, part_b.solid, X_ST, axis, 0.0).distance > 0.0) continue;
      deepest = std::max(deepest, depth(part_a.solid, part_b.solid, X_ST));
    }
  }
  return -deepest;
}

}  // namespace takt::collision
