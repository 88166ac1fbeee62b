// Family "rotation": axes of one frame in another. R_AB has the axes of B, seen from A.
#include <cmath>

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/rotation.h"

namespace takt::primitives::rotations {
namespace {

using net::Rotation;
using net::Vector;

constexpr auto kCompose = [] {
  return ports({{"left", "", "R_AB", "A>B"}, {"right", "", "R_BC", "B>C"}}, {{"value", "", "R_AC = R_AB R_BC", "A>C"}});
};
constexpr auto kInverse = [] { return ports({{"input", "", "R_AB", "A>B"}}, {{"value", "", "R_BA", "B>A"}}); };
constexpr auto kRotate = [] {
  return ports({{"rotation", "", "R_AB", "A>B"}, {"vector", "u", "a vector in the axes of B", "B"}},
               {{"value", "u", "the same in the axes of A", "A"}});
};
constexpr auto kLog = [] {
  return ports({{"input", "", "R_AB", "A>B"}}, {{"value", "rad", "axis times angle in [0, pi]", "A"}});
};
constexpr auto kExp = [] {
  return ports({{"input", "rad", "axis times angle", "A"}}, {{"value", "", "the rotation", "A>B"}});
};
constexpr auto kAngle = [] {
  return ports({{"a", "", "a rotation", "A>B"}, {"b", "", "another", "A>B"}}, {{"value", "rad", "in [0, pi]"}});
};
constexpr auto kSlerp = [] {
  return ports({{"a", "", "given where share is 0", "A>B"},
                {"b", "", "given where share is 1", "A>B"},
                {"share", "1", "any number"}},
               {{"value", "", "between the two", "A>B"}});
};
constexpr auto kFromRpy = [] {
  return ports({{"roll", "rad", "about x, first"}, {"pitch", "rad", "about y"}, {"yaw", "rad", "about z, last"}},
               {{"value", "", "the rotation"}});
};
constexpr auto kToRpy = [] {
  return ports({{"input", "", "a rotation"}}, {{"roll", "rad", "about x, first, in [-pi, pi]"},
                                               {"pitch", "rad", "about y, in [-pi/2, pi/2]"},
                                               {"yaw", "rad", "about z, last, in [-pi, pi]"}});
};
constexpr auto kFromAxis = [] {
  return ports({{"axis", "u", "of any length"}, {"angle", "rad", "about it"}}, {{"value", "", "the rotation"}});
};
constexpr auto kParts = [] {
  return ports({{"input", "", "a rotation"}},
               {{"w", "1", "real part, >= 0"}, {"x", "1", "of i"}, {"y", "1", "of j"}, {"z", "1", "of k"}});
};
constexpr auto kFromParts = [] {
  return ports({{"w", "1", "real part"}, {"x", "1", "of i"}, {"y", "1", "of j"}, {"z", "1", "of k"}},
               {{"value", "", "the rotation"}});
};
constexpr auto kTurn = [] {
  return ports({{"from", "u", "a direction", "A"}, {"to", "v", "another", "A"}},
               {{"value", "", "turns the first into the second"}});
};

using ComposeRotations =
    Function<kCompose, [](const Rotation& R_AB, const Rotation& R_BC) { return Rotation(R_AB * R_BC).normalized(); }>;
using InverseRotation = Function<kInverse, [](const Rotation& R_AB) -> Rotation { return R_AB.conjugate(); }>;
using Rotate = Function<kRotate, [](const Rotation& R_AB, const Vector& v_B) -> Vector { return R_AB * v_B; }>;
using RotationVector = Function<kLog, [](const Rotation& R) { return rotation_log(R); }>;
using RotationFromVector = Function<kExp, [](const Vector& v) -> std::optional<Rotation> {
  if (!std::isfinite(v.norm())) return std::nullopt;
  return rotation_exp(v);
}>;
using RotationAngle = Function<kAngle, [](const Rotation& a, const Rotation& b) -> double {
  return rotation_log(a.conjugate() * b).norm();
}>;
using Slerp = Function<kSlerp, [](const Rotation& a, const Rotation& b, double share) -> std::optional<Rotation> {
  if (share == 1.0) return b;
  const Vector way = share * rotation_log(a.conjugate() * b);
  if (!std::isfinite(way.norm())) return std::nullopt;
  return Rotation(a * rotation_exp(way)).normalized();
}>;
using RotationFromRpy = Function<kFromRpy, [](double roll, double pitch, double yaw) -> Rotation {
  using Axis = Eigen::AngleAxisd;
  return Axis(yaw, Vector::UnitZ()) * Axis(pitch, Vector::UnitY()) * Axis(roll, Vector::UnitX());
}>;
using RotationToRpy = Function<kToRpy, [](const Rotation& rotation) {
  const Eigen::Matrix3d R = rotation.toRotationMatrix();
  const double cosine = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), cosine);
  // Looking straight up or down, roll and yaw turn about one axis: yaw is then 0.
  if (cosine < 1e-9) return std::tuple(std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0);
  return std::tuple(std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0)));
}>;
using RotationFromAxis = Function<kFromAxis, [](const Vector& axis, double angle) -> std::optional<Rotation> {
  const double length = axis.stableNorm();
  if (!(length > 0.0 && std::isfinite(length))) return std::nullopt;
  return Rotation(Eigen::AngleAxisd(angle, (axis / length).normalized()));
}>;
using RotationComponents = Function<kParts, [](const Rotation& R) {
  const double sign = R.w() < 0.0 ? -1.0 : 1.0;
  return std::tuple(sign * R.w(), sign * R.x(), sign * R.y(), sign * R.z());
}>;
using AssembleRotation = Function<kFromParts, [](double w, double x, double y, double z) -> std::optional<Rotation> {
  const Rotation R(w, x, y, z);
  const double length = R.coeffs().stableNorm();
  if (!(length > 0.0 && std::isfinite(length))) return std::nullopt;
  return Rotation(R.coeffs() / length).normalized();
}>;
using RotationBetween = Function<kTurn, [](const Vector& from, const Vector& to) -> std::optional<Rotation> {
  if (!(from.stableNorm() > 0.0 && to.stableNorm() > 0.0)) return std::nullopt;
  return Rotation::FromTwoVectors(from.stableNormalized(), to.stableNormalized());
}>;

TAKT_PRIMITIVE(ComposeRotations, "rotation", "Two rotations one after the other: R_AC = R_AB R_BC.");
TAKT_PRIMITIVE(InverseRotation, "rotation", "The inverse rotation.");
TAKT_PRIMITIVE(Rotate, "rotation", "A free vector in other axes.");
TAKT_PRIMITIVE(RotationVector, "rotation", "Axis times angle of a rotation (logarithm).");
TAKT_PRIMITIVE(RotationFromVector, "rotation",
               "The rotation about a vector by its length (exponential). Null where the length is beyond all numbers.");
TAKT_PRIMITIVE(RotationAngle, "rotation", "By how much two rotations differ.");
TAKT_PRIMITIVE(
    Slerp, "rotation",
    "Along the shortest rotation from a to b at constant angular velocity: a at share 0, b at share 1; also beyond. "
    "Null where share times angle is too large for a number.");
TAKT_PRIMITIVE(RotationFromRpy, "rotation", "Rz(yaw) Ry(pitch) Rx(roll): about fixed axes x, y, z, as in URDF.");
TAKT_PRIMITIVE(RotationToRpy, "rotation",
               "Roll, pitch and yaw of a rotation. Where pitch is a right angle only roll and yaw together are known: "
               "yaw is then 0.");
TAKT_PRIMITIVE(RotationFromAxis, "rotation", "A rotation about an axis. Null where the axis has no length.");
TAKT_PRIMITIVE(RotationComponents, "rotation", "The unit quaternion of a rotation.");
TAKT_PRIMITIVE(AssembleRotation, "rotation",
               "A rotation from a quaternion, which is brought to length 1. Null where it has no length.");
TAKT_PRIMITIVE(RotationBetween, "rotation",
               "The smallest rotation that turns one direction into another. Null where one has no length.");

}  // namespace
}  // namespace takt::primitives::rotations
