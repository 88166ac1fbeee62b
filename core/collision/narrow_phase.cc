// This file and native_shape.cc are the only ones that know FCL.
#include "core/collision/narrow_phase.h"

#include <algorithm>
#include <exception>
#include <limits>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

namespace takt::collision {

namespace {

/// What a solver says: the axis from A to B, and the distance that it believes in.
struct Proposal {
  Eigen::Vector3d axis_A = Eigen::Vector3d::Zero();
  double distance = 0.0;  ///< m; 0: they overlap, or it failed
};

Proposal propose(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB, fcl::GJKSolverType solver) {
  constexpr double kTolerance = 1e-9;  // m, of the distance; at the library's default of 1e-6 some are off by 0.1 m
  const fcl::DistanceRequestd request(/*enable_nearest_points=*/true, /*enable_signed_distance=*/false, 0.0, 0.0,
                                      kTolerance, solver);
  fcl::DistanceResultd result;
  try {
    fcl::distance(&a.native(), Eigen::Isometry3d::Identity(), &b.native(), X_AB, request, result);
  } catch (const std::exception&) {
    return {};
  }
  const Eigen::Vector3d between = result.nearest_points[1] - result.nearest_points[0];
  const double length = between.norm();
  if (!(result.min_distance > 0.0) || !(length > 1e-9)) return {};
  return {.axis_A = between / length, .distance = result.min_distance};
}

}  // namespace

double gap_along(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB, const Eigen::Vector3d& axis_A) {
  const Eigen::Vector3d axis_B = X_AB.linear().transpose() * axis_A;
  const double end_of_a = axis_A.dot(a.support(axis_A));
  const double begin_of_b = axis_A.dot(X_AB.translation()) + axis_B.dot(b.support(-axis_B));
  return begin_of_b - end_of_a;
}

namespace {

/// Uphill from an axis, until the gap is `enough` (m): it grows along the difference of the support points.
Separation climbed(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB, Separation best, double enough,
                   int steps) {
  double turn = 0.2;
  for (int i = 0; i < steps && turn > 1e-5 && best.distance <= enough; ++i) {
    const Eigen::Vector3d axis_B = X_AB.linear().transpose() * best.axis_A;
    const Eigen::Vector3d between = X_AB * b.support(-axis_B) - a.support(best.axis_A);
    const Eigen::Vector3d across = between - between.dot(best.axis_A) * best.axis_A;
    const double length = across.norm();
    if (length < 1e-9) break;
    const Eigen::Vector3d axis = (best.axis_A + turn / length * across).normalized();
    const double gap = gap_along(a, b, X_AB, axis);
    if (gap > best.distance) best = {.distance = gap, .axis_A = axis};
    turn *= gap >= best.distance ? 1.2 : 0.5;
  }
  return best;
}

}  // namespace

Separation separation(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB, const Eigen::Vector3d& hint,
                      double enough, Effort effort) {
  Separation best{.distance = gap_along(a, b, X_AB, hint), .axis_A = hint};
  if (best.distance > enough) return best;
  const Eigen::Vector3d between = X_AB * b.centre() - a.centre();
  if (const double length = between.norm(); length > 0.0) {
    const double gap = gap_along(a, b, X_AB, between / length);
    if (gap > best.distance) best = {.distance = gap, .axis_A = between / length};
  }
  constexpr int kFewSteps = 4;  // they cost a fifth of what the library does
  best = climbed(a, b, X_AB, best, enough, kFewSteps);
  if (best.distance > enough || effort == Effort::kBound) {
    best.distance = std::max(best.distance, 0.0);
    return best;
  }
  // The quicker solver is wrong in one case of a thousand; where the shapes do not confirm it the other one is asked,
  // which allocates, or in a cycle the shapes themselves.
  for (const fcl::GJKSolverType solver : {fcl::GST_INDEP, fcl::GST_LIBCCD}) {
    if (effort == Effort::kCyclic && solver != fcl::GST_INDEP) break;
    const Proposal proposal = propose(a, b, X_AB, solver);
    if (proposal.distance <= 0.0) continue;
    const double gap = gap_along(a, b, X_AB, proposal.axis_A);
    if (gap > best.distance) best = {.distance = gap, .axis_A = proposal.axis_A};
    constexpr double kConfirmed = 1e-6;  // m
    if (proposal.distance - gap < kConfirmed) break;
    if (effort == Effort::kCyclic) {
      constexpr int kManySteps = 24;
      best = climbed(a, b, X_AB, best, enough, kManySteps);
      break;
    }
  }
  best.distance = std::max(best.distance, 0.0);
  return best;
}

double depth(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB) {
  // The way out along any axis is an upper bound: that of the library, and the axes of both shapes.
  double least = std::numeric_limits<double>::infinity();
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  const auto try_axis = [&](const Eigen::Vector3d& axis) {
    const double out = -gap_along(a, b, X_AB, axis);
    if (out >= least) return false;
    least = out;
    best = axis;
    return true;
  };
  for (int i = 0; i < 3; ++i) {
    for (const double sign : {1.0, -1.0}) {
      (void)try_axis(sign * Eigen::Vector3d::Unit(i));
      (void)try_axis(sign * X_AB.linear().col(i));
    }
  }
  fcl::CollisionRequestd request(/*num_max_contacts=*/1, /*enable_contact=*/true);
  fcl::CollisionResultd result;
  try {
    fcl::collide(&a.native(), Eigen::Isometry3d::Identity(), &b.native(), X_AB, request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      const Eigen::Vector3d normal = result.getContact(i).normal;
      if (!normal.allFinite() || normal.norm() < 0.5) continue;
      (void)try_axis(normal.normalized());
      (void)try_axis(-normal.normalized());
    }
  } catch (const std::exception&) {
    // What the axes of the shapes gave is still a bound.
  }
  // Downhill from the best one: the way out grows along the difference of the support points.
  constexpr int kSteps = 40;
  double turn = 0.3;
  for (int i = 0; i < kSteps && turn > 1e-4; ++i) {
    const Eigen::Vector3d best_B = X_AB.linear().transpose() * best;
    const Eigen::Vector3d between = a.support(best) - X_AB * b.support(-best_B);
    const Eigen::Vector3d across = between - between.dot(best) * best;
    if (across.norm() < 1e-9) break;
    turn *= try_axis((best - turn * across.normalized()).normalized()) ? 1.2 : 0.5;
  }
  return std::max(least, 0.0);
}

}  // namespace takt::collision
