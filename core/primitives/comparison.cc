// Family "comparison": numbers of one unit, whole numbers or texts to a Boolean.
#include <cmath>

#include "core/net/registry.h"
#include "core/primitives/function.h"

namespace takt::primitives {
namespace {

using net::Integer;
using net::Text;

constexpr auto kTwo = [] {
  return ports({{"a", "u", "left side"}, {"b", "u", "right side"}}, {{"value", "", "the answer"}});
};
constexpr auto kTwoPlain = [] {
  return ports({{"a", "", "left side"}, {"b", "", "right side"}}, {{"value", "", "the answer"}});
};
constexpr auto kTolerance = [] {
  return ports({{"a", "u", "left side"}, {"b", "u", "right side"}}, {{"value", "", "the answer"}},
               {{"tolerance", "u", "largest difference that counts as equal", "[0,inf)", "", 0.0}});
};
constexpr auto kRange = [] {
  return ports({{"input", "u", "value to compare"},
                {"lower", "u", "smallest value inside"},
                {"upper", "u", "largest value inside"}},
               {{"value", "", "lower <= input <= upper"}});
};

using GreaterThan = Function<kTwo, [](double a, double b) { return (a > b); }>;
using LessThan = Function<kTwo, [](double a, double b) { return a < b; }>;
using AtLeast = Function<kTwo, [](double a, double b) { return (a >= b); }>;
using AtMost = Function<kTwo, [](double a, double b) { return a <= b; }>;
using Equal = Function<kTolerance, [](double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }>;
using InRange = Function<kRange, [](double x, double lower, double upper) { return lower <= x && x <= upper; }>;
using GreaterThanInteger = Function<kTwoPlain, [](Integer a, Integer b) { return (a > b); }>;
using LessThanInteger = Function<kTwoPlain, [](Integer a, Integer b) { return a < b; }>;
using EqualIntegers = Function<kTwoPlain, [](Integer a, Integer b) { return a == b; }>;
using EqualStrings = Function<kTwoPlain, [](const Text& a, const Text& b) { return a.view() == b.view(); }>;

TAKT_PRIMITIVE(GreaterThan, "comparison", "a > b.");
TAKT_PRIMITIVE(LessThan, "comparison", "a < b.");
TAKT_PRIMITIVE(AtLeast, "comparison", "a >= b.");
TAKT_PRIMITIVE(AtMost, "comparison", "a <= b.");
TAKT_PRIMITIVE(Equal, "comparison", "|a - b| <= tolerance.");
TAKT_PRIMITIVE(InRange, "comparison", "lower <= input <= upper.");
TAKT_PRIMITIVE(GreaterThanInteger, "comparison", "a > b.");
TAKT_PRIMITIVE(LessThanInteger, "comparison", "a < b.");
TAKT_PRIMITIVE(EqualIntegers, "comparison", "a = b.");
TAKT_PRIMITIVE(EqualStrings, "comparison", "Both texts have the same bytes.");

TAKT_MEANING(GreaterThan, "value", "b < a");
TAKT_MEANING(LessThan, "value", "a < b");
TAKT_MEANING(AtLeast, "value", "b <= a");
TAKT_MEANING(AtMost, "value", "a <= b");
TAKT_MEANING(InRange, "value", "lower <= input & input <= upper");
TAKT_MEANING(GreaterThanInteger, "value", "b < a");
TAKT_MEANING(LessThanInteger, "value", "a < b");
TAKT_MEANING(EqualIntegers, "value", "a = b");

}  // namespace
}  // namespace takt::primitives
