// Family "limit": bounds of value and rate, thresholds with a dead zone.
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/primitives/function.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// An error unless lower <= upper.
Diagnostics check_order(double lower, double upper) {
  Diagnostics diagnostics;
  if (lower > upper) diagnostics.error(Code::kOutOfRange, "/lower", "lower is above upper", "Keep lower <= upper");
  return diagnostics;
}

class Saturation final : public Primitive {
 public:
  explicit Saturation(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to limit"})),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "inside [lower, upper]"})),
        limited_(setup.out<Boolean>("limited", {.doc = "the input was outside"})),
        lower_(setup.parameter<Real>("lower", {.unit = "u", .doc = "smallest value", .example = "-1.0"})),
        upper_(setup.parameter<Real>("upper", {.unit = "u", .doc = "largest value", .example = "1.0"})) {}

  Diagnostics prepare() override { return check_order(lower_, upper_); }

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
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to follow"})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: value = input in this cycle"))),
        value_(setup.out<Real>("value", {.unit = "u", .doc = "the input, with bounded rate"})),
        rate_max_(setup.parameter<Real>(
            "rate_max", {.unit = "u/s", .doc = "largest change per second", .range = "(0,inf)", .example = "10.0"})) {}

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

class Hysteresis final : public Primitive {
 public:
  explicit Hysteresis(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to compare"})),
        value_(setup.out<Boolean>("value", {.doc = "true from above `upper` until below `lower`"})),
        lower_(setup.parameter<Real>("lower", {.unit = "u", .doc = "becomes false below", .example = "-0.5"})),
        upper_(setup.parameter<Real>("upper", {.unit = "u", .doc = "becomes true above", .example = "0.5"})),
        initial_(setup.parameter<Boolean>("initial", false,
                                          {.doc = "state of a first value between the two, also after null"})) {}

  Diagnostics prepare() override { return check_order(lower_, upper_); }

  void update(const Cycle& cycle) override {
    if (cycle.first || input_.null()) state_ = initial_;
    if (input_.null()) return value_.set_null();
    if (*input_ > upper_) state_ = true;
    if (*input_ < lower_) state_ = false;
    value_.set(state_);
  }

 private:
  In<Real> input_;
  Out<Boolean> value_;
  double lower_, upper_;
  bool initial_;
  bool state_ = false;
};

constexpr auto kClamp = [] {
  return ports({{"input", "u", "value to limit"}, {"lower", "u", "smallest value"}, {"upper", "u", "largest value"}},
               {{"value", "u", "inside [lower, upper]"}, {"limited", "", "the input was outside"}});
};
constexpr auto kDeadBand = [] {
  return ports({{"input", "u", "value to which the dead band is applied"}},
               {{"value", "u", "0 inside, without a jump beside it"}},
               {{"width", "u", "half width of the band", "[0,inf)", "0.1"}});
};
constexpr auto kQuantize = [] {
  return ports({{"input", "u", "value to round"}}, {{"value", "u", "the nearest multiple"}},
               {{"step", "u", "of which it is a multiple", "(0,inf)", "0.25"}});
};

using Clamp = Function<kClamp, [](double x, double lower, double upper) -> std::optional<std::tuple<double, bool>> {
  if (upper < lower) return std::nullopt;
  return std::tuple(std::clamp(x, lower, upper), x < lower || upper < x);
}>;
using DeadBand =
    Function<kDeadBand, [](double x, double width) { return std::copysign(std::max(std::abs(x) - width, 0.0), x); }>;
using Quantize = Function<kQuantize, [](double x, double step) {
  const double multiple = std::nearbyint(x / step) * step;
  return std::isfinite(multiple) ? multiple : x;  // so large that no multiple is nearer than the input itself
}>;

TAKT_PRIMITIVE(Saturation, "limit", "The input, brought to the nearest value inside [lower, upper].");
TAKT_PRIMITIVE(Clamp, "limit",
               "The input, brought to the nearest value between two other signals. Null where lower is above upper.");
TAKT_PRIMITIVE(RateLimiter, "limit",
               "Follows the input with bounded rate. The first cycle, and the first after null, gives the input.");
TAKT_PRIMITIVE(Hysteresis, "limit",
               "A threshold with two edges (Schmitt trigger), so that noise does not make it chatter.");
TAKT_PRIMITIVE(DeadBand, "limit", "The input less the width of the band, and 0 inside the band.");
TAKT_PRIMITIVE(Quantize, "limit", "The nearest multiple of a step; halves go to the even multiple.");

}  // namespace
}  // namespace takt::primitives
