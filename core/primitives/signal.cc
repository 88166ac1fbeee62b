// Limits, rates and filters over Real.
#include <algorithm>
#include <cmath>
#include <numbers>

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

class Saturation final : public net::Primitive {
 public:
  explicit Saturation(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        low_(s.in<Real>("low", {.unit = "u"})),
        high_(s.in<Real>("high", {.unit = "u"})),
        limited_(s.out<Real>("limited", {.unit = "u", .doc = "null where low > high", .may_be_null = true})),
        limit_reached_(s.out<Boolean>("limit_reached", {.may_be_null = true})) {}
  void update(const Cycle&) override {
    if (value_.null() || low_.null() || high_.null() || *low_ > *high_) {
      limit_reached_.set_null();
      return limited_.set_null();
    }
    limited_.set(std::clamp(*value_, *low_, *high_));
    limit_reached_.set(*value_ < *low_ || *value_ > *high_);
  }

 private:
  In<Real> value_, low_, high_;
  Out<Real> limited_;
  Out<Boolean> limit_reached_;
};
TAKT_PRIMITIVE(Saturation, "limits", "Keeps a value between two bounds and says when it had to.");

class RateLimiter final : public net::Primitive {
 public:
  explicit RateLimiter(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        reset_(s.in<Boolean>(
            "reset",
            {.doc = "true: limited = value in this cycle", .on_null = OnNull::kCountsAsFalse, .optional = true})),
        limited_(s.out<Real>("limited", {.unit = "u", .doc = "first cycle, and after null: value"})),
        rate_max_(s.parameter<Real>("rate_max", {.unit = "u/s", .range = "(0,inf)"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) known_ = false;
    if (value_.null()) {
      known_ = false;
      return limited_.set_null();
    }
    const double step = rate_max_ * cycle.dt;
    last_ = known_ && !reset_.value_or(false) ? std::clamp(*value_, last_ - step, last_ + step) : *value_;
    known_ = true;
    limited_.set(last_);
  }

 private:
  In<Real> value_;
  In<Boolean> reset_;
  Out<Real> limited_;
  Real rate_max_;
  bool known_ = false;
  Real last_ = 0.0;
};
TAKT_PRIMITIVE(
    RateLimiter, "limits",
    "Follows a signal with bounded rate: |limited[k] - limited[k-1]| <= rate_max * period. Null drops the history.");

class LowPass final : public net::Primitive {
 public:
  explicit LowPass(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        filtered_(s.out<Real>("filtered", {.unit = "u", .doc = "first cycle, and after null: value"})),
        cutoff_(s.parameter<Real>("cutoff", {.unit = "1/s", .doc = "corner frequency, Hz", .range = "(0,inf)"})) {
    s.latency("value", "filtered", {.cycles = 0, .data_dependent = true});
  }
  void update(const Cycle& cycle) override {
    if (cycle.first) known_ = false;
    if (value_.null()) {
      known_ = false;
      return filtered_.set_null();
    }
    // Exact for inputs that are constant over a cycle.
    const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * cutoff_ * cycle.dt);
    state_ = known_ ? state_ + share * (*value_ - state_) : *value_;
    known_ = true;
    filtered_.set(state_);
  }

 private:
  In<Real> value_;
  Out<Real> filtered_;
  Real cutoff_;
  bool known_ = false;
  Real state_ = 0.0;
};
TAKT_PRIMITIVE(LowPass, "filters", "First-order low pass. Null drops the history.");

class Differentiator final : public net::Primitive {
 public:
  explicit Differentiator(Setup& s)
      : value_(s.in<Real>("value", {.unit = "u"})),
        derivative_(
            s.out<Real>("derivative",
                        {.unit = "u/s", .doc = "backward difference; null in the first cycle", .may_be_null = true})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) known_ = false;
    const bool both = known_ && !value_.null();
    if (both) {
      derivative_.set((*value_ - last_) / cycle.dt);
    } else {
      derivative_.set_null();
    }
    known_ = !value_.null();
    last_ = value_.value_or(0.0);
  }

 private:
  In<Real> value_;
  Out<Real> derivative_;
  bool known_ = false;
  Real last_ = 0.0;
};
TAKT_PRIMITIVE(Differentiator, "filters",
               "Rate of change over one cycle. Not for held samples: their velocity comes from the driver (row T2).");

}  // namespace
}  // namespace takt::primitives
