#include "core/motion/motion_state.h"

#include <algorithm>

#include "core/motion/piece_walk.h"

namespace takt::motion {

std::optional<JointSample> joints_at(const ArmModel& arm, const Motion& motion, double tau) {
  constexpr int kSteps = 16;
  const LawPoint at = motion.law.at(tau);
  JointVector q = motion.q_start;
  for (PathPiece piece : pieces_of(motion.path)) {
    const bool last = at.s <= piece.s_end || piece.s_end == 1.0;
    // The place itself, a hair inside where it is the begin of a piece: a piece without width has no derivatives.
    constexpr double kHair = 1e-6;
    const double share = last ? std::clamp((at.s - piece.s_begin) / (piece.s_end - piece.s_begin), kHair, 1.0) : 1.0;
    const bool at_begin = last && at.s <= piece.s_begin;
    piece.own_end = piece.own_begin + share * (piece.own_end - piece.own_begin);
    const PieceWalk walk = walk_piece(arm.inverse, piece, arm.X_FM, q, at_begin ? 1 : kSteps);
    if (walk.end != WalkEnd::kGoal) return std::nullopt;
    const PieceWalk::Node& node = at_begin ? walk.nodes.front() : walk.nodes.back();
    q = node.q;
    if (!last) continue;
    const double rate = 1.0 / (share * (piece.s_end - piece.s_begin));  // of t by s
    const JointVector first = rate * node.dq;
    const JointVector second = (rate * rate) * node.ddq;
    return JointSample{.q = q, .dq = at.ds * first, .ddq = (at.ds * at.ds) * second + at.dds * first};
  }
  return std::nullopt;
}

}  // namespace takt::motion
