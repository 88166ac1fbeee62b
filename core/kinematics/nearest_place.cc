#include "core/kinematics/nearest_place.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/random.h"
#include "core/kinematics/joint_range.h"
#include "core/kinematics/pose_error.h"

namespace takt::kinematics {
namespace {

constexpr int kNearestSeeds = 200;
constexpr int kMostSteps = 100;
constexpr double kNearestTurnWeight = 1e-3;  // of rad against the reach
constexpr double kNearestMaxStep = 0.4;      // rad or m of one joint: the linear picture is good no further
constexpr double kAtPlace = 1e-9;            // m

class Nearest {
 public:
  Nearest(const Chain& chain, const Eigen::Isometry3d& X_BM, const Eigen::Isometry3d& X_FM)
      : chain_(chain), X_BM_(X_BM), X_FM_(X_FM), length_(std::max(chain.reach(), 1e-3)) {}

  /// From one beginning; nothing if it does not end at the place.
  [[nodiscard]] std::optional<NearestPlace> from(JointVector q) const {
    q = clamped(q);
    double damping = 1e-6;
    for (int k = 0; k < kMostSteps; ++k) {
      const JointVector next = clamped(q + step(q, kNearestTurnWeight, damping));
      const bool better = cost(next) < cost(q);
      damping = std::clamp(better ? 0.2 * damping : 10.0 * damping, 1e-12, 1e3);
      if (!better && damping >= 1e3) break;
      if (!better) continue;
      const double moved = (next - q).cwiseAbs().maxCoeff();
      q = next;
      if (moved < 1e-10) break;
    }
    // The last of the way to the place, without regard to turns: some micrometres.
    for (int k = 0; k < 10 && off(q) > 0.1 * kAtPlace; ++k) q = clamped(q + step(q, 0.0, 1e-15));
    if (!(off(q) <= kAtPlace)) return std::nullopt;
    const Eigen::Matrix3d R_MM = (chain_.forward(q) * X_FM_).linear().transpose() * X_BM_.linear();
    return NearestPlace{.q = q, .turn = Eigen::AngleAxisd(R_MM).angle()};
  }

 private:
  [[nodiscard]] Vector6 error_at(const JointVector& q) const { return pose_error(chain_.forward(q) * X_FM_, X_BM_); }
  [[nodiscard]] double off(const JointVector& q) const { return error_at(q).head<3>().norm(); }
  [[nodiscard]] double cost(const JointVector& q) const {
    const Vector6 error = error_at(q);
    return error.head<3>().squaredNorm() / (length_ * length_) +
           kNearestTurnWeight * kNearestTurnWeight * error.tail<3>().squaredNorm();
  }

  [[nodiscard]] JointVector step(const JointVector& q, double turn_weight, double damping) const {
    Eigen::Isometry3d X_BF;
    Jacobian J;
    chain_.jacobian(q, X_BF, J);
    const Eigen::Vector3d p_FM_B = X_BF.linear() * X_FM_.translation();
    for (Eigen::Index i = 0; i < J.cols(); ++i) J.col(i).head<3>() += J.col(i).tail<3>().cross(p_FM_B).eval();
    Vector6 error = error_at(q);
    J.topRows<3>() /= length_;
    error.head<3>() /= length_;
    J.bottomRows<3>() *= turn_weight;
    error.tail<3>() *= turn_weight;
    JointMatrix normal = J.transpose() * J;
    normal.diagonal().array() += damping * turn_weight * turn_weight + 1e-15;
    JointVector delta = normal.ldlt().solve(JointVector(J.transpose() * error));
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kNearestMaxStep) delta *= kNearestMaxStep / longest;
    return delta;
  }

  [[nodiscard]] JointVector clamped(const JointVector& q) const {
    return q.cwiseMax(chain_.lower()).cwiseMin(chain_.upper());
  }

  const Chain& chain_;
  const Eigen::Isometry3d& X_BM_;
  const Eigen::Isometry3d& X_FM_;
  double length_;
};

}  // namespace

std::optional<NearestPlace> nearest_place(const Chain& chain, const Eigen::Isometry3d& X_BM,
                                          const Eigen::Isometry3d& X_FM, const JointVector& reference) {
  if (!X_BM.matrix().allFinite()) return std::nullopt;
  const Nearest nearest(chain, X_BM, X_FM);
  if (auto near = nearest.from(reference)) return near;
  std::optional<NearestPlace> best;
  Random random(1, "nearest place");
  for (int k = 0; k < kNearestSeeds; ++k) {
    JointVector q(chain.joint_count());
    for (int i = 0; i < q.size(); ++i) {
      const OneTurn turn = one_turn(chain, i);
      q[i] = random.uniform(turn.low, turn.high);
    }
    auto found = nearest.from(q);
    // A clear gain is wanted, so that rounding does not choose.
    if (found && (!best || found->turn < best->turn - 1e-6)) best = std::move(found);
  }
  return best;
}

}  // namespace takt::kinematics
