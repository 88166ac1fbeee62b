#include "core/motion/joint_track.h"

#include <algorithm>
#include <cmath>

#include "core/motion/piece_walk.h"

namespace takt::motion {
namespace {

constexpr double kNodeStep = 0.01;  // s between nodes, on average over the piece
constexpr int kFewestSteps = 16, kMostSteps = 512;

/// How long the law is on the part [s_begin, s_end] of the path, s.
double time_on(const TimeLaw& law, double s_begin, double s_end) {
  const auto time_at = [&](double s) {
    double low = 0.0, high = law.duration();
    for (int i = 0; i < 30; ++i) (law.at(0.5 * (low + high)).s < s ? low : high) = 0.5 * (low + high);
    return high;
  };
  return (s_end >= 1.0 ? law.duration() : time_at(s_end)) - (s_begin <= 0.0 ? 0.0 : time_at(s_begin));
}

struct Rates {
  double ds = 0.0, dds = 0.0;  ///< 1/s, 1/s^2
};

/// The largest of a law between two times.
Rates largest_rates(const TimeLaw& law, double from, double to) {
  LawPoint now = law.at(from);
  Rates most;
  const auto look = [&most](const LawPoint& point) {
    most = {.ds = std::max(most.ds, std::abs(point.ds)), .dds = std::max(most.dds, std::abs(point.dds))};
  };
  look(now);
  for (const TimeLaw::Segment& segment : law.segments_between(from, to)) {
    now.ddds = segment.jerk;
    const double turns = segment.jerk != 0.0 ? -now.dds / segment.jerk : 0.0;  // where the rate is largest
    if (turns > 0.0 && turns < segment.duration_s) look(advanced(now, turns));
    now = advanced(now, segment.duration_s);
    look(now);
  }
  return most;
}

}  // namespace

std::optional<JointTrack> JointTrack::follow(const ArmModel& arm, const Motion& motion) {
  return follow(arm, motion, motion.law);
}

std::optional<JointTrack> JointTrack::follow(const ArmModel& arm, const Motion& motion, const TimeLaw& law) {
  JointTrack track;
  track.law_ = law;
  JointVector q = motion.q_start;
  for (PathPiece& piece : pieces_of(motion.path)) {
    Piece own{.s_begin = piece.s_begin, .s_end = piece.s_end, .path = std::move(piece)};
    if (is_cartesian(own.path.geometry)) {
      const double wanted = std::ceil(time_on(law, own.s_begin, own.s_end) / kNodeStep);
      const int steps = static_cast<int>(std::clamp<double>(wanted, kFewestSteps, kMostSteps));
      const PieceWalk walk = walk_piece(arm.inverse, own.path, arm.X_FM, q, steps);
      if (walk.end != WalkEnd::kGoal) return std::nullopt;
      own.nodes.reserve(walk.nodes.size());
      for (const PieceWalk::Node& node : walk.nodes) own.nodes.push_back({node.q, node.dq, node.ddq});
      q = own.nodes.back().q;
    } else {
      q = sample(own.path.geometry, {.s = own.path.own_end, .ds = 0.0, .dds = 0.0}).joints.q;
    }
    find_derivatives(own);
    track.pieces_.push_back(std::move(own));
  }
  if (track.pieces_.empty()) return std::nullopt;
  return track;
}

/// The polynomial of fifth degree through position, velocity and acceleration at both nodes beside t.
JointVector JointTrack::between(const std::vector<Node>& nodes, double t) {
  const double steps = static_cast<double>(nodes.size() - 1);
  const auto left = static_cast<std::size_t>(std::clamp(std::floor(t * steps), 0.0, steps - 1.0));
  const Node &a = nodes[left], &b = nodes[left + 1];
  const double h = 1.0 / steps, u = std::clamp(t * steps - static_cast<double>(left), 0.0, 1.0);
  const double v = 1.0 - u, u3 = u * u * u, v3 = v * v * v;
  return v3 * (1.0 + 3.0 * u + 6.0 * u * u) * a.q + u3 * (1.0 + 3.0 * v + 6.0 * v * v) * b.q +
         h * (v3 * u * (1.0 + 3.0 * u) * a.dq - u3 * v * (1.0 + 3.0 * v) * b.dq) +
         (0.5 * h * h) * (v3 * u * u * a.ddq + u3 * v * v * b.ddq);
}

void JointTrack::find_derivatives(Piece& piece) {
  constexpr int kLooks = 32;
  const double span = piece.s_end - piece.s_begin, by_span = span > 0.0 ? 1.0 / span : 0.0;
  const auto look = [&piece, by_span](const JointVector& by_t, const JointVector& twice_by_t) {
    if (piece.first.size() == 0) piece.first = piece.second = JointVector::Zero(by_t.size());
    piece.first = piece.first.cwiseMax(by_t.cwiseAbs() * by_span);
    piece.second = piece.second.cwiseMax(twice_by_t.cwiseAbs() * (by_span * by_span));
  };
  for (const Node& node : piece.nodes) look(node.dq, node.ddq);
  if (!piece.nodes.empty()) return;
  const double rate = piece.path.own_end - piece.path.own_begin;
  for (int k = 0; k <= kLooks; ++k) {
    const double own = piece.path.own_begin + rate * k / kLooks;
    const PathSample there = sample(piece.path.geometry, {.s = own, .ds = rate, .dds = 0.0});
    look(there.joints.dq, there.joints.ddq);
  }
}

JointVector JointTrack::largest_acceleration(double from, double to) const {
  constexpr double kReserve = 1.25;
  const auto [ds, dds] = largest_rates(law_, from, to);
  const double s_from = law_.at(from).s, s_to = law_.at(to).s;
  JointVector most = JointVector::Zero(pieces_.front().first.size());
  for (const Piece& piece : pieces_)
    if (piece.s_begin <= s_to && piece.s_end >= s_from)
      most = most.cwiseMax(kReserve * (piece.first * dds + piece.second * (ds * ds)));
  return most;
}

JointVector JointTrack::at(double tau) const {
  const double s = law_.at(tau).s;
  const auto later = std::ranges::upper_bound(pieces_, s, {}, &Piece::s_begin);
  const Piece& piece = later == pieces_.begin() ? pieces_.front() : *(later - 1);
  const double span = piece.s_end - piece.s_begin;
  const double t = span > 0.0 ? std::clamp((s - piece.s_begin) / span, 0.0, 1.0) : 1.0;
  if (!piece.nodes.empty()) return between(piece.nodes, t);
  const double own = piece.path.own_begin + t * (piece.path.own_end - piece.path.own_begin);
  return sample(piece.path.geometry, {.s = own, .ds = 0.0, .dds = 0.0}).joints.q;
}

}  // namespace takt::motion
