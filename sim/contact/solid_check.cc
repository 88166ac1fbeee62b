#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "sim/model/solids.h"

namespace takt::sim {
namespace {

constexpr double kOnFace = 1e-5;   // m: so near to a face is on it
constexpr double kUpright = 1e-3;  // so little does the axis of a bore lean

/// Half the size of what a bore may be in, along each axis; nothing for other shapes.
std::optional<Eigen::Vector3d> half_size(const ObjectShape& shape) {
  if (const auto* box = std::get_if<kinematics::Box>(&shape)) return Eigen::Vector3d(0.5 * box->size);
  const auto* cylinder = std::get_if<kinematics::Cylinder>(&shape);
  if (!cylinder) return std::nullopt;
  return Eigen::Vector3d(cylinder->radius, cylinder->radius, 0.5 * cylinder->length);
}

/// The axis of the shape that a bore is parallel to; -1 if it is perpendicular to no flat face.
int axis_of(const ObjectShape& shape, const world::Bore& bore) {
  const Eigen::Vector3d z = bore.X_SB.linear().col(2);
  Eigen::Index axis = 0;
  z.cwiseAbs().maxCoeff(&axis);
  if (1.0 - std::abs(z[axis]) > kUpright) return -1;
  return std::holds_alternative<kinematics::Cylinder>(shape) && axis != 2 ? -1 : static_cast<int>(axis);
}

/// How much material is around the mouth, m; below 0: it reaches over the rim of the face.
double wall_around(const ObjectShape& shape, const Eigen::Vector3d& half, const world::Bore& bore, int axis) {
  Eigen::Vector3d off = bore.X_SB.translation();
  off[axis] = 0.0;
  const double radius = bore.radius + bore.chamfer;
  if (std::holds_alternative<kinematics::Cylinder>(shape)) return half.x() - off.norm() - radius;
  Eigen::Vector3d left = half - off.cwiseAbs();
  left[axis] = left.maxCoeff();
  return left.minCoeff() - radius;
}

void check_bore(const ObjectGeometry& part, const Eigen::Vector3d& half, const world::Bore& bore, const std::string& at,
                Diagnostics& diagnostics) {
  const auto wrong = [&](std::string message, std::string hint) {
    diagnostics.error(Code::kInvalidValue, at, std::move(message), std::move(hint));
  };
  const auto positive = [&](std::string_view what, double value, bool zero) {
    if (value > 0.0 || (zero && value == 0.0)) return true;
    diagnostics.error(Code::kOutOfRange, at, fmt::format("{} is {}", what, value),
                      zero ? "Give 0 m or more" : "Give more than 0 m");
    return false;
  };
  const bool sizes = positive("the radius of the bore", bore.radius, false) & positive("its depth", bore.depth, false) &
                     positive("its chamfer", bore.chamfer, true);
  if (!sizes) return;
  const int axis = axis_of(part.shape, bore);
  if (axis < 0) {
    return wrong("the bore is not perpendicular to a flat face",
                 "its z axis along an axis of the box or of the cylinder, out of the material");
  }
  const double side = bore.X_SB.linear()(axis, 2) * bore.X_SB.translation()[axis];
  if (std::abs(side - half[axis]) > kOnFace) {
    return wrong(fmt::format("the mouth of the bore is {} m off the face", side - half[axis]),
                 fmt::format("on the face, {} m from the middle of the shape", half[axis]));
  }
  if (wall_around(part.shape, half, bore, axis) < 0.0)
    wrong("the mouth of the bore reaches over the rim of the face", "a smaller radius or chamfer, or another position");
  const double thickness = 2.0 * half[axis], mouths = bore.chamfer * (bore.through() ? 2.0 : 1.0);
  if (!bore.through() && bore.depth >= thickness) {
    diagnostics.error(Code::kOutOfRange, at, fmt::format("a depth of {} m in {} m of material", bore.depth, thickness),
                      "Make it less, or leave the depth out: then the bore goes through");
  }
  if (mouths >= std::min(bore.depth, thickness)) {
    diagnostics.error(Code::kOutOfRange, at, fmt::format("the chamfer of {} m leaves no wall", bore.chamfer),
                      "Make it less than the length of the bore");
  }
}

}  // namespace

void check_solid(const ObjectGeometry& part, const std::string& at, Diagnostics& diagnostics) {
  const auto half = half_size(part.shape);
  const auto* cylinder = std::get_if<kinematics::Cylinder>(&part.shape);
  if (part.chamfer != 0.0) {
    const double most = cylinder ? std::min(cylinder->radius, 0.5 * cylinder->length) : 0.0;
    if (!(part.chamfer > 0.0 && part.chamfer < most)) {
      diagnostics.error(Code::kOutOfRange, at, fmt::format("a chamfer of {} m", part.chamfer),
                        fmt::format("Give a chamfer to cylinders only, 0 to {} m", most));
    }
  }
  if (!part.bores.empty() && !half)
    return diagnostics.error(Code::kUnsupported, at, "a bore in this shape", "Drill a box or a cylinder");
  for (std::size_t i = 0; i < part.bores.size(); ++i)
    check_bore(part, *half, part.bores[i], at + "/bores" + pointer_segment(i), diagnostics);
}

}  // namespace takt::sim
