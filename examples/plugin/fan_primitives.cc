// Family "fan": drives and reads a fan. And Smoothstep, which knows nothing of fans.
#include <algorithm>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "fan.h"

namespace fan {
namespace {

using namespace takt::net;

class FanCommand final : public Primitive {
 public:
  explicit FanCommand(Setup& setup)
      : speed_(setup.in<Real>("speed", {.unit = "rad/s", .doc = "wanted speed", .on_null = OnNull::kStop})),
        fan_(setup.device<Fan>("device", Fan::kKind, "the fan that is driven")) {
    setup.claims("device");
  }

  void update(const Cycle& cycle) override {
    if (!speed_.null()) return fan_->propose(*speed_);
    cycle.signals->fail_with(Cause::Code::kNullInput, "the fan's speed is null", cycle.index);
  }

 private:
  In<Real> speed_;
  Fan* fan_;
};

class FanState final : public Primitive {
 public:
  explicit FanState(Setup& setup)
      : speed_(setup.out<Real>("speed", {.unit = "rad/s", .doc = "measured speed", .may_be_null = true})),
        fan_(setup.device<Fan>("device", Fan::kKind, "the fan that is read")) {}

  void update(const Cycle&) override {
    const auto speed = fan_->speed();
    speed ? speed_.set(*speed) : speed_.set_null();
  }

 private:
  Out<Real> speed_;
  Fan* fan_;
};

class Smoothstep final : public Primitive {
 public:
  explicit Smoothstep(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u", .doc = "signal"})),
        out_(setup.out<Real>("out", {.unit = "1", .doc = "0 below `from`, 1 above `to`, 3x^2 - 2x^3 between"})),
        from_(setup.parameter<Real>("from", {.unit = "u", .doc = "where it begins"})),
        to_(setup.parameter<Real>("to", {.unit = "u", .doc = "where it ends"})) {}

  takt::Diagnostics prepare() override {
    takt::Diagnostics diagnostics;
    if (!(to_ > from_)) diagnostics.error(takt::Code::kOutOfRange, "/to", "'to' is not beyond 'from'", "from < to");
    return diagnostics;
  }

  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    const double x = std::clamp((*in_ - from_) / (to_ - from_), 0.0, 1.0);
    out_.set(x * x * (3.0 - 2.0 * x));
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  double from_, to_;
};

TAKT_PRIMITIVE(FanCommand, "fan", "Drives a fan: hands the wanted speed to it each cycle.");
TAKT_PRIMITIVE(FanState, "fan", "Reads a fan.");
TAKT_PRIMITIVE(Smoothstep, "fan", "A soft step: from 0 to 1 while the signal goes from one bound to the other.");

}  // namespace
}  // namespace fan
