// Arithmetic over Real. Null in, null out; a result that is not finite becomes null (rows N1, N5).
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using net::Cycle;
using net::In;
using net::Out;
using net::Real;
using net::Setup;

class Add final : public net::Primitive {
 public:
  explicit Add(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        sum_(s.out<Real>("sum", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return sum_.set_null();
    sum_.set(*a_ + *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> sum_;
};
TAKT_PRIMITIVE(Add, "arithmetic", "Sum of two values of one unit.");

class Subtract final : public net::Primitive {
 public:
  explicit Subtract(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        difference_(s.out<Real>("difference", {.unit = "u", .doc = "a - b"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return difference_.set_null();
    difference_.set(*a_ - *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> difference_;
};
TAKT_PRIMITIVE(Subtract, "arithmetic", "Difference of two values of one unit.");

class Multiply final : public net::Primitive {
 public:
  explicit Multiply(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "v"})),
        product_(s.out<Real>("product", {.unit = "u*v"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return product_.set_null();
    product_.set(*a_ * *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> product_;
};
TAKT_PRIMITIVE(Multiply, "arithmetic", "Product of two values; units multiply.");

class Divide final : public net::Primitive {
 public:
  explicit Divide(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "v"})),
        quotient_(s.out<Real>("quotient", {.unit = "u/v", .doc = "a / b; null where b is 0", .may_be_null = true})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null() || *b_ == 0.0) return quotient_.set_null();
    quotient_.set(*a_ / *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> quotient_;
};
TAKT_PRIMITIVE(Divide, "arithmetic", "Quotient of two values; units divide. Division by zero gives null.");

class Gain final : public net::Primitive {
 public:
  explicit Gain(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        scaled_(s.out<Real>("scaled", {.unit = "u", .doc = "gain * value"})),
        gain_(s.parameter<Real>("gain", {.doc = "factor, without unit"})) {}
  void update(const Cycle&) override {
    if (value_.null()) return scaled_.set_null();
    scaled_.set(gain_ * *value_);
  }

 private:
  In<Real> value_;
  Out<Real> scaled_;
  Real gain_;
};
TAKT_PRIMITIVE(Gain, "arithmetic", "Value times a constant factor.");

class Negate final : public net::Primitive {
 public:
  explicit Negate(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})), negated_(s.out<Real>("negated", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (value_.null()) return negated_.set_null();
    negated_.set(-*value_);
  }

 private:
  In<Real> value_;
  Out<Real> negated_;
};
TAKT_PRIMITIVE(Negate, "arithmetic", "Value with the opposite sign.");

class AbsoluteValue final : public net::Primitive {
 public:
  explicit AbsoluteValue(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})), magnitude_(s.out<Real>("magnitude", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (value_.null()) return magnitude_.set_null();
    magnitude_.set(std::abs(*value_));
  }

 private:
  In<Real> value_;
  Out<Real> magnitude_;
};
TAKT_PRIMITIVE(AbsoluteValue, "arithmetic", "Magnitude of a value.");

class Minimum final : public net::Primitive {
 public:
  explicit Minimum(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        least_(s.out<Real>("least", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return least_.set_null();
    least_.set(std::min(*a_, *b_));
  }

 private:
  In<Real> a_, b_;
  Out<Real> least_;
};
TAKT_PRIMITIVE(Minimum, "arithmetic", "The smaller of two values.");

class Maximum final : public net::Primitive {
 public:
  explicit Maximum(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        greatest_(s.out<Real>("greatest", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return greatest_.set_null();
    greatest_.set(std::max(*a_, *b_));
  }

 private:
  In<Real> a_, b_;
  Out<Real> greatest_;
};
TAKT_PRIMITIVE(Maximum, "arithmetic", "The greater of two values.");

class Constant final : public net::Primitive {
 public:
  explicit Constant(Setup& s)
      : value_(s.out<Real>("value", {.unit = "u"})), constant_(s.parameter<Real>("constant", {.unit = "u"})) {}
  void update(const Cycle&) override { value_.set(constant_); }

 private:
  Out<Real> value_;
  Real constant_;
};
TAKT_PRIMITIVE(Constant, "arithmetic", "A value that never changes. Inputs take constants as parameters too.");

}  // namespace
}  // namespace takt::primitives
