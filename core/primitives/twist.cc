// Family "twist": velocities of frames, linear first; also accelerations and small displacements, as the unit says.
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/linear.h"

namespace takt::primitives::twists {
namespace {

using net::Frame;
using net::Twist;
using net::Vector;

constexpr auto kAlike = [] {
  return ports({{"a", "u,v", "left side", "A"}, {"b", "u,v", "right side", "A"}},
               {{"value", "u,v", "the result", "A"}});
};
constexpr auto kScale = [] {
  return ports({{"twist", "u,v", "value to scale", "A"}, {"factor", "w", "by how much"}},
               {{"value", "u*w,v*w", "factor * twist", "A"}});
};
constexpr auto kFromParts = [] {
  return ports({{"linear", "u", "velocity of the origin", "A"}, {"angular", "v", "angular velocity", "A"}},
               {{"value", "u,v", "the twist", "A"}});
};
constexpr auto kParts = [] {
  return ports({{"input", "u,v", "a twist", "A"}},
               {{"linear", "u", "velocity of the origin", "A"}, {"angular", "v", "angular velocity", "A"}});
};
constexpr auto kRotate = [] {
  return ports({{"frame", "", "X_AB", "A>B"}, {"twist", "u,v", "in the axes of B", "B"}},
               {{"value", "u,v", "the same in the axes of A", "A"}});
};
constexpr auto kTransform = [] {
  return ports({{"frame", "", "X_AB, both fixed to one body", "A>B"},
                {"twist", "m/s,rad/s", "of the body at the origin of B, in the axes of B", "B"}},
               {{"value", "m/s,rad/s", "of the body at the origin of A, in the axes of A", "A"}});
};
constexpr auto kShift = [] {
  return ports({{"twist", "m/s,rad/s", "of a body at a point P of it", "A"},
                {"point", "m", "from P to the point Q of the body", "A"}},
               {{"value", "m/s,rad/s", "of the body at Q, in the same axes", "A"}});
};
constexpr auto kLimit = [] {
  return ports({{"input", "u,v", "a twist", "A"}},
               {{"value", "u,v", "within both bounds, in the same proportion", "A"}},
               {{"linear_max", "u", "largest linear length", "[0,inf)", "0.25"},
                {"angular_max", "v", "largest angular length", "[0,inf)", "0.5"}});
};

constexpr auto kCorrect = [] {
  return ports({{"base", "u,v", "a twist that is kept", "A"}, {"correction", "u,v", "what is added to it", "A"}},
               {{"value", "u,v", "the sum, within both bounds", "A"}},
               {{"linear_max", "u", "largest linear length", "[0,inf)", "0.25"},
                {"angular_max", "v", "largest angular length", "[0,inf)", "0.5"}});
};

/// The largest share of a length that a bound allows.
double allowed(double length, double bound) { return length > bound ? bound / length : 1.0; }

/// base + share * correction with the largest share up to 1 that the bound allows; a base beyond it is shortened.
Vector corrected(const Vector& base, const Vector& correction, double bound) {
  const double room = bound * bound - base.squaredNorm();
  if (room <= 0.0) return base * allowed(base.norm(), bound);
  const double along = base.dot(correction), length = correction.squaredNorm();
  if (!(length > 0.0) || (base + correction).squaredNorm() <= bound * bound) return base + correction;
  return base + (std::sqrt(along * along + length * room) - along) / length * correction;
}

using AddTwists = Function<kAlike, [](const Twist& a, const Twist& b) { return plus(a, b); }>;
using SubtractTwists = Function<kAlike, [](const Twist& a, const Twist& b) { return minus(a, b); }>;
using ScaleTwist = Function<kScale, [](const Twist& a, double k) { return times(a, k); }>;
using AssembleTwist = Function<kFromParts, [](const Vector& linear, const Vector& angular) {
  return Twist{.linear = linear, .angular = angular};
}>;
using TwistComponents = Function<kParts, [](const Twist& V) { return std::tuple(V.linear, V.angular); }>;
using RotateTwist = Function<kRotate, [](const Frame& X_AB, const Twist& V) {
  return Twist{.linear = X_AB.linear() * V.linear, .angular = X_AB.linear() * V.angular};
}>;
using TransformTwist = Function<kTransform, [](const Frame& X_AB, const Twist& V_B) {
  const Vector angular = X_AB.linear() * V_B.angular;
  return Twist{.linear = X_AB.linear() * V_B.linear + X_AB.translation().cross(angular), .angular = angular};
}>;
using ShiftTwist = Function<kShift, [](const Twist& V, const Vector& p_PQ) {
  return Twist{.linear = V.linear + V.angular.cross(p_PQ), .angular = V.angular};
}>;
using LimitTwist = Function<kLimit, [](const Twist& V, double linear_max, double angular_max) {
  return times(V, std::min(allowed(V.linear.norm(), linear_max), allowed(V.angular.norm(), angular_max)));
}>;
using CorrectTwist =
    Function<kCorrect, [](const Twist& base, const Twist& correction, double linear_max, double angular_max) {
      return Twist{.linear = corrected(base.linear, correction.linear, linear_max),
                   .angular = corrected(base.angular, correction.angular, angular_max)};
    }>;

TAKT_PRIMITIVE(AddTwists, "twist", "a + b, both at one point and in the same axes.");
TAKT_PRIMITIVE(SubtractTwists, "twist", "a - b, both at one point and in the same axes.");
TAKT_PRIMITIVE(ScaleTwist, "twist", "factor * twist; a difference of poses times 1/s is a twist.");
TAKT_PRIMITIVE(AssembleTwist, "twist", "A twist from linear and angular velocity.");
TAKT_PRIMITIVE(TwistComponents, "twist", "Linear and angular velocity of a twist.");
TAKT_PRIMITIVE(RotateTwist, "twist", "A twist in other axes, at the same point.");
TAKT_PRIMITIVE(TransformTwist, "twist", "The velocity of a body at another point and in other axes (adjoint).");
TAKT_PRIMITIVE(ShiftTwist, "twist", "The velocity of a body at another point of it, in the same axes.");
TAKT_PRIMITIVE(CorrectTwist, "twist",
               "base + correction, both at one point and in the same axes. Of each part only the correction is "
               "shortened so that the sum is not longer than allowed; a base that is itself longer is shortened and "
               "not corrected.");
TAKT_PRIMITIVE(LimitTwist, "twist", "The same direction of both parts, but neither longer than allowed.");

}  // namespace
}  // namespace takt::primitives::twists
