#include "core/motion/path.h"

#include <algorithm>
#include <cmath>

namespace takt::motion {
namespace {

JointSample proportional(const JointVector& start, const JointVector& goal, const PathPoint& at) {
  const JointVector way = goal - start;
  JointSample sample{.q = start + at.s * way, .dq = at.ds * way, .ddq = at.dds * way};
  if (at.s >= 1.0) sample.q = goal;
  return sample;
}

/// The turn of M about its fixed axis, as orientation and angular parts of a sample.
void set_turn(const Eigen::Quaterniond& R_start, const Eigen::Vector3d& axis, double angle, const PathPoint& at,
              FrameSample& sample) {
  sample.X_BM.linear() = (Eigen::AngleAxisd(at.s * angle, axis) * R_start).toRotationMatrix();
  sample.V_BM_B.tail<3>() = (at.ds * angle) * axis;
  sample.A_BM_B.tail<3>() = (at.dds * angle) * axis;
}

PathSample sample_one(const JointLine& line, const PathPoint& at) {
  return {.cartesian = false, .joints = line.sample(at), .frame = {}, .held = {}};
}
PathSample sample_one(const JointCurve& curve, const PathPoint& at) {
  return {.cartesian = false, .joints = curve.sample(at), .frame = {}, .held = {}};
}
PathSample sample_one(const CompositePath& path, const PathPoint& at) { return path.sample(at); }
PathSample sample_one(const auto& cartesian, const PathPoint& at) {
  return {.cartesian = true, .joints = {}, .frame = cartesian.sample(at), .held = cartesian.held(at)};
}

}  // namespace

JointSample JointLine::sample(const PathPoint& at) const { return proportional(q_start, q_goal, at); }

CartesianLine CartesianLine::between(const Eigen::Isometry3d& X_BM_start, const Eigen::Isometry3d& X_BM_goal,
                                     const JointVector& held_start, const JointVector& held_goal) {
  CartesianLine line;
  line.p_start = X_BM_start.translation();
  line.R_start = Eigen::Quaterniond(X_BM_start.linear()).normalized();
  const Eigen::Vector3d way = X_BM_goal.translation() - line.p_start;
  // A way below this is lost in the rounding of the poses themselves.
  constexpr double kNoWay = 1e-13;
  if (way.norm() > kNoWay) {
    line.length = way.norm();
    line.direction = way / line.length;
  }
  const FixedAxisTurn turn = short_turn(line.R_start, Eigen::Quaterniond(X_BM_goal.linear()).normalized());
  line.axis = turn.axis;
  line.angle = turn.angle;
  line.held_start = held_start;
  line.held_goal = held_goal;
  return line;
}

FixedAxisTurn short_turn(const Eigen::Quaterniond& R_start, const Eigen::Quaterniond& R_goal) {
  Eigen::Quaterniond turn = (R_goal * R_start.conjugate()).normalized();
  // Below this, the sign of w is rounding: the turn is half a turn.
  constexpr double kHalfTurn = 1e-9;
  bool flip = turn.w() < 0.0;
  if (std::abs(turn.w()) < kHalfTurn) {
    const auto& v = turn.vec();
    const double leading = std::abs(v.x()) > kHalfTurn ? v.x() : std::abs(v.y()) > kHalfTurn ? v.y() : v.z();
    flip = leading < 0.0;
  }
  if (flip) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  // A turn below this is lost in the rounding of the poses themselves.
  constexpr double kNoTurn = 1e-13;
  if (sine < kNoTurn) return {};
  return {.axis = turn.vec() / sine, .angle = 2.0 * std::atan2(sine, turn.w())};
}

FrameSample CartesianLine::sample(const PathPoint& at) const {
  FrameSample sample;
  sample.X_BM.translation() = p_start + (at.s * length) * direction;
  sample.V_BM_B.head<3>() = (at.ds * length) * direction;
  sample.A_BM_B.head<3>() = (at.dds * length) * direction;
  set_turn(R_start, axis, angle, at, sample);
  return sample;
}

JointSample CartesianLine::held(const PathPoint& at) const { return proportional(held_start, held_goal, at); }

FrameSample CartesianArc::sample(const PathPoint& at) const {
  const Eigen::Vector3d out = p_start - centre;
  const Eigen::Vector3d along = normal.cross(out);
  const double cosine = std::cos(at.s * arc);
  const double sine = std::sin(at.s * arc);
  const Eigen::Vector3d radial = cosine * out + sine * along;
  const Eigen::Vector3d tangent = cosine * along - sine * out;
  FrameSample sample;
  sample.X_BM.translation() = centre + radial;
  sample.V_BM_B.head<3>() = (at.ds * arc) * tangent;
  sample.A_BM_B.head<3>() = (at.dds * arc) * tangent - (at.ds * arc) * (at.ds * arc) * radial;
  set_turn(R_start, axis, angle, at, sample);
  return sample;
}

JointSample CartesianArc::held(const PathPoint& at) const { return proportional(held_start, held_goal, at); }

bool is_cartesian(const Geometry& geometry) {
  return !std::holds_alternative<JointLine>(geometry) && !std::holds_alternative<JointCurve>(geometry);
}

PathSample sample(const Geometry& geometry, const PathPoint& at) {
  return std::visit([&](const auto& one) { return sample_one(one, at); }, geometry);
}

PathPoint PathPiece::own(const PathPoint& at) const {
  const double rate = (own_end - own_begin) / (s_end - s_begin);
  // From the nearer end, so that both ends of the piece are met exactly.
  const double middle = 0.5 * (s_begin + s_end);
  const double s = at.s < middle ? own_begin + (at.s - s_begin) * rate : own_end - (s_end - at.s) * rate;
  return {.s = s, .ds = at.ds * rate, .dds = at.dds * rate};
}

std::size_t CompositePath::piece_at(double s) const {
  const auto after = std::upper_bound(pieces.begin(), pieces.end(), s,
                                      [](double t, const PathPiece& piece) { return t < piece.s_end; });
  return std::min(static_cast<std::size_t>(after - pieces.begin()), pieces.size() - 1);
}

PathSample CompositePath::sample(const PathPoint& at) const {
  const PathPiece& piece = pieces[piece_at(at.s)];
  return motion::sample(piece.geometry, piece.own(at));
}

bool CompositePath::has_joint_pieces() const {
  return std::ranges::any_of(pieces, [](const PathPiece& piece) { return !is_cartesian(piece.geometry); });
}

bool CompositePath::has_cartesian_pieces() const {
  return std::ranges::any_of(pieces, [](const PathPiece& piece) { return is_cartesian(piece.geometry); });
}

std::vector<PathPiece> pieces_of(const Path& path) {
  return std::visit(
      [](const auto& one) -> std::vector<PathPiece> {
        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, CompositePath>) {
          return one.pieces;
        } else {
          return {{.geometry = one}};
        }
      },
      path);
}

PathSample sample(const Path& path, const PathPoint& at) {
  return std::visit([&](const auto& one) { return sample_one(one, at); }, path);
}

}  // namespace takt::motion
