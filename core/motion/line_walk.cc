#include "core/motion/line_walk.h"

#include <algorithm>
#include <cmath>

namespace takt::motion {
namespace {

using kinematics::IkStatus;
using Node = LineWalk::Node;

/// A solution further than this (rad or m) from where its predecessor's derivatives point is looked at in smaller
/// steps; a true continuation comes nearer with each halving.
constexpr double kSurprise = 0.01;
/// A step is halved at most so often: 1 / (32 * 2^12) of the line is below a hundredth of a millimetre per metre.
constexpr int kHalvings = 12;

class Walker {
 public:
  Walker(const kinematics::InverseKinematics& inverse, const CartesianLine& line, const Eigen::Isometry3d& X_FM)
      : inverse_(inverse), line_(line), X_MF_(X_FM.inverse()) {}

  /// From `node` at s0 to s1, in place. `s_end` is how far it came.
  WalkEnd step(Node& node, double s0, double s1, int halvings, double& s_end) const {
    const double h = s1 - s0;
    const JointVector expected = node.q + h * (node.dq + h / 2 * node.ddq);
    const FrameSample at = sample(s1);
    JointVector q = expected;
    const IkStatus status = inverse_.solve(at.X_BM, line_.held({.s = s1}).q, q);
    if (status == IkStatus::kOk && (q - expected).cwiseAbs().maxCoeff() <= kSurprise) {
      node.q = q;
      s_end = s1;
      return differentiate(at, node) ? WalkEnd::kGoal : WalkEnd::kSingular;
    }
    if (halvings == 0) return status == IkStatus::kOk ? WalkEnd::kOtherBranch : WalkEnd::kUnreachable;
    const double middle = s0 + h / 2;
    const WalkEnd first = step(node, s0, middle, halvings - 1, s_end);
    return first == WalkEnd::kGoal ? step(node, middle, s1, halvings - 1, s_end) : first;
  }

  /// Derivatives by s at a node whose q is known. @return false at a singularity.
  bool differentiate(const FrameSample& at, Node& node) const {
    const JointSample held = line_.held({.s = 0.0, .ds = 1.0});
    node.dq.resize(node.q.size());
    node.ddq.resize(node.q.size());
    return inverse_.rates(node.q, at.V_BM_B, held.dq, node.dq) == IkStatus::kOk &&
           inverse_.accelerations(node.q, node.dq, at.A_BM_B, held.ddq, node.ddq) == IkStatus::kOk;
  }

  /// Pose, velocity and acceleration of the *flange* (in the members for M) for ds = 1, dds = 0.
  FrameSample sample(double s) const {
    FrameSample at = line_.sample({.s = s, .ds = 1.0});
    const Eigen::Vector3d p_MF_B = at.X_BM.linear() * X_MF_.translation();
    const Eigen::Vector3d w = at.V_BM_B.tail<3>();
    at.V_BM_B.head<3>() += w.cross(p_MF_B);
    at.A_BM_B.head<3>() += at.A_BM_B.tail<3>().cross(p_MF_B) + w.cross(w.cross(p_MF_B));
    at.X_BM = at.X_BM * X_MF_;
    return at;
  }

 private:
  const kinematics::InverseKinematics& inverse_;
  const CartesianLine& line_;
  Eigen::Isometry3d X_MF_;
};

/// Derivatives in one cell of width h: cubic Hermite interpolation of dq at `t` in [0, 1].
LineWalk::Derivatives hermite(const Node& a, const Node& b, double h, double t) {
  // f(t) = a0 + a1 t + a2 t^2 + a3 t^3 with the values and (scaled) slopes of both ends.
  const JointVector rise = b.dq - a.dq;
  const JointVector a1 = h * a.ddq;
  const JointVector a2 = 3.0 * rise - h * (2.0 * a.ddq + b.ddq);
  const JointVector a3 = h * (a.ddq + b.ddq) - 2.0 * rise;
  return {.first = a.dq + t * (a1 + t * (a2 + t * a3)),
          .second = (a1 + t * (2.0 * a2 + 3.0 * t * a3)) / h,
          .third = (2.0 * a2 + 6.0 * t * a3) / (h * h)};
}

}  // namespace

LineWalk walk_line(const kinematics::InverseKinematics& inverse, const CartesianLine& line,
                   const Eigen::Isometry3d& X_FM, const JointVector& q_start, int steps) {
  const Walker walker(inverse, line, X_FM);
  LineWalk walk{.nodes = {}, .steps = steps, .s_end = 0.0};
  walk.nodes.reserve(static_cast<std::size_t>(steps) + 1);
  Node node{.q = q_start, .dq = {}, .ddq = {}};
  walk.end = walker.differentiate(walker.sample(0.0), node) ? WalkEnd::kGoal : WalkEnd::kSingular;
  for (int i = 0; walk.end == WalkEnd::kGoal; ++i) {
    walk.nodes.push_back(node);
    walk.measure = inverse.singularity_measure(node.q);
    if (walk.measure < kSingularityLeast) walk.end = WalkEnd::kSingular;
    if (walk.end != WalkEnd::kGoal || i == steps) break;
    const double h = 1.0 / steps;
    walk.end = walker.step(node, i * h, (i + 1) * h, kHalvings, walk.s_end);
  }
  return walk;
}

LineWalk::Derivatives LineWalk::derivatives(double s) const {
  const double place = std::clamp(s, 0.0, 1.0) * steps;
  const int cell = std::min(static_cast<int>(place), steps - 1);
  const auto i = static_cast<std::size_t>(cell);
  return hermite(nodes[i], nodes[i + 1], 1.0 / steps, place - cell);
}

JointVector LineWalk::roughness() const {
  const double h = 1.0 / steps;
  JointVector jump = JointVector::Zero(nodes.front().q.size());
  for (std::size_t i = 1; i + 1 < nodes.size(); ++i) {
    const JointVector left = hermite(nodes[i - 1], nodes[i], h, 1.0).third;
    const JointVector right = hermite(nodes[i], nodes[i + 1], h, 0.0).third;
    jump = jump.cwiseMax((right - left).cwiseAbs());
  }
  return jump;
}

}  // namespace takt::motion
