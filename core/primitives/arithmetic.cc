// Family "arithmetic": real numbers with units.
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

/// value = f(a, b); null if one is null.
class OfTwo : public Primitive {
 protected:
  struct Units {
    const char *a, *b, *value;
    bool may_be_null = false;
  };
  OfTwo(Setup& setup, const Units& units)
      : a_(setup.in<Real>("a", {.unit = units.a, .doc = "left side"})),
        b_(setup.in<Real>("b", {.unit = units.b, .doc = "right side"})),
        value_(setup.out<Real>("value", {.unit = units.value, .doc = "the result", .may_be_null = units.may_be_null})) {
  }
  virtual double result(double a, double b) const = 0;

 public:
  void update(const Cycle&) final {
    if (a_.null() || b_.null()) return value_.set_null();
    value_.set(result(*a_, *b_));
  }

 private:
  In<Real> a_, b_;
  Out<Real> value_;
};

/// value = f(input); null of null.
class OfOne : public Primitive {
 protected:
  explicit OfOne(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "the argument"})),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "the result"})) {}
  virtual double result(double x) const = 0;

 public:
  void update(const Cycle&) final {
    if (input_.null()) return value_.set_null();
    value_.set(result(*input_));
  }

 private:
  In<Real> input_;
  Out<Real> value_;
};

class Add final : public OfTwo {
 public:
  explicit Add(Setup& setup) : OfTwo(setup, {"u", "u", "u"}) {}
  double result(double a, double b) const override { return a + b; }
};

class Subtract final : public OfTwo {
 public:
  explicit Subtract(Setup& setup) : OfTwo(setup, {"u", "u", "u"}) {}
  double result(double a, double b) const override { return a - b; }
};

class Multiply final : public OfTwo {
 public:
  explicit Multiply(Setup& setup) : OfTwo(setup, {"u", "v", "u*v"}) {}
  double result(double a, double b) const override { return a * b; }
};

class Divide final : public OfTwo {
 public:
  explicit Divide(Setup& setup) : OfTwo(setup, {"u", "v", "u/v", true}) {}
  double result(double a, double b) const override { return a / b; }
};

class Min final : public OfTwo {
 public:
  explicit Min(Setup& setup) : OfTwo(setup, {"u", "u", "u"}) {}
  double result(double a, double b) const override { return std::min(a, b); }
};

class Max final : public OfTwo {
 public:
  explicit Max(Setup& setup) : OfTwo(setup, {"u", "u", "u"}) {}
  double result(double a, double b) const override { return std::max(a, b); }
};

class Negate final : public OfOne {
 public:
  explicit Negate(Setup& setup) : OfOne(setup) {}
  double result(double x) const override { return -x; }
};

class Abs final : public OfOne {
 public:
  explicit Abs(Setup& setup) : OfOne(setup) {}
  double result(double x) const override { return std::abs(x); }
};

class Gain final : public OfOne {
 public:
  explicit Gain(Setup& setup)
      : OfOne(setup),
        factor_(setup.parameter<Real>("factor", {.unit = "1", .doc = "what the input is multiplied by"})) {}
  double result(double x) const override { return factor_ * x; }

 private:
  double factor_;
};

TAKT_PRIMITIVE(Add, "arithmetic", "a + b.");
TAKT_PRIMITIVE(Subtract, "arithmetic", "a - b.");
TAKT_PRIMITIVE(Multiply, "arithmetic", "a * b; the units multiply.");
TAKT_PRIMITIVE(Divide, "arithmetic", "a / b; the units divide. Null if b is zero.");
TAKT_PRIMITIVE(Min, "arithmetic", "The smaller of a and b.");
TAKT_PRIMITIVE(Max, "arithmetic", "The larger of a and b.");
TAKT_PRIMITIVE(Negate, "arithmetic", "-input.");
TAKT_PRIMITIVE(Abs, "arithmetic", "|input|.");
TAKT_PRIMITIVE(Gain, "arithmetic", "factor * input; the unit stays.");

}  // namespace
}  // namespace takt::primitives
