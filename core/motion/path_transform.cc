#include "core/motion/path_transform.h"

#include <utility>

namespace takt::motion {
namespace {

struct View {
  Eigen::Isometry3d X_AB;
  Eigen::Quaterniond R_AB;
  JointVector held;

  std::optional<Geometry> operator()(const JointLine&) const { return std::nullopt; }
  std::optional<Geometry> operator()(const JointCurve&) const { return std::nullopt; }
  std::optional<Geometry> operator()(const CarriedLine&) const { return std::nullopt; }
  std::optional<Geometry> operator()(CartesianLine line) const {
    line.p_start = X_AB * line.p_start;
    line.R_start = R_AB * line.R_start;
    line.direction = R_AB * line.direction;
    line.axis = R_AB * line.axis;
    line.held_start = line.held_goal = held;
    return line;
  }
  std::optional<Geometry> operator()(CartesianArc arc) const {
    arc.p_start = X_AB * arc.p_start;
    arc.R_start = R_AB * arc.R_start;
    arc.centre = X_AB * arc.centre;
    arc.normal = R_AB * arc.normal;
    arc.axis = R_AB * arc.axis;
    arc.held_start = arc.held_goal = held;
    return arc;
  }
  std::optional<Geometry> operator()(CartesianCurve curve) const {
    curve.R_ref = R_AB * curve.R_ref;
    for (std::size_t k = 0; k < curve.p.c.size(); ++k) {
      curve.p.c[k] = k == 0 ? Eigen::Vector3d(X_AB * curve.p.c[k]) : Eigen::Vector3d(R_AB * curve.p.c[k]);
      curve.phi.c[k] = R_AB * curve.phi.c[k];
      curve.held_curve.c[k] = k == 0 ? held : JointVector(JointVector::Zero(held.size()));
    }
    return curve;
  }
};

}  // namespace

std::optional<Path> seen_from(const Path& path, const Eigen::Isometry3d& X_AB, const JointVector& held) {
  const View view{X_AB, Eigen::Quaterniond(X_AB.linear()).normalized(), held};
  CompositePath seen;
  for (PathPiece piece : pieces_of(path)) {
    auto geometry = std::visit(view, std::move(piece.geometry));
    if (!geometry) return std::nullopt;
    piece.geometry = std::move(*geometry);
    seen.pieces.push_back(std::move(piece));
  }
  if (std::holds_alternative<CompositePath>(path)) return seen;
  return std::visit(
      [](auto& one) -> std::optional<Path> {
        if constexpr (std::is_constructible_v<Path, decltype(one)>) {
          return Path(one);
        } else {
          return std::nullopt;
        }
      },
      seen.pieces.front().geometry);
}

}  // namespace takt::motion
