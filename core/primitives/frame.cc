// Family "frame": poses. X_AB is the pose of B in A.
#include <cmath>

#include "core/kinematics/pose_error.h"
#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/linear.h"
#include "core/primitives/rotation.h"

namespace takt::primitives::frames {
namespace {

using net::Frame;
using net::Rotation;
using net::Twist;
using net::Vector;

constexpr auto kCompose = [] {
  return ports({{"left", "", "X_AB", "A>B"}, {"right", "", "X_BC", "B>C"}}, {{"value", "", "X_AC = X_AB X_BC", "A>C"}});
};
constexpr auto kInverse = [] { return ports({{"input", "", "X_AB", "A>B"}}, {{"value", "", "X_BA", "B>A"}}); };
constexpr auto kRelative = [] {
  return ports({{"from", "", "X_WA", "W>A"}, {"to", "", "X_WB", "W>B"}}, {{"value", "", "X_AB", "A>B"}});
};
constexpr auto kPoint = [] {
  return ports({{"frame", "", "X_AB", "A>B"}, {"point", "m", "a point seen from B", "B"}},
               {{"value", "m", "the same point seen from A", "A"}});
};
constexpr auto kRotate = [] {
  return ports({{"frame", "", "X_AB", "A>B"}, {"vector", "u", "a vector in the axes of B", "B"}},
               {{"value", "u", "the same in the axes of A", "A"}});
};
constexpr auto kFromParts = [] {
  return ports({{"position", "m", "origin", "A"}, {"rotation", "", "axes", "A>B"}},
               {{"value", "", "the frame", "A>B"}});
};
constexpr auto kParts = [] {
  return ports({{"input", "", "a frame", "A>B"}},
               {{"position", "m", "its origin", "A"}, {"rotation", "", "its axes, w >= 0", "A>B"}});
};
constexpr auto kError = [] {
  return ports(
      {{"from", "", "X_AB as it is", "A>B"}, {"to", "", "X_AB as it should be", "A>B"}},
      {{"value", "m,rad", "displacement of the origin, then axis times angle in [0, pi], in the axes of A", "A"}});
};
constexpr auto kDisplace = [] {
  return ports(
      {{"frame", "", "X_AB", "A>B"}, {"displacement", "m,rad", "displacement, then axis times angle, in A", "A"}},
      {{"value", "", "the frame, moved", "A>B"}});
};
constexpr auto kDistance = [] {
  return ports({{"a", "", "a frame", "A>B"}, {"b", "", "another", "A>B"}},
               {{"distance", "m", "of the origins"}, {"angle", "rad", "between the axes, in [0, pi]"}});
};
constexpr auto kNear = [] {
  return ports({{"a", "", "a frame", "A>B"}, {"b", "", "another", "A>B"}}, {{"value", "", "the answer"}},
               {{"distance_max", "m", "of the origins", "[0,inf)", "0.001"},
                {"angle_max", "rad", "between the axes", "[0,inf)", "0.01"}});
};
constexpr auto kLine = [] {
  return ports({{"a", "", "given where share is 0", "A>B"},
                {"b", "", "given where share is 1", "A>B"},
                {"share", "1", "any number"}},
               {{"value", "", "between the two", "A>B"}});
};

using Compose = Function<kCompose, [](const Frame& X_AB, const Frame& X_BC) { return X_AB * X_BC; }>;
using Inverse = Function<kInverse, [](const Frame& X_AB) { return X_AB.inverse(); }>;
using RelativeFrame = Function<kRelative, [](const Frame& X_WA, const Frame& X_WB) { return X_WA.inverse() * X_WB; }>;
using TransformPoint = Function<kPoint, [](const Frame& X_AB, const Vector& p_B) -> Vector { return X_AB * p_B; }>;
using RotateVector =
    Function<kRotate, [](const Frame& X_AB, const Vector& v_B) -> Vector { return X_AB.linear() * v_B; }>;
using AssembleFrame = Function<kFromParts, [](const Vector& p, const Rotation& R) { return make_frame(R, p); }>;
using FrameComponents =
    Function<kParts, [](const Frame& X) { return std::tuple(Vector(X.translation()), rotation_of(X)); }>;
using FrameDifference = Function<kError, [](const Frame& from, const Frame& to) {
  const kinematics::Vector6 error = kinematics::pose_error(from, to);
  return Twist{.linear = error.head<3>(), .angular = error.tail<3>()};
}>;
using DisplaceFrame = Function<kDisplace, [](const Frame& X, const Twist& way) -> std::optional<Frame> {
  if (!std::isfinite(way.angular.norm())) return std::nullopt;
  return make_frame(rotation_exp(way.angular) * rotation_of(X), X.translation() + way.linear);
}>;
using FrameDistance = Function<kDistance, [](const Frame& a, const Frame& b) {
  const kinematics::Vector6 error = kinematics::pose_error(a, b);
  return std::tuple(error.head<3>().norm(), error.tail<3>().norm());
}>;
using FramesNear = Function<kNear, [](const Frame& a, const Frame& b, double distance_max, double angle_max) {
  const kinematics::Vector6 error = kinematics::pose_error(a, b);
  return error.head<3>().norm() <= distance_max && error.tail<3>().norm() <= angle_max;
}>;
using InterpolateFrames = Function<kLine, [](const Frame& a, const Frame& b, double share) -> std::optional<Frame> {
  if (share == 1.0) return b;
  const kinematics::Vector6 way = share * kinematics::pose_error(a, b);
  if (!std::isfinite(way.norm())) return std::nullopt;
  return make_frame(rotation_exp(way.tail<3>()) * rotation_of(a), a.translation() + way.head<3>());
}>;

TAKT_PRIMITIVE(Compose, "frame", "Two poses one after the other: X_AC = X_AB X_BC.");
TAKT_PRIMITIVE(Inverse, "frame", "The inverse pose: X_BA from X_AB.");
TAKT_PRIMITIVE(RelativeFrame, "frame", "Pose of one frame in another: X_AB from X_WA and X_WB.");
TAKT_PRIMITIVE(TransformPoint, "frame", "A point seen from another frame.");
TAKT_PRIMITIVE(RotateVector, "frame", "A free vector in the axes of another frame.");
TAKT_PRIMITIVE(AssembleFrame, "frame", "A frame from origin and axes.");
TAKT_PRIMITIVE(FrameComponents, "frame", "Origin and axes of a frame.");
TAKT_PRIMITIVE(FrameDifference, "frame",
               "The difference of two poses: the displacement of the origin, and the rotation vector (logarithm).");
TAKT_PRIMITIVE(DisplaceFrame, "frame",
               "A pose moved by a difference: the origin by a displacement, the axes about their origin (exponential). "
               "Null where the angle is too large for a number.");
TAKT_PRIMITIVE(FrameDistance, "frame", "How far apart two poses are, and by what angle they differ.");
TAKT_PRIMITIVE(FramesNear, "frame", "Two poses differ by no more than a distance and an angle.");
TAKT_PRIMITIVE(InterpolateFrames, "frame",
               "The origin on a straight line, the axes about one fixed axis at constant speed: a at share 0, b at "
               "share 1; also beyond. Null where that is beyond all numbers.");

}  // namespace
}  // namespace takt::primitives::frames
