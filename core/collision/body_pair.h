#pragma once

#include <utility>
#include <vector>

#include "core/collision/narrow_phase.h"
#include "core/collision/scene.h"

namespace takt::collision {

/// No point of body a is nearer to body b than this, m: from balls and boxes around them; may be negative.
/// Realtime: cyclic.
[[nodiscard]] double quick_bound(const Scene& scene, const Poses& poses, int a, int b);

/// Two bodies whose distance is asked again and again: it keeps the axes that parted their solids last.
/// Thread: one at a time. Realtime: the constructor setup; queries any thread.
class BodyPair {
 public:
  /// The scene must outlive it.
  BodyPair(const Scene& scene, int a, int b);

  [[nodiscard]] int a() const { return a_; }
  [[nodiscard]] int b() const { return b_; }

  /// Their distance, m; certified (separation()). 0: they overlap or touch.
  /// @param enough  m: a larger distance need not be exact
  [[nodiscard]] double distance(const Poses& poses, double enough, Effort effort = Effort::kThorough);
  /// A bound of their distance from below, m, by balls, boxes and the axes that parted them last; may be negative. It
  /// costs a tenth of distance(). @param enough  m: a larger one need not be exact
  [[nodiscard]] double bound(const Poses& poses, double enough) const;
  /// Positive: their distance; else minus how deep they overlap, m.
  [[nodiscard]] double signed_distance(const Poses& poses);

 private:
  [[nodiscard]] Eigen::Isometry3d between(const Poses& poses) const;

  const Body* body_a_;
  const Body* body_b_;
  int a_, b_;
  std::vector<Eigen::Vector3d> axes_;  ///< in the frame of the solid of A; one per pair of solids
};

/// The smallest distance over many pairs, asked again and again. Bounds order the pairs, so few distances are computed.
/// Thread: one at a time. Realtime: the constructor setup; queries cyclic.
class NearestPair {
 public:
  NearestPair(const Scene& scene, std::vector<BodyPair> pairs);

  /// m; certified. 0: two of them overlap or touch. Infinite without pairs.
  [[nodiscard]] double distance(const Poses& poses);
  /// The pair that it was, in the order of the constructor.
  [[nodiscard]] std::size_t nearest() const { return nearest_; }

 private:
  /// Around one of the bodies.
  struct Ball {
    int body;
    Eigen::Vector3d middle;  ///< in the body, m
    Eigen::Vector3d at;      ///< of this query
  };
  struct Coarse {
    std::size_t a, b;  ///< of balls_
    double radii;      ///< of both, m
  };
  std::vector<BodyPair> pairs_;
  std::vector<Coarse> coarse_;  ///< of the pairs, in their order
  std::vector<Ball> balls_;
  std::size_t nearest_ = 0;  ///< of the last query: most often it still is
};

}  // namespace takt::collision
