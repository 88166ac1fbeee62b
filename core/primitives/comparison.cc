// Family "comparison": real numbers of one unit to a Boolean.
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

class OfTwo : public Primitive {
 protected:
  explicit OfTwo(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u", .doc = "left side"})),
        b_(setup.in<Real>("b", {.unit = "u", .doc = "right side"})),
        value_(setup.out<Boolean>("value", {.doc = "the answer"})) {}
  virtual bool result(double a, double b) const = 0;

 public:
  void update(const Cycle&) final {
    if (a_.null() || b_.null()) return value_.set_null();
    value_.set(result(*a_, *b_));
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> value_;
};

class GreaterThan final : public OfTwo {
 public:
  explicit GreaterThan(Setup& setup) : OfTwo(setup) {}
  bool result(double a, double b) const override { return a > b; }
};

class LessThan final : public OfTwo {
 public:
  explicit LessThan(Setup& setup) : OfTwo(setup) {}
  bool result(double a, double b) const override { return a < b; }
};

class Equal final : public OfTwo {
 public:
  explicit Equal(Setup& setup)
      : OfTwo(setup),
        tolerance_(setup.parameter<Real>(
            "tolerance", 0.0, {.unit = "u", .doc = "largest difference that counts as equal", .range = "[0,inf)"})) {}
  bool result(double a, double b) const override { return std::abs(a - b) <= tolerance_; }

 private:
  double tolerance_;
};

class InRange final : public Primitive {
 public:
  explicit InRange(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "what is compared"})),
        lower_(setup.in<Real>("lower", {.unit = "u", .doc = "smallest value inside"})),
        upper_(setup.in<Real>("upper", {.unit = "u", .doc = "largest value inside"})),
        value_(setup.out<Boolean>("value", {.doc = "lower <= input <= upper"})) {}
  void update(const Cycle&) override {
    if (input_.null() || lower_.null() || upper_.null()) return value_.set_null();
    value_.set(*lower_ <= *input_ && *input_ <= *upper_);
  }

 private:
  In<Real> input_, lower_, upper_;
  Out<Boolean> value_;
};

TAKT_PRIMITIVE(GreaterThan, "comparison", "a > b.");
TAKT_PRIMITIVE(LessThan, "comparison", "a < b.");
TAKT_PRIMITIVE(Equal, "comparison", "|a - b| <= tolerance.");
TAKT_PRIMITIVE(InRange, "comparison", "lower <= input <= upper.");

TAKT_MEANING(GreaterThan, "value", "b < a");
TAKT_MEANING(LessThan, "value", "a < b");
TAKT_MEANING(InRange, "value", "lower <= input & input <= upper");

}  // namespace
}  // namespace takt::primitives
