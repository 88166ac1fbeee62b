#include "core/motion/piece_walk.h"

#include <algorithm>
#include <cmath>

namespace takt::motion {
namespace {

using kinematics::IkStatus;
using Node = PieceWalk::Node;

/// A solution further than this (rad or m) from where its predecessor's derivatives point is looked at in smaller
/// steps; a true continuation comes nearer with each halving.
constexpr double kSurprise = 0.01;
/// A step is halved at most so often: 1 / (32 * 2^12) of the piece is below a hundredth of a millimetre per metre.
constexpr int kHalvings = 12;

/// Where a piece is at t, with derivatives by t.
PathSample sample_by_t(const PathPiece& piece, double t) {
  const double span = piece.own_end - piece.own_begin;
  const double own = t < 0.5 ? piece.own_begin + t * span : piece.own_end - (1.0 - t) * span;
  return sample(piece.geometry, {.s = own, .ds = span, .dds = 0.0});
}

class Walker {
 public:
  Walker(const kinematics::InverseKinematics& inverse, const PathPiece& piece, const Eigen::Isometry3d& X_FM)
      : inverse_(inverse), piece_(piece), X_MF_(X_FM.inverse()) {}

  /// From `node` at t0 to t1, in place. `t_end` is how far it came, `regular` as in differentiate().
  WalkEnd step(Node& node, double t0, double t1, int halvings, double& t_end, bool& regular) const {
    const double h = t1 - t0;
    const JointVector expected = node.q + h * (node.dq + h / 2 * node.ddq);
    const PathSample at = sample_by_t(piece_, t1);
    JointVector q = expected;
    const IkStatus status = inverse_.solve(at.frame.X_BM * X_MF_, at.held.q, q);
    if (status == IkStatus::kOk && (q - expected).cwiseAbs().maxCoeff() <= kSurprise) {
      node.q = q;
      t_end = t1;
      return differentiate(at, node, regular) ? WalkEnd::kGoal : WalkEnd::kSingular;
    }
    if (halvings == 0) return status == IkStatus::kOk ? WalkEnd::kOtherBranch : WalkEnd::kUnreachable;
    const double middle = t0 + h / 2;
    const WalkEnd first = step(node, t0, middle, halvings - 1, t_end, regular);
    return first == WalkEnd::kGoal ? step(node, middle, t1, halvings - 1, t_end, regular) : first;
  }

  /// Derivatives by t at a node whose q is known, and whether its measure is at least kSingularityLeast.
  /// @return false where there are none.
  bool differentiate(const PathSample& at, Node& node, bool& regular) const {
    node.dX = at.frame.V_BM_B;
    node.ddX = at.frame.A_BM_B;
    // The same motion, told of the flange.
    const Eigen::Vector3d p_MF_B = at.frame.X_BM.linear() * X_MF_.translation();
    const Eigen::Vector3d w = node.dX.tail<3>();
    kinematics::InverseKinematics::Goal flange{
        .V_BF_B = node.dX, .A_BF_B = node.ddX, .held = {}, .held_dq = at.held.dq, .held_ddq = at.held.ddq};
    flange.V_BF_B.head<3>() += w.cross(p_MF_B);
    flange.A_BF_B.head<3>() += flange.A_BF_B.tail<3>().cross(p_MF_B) + w.cross(w.cross(p_MF_B));
    kinematics::InverseKinematics::Passage passage;
    const bool exist = inverse_.pass(node.q, flange, kSingularityLeast, passage) == IkStatus::kOk;
    node.dq = passage.dq;
    node.ddq = passage.ddq;
    regular = passage.regular;
    return exist;
  }

 private:
  const kinematics::InverseKinematics& inverse_;
  const PathPiece& piece_;
  Eigen::Isometry3d X_MF_;
};

PieceWalk walk_frame(const kinematics::InverseKinematics& inverse, const PathPiece& piece,
                     const Eigen::Isometry3d& X_FM, const JointVector& q_start, int steps) {
  const Walker walker(inverse, piece, X_FM);
  PieceWalk walk{.nodes = {}, .steps = steps, .t_end = 0.0};
  walk.nodes.reserve(static_cast<std::size_t>(steps) + 1);
  Node node{.q = q_start, .dq = {}, .ddq = {}};
  bool regular = false;
  walk.end = walker.differentiate(sample_by_t(piece, 0.0), node, regular) ? WalkEnd::kGoal : WalkEnd::kSingular;
  for (int i = 0; walk.end == WalkEnd::kGoal; ++i) {
    walk.nodes.push_back(node);
    if (!regular) walk.end = WalkEnd::kSingular;
    if (walk.end != WalkEnd::kGoal || i == steps) break;
    const double h = 1.0 / steps;
    walk.end = walker.step(node, i * h, (i + 1) * h, kHalvings, walk.t_end, regular);
  }
  if (walk.end == WalkEnd::kSingular && !walk.nodes.empty())
    walk.measure = inverse.singularity_measure(walk.nodes.back().q);
  return walk;
}

PieceWalk walk_joints(const PathPiece& piece, int steps) {
  PieceWalk walk{.nodes = {}, .steps = steps};
  walk.nodes.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    const JointSample at = sample_by_t(piece, static_cast<double>(i) / steps).joints;
    walk.nodes.push_back({.q = at.q, .dq = at.dq, .ddq = at.ddq});
  }
  return walk;
}

}  // namespace

PieceWalk walk_piece(const kinematics::InverseKinematics* inverse, const PathPiece& piece,
                     const Eigen::Isometry3d& X_FM, const JointVector& q_start, int steps) {
  return is_cartesian(piece.geometry) ? walk_frame(*inverse, piece, X_FM, q_start, steps) : walk_joints(piece, steps);
}

JointVector PieceWalk::roughness() const {
  // Third derivative of the cubic through first and second derivatives at the ends of a cell, at either end.
  const double h = 1.0 / steps;
  const auto third = [&](std::size_t left, double at_right) -> JointVector {
    const Node& a = nodes[left];
    const Node& b = nodes[left + 1];
    const JointVector rise = b.dq - a.dq;
    const JointVector c2 = 3.0 * rise - h * (2.0 * a.ddq + b.ddq);
    const JointVector c3 = h * (a.ddq + b.ddq) - 2.0 * rise;
    return (2.0 * c2 + 6.0 * at_right * c3) / (h * h);
  };
  JointVector jump = JointVector::Zero(nodes.front().q.size());
  for (std::size_t i = 1; i + 1 < nodes.size(); ++i) {
    jump = jump.cwiseMax((third(i, 0.0) - third(i - 1, 1.0)).cwiseAbs());
  }
  return jump;
}

}  // namespace takt::motion
