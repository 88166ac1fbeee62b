#include "core/motion/reach_text.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "core/kinematics/solutions.h"

namespace takt::motion {
namespace {

using kinematics::Chain;
using kinematics::JointVector;

bool all_turn(const Chain& chain) {
  for (int joint = 0; joint < chain.joint_count(); ++joint)
    if (chain.is_prismatic(joint)) return false;
  return true;
}

/// Height of the second joint's axis over the base: the flange goes round it in a circle. @return m; 0: there is none
double shoulder_height(const Chain& chain, const JointVector& q) {
  constexpr double kAway = 0.5;  // rad
  const auto at = [&](double turn) {
    JointVector turned = q;
    turned[1] += turn;
    return Eigen::Vector3d(chain.forward(turned).translation());
  };
  // Centre of the circle through three points. Source: barycentric coordinates of the circumcentre.
  const Eigen::Vector3d a = at(-kAway), b = at(0.0), c = at(kAway);
  const double A = (b - c).squaredNorm(), B = (c - a).squaredNorm(), C = (a - b).squaredNorm();
  const double wa = A * (B + C - A), wb = B * (C + A - B), wc = C * (A + B - C);
  const double sum = wa + wb + wc;
  return sum > 1e-9 ? (wa * a.z() + wb * b.z() + wc * c.z()) / sum : 0.0;
}

/// Looks for poses that an arm reaches near one that it does not, in the same orientation.
class Neighbours {
 public:
  Neighbours(const Chain& chain, const Eigen::Isometry3d& X_BF, const JointVector& q_near)
      : chain_(chain), X_BF_(X_BF), height_(shoulder_height(chain, q_near)) {
    search_.reference = q_near;
    search_.most = search_.enough = 1;
  }

  struct Found {
    Eigen::Vector3d p;  ///< m, of the flange in the base
    double moved;       ///< m, from the pose that is out of reach
    bool nearer;        ///< to the arm
  };
  /// The nearest of those on the lines through the shoulder and, level with the pose, through the first axis.
  [[nodiscard]] std::optional<Found> nearest() const {
    std::optional<Found> best;
    for (const double height : {height_, X_BF_.translation().z()}) {
      for (const int direction : {-1, 1}) {
        const auto found = along(Eigen::Vector3d(0.0, 0.0, height), direction);
        if (found && (!best || found->moved < best->moved)) best = found;
      }
    }
    return best;
  }

  /// It is reached where it is, turned by right angles.
  [[nodiscard]] bool turned() const {
    for (int axis = 0; axis < 3; ++axis) {
      for (int quarter = 1; quarter < 4; ++quarter) {
        Eigen::Isometry3d X = X_BF_;
        X.linear() *= Eigen::AngleAxisd(0.5 * quarter * std::numbers::pi, Eigen::Vector3d::Unit(axis)).matrix();
        if (reaches(X)) return true;
      }
    }
    return false;
  }

 private:
  [[nodiscard]] bool reaches(const Eigen::Isometry3d& X_BF) const {
    return !kinematics::inverse_solutions(chain_, X_BF, search_).empty();
  }

  /// From the pose towards a point (-1) or away from it (1): in steps that grow, then by halving.
  [[nodiscard]] std::optional<Found> along(const Eigen::Vector3d& p, int direction) const {
    constexpr double kFirst = 0.01, kGrowth = 1.5, kExact = 1e-3;  // m, 1, m
    const Eigen::Vector3d way = X_BF_.translation() - p;
    const double distance = way.norm(), farthest = direction > 0 ? 2.0 * chain_.reach() : distance;
    if (distance < kExact) return std::nullopt;
    const auto reached = [&](double moved) {
      Eigen::Isometry3d X = X_BF_;
      X.translation() += way / distance * direction * moved;
      return reaches(X);
    };
    double outside = 0.0, inside = kFirst;
    for (double step = kFirst; !reached(inside); step *= kGrowth) {
      outside = inside;
      inside += step;
      if (inside > farthest) return std::nullopt;
    }
    while (inside - outside > kExact) {
      const double middle = 0.5 * (inside + outside);
      (reached(middle) ? inside : outside) = middle;
    }
    return Found{X_BF_.translation() + way / distance * direction * inside, inside, direction < 0};
  }

  const Chain& chain_;
  const Eigen::Isometry3d& X_BF_;
  double height_;
  kinematics::SolutionOptions search_;
};

}  // namespace

std::string reach_text(const Chain& chain, const Eigen::Isometry3d& X_BF, const JointVector& q_near) {
  // Other chains are searched numerically, which takes a thousand times longer.
  const bool is_fast = chain.joint_count() >= 6 && chain.joint_count() <= 7 && all_turn(chain);
  if (!is_fast) return "a pose that some joint configuration inside the limits reaches";
  // A search by halving is for places around the arm.
  constexpr double kFar = 100.0;
  if (const double distance = X_BF.translation().stableNorm(); distance > kFar * chain.reach())
    return fmt::format("too far from the arm: {:.3g} m, and it reaches {:.3f} m", distance, chain.reach());
  const Neighbours neighbours(chain, X_BF, q_near);
  if (const auto found = neighbours.nearest())
    return fmt::format("too {} the arm by {:.3f} m: in this orientation the flange gets to ({:.3f}, {:.3f}, {:.3f}) m",
                       found->nearer ? "far from" : "near to", found->moved, found->p.x(), found->p.y(), found->p.z());
  if (neighbours.turned()) return "it can be reached in another orientation";
  return "the arm does not have this orientation anywhere near";
}

}  // namespace takt::motion
