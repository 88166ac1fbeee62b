// Family "joints": arrays with one number per joint.
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/linear.h"

namespace takt::primitives::joint_arrays {
namespace {

using net::Integer;
using net::JointArray;
using MaybeJoints = std::optional<JointArray>;

constexpr auto kAlike = [] {
  return ports({{"a", "u", "left side"}, {"b", "u", "right side"}}, {{"value", "u", "the result"}});
};
constexpr auto kScale = [] {
  return ports({{"joints", "u", "value to scale"}, {"factor", "v", "by how much"}},
               {{"value", "u*v", "factor * joints"}});
};
constexpr auto kLargest = [] { return ports({{"input", "u", "an array"}}, {{"value", "u", "largest of |element|"}}); };
constexpr auto kLine = [] {
  return ports(
      {{"a", "u", "given where share is 0"}, {"b", "u", "given where share is 1"}, {"share", "1", "any number"}},
      {{"value", "u", "a + share (b - a)"}});
};
constexpr auto kElement = [] {
  return ports({{"input", "u", "an array"}, {"index", "", "which element, from 0"}}, {{"value", "u", "the element"}});
};
constexpr auto kReplace = [] {
  return ports({{"input", "u", "an array"}, {"index", "", "which element, from 0"}, {"element", "u", "its new value"}},
               {{"value", "u", "the array with it"}});
};
constexpr auto kJoin = [] {
  return ports({{"a", "u", "the first elements"}, {"b", "u", "the elements after them"}},
               {{"value", "u", "all of them"}});
};
constexpr auto kFromReal = [] { return ports({{"input", "u", "a number"}}, {{"value", "u", "an array of this one"}}); };
constexpr auto kDeadBand = [] {
  return ports({{"input", "u", "an array"}, {"width", "u", "of each element's band, >= 0"}},
               {{"value", "u", "remainder"}});
};
constexpr auto kNear = [] {
  return ports({{"a", "u", "left side"}, {"b", "u", "right side"}}, {{"value", "", "the answer"}},
               {{"tolerance", "u", "largest difference of an element", "[0,inf)", "0.01"}});
};

template <class F>
MaybeJoints of_two(const JointArray& a, const JointArray& b, F f) {
  if (!same_shape(a, b)) return std::nullopt;
  return f(a, b);
}
double largest(const JointArray& q) {
  double value = 0.0;
  for (const double x : q.value) value = std::max(value, std::abs(x));
  return value;
}
bool has(const JointArray& q, Integer index) { return index >= 0 && index < q.size; }

using AddJoints =
    Function<kAlike, [](const JointArray& a, const JointArray& b) { return of_two(a, b, plus<JointArray>); }>;
using SubtractJoints =
    Function<kAlike, [](const JointArray& a, const JointArray& b) { return of_two(a, b, minus<JointArray>); }>;
using ScaleJoints = Function<kScale, [](const JointArray& a, double k) { return times(a, k); }>;
using LargestJoint = Function<kLargest, [](const JointArray& a) { return largest(a); }>;
using InterpolateJoints = Function<kLine, [](const JointArray& a, const JointArray& b, double share) -> MaybeJoints {
  if (!same_shape(a, b)) return std::nullopt;
  return share == 1.0 ? b : toward(a, b, share);
}>;
using JointsNear = Function<kNear, [](const JointArray& a, const JointArray& b, double tolerance) {
  return same_shape(a, b) ? std::optional(largest(minus(a, b)) <= tolerance) : std::nullopt;
}>;
using DeadBandJoints = Function<kDeadBand, [](const JointArray& a, const JointArray& width) -> MaybeJoints {
  if (!same_shape(a, width)) return std::nullopt;
  JointArray rest = a;
  for (std::size_t i = 0; i < rest.value.size(); ++i) {
    if (width.value[i] < 0.0) return std::nullopt;
    const double left = std::max(0.0, std::abs(a.value[i]) - width.value[i]);
    rest.value[i] = left == 0.0 ? 0.0 : std::copysign(left, a.value[i]);
  }
  return rest;
}>;
using JointElement = Function<kElement, [](const JointArray& a, Integer index) -> std::optional<double> {
  if (!has(a, index)) return std::nullopt;
  return a.value[static_cast<std::size_t>(index)];
}>;
using ReplaceJoint = Function<kReplace, [](const JointArray& a, Integer index, double element) -> MaybeJoints {
  if (!has(a, index)) return std::nullopt;
  JointArray changed = a;
  changed.value[static_cast<std::size_t>(index)] = element;
  return changed;
}>;
using JoinJoints = Function<kJoin, [](const JointArray& a, const JointArray& b) -> MaybeJoints {
  if (net::kJointCapacity < a.size + b.size) return std::nullopt;
  JointArray all = a;
  all.size = a.size + b.size;
  std::copy_n(b.value.begin(), b.size, all.value.begin() + a.size);
  return all;
}>;
using JointsFromReal = Function<kFromReal, [](double x) {
  JointArray one;
  one.size = 1;
  one.value[0] = x;
  return one;
}>;

TAKT_PRIMITIVE(AddJoints, "joints", "a + b, element by element. Null where the numbers of elements differ.");
TAKT_PRIMITIVE(SubtractJoints, "joints", "a - b, element by element. Null where the numbers of elements differ.");
TAKT_PRIMITIVE(ScaleJoints, "joints", "factor * joints.");
TAKT_PRIMITIVE(LargestJoint, "joints", "The largest size of an element; 0 of an array without elements.");
TAKT_PRIMITIVE(
    InterpolateJoints, "joints",
    "On the line through a and b: a at share 0, b at share 1; also beyond. Null where the numbers of elements "
    "differ.");
TAKT_PRIMITIVE(JointsNear, "joints", "No element differs by more than the tolerance. Null where their numbers differ.");
TAKT_PRIMITIVE(
    DeadBandJoints, "joints",
    "Each element less the width of its band, and 0 inside of it. Null where the numbers of elements differ or "
    "a width is below 0.");
TAKT_PRIMITIVE(JointElement, "joints", "One element of an array. Null where there is none of that index.");
TAKT_PRIMITIVE(ReplaceJoint, "joints", "The array with another element. Null where there is none of that index.");
TAKT_PRIMITIVE(JoinJoints, "joints", "One array behind the other. Null where they are more than 12 together.");
TAKT_PRIMITIVE(JointsFromReal, "joints", "An array of one element; JoinJoints makes longer ones.");

}  // namespace
}  // namespace takt::primitives::joint_arrays
