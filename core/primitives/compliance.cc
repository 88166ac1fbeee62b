// Family "force": laws that make an arm give way. What presses is in force_control.cc.
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr const char* kWrenchUnit = "N,N*m";

/// A property of each direction, linear and angular, as two parameters.
struct SixAxes {
  SixAxes(Setup& setup, const char* linear_name, const char* linear_unit, const char* linear_example,
          const char* angular_name, const char* angular_unit, const char* angular_example, const char* range)
      : linear(setup.parameter<Vector>(
            linear_name, {.unit = linear_unit, .doc = "along x, y, z", .range = range, .example = linear_example})),
        angular(setup.parameter<Vector>(
            angular_name, {.unit = angular_unit, .doc = "about x, y, z", .range = range, .example = angular_example})) {
  }
  Vector linear, angular;
};

class ImpedanceLaw final : public Primitive {
 public:
  explicit ImpedanceLaw(Setup& setup)
      : error_(setup.in<Twist>(
            "error", {.unit = "m,rad", .frame = "A", .doc = "from the actual to the desired pose (FrameDifference)"})),
        twist_error_(setup.in<Twist>("twist_error",
                                     {.unit = "m/s,rad/s", .frame = "A", .doc = "desired twist minus actual twist"})),
        feed_forward_(setup.in<Wrench>("feed_forward", {.unit = kWrenchUnit,
                                                        .frame = "A",
                                                        .doc = "added; null counts as 0",
                                                        .on_null = OnNull::kHandled,
                                                        .optional = true})),
        wrench_(setup.out<Wrench>("wrench", {.unit = kWrenchUnit, .frame = "A", .doc = "to be exerted"})),
        stiffness_(setup, "stiffness", "N/m", "[500.0, 500.0, 500.0]", "rotational_stiffness", "N*m/rad",
                   "[50.0, 50.0, 50.0]", "[0,inf)"),
        damping_(setup, "damping", "N*s/m", "[40.0, 40.0, 40.0]", "rotational_damping", "N*m*s/rad", "[4.0, 4.0, 4.0]",
                 "[0,inf)") {}

  void update(const Cycle&) override {
    if (error_.null() || twist_error_.null()) return wrench_.set_null();
    const Wrench extra = feed_forward_.value_or(Wrench{});
    wrench_.set({.force = stiffness_.linear.cwiseProduct(error_->linear) +
                          damping_.linear.cwiseProduct(twist_error_->linear) + extra.force,
                 .torque = stiffness_.angular.cwiseProduct(error_->angular) +
                           damping_.angular.cwiseProduct(twist_error_->angular) + extra.torque});
  }

 private:
  In<Twist> error_, twist_error_;
  In<Wrench> feed_forward_;
  Out<Wrench> wrench_;
  SixAxes stiffness_, damping_;
};

/// m x'' + d x' + k x = f in each of six directions, by backward differences: stable for any mass, damping, stiffness
/// and period.
class AdmittanceLaw final : public Primitive {
 public:
  explicit AdmittanceLaw(Setup& setup)
      : wrench_(setup.in<Wrench>(
            "wrench",
            {.unit = kWrenchUnit, .frame = "A", .doc = "that the surroundings exert, minus the desired one"})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to no offset, at rest"))),
        offset_(setup.out<Twist>("offset", {.unit = "m,rad", .frame = "A", .doc = "displacement (DisplaceFrame)"})),
        twist_(setup.out<Twist>("twist", {.unit = "m/s,rad/s", .frame = "A", .doc = "its velocity"})),
        acceleration_(setup.out<Twist>("acceleration", {.unit = "m/s^2,rad/s^2", .frame = "A", .doc = "its change"})),
        mass_(setup, "mass", "kg", "[5.0, 5.0, 5.0]", "inertia", "kg*m^2", "[0.1, 0.1, 0.1]", "(0,inf)"),
        damping_(setup, "damping", "N*s/m", "[100.0, 100.0, 100.0]", "rotational_damping", "N*m*s/rad",
                 "[2.0, 2.0, 2.0]", "[0,inf)"),
        stiffness_(setup, "stiffness", "N/m", "[500.0, 500.0, 500.0]", "rotational_stiffness", "N*m/rad",
                   "[10.0, 10.0, 10.0]", "[0,inf)") {}

  void update(const Cycle& cycle) override {
    if (cycle.first || wrench_.null() || reset_.value_or(false)) linear_ = angular_ = {};
    if (wrench_.null()) {
      offset_.set_null();
      twist_.set_null();
      return acceleration_.set_null();
    }
    const Vector a = step(linear_, wrench_->force, mass_.linear, damping_.linear, stiffness_.linear, cycle.dt);
    const Vector alpha = step(angular_, wrench_->torque, mass_.angular, damping_.angular, stiffness_.angular, cycle.dt);
    offset_.set({.linear = linear_.x, .angular = angular_.x});
    twist_.set({.linear = linear_.v, .angular = angular_.v});
    acceleration_.set({.linear = a, .angular = alpha});
    const bool finite =
        linear_.x.allFinite() && angular_.x.allFinite() && linear_.v.allFinite() && angular_.v.allFinite();
    if (!finite) linear_ = angular_ = {};
  }

 private:
  struct State {
    Vector x = Vector::Zero(), v = Vector::Zero();
  };
  /// @return the acceleration of this step.
  static Vector step(State& s, const Vector& f, const Vector& m, const Vector& d, const Vector& k, double h) {
    const Vector rest = f - k.cwiseProduct(s.x) - (d + h * k).cwiseProduct(s.v);
    const Vector a = rest.cwiseQuotient(m + h * d + h * h * k);
    s.v += h * a;
    s.x += h * s.v;
    return a;
  }

  In<Wrench> wrench_;
  In<Boolean> reset_;
  Out<Twist> offset_, twist_, acceleration_;
  SixAxes mass_, damping_, stiffness_;
  State linear_, angular_;
};

TAKT_PRIMITIVE(ImpedanceLaw, "force",
               "A spring and a damper in six directions: stiffness * error + damping * twist_error + feed_forward. The "
               "first cycle is like any other.");
TAKT_PRIMITIVE(AdmittanceLaw, "force",
               "Motion of a body with mass, damper and spring in each of six directions under a wrench. It begins at "
               "rest without offset, in the first cycle, at a reset and after null; the first cycle has run for one "
               "period.");

}  // namespace
}  // namespace takt::primitives
