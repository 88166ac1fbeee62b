// What to make of null where the general rule (null in, null out) is not wanted.
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using net::Boolean;
using net::Cycle;
using net::In;
using net::OnNull;
using net::Out;
using net::Real;
using net::Setup;

class IsNull final : public net::Primitive {
 public:
  explicit IsNull(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u", .on_null = OnNull::kHandled})), null_(s.out<Boolean>("null")) {}
  void update(const Cycle&) override { null_.set(value_.null()); }

 private:
  In<Real> value_;
  Out<Boolean> null_;
};
TAKT_PRIMITIVE(IsNull, "null handling", "True while a value is null.");

class CountNullAsTrue final : public net::Primitive {
 public:
  explicit CountNullAsTrue(Setup& s)
      : value_(s.in<Boolean>("value", {.on_null = OnNull::kCountsAsTrue})), certain_(s.out<Boolean>("certain")) {}
  void update(const Cycle&) override { certain_.set(value_.value_or(true)); }

 private:
  In<Boolean> value_;
  Out<Boolean> certain_;
};
TAKT_PRIMITIVE(CountNullAsTrue, "null handling",
               "Takes null for true: what a stop or a guard makes of a sensor that does not answer (row N3).");

class DefaultTo final : public net::Primitive {
 public:
  explicit DefaultTo(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u", .on_null = OnNull::kHandled})),
        fallback_(s.in<Real>("fallback", {.unit = "u", .on_null = OnNull::kHandled})),
        result_(s.out<Real>("result", {.unit = "u"})) {}
  void update(const Cycle&) override {
    const In<Real>& chosen = value_.null() ? fallback_ : value_;
    if (chosen.null()) return result_.set_null();
    result_.set(*chosen);
  }

 private:
  In<Real> value_, fallback_;
  Out<Real> result_;
};
TAKT_PRIMITIVE(DefaultTo, "null handling", "A value, or another one while it is null.");

class HoldLast final : public net::Primitive {
 public:
  explicit HoldLast(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u", .on_null = OnNull::kHandled})),
        held_(s.out<Real>("held", {.unit = "u",
                                   .doc = "null before the first value, and after `cycles` nulls in a row",
                                   .may_be_null = true})),
        cycles_(s.parameter<net::Integer>("cycles",
                                          {.doc = "how many nulls in a row are bridged", .range = "[1,1000000]"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) age_ = cycles_ + 1;
    if (!value_.null()) {
      last_ = *value_;
      age_ = 0;
    } else if (age_ <= cycles_) {
      ++age_;
    }
    if (age_ > cycles_) return held_.set_null();
    held_.set(last_);
  }

 private:
  In<Real> value_;
  Out<Real> held_;
  net::Integer cycles_;
  net::Integer age_ = 0;
  Real last_ = 0.0;
};
TAKT_PRIMITIVE(HoldLast, "null handling", "Bridges short absences: repeats the last value for some cycles.");

}  // namespace
}  // namespace takt::primitives
