// Family "vector": three numbers of one unit, in the axes of one frame.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/linear.h"

namespace takt::primitives::vectors {
namespace {

using net::Vector;

constexpr auto kAlike = [] {
  return ports({{"a", "u", "left side", "A"}, {"b", "u", "right side", "A"}}, {{"value", "u", "the result", "A"}});
};
constexpr auto kScale = [] {
  return ports({{"vector", "u", "value to scale", "A"}, {"factor", "v", "by how much"}},
               {{"value", "u*v", "factor * vector", "A"}});
};
constexpr auto kDot = [] {
  return ports({{"a", "u", "left side", "A"}, {"b", "v", "right side", "A"}}, {{"value", "u*v", "scalar product"}});
};
constexpr auto kCross = [] {
  return ports({{"a", "u", "left side", "A"}, {"b", "v", "right side", "A"}},
               {{"value", "u*v", "vector product", "A"}});
};
constexpr auto kNorm = [] { return ports({{"input", "u", "a vector"}}, {{"value", "u", "its length"}}); };
constexpr auto kUnit = [] {
  return ports({{"input", "u", "a vector", "A"}}, {{"value", "1", "length 1, the same direction", "A"}});
};
constexpr auto kSame = [] { return ports({{"input", "u", "a vector", "A"}}, {{"value", "u", "the result", "A"}}); };
constexpr auto kDistance = [] {
  return ports({{"a", "u", "a point", "A"}, {"b", "u", "another", "A"}}, {{"value", "u", "how far apart"}});
};
constexpr auto kAngle = [] {
  return ports({{"a", "u", "a direction", "A"}, {"b", "v", "another", "A"}}, {{"value", "rad", "in [0, pi]"}});
};
constexpr auto kAlong = [] {
  return ports({{"input", "u", "a vector", "A"}, {"direction", "v", "of any length", "A"}},
               {{"along", "u", "the part along the direction", "A"}, {"across", "u", "remainder", "A"}});
};
constexpr auto kLine = [] {
  return ports({{"a", "u", "given where share is 0", "A"},
                {"b", "u", "given where share is 1", "A"},
                {"share", "1", "any number"}},
               {{"value", "u", "a + share (b - a)", "A"}});
};
constexpr auto kLimit = [] {
  return ports({{"input", "u", "a vector", "A"}}, {{"value", "u", "no longer than allowed", "A"}},
               {{"length_max", "u", "largest length", "[0,inf)", "1.0"}});
};
constexpr auto kParts = [] {
  return ports({{"input", "u", "a vector"}},
               {{"x", "u", "first component"}, {"y", "u", "second component"}, {"z", "u", "third component"}});
};
constexpr auto kFromParts = [] {
  return ports({{"x", "u", "first component"}, {"y", "u", "second component"}, {"z", "u", "third component"}},
               {{"value", "u", "the vector"}});
};

using AddVectors = Function<kAlike, [](const Vector& a, const Vector& b) -> Vector { return a + b; }>;
using SubtractVectors = Function<kAlike, [](const Vector& a, const Vector& b) -> Vector { return a - b; }>;
using ScaleVector = Function<kScale, [](const Vector& a, double k) -> Vector { return k * a; }>;
using DotProduct = Function<kDot, [](const Vector& a, const Vector& b) -> double { return a.dot(b); }>;
using CrossProduct = Function<kCross, [](const Vector& a, const Vector& b) -> Vector { return a.cross(b); }>;
using Norm = Function<kNorm, [](const Vector& v) -> double { return v.norm(); }>;
using NegateVector = Function<kSame, [](const Vector& v) -> Vector { return -v; }>;
using Normalize = Function<kUnit, [](const Vector& v) -> std::optional<Vector> {
  const double length = v.stableNorm();
  if (!(length >= std::numeric_limits<double>::min())) return std::nullopt;
  return Vector((v / length).normalized());
}>;
using Distance = Function<kDistance, [](const Vector& a, const Vector& b) -> double { return (b - a).norm(); }>;
using AngleBetween = Function<kAngle, [](const Vector& a, const Vector& b) -> std::optional<double> {
  if (a.isZero(0.0) || b.isZero(0.0)) return std::nullopt;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}>;
using SplitVector = Function<kAlong, [](const Vector& v, const Vector& d) -> std::optional<std::tuple<Vector, Vector>> {
  const double square = d.squaredNorm();
  if (!(square > 0.0)) return std::nullopt;
  const Vector along = (v.dot(d) / square) * d;
  return std::tuple(along, Vector(v - along));
}>;
using InterpolateVectors = Function<kLine, [](const Vector& a, const Vector& b, double share) {
  return share == 1.0 ? b : toward(a, b, share);
}>;
using LimitVector = Function<kLimit, [](const Vector& v, double length_max) -> Vector {
  const double length = v.norm();
  return length <= length_max ? v : Vector((length_max / length) * v);
}>;
using VectorComponents = Function<kParts, [](const Vector& v) { return std::tuple(v.x(), v.y(), v.z()); }>;
using AssembleVector = Function<kFromParts, [](double x, double y, double z) { return Vector(x, y, z); }>;

TAKT_PRIMITIVE(AddVectors, "vector", "a + b.");
TAKT_PRIMITIVE(SubtractVectors, "vector", "a - b.");
TAKT_PRIMITIVE(ScaleVector, "vector", "factor * vector.");
TAKT_PRIMITIVE(DotProduct, "vector", "Scalar product of two vectors.");
TAKT_PRIMITIVE(CrossProduct, "vector", "Vector product of two vectors.");
TAKT_PRIMITIVE(Norm, "vector", "Length of a vector.");
TAKT_PRIMITIVE(NegateVector, "vector", "-input.");
TAKT_PRIMITIVE(Normalize, "vector", "The direction of a vector. Null of a vector without length.");
TAKT_PRIMITIVE(Distance, "vector", "|b - a|.");
TAKT_PRIMITIVE(AngleBetween, "vector", "The angle between two directions. Null where one has no length.");
TAKT_PRIMITIVE(SplitVector, "vector",
               "A vector as the sum of a part along a direction and one across it. Null where the direction has no "
               "length.");
TAKT_PRIMITIVE(InterpolateVectors, "vector", "On the line through a and b: a at share 0, b at share 1; also beyond.");
TAKT_PRIMITIVE(LimitVector, "vector", "The same direction, but no longer than allowed.");
TAKT_PRIMITIVE(VectorComponents, "vector", "The three numbers of a vector.");
TAKT_PRIMITIVE(AssembleVector, "vector", "A vector from three numbers.");

}  // namespace
}  // namespace takt::primitives::vectors
