// Family "signal": limits and filters of real numbers.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

class Saturation final : public Primitive {
 public:
  explicit Saturation(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "what is limited"})),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "inside [lower, upper]"})),
        limited_(setup.out<Boolean>("limited", {.doc = "the input was outside"})),
        lower_(setup.parameter<Real>("lower", {.unit = "u", .doc = "smallest value"})),
        upper_(setup.parameter<Real>("upper", {.unit = "u", .doc = "largest value"})) {}

  Findings prepare() override {
    Findings findings;
    if (lower_ > upper_) findings.error("/lower", "lower is above upper", "lower <= upper");
    return findings;
  }

  void update(const Cycle&) override {
    if (input_.null()) {
      limited_.set_null();
      return value_.set_null();
    }
    value_.set(std::clamp(*input_, lower_, std::max(lower_, upper_)));
    limited_.set(*input_ < lower_ || *input_ > upper_);
  }

 private:
  In<Real> input_;
  Out<Real> value_;
  Out<Boolean> limited_;
  double lower_, upper_;
};

class RateLimiter final : public Primitive {
 public:
  explicit RateLimiter(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "what is followed"})),
        reset_(setup.in<Boolean>(
            "reset",
            {.doc = "true: value = input in this cycle", .on_null = OnNull::kCountsAsFalse, .optional = true})),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "the input, with bounded rate"})),
        rate_max_(setup.parameter<Real>("rate_max",
                                        {.unit = "u/s", .doc = "largest change per second", .range = "(0,inf)"})) {}

  void update(const Cycle& cycle) override {
    if (input_.null()) {
      has_history_ = false;
      return value_.set_null();
    }
    const double step = rate_max_ * cycle.dt;
    const bool follow = !cycle.first && has_history_ && !reset_.value_or(false);
    last_ = follow ? std::clamp(*input_, last_ - step, last_ + step) : *input_;
    has_history_ = true;
    value_.set(last_);
  }

 private:
  In<Real> input_;
  In<Boolean> reset_;
  Out<Real> value_;
  double rate_max_;
  double last_ = 0.0;
  bool has_history_ = false;
};

class LowPass final : public Primitive {
 public:
  explicit LowPass(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "what is smoothed"})),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "the smoothed input"})),
        cutoff_(setup.parameter<Real>("cutoff", {.unit = "Hz", .doc = "frequency at -3 dB", .range = "(0,inf)"})) {
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }

  void update(const Cycle& cycle) override {
    if (input_.null()) {
      has_history_ = false;
      return value_.set_null();
    }
    // Exact for an input that is constant between the cycles.
    const double share = -std::expm1(-2.0 * std::numbers::pi * cutoff_ * cycle.dt);
    const bool follow = !cycle.first && has_history_;
    state_ = follow ? state_ + share * (*input_ - state_) : *input_;
    has_history_ = true;
    value_.set(state_);
  }

 private:
  In<Real> input_;
  Out<Real> value_;
  double cutoff_;
  double state_ = 0.0;
  bool has_history_ = false;
};

class Differentiator final : public Primitive {
 public:
  explicit Differentiator(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "what is differenced"})),
        value_(setup.out<Real>("value", {.unit = "u/s", .doc = "change since the last cycle", .may_be_null = true})) {}

  void update(const Cycle& cycle) override {
    const bool known = !cycle.first && has_history_ && !input_.null();
    if (known) {
      value_.set((*input_ - last_) / cycle.dt);
    } else {
      value_.set_null();
    }
    has_history_ = !input_.null();
    last_ = *input_;
  }

 private:
  In<Real> input_;
  Out<Real> value_;
  double last_ = 0.0;
  bool has_history_ = false;
};

TAKT_PRIMITIVE(Saturation, "signal", "The input, brought to the nearest value inside [lower, upper].");
TAKT_PRIMITIVE(RateLimiter, "signal",
               "Follows the input with bounded rate. The first cycle, and the first after null, gives the input.");
TAKT_PRIMITIVE(LowPass, "signal", "First-order low pass. The first cycle, and the first after null, gives the input.");
TAKT_PRIMITIVE(Differentiator, "signal",
               "Backward difference per second. Null in the first cycle and in the first after null.");

}  // namespace
}  // namespace takt::primitives
