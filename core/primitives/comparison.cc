// Comparison of Real values; null in, null out.
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using net::Boolean;
using net::Cycle;
using net::In;
using net::Out;
using net::Real;
using net::Setup;

class GreaterThan final : public net::Primitive {
 public:
  explicit GreaterThan(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        greater_(s.out<Boolean>("greater", {.doc = "a > b"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return greater_.set_null();
    greater_.set(*a_ > *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> greater_;
};
TAKT_PRIMITIVE(GreaterThan, "comparison", "True while a is above b.");

class LessThan final : public net::Primitive {
 public:
  explicit LessThan(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        less_(s.out<Boolean>("less", {.doc = "a < b"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return less_.set_null();
    less_.set(*a_ < *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> less_;
};
TAKT_PRIMITIVE(LessThan, "comparison", "True while a is below b.");

class Near final : public net::Primitive {
 public:
  explicit Near(Setup& s)
      : a_(s.in<Real>("a", {.unit = "u"})),
        b_(s.in<Real>("b", {.unit = "u"})),
        near_(s.out<Boolean>("near", {.doc = "|a - b| <= tolerance"})),
        tolerance_(s.parameter<Real>("tolerance", {.unit = "u", .range = "[0,inf)"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return near_.set_null();
    near_.set(std::abs(*a_ - *b_) <= tolerance_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> near_;
  Real tolerance_;
};
TAKT_PRIMITIVE(Near, "comparison", "True while two values differ by no more than a tolerance.");

class InRange final : public net::Primitive {
 public:
  explicit InRange(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        low_(s.in<Real>("low", {.unit = "u"})),
        high_(s.in<Real>("high", {.unit = "u"})),
        inside_(s.out<Boolean>("inside", {.doc = "low <= value <= high"})) {}
  void update(const Cycle&) override {
    if (value_.null() || low_.null() || high_.null()) return inside_.set_null();
    inside_.set(*low_ <= *value_ && *value_ <= *high_);
  }

 private:
  In<Real> value_, low_, high_;
  Out<Boolean> inside_;
};
TAKT_PRIMITIVE(InRange, "comparison", "True while a value lies between two bounds, bounds included.");

}  // namespace
}  // namespace takt::primitives
