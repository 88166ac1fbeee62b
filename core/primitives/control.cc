// Family "control": closed loops of one signal.
#include <algorithm>
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// Source: Astrom, Hagglund, "Advanced PID Control", 2006 (form, filter of the derivative, back-calculation).
class Pid final : public Primitive {
 public:
  explicit Pid(Setup& setup)
      : set_point_(setup.in<Real>("set_point", {.unit = "u", .doc = "desired value"})),
        measured_(setup.in<Real>("measured", {.unit = "u", .doc = "what is"})),
        feed_forward_(setup.in<Real>("feed_forward", {.unit = "v",
                                                      .doc = "added to the output; null counts as 0",
                                                      .on_null = OnNull::kHandled,
                                                      .optional = true})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: begins anew"))),
        initial_(setup.in<Real>("initial", {.unit = "v",
                                            .doc = "output where the controller begins, so that a take-over makes no "
                                                   "jump; null: it begins without integral",
                                            .on_null = OnNull::kHandled,
                                            .optional = true})),
        value_(setup.out<Real>("value", {.unit = "v", .doc = "inside [lower, upper]"})),
        integral_out_(setup.out<Real>("integral", {.unit = "v", .doc = "the part that the integral has in it"})),
        limited_(setup.out<Boolean>("limited", {.doc = "the output is at a bound"})),
        gain_(setup.parameter<Real>("gain", {.unit = "v/u", .doc = "of all three parts", .example = "2.0"})),
        integral_time_(time(setup, "integral_time", "0: no integral")),
        derivative_time_(time(setup, "derivative_time", "0: no derivative")),
        filter_(setup.parameter<Real>(
            "filter", 10.0,
            {.unit = "1", .doc = "the derivative is smoothed with derivative_time / filter", .range = "[1,1e6]"})),
        tracking_time_(
            time(setup, "tracking_time",
                 "how fast the integral is reduced at a bound; 0: sqrt(integral_time derivative_time), without "
                 "a derivative integral_time")),
        lower_(setup.parameter<Real>("lower", -1e300, {.unit = "v", .doc = "smallest output"})),
        upper_(setup.parameter<Real>("upper", 1e300, {.unit = "v", .doc = "largest output"})) {}

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (lower_ > upper_) diagnostics.error(Code::kOutOfRange, "/lower", "lower is above upper", "Keep lower <= upper");
    if (tracking_time_ == 0.0)
      tracking_time_ = derivative_time_ > 0.0 ? std::sqrt(integral_time_ * derivative_time_) : integral_time_;
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    const bool goes_on = running_ && !cycle.first && !reset_.value_or(false);
    running_ = !set_point_.null() && !measured_.null();
    if (!running_) return set_null();
    const double proportional = gain_ * (*set_point_ - *measured_) + feed_forward_.value_or(0.0);
    if (goes_on) {
      differentiate(cycle.dt);
    } else {
      derivative_ = 0.0;
      integral_ = initial_.null() || integral_time_ == 0.0 ? 0.0 : *initial_ - proportional;
    }
    before_ = *measured_;
    const double wanted = proportional + integral_ + derivative_;
    const double value = std::clamp(wanted, lower_, std::max(lower_, upper_));
    running_ = std::isfinite(wanted);  // what could not be held any more is not kept
    value_.set(running_ ? value : wanted);
    integral_out_.set(integral_);
    limited_.set(wanted <= lower_ || wanted >= upper_);
    integrate(value - wanted, cycle.dt);
  }

 private:
  static double time(Setup& setup, const char* name, const char* doc) {
    return setup.parameter<Real>(name, 0.0, {.unit = "s", .doc = doc, .range = "[0,1e6]"});
  }
  /// Of the measured value, so that a step of the set point makes no kick; backward differences are stable for any dt.
  void differentiate(double dt) {
    if (derivative_time_ == 0.0) return;
    const double lag = derivative_time_ / filter_;
    derivative_ = (lag * derivative_ - gain_ * derivative_time_ * (*measured_ - before_)) / (lag + dt);
  }
  /// For the next cycle; what the bounds took away is paid back (back-calculation).
  void integrate(double taken_away, double dt) {
    if (integral_time_ == 0.0) return;
    integral_ +=
        gain_ * dt / integral_time_ * (*set_point_ - *measured_) + std::min(1.0, dt / tracking_time_) * taken_away;
  }
  void set_null() {
    value_.set_null();
    integral_out_.set_null();
    limited_.set_null();
  }

  In<Real> set_point_, measured_, feed_forward_;
  In<Boolean> reset_;
  In<Real> initial_;
  Out<Real> value_, integral_out_;
  Out<Boolean> limited_;
  double gain_, integral_time_, derivative_time_, filter_, tracking_time_, lower_, upper_;
  bool running_ = false;
  double integral_ = 0.0, derivative_ = 0.0, before_ = 0.0;
};

TAKT_PRIMITIVE(Pid, "control",
               "gain (e + 1/integral_time * integral of e - derivative_time * derivative of measured), e = set_point - "
               "measured, inside bounds with anti-windup by back-calculation. It begins in the first cycle, at a reset "
               "and after null: with the output `initial` where that is given, else with the proportional part.");

}  // namespace
}  // namespace takt::primitives
