// Family "logic": three-valued, as Kleene's strong logic (row N2).
#include <array>
#include <optional>

#include "core/net/registry.h"
#include "core/primitives/function.h"

namespace takt::primitives::booleans {
namespace {

using namespace net;

/// true, false or null.
using Truth = std::optional<bool>;

Truth truth(const In<Boolean>& in) { return in.null() ? std::nullopt : Truth(*in); }

/// value = rule(a, b) for a rule that knows what to make of null.
template <auto rule>
class Connective final : public Primitive {
 public:
  explicit Connective(Setup& setup)
      : a_(setup.in<Boolean>("a", {.doc = "left side", .on_null = OnNull::kMayPass})),
        b_(setup.in<Boolean>("b", {.doc = "right side", .on_null = OnNull::kMayPass})),
        value_(setup.out<Boolean>("value", {.doc = "the result"})) {}
  void update(const Cycle&) override {
    if (const Truth result = rule(truth(a_), truth(b_))) return value_.set(*result);
    value_.set_null();
  }

 private:
  In<Boolean> a_, b_;
  Out<Boolean> value_;
};

/// Null wherever one of the two that are not null could still decide it.
Truth either(Truth a, Truth b, bool decides) {
  if (a == decides || b == decides) return decides;
  return a && b ? Truth(!decides) : std::nullopt;
}

using And = Connective<[](Truth a, Truth b) { return either(a, b, false); }>;
using Or = Connective<[](Truth a, Truth b) { return either(a, b, true); }>;
using Implies = Connective<[](Truth a, Truth b) { return either(a ? Truth(!*a) : a, b, true); }>;

constexpr auto kTwo = [] {
  return ports({{"a", "", "left side"}, {"b", "", "right side"}}, {{"value", "", "the result"}});
};
constexpr auto kOne = [] { return ports({{"input", "", "value to negate"}}, {{"value", "", "the opposite"}}); };

using Xor = Function<kTwo, [](bool a, bool b) { return a != b; }>;
using Equivalent = Function<kTwo, [](bool a, bool b) { return a == b; }>;
using Not = Function<kOne, [](bool x) { return !x; }>;

class Majority final : public Primitive {
 public:
  explicit Majority(Setup& setup)
      : in_{setup.in<Boolean>("a", {.doc = "first voice", .on_null = OnNull::kMayPass}),
            setup.in<Boolean>("b", {.doc = "second voice", .on_null = OnNull::kMayPass}),
            setup.in<Boolean>("c", {.doc = "third voice", .on_null = OnNull::kMayPass})},
        value_(setup.out<Boolean>("value", {.doc = "what at least two say"})) {}
  void update(const Cycle&) override {
    std::array<int, 2> votes{};
    for (const In<Boolean>& in : in_)
      if (!in.null()) ++votes[*in];
    if (votes[0] < 2 && votes[1] < 2) return value_.set_null();
    value_.set(votes[1] >= 2);
  }

 private:
  std::array<In<Boolean>, 3> in_;
  Out<Boolean> value_;
};

TAKT_PRIMITIVE(And, "logic", "True if both are true; false if one is false, whatever the other; else null.");
TAKT_PRIMITIVE(Or, "logic", "True if one is true, whatever the other; false if both are false; else null.");
TAKT_PRIMITIVE(Xor, "logic", "True if exactly one is true; null if one is null.");
TAKT_PRIMITIVE(Not, "logic", "The opposite; null of null.");
TAKT_PRIMITIVE(Implies, "logic", "False if a is true and b is false; true if a is false or b is true; else null.");
TAKT_PRIMITIVE(Equivalent, "logic", "True if both are the same; null if one is null.");
TAKT_PRIMITIVE(Majority, "logic", "What at least two of three say (voting sensors); null where no two agree.");

TAKT_MEANING(And, "value", "a & b");
TAKT_MEANING(Or, "value", "a | b");
TAKT_MEANING(Xor, "value", "a ^ b");
TAKT_MEANING(Not, "value", "!input");
TAKT_MEANING(Implies, "value", "!a | b");
TAKT_MEANING(Equivalent, "value", "!(a ^ b)");
TAKT_MEANING(Majority, "value", "a & b | b & c | a & c");

}  // namespace
}  // namespace takt::primitives::booleans
