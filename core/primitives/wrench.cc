// Family "wrench": force and torque about one origin, in the axes of one frame.

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/linear.h"

namespace takt::primitives::wrenches {
namespace {

using net::Frame;
using net::Twist;
using net::Vector;
using net::Wrench;

constexpr auto kAlike = [] {
  return ports({{"a", "N,N*m", "left side", "A"}, {"b", "N,N*m", "right side", "A"}},
               {{"value", "N,N*m", "the result", "A"}});
};
constexpr auto kScale = [] {
  return ports({{"wrench", "u,v", "value to scale", "A"}, {"factor", "w", "by how much"}},
               {{"value", "u*w,v*w", "factor * wrench", "A"}});
};
constexpr auto kFromParts = [] {
  return ports({{"force", "N", "force", "A"}, {"torque", "N*m", "torque", "A"}},
               {{"value", "N,N*m", "the wrench", "A"}});
};
constexpr auto kParts = [] {
  return ports({{"input", "N,N*m", "a wrench", "A"}},
               {{"force", "N", "its force", "A"}, {"torque", "N*m", "its torque", "A"}});
};
constexpr auto kTransform = [] {
  return ports({{"frame", "", "X_AB", "A>B"}, {"wrench", "N,N*m", "about the origin of B, in its axes", "B"}},
               {{"value", "N,N*m", "the same about the origin of A, in its axes", "A"}});
};
constexpr auto kPower = [] {
  return ports({{"wrench", "N,N*m", "on a body", "A"}, {"twist", "m/s,rad/s", "of the body at the same point", "A"}},
               {{"value", "W", "power of the wrench; 1 W = 1 N m/s, and rad counts as 1"}});
};
constexpr auto kDeadBand = [] {
  return ports({{"input", "N,N*m", "value to which the dead band is applied", "A"}},
               {{"value", "N,N*m", "0 inside, without a jump beside it", "A"}},
               {{"force", "N", "magnitude of the force dead band", "[0,inf)", "1.0"},
                {"torque", "N*m", "magnitude of the torque dead band", "[0,inf)", "0.1"}});
};
constexpr auto kLimit = [] {
  return ports({{"input", "N,N*m", "a wrench", "A"}},
               {{"value", "N,N*m", "within both bounds", "A"}, {"limited", "", "a part was longer"}},
               {{"force_max", "N", "largest length of the force", "[0,inf)", "50.0"},
                {"torque_max", "N*m", "largest length of the torque", "[0,inf)", "5.0"}});
};

Vector shortened(const Vector& v, double by) {
  const double length = v.norm();
  return length > by ? Vector((1.0 - by / length) * v) : Vector::Zero();
}
Vector at_most(const Vector& v, double bound) {
  const double length = v.norm();
  return length > bound ? Vector((bound / length) * v) : v;
}

using AddWrenches = Function<kAlike, [](const Wrench& a, const Wrench& b) { return plus(a, b); }>;
using SubtractWrenches = Function<kAlike, [](const Wrench& a, const Wrench& b) { return minus(a, b); }>;
using ScaleWrench = Function<kScale, [](const Wrench& a, double k) { return times(a, k); }>;
using AssembleWrench = Function<kFromParts, [](const Vector& force, const Vector& torque) {
  return Wrench{.force = force, .torque = torque};
}>;
using WrenchComponents = Function<kParts, [](const Wrench& w) { return std::tuple(w.force, w.torque); }>;
using TransformWrench = Function<kTransform, [](const Frame& X_AB, const Wrench& w) {
  const Vector force = X_AB.linear() * w.force;
  return Wrench{.force = force, .torque = X_AB.linear() * w.torque + X_AB.translation().cross(force)};
}>;
using WrenchPower =
    Function<kPower, [](const Wrench& w, const Twist& V) { return w.force.dot(V.linear) + w.torque.dot(V.angular); }>;
using DeadBandWrench = Function<kDeadBand, [](const Wrench& w, double force, double torque) {
  return Wrench{.force = shortened(w.force, force), .torque = shortened(w.torque, torque)};
}>;
using LimitWrench = Function<kLimit, [](const Wrench& w, double force_max, double torque_max) {
  const bool limited = (w.force.norm() > force_max || w.torque.norm() > torque_max);
  return std::tuple(Wrench{.force = at_most(w.force, force_max), .torque = at_most(w.torque, torque_max)}, limited);
}>;

TAKT_PRIMITIVE(AddWrenches, "wrench", "a + b, both about one origin and in the same axes.");
TAKT_PRIMITIVE(SubtractWrenches, "wrench", "a - b, both about one origin and in the same axes.");
TAKT_PRIMITIVE(ScaleWrench, "wrench", "factor * wrench.");
TAKT_PRIMITIVE(AssembleWrench, "wrench", "A wrench from force and torque.");
TAKT_PRIMITIVE(WrenchComponents, "wrench", "Force and torque of a wrench.");
TAKT_PRIMITIVE(TransformWrench, "wrench", "A wrench about another origin and in other axes (adjoint).");
TAKT_PRIMITIVE(WrenchPower, "wrench", "Power that a wrench brings into a body that moves.");
TAKT_PRIMITIVE(DeadBandWrench, "wrench",
               "Force and torque shortened by some length each, and 0 where they are shorter: the noise of a sensor at "
               "rest moves nothing.");
TAKT_PRIMITIVE(LimitWrench, "wrench", "Force and torque with their directions, but neither longer than allowed.");

}  // namespace
}  // namespace takt::primitives::wrenches
