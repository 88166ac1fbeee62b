#include "sim/world/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {
namespace {

using Eigen::Vector3d;

constexpr double kHingeMargin = 0.05;   // rad beyond the range: mechanical stops give way a little
constexpr double kSlideMargin = 0.005;  // m
constexpr double kClearance = 0.002;    // m: pairs that come nearer than this count as meeting
constexpr int kEffort = 4000;           // boxes of joint space per pair of bodies
constexpr int kMaxJoints = 12;

Vector3d vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }
Eigen::Quaterniond quaternion(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

struct Ball {
  Vector3d centre;  ///< in the frame of the body
  double radius = 0.0;
};

/// A shape that stands: a box about its centre, or a half space below its plane.
struct Obstacle {
  Eigen::Isometry3d X_OW;  ///< the world in its frame
  Vector3d half;
  bool plane = false;

  [[nodiscard]] double distance(const Vector3d& p_W) const {
    const Vector3d p = X_OW * p_W;
    if (plane) return p.z();
    return (p.cwiseAbs() - half).cwiseMax(0.0).norm();
  }
};

/// A joint above a body, with the transforms from the joint before.
struct ChainJoint {
  bool slide = false;
  double low = 0.0, high = 0.0;
  Eigen::Isometry3d X_before;  ///< the frame at the joint's anchor in that of the joint before, before it moves
  Vector3d axis;               ///< in that frame
};

/// The joints from the world to a body, and the body in the frame of the last of them.
struct Chain {
  std::vector<ChainJoint> joints;
  Eigen::Isometry3d X_end;
};

/// Nothing if the body, or one above it, moves in a way that is not bounded by ranges.
std::optional<Chain> chain_of(const mjModel& model, int body) {
  std::vector<int> path;
  for (int b = body; b > 0; b = model.body_parentid[b]) path.push_back(b);
  Chain chain;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (auto b = path.rbegin(); b != path.rend(); ++b) {
    if (model.body_mocapid[*b] >= 0) return std::nullopt;
    X = X * Eigen::Translation3d(vector(model.body_pos + 3 * *b)) * quaternion(model.body_quat + 4 * *b);
    for (int k = 0; k < model.body_jntnum[*b]; ++k) {
      const int joint = model.body_jntadr[*b] + k;
      const int type = model.jnt_type[joint];
      if (type != mjJNT_HINGE && type != mjJNT_SLIDE) return std::nullopt;
      ChainJoint made;
      made.slide = type == mjJNT_SLIDE;
      if (made.slide && !model.jnt_limited[joint]) return std::nullopt;
      const double margin = made.slide ? kSlideMargin : kHingeMargin;
      const double zero = model.qpos0[model.jnt_qposadr[joint]];
      made.low = -std::numbers::pi;
      made.high = std::numbers::pi;
      if (model.jnt_limited[joint]) {
        made.low = model.jnt_range[2 * joint] - zero - margin;
        made.high = model.jnt_range[2 * joint + 1] - zero + margin;
      }
      const Eigen::Translation3d anchor(vector(model.jnt_pos + 3 * joint));
      made.X_before = X * anchor;
      made.axis = vector(model.jnt_axis + 3 * joint);
      chain.joints.push_back(made);
      X = Eigen::Isometry3d(anchor.inverse());
    }
  }
  chain.X_end = X;
  if (chain.joints.size() > kMaxJoints) return std::nullopt;
  return chain;
}

/// Balls that cover a shape, along the longest side of the box about it; in the frame of the body.
void cover(const mjModel& model, int geom, std::vector<Ball>& balls) {
  const Vector3d half = vector(model.geom_aabb + 6 * geom + 3);
  const Eigen::Isometry3d X_G =
      Eigen::Translation3d(vector(model.geom_pos + 3 * geom)) * quaternion(model.geom_quat + 4 * geom);
  Eigen::Index longest = 0;
  half.maxCoeff(&longest);
  if (model.geom_type[geom] == mjGEOM_SPHERE) {
    balls.push_back({X_G.translation(), model.geom_size[3 * geom]});
    return;
  }
  const bool round =
      (model.geom_type[geom] == mjGEOM_CAPSULE || model.geom_type[geom] == mjGEOM_CYLINDER) && longest == 2;
  const double across = round ? half[0] : std::sqrt(std::max(0.0, half.squaredNorm() - half[longest] * half[longest]));
  const int count = std::clamp(static_cast<int>(std::ceil(half[longest] / std::max(across, 0.01))), 1, 8);
  const double piece = half[longest] / count;
  for (int i = 0; i < count; ++i) {
    Vector3d centre = vector(model.geom_aabb + 6 * geom);
    centre[longest] += (2 * i + 1 - count) * piece;
    balls.push_back({X_G * centre, std::hypot(across, piece)});
  }
}

bool collides(const mjModel& model, int geom) {
  return model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0;
}

bool may_touch(const mjModel& model, int a, int b) {
  return (model.geom_contype[a] & model.geom_conaffinity[b]) != 0 ||
         (model.geom_contype[b] & model.geom_conaffinity[a]) != 0;
}

/// A body that moves within ranges, or stands.
struct Mover {
  int body = 0;
  Chain chain;
  std::vector<Ball> balls;  ///< in the frame of the body
  std::vector<int> geoms;
  /// Bounds over all postures; [j] from joint j on.
  std::vector<double> from_anchor;  ///< of any point of the body from joint j's anchor
  std::vector<double> from_axis;    ///< likewise from joint j's axis; of a slide: 1

  [[nodiscard]] bool stands() const { return chain.joints.empty(); }
};

double travel(const ChainJoint& joint) { return std::max(std::abs(joint.low), std::abs(joint.high)); }

/// How far joint k's anchor can be from joint j's axis (from_axis) or anchor, j < k; k past the end: the body's points.
class Bounds {
 public:
  Bounds(const Mover& mover) : joints_(mover.chain.joints) {
    for (const Ball& ball : mover.balls)
      points_ = std::max(points_, (mover.chain.X_end * ball.centre).norm() + ball.radius);
  }

  [[nodiscard]] double from_anchor(std::size_t j, std::size_t k) const {
    double sum = joints_[j].slide ? travel(joints_[j]) : 0.0;
    for (std::size_t i = j + 1; i < joints_.size() && i <= k; ++i) {
      sum += joints_[i].X_before.translation().norm();
      if (i < k && joints_[i].slide) sum += travel(joints_[i]);
    }
    return k < joints_.size() ? sum : sum + points_;
  }
  [[nodiscard]] double from_axis(std::size_t j, std::size_t k) const {
    if (joints_[j].slide) return 1.0;  // m of motion per m
    const double beyond = j + 1 < joints_.size() ? perpendicular(j) : 0.0;
    if (j + 1 == k && k < joints_.size()) return beyond;
    if (j + 1 >= joints_.size()) return points_;
    return beyond + from_anchor(j + 1, k);
  }

 private:
  /// Of the next joint's anchor from this axis.
  [[nodiscard]] double perpendicular(std::size_t j) const {
    return joints_[j].axis.cross(joints_[j + 1].X_before.translation()).norm();
  }

  const std::vector<ChainJoint>& joints_;
  double points_ = 0.0;
};

/// Searches the joint space of a mover for a posture in which it may touch what stands.
class Search {
 public:
  Search(const Mover& mover, const std::vector<Obstacle>& obstacles) : mover_(mover), obstacles_(obstacles) {
    const Bounds bounds(mover);
    const std::size_t n = mover.chain.joints.size();
    for (std::size_t k = 0; k <= n; ++k) {
      for (std::size_t j = 0; j < std::min(k, n); ++j) axis_[j][k] = bounds.from_axis(j, k);
    }
    for (std::size_t j = 0; j < n; ++j) anchor_[j] = bounds.from_anchor(j, n);
  }

  /// @return false only if that is proven
  [[nodiscard]] bool may_meet() {
    Box whole{};
    for (std::size_t j = 0; j < mover_.chain.joints.size(); ++j) {
      const ChainJoint& joint = mover_.chain.joints[j];
      whole.centre[j] = 0.5 * (joint.low + joint.high);
      whole.width[j] = 0.5 * (joint.high - joint.low);
    }
    std::vector<Box> open{whole};
    for (int effort = 0; !open.empty(); ++effort) {
      if (effort >= kEffort) return true;
      const Box box = open.back();
      open.pop_back();
      if (is_clear(box)) continue;
      if (touches_) return true;
      const std::size_t j = widest(box);
      for (const double side : {-0.5, 0.5}) {
        Box half = box;
        half.width[j] *= 0.5;
        half.centre[j] += side * box.width[j];
        open.push_back(half);
      }
    }
    return false;
  }

 private:
  struct Box {
    std::array<double, kMaxJoints> centre, width;
  };

  [[nodiscard]] double distance(const Vector3d& p_W) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Obstacle& obstacle : obstacles_) least = std::min(least, obstacle.distance(p_W));
    return least;
  }

  /// How far joint k's anchor (or the body's points) can be from where it is at the centre of the box.
  [[nodiscard]] double spread(const Box& box, std::size_t k) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < std::min(k, mover_.chain.joints.size()); ++j) {
      const double turned = mover_.chain.joints[j].slide ? box.width[j] : std::min(box.width[j], std::numbers::pi);
      sum += turned * axis_[j][k];
    }
    return sum;
  }

  [[nodiscard]] bool is_clear(const Box& box) {
    const std::size_t n = mover_.chain.joints.size();
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (std::size_t j = 0; j < n; ++j) {
      const ChainJoint& joint = mover_.chain.joints[j];
      X = X * joint.X_before;
      // From this anchor on the joints may do what they like.
      if (distance(X.translation()) - spread(box, j) - anchor_[j] > kClearance) return true;
      if (joint.slide) {
        X = X * Eigen::Translation3d(box.centre[j] * joint.axis);
      } else {
        X = X * Eigen::AngleAxisd(box.centre[j], joint.axis);
      }
    }
    X = X * mover_.chain.X_end;
    double least = std::numeric_limits<double>::infinity();
    for (const Ball& ball : mover_.balls) least = std::min(least, distance(X * ball.centre) - ball.radius);
    touches_ = least <= kClearance;
    return least - spread(box, n) > kClearance;
  }

  [[nodiscard]] std::size_t widest(const Box& box) const {
    const std::size_t n = mover_.chain.joints.size();
    std::size_t best = 0;
    for (std::size_t j = 1; j < n; ++j) {
      if (box.width[j] * axis_[j][n] > box.width[best] * axis_[best][n]) best = j;
    }
    return best;
  }

  const Mover& mover_;
  const std::vector<Obstacle>& obstacles_;
  std::array<std::array<double, kMaxJoints + 1>, kMaxJoints> axis_{};
  std::array<double, kMaxJoints> anchor_{};
  bool touches_ = false;
};

std::optional<Mover> mover_of(const mjModel& model, int body) {
  Mover mover;
  mover.body = body;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    const int geom = model.body_geomadr[body] + i;
    if (collides(model, geom)) mover.geoms.push_back(geom);
  }
  if (mover.geoms.empty()) return std::nullopt;
  auto chain = chain_of(model, body);
  if (!chain) return std::nullopt;
  mover.chain = std::move(*chain);
  for (const int geom : mover.geoms) {
    if (!mover.stands() && model.geom_type[geom] == mjGEOM_PLANE) return std::nullopt;
    if (!mover.stands()) cover(model, geom, mover.balls);
  }
  return mover;
}

std::vector<Obstacle> obstacles_of(const mjModel& model, const Mover& standing) {
  std::vector<Obstacle> obstacles;
  for (const int geom : standing.geoms) {
    const Eigen::Isometry3d X_WG = standing.chain.X_end * Eigen::Translation3d(vector(model.geom_pos + 3 * geom)) *
                                   quaternion(model.geom_quat + 4 * geom);
    const bool plane = model.geom_type[geom] == mjGEOM_PLANE;
    const mjtNum* box = model.geom_aabb + 6 * geom;
    const Eigen::Isometry3d X_WO = plane ? X_WG : X_WG * Eigen::Translation3d(vector(box));
    obstacles.push_back({X_WO.inverse(Eigen::Isometry), vector(box + 3), plane});
  }
  return obstacles;
}

/// Two that move, on different chains: the balls in which they live.
bool apart(const Mover& a, const Mover& b) {
  const auto home = [](const Mover& m) {
    return Ball{m.chain.joints[0].X_before.translation(), Bounds(m).from_anchor(0, m.chain.joints.size())};
  };
  const Ball x = home(a), y = home(b);
  return (x.centre - y.centre).norm() > x.radius + y.radius + kClearance;
}

bool excluded(const mjModel& model, int a, int b) {
  const int signature = (std::min(a, b) << 16) + std::max(a, b);
  return std::find(model.exclude_signature, model.exclude_signature + model.nexclude, signature) !=
         model.exclude_signature + model.nexclude;
}

/// As MuJoCo filters pairs of bodies before it looks at their shapes.
bool could_collide(const mjModel& model, int a, int b) {
  const int weld_a = model.body_weldid[a], weld_b = model.body_weldid[b];
  if (weld_a == weld_b || excluded(model, a, b)) return false;
  const int above_a = model.body_weldid[model.body_parentid[weld_a]];
  const int above_b = model.body_weldid[model.body_parentid[weld_b]];
  // Neighbours do not touch, but those of what stands do.
  if (weld_a != 0 && weld_b != 0 && (above_a == weld_b || above_b == weld_a)) return false;
  for (int i = model.body_geomadr[a]; i < model.body_geomadr[a] + model.body_geomnum[a]; ++i) {
    for (int j = model.body_geomadr[b]; j < model.body_geomadr[b] + model.body_geomnum[b]; ++j) {
      if (may_touch(model, i, j)) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<std::pair<int, int>> never_meet(const mjModel_& model) {
  std::vector<Mover> movers;
  for (int body = 0; body < static_cast<int>(model.nbody); ++body) {
    if (auto mover = mover_of(model, body)) movers.push_back(std::move(*mover));
  }
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < movers.size(); ++i) {
    for (std::size_t j = i + 1; j < movers.size(); ++j) {
      const Mover& a = movers[i];
      const Mover& b = movers[j];
      if ((a.stands() && b.stands()) || !could_collide(model, a.body, b.body)) continue;
      bool never = false;
      if (a.stands() || b.stands()) {
        const std::vector<Obstacle> obstacles = obstacles_of(model, a.stands() ? a : b);
        never = !Search(a.stands() ? b : a, obstacles).may_meet();
      } else {
        never = apart(a, b);
      }
      if (never) pairs.emplace_back(a.body, b.body);
    }
  }
  return pairs;
}

std::vector<int> meet_nothing(const mjModel_& model, const std::vector<std::pair<int, int>>& never) {
  std::vector<int> alone;
  const int bodies = static_cast<int>(model.nbody);
  for (int a = 0; a < bodies; ++a) {
    bool meets = model.body_geomnum[a] == 0;
    for (int b = 0; b < bodies && !meets; ++b) {
      if (a == b || !could_collide(model, std::min(a, b), std::max(a, b))) continue;
      meets = std::ranges::find(never, std::pair(std::min(a, b), std::max(a, b))) == never.end();
    }
    if (!meets) alone.push_back(a);
  }
  return alone;
}

}  // namespace takt::sim
