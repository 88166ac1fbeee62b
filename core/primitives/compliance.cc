// Family "force": laws that make an arm give way, or press with a force.
#include <algorithm>
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

/// Two modes, free and in contact, and no jump of the velocity from one to the other.
class ForceController final : public Primitive {
 public:
  explicit ForceController(Setup& setup)
      : wanted_(setup.in<Real>("wanted", {.unit = "N", .doc = "force that the tool is to exert, >= 0"})),
        force_(setup.in<Real>("force", {.unit = "N", .doc = "with which it presses, along the approach"})),
        velocity_(setup.out<Real>("velocity", {.unit = "m/s", .doc = "along the approach"})),
        contact_(setup.out<Boolean>("contact", {.doc = "the force is controlled"})),
        approach_(number(setup, "approach_velocity", "m/s", "while nothing is touched", "0.01", "[0,1]")),
        touch_(number(setup, "contact_force", "N", "from here on there is contact", "2.0", "(0,inf)")),
        release_(
            number(setup, "release_force", "N", "below it for release_time there is none any more", "0.5", "[0,inf)")),
        release_time_(number(setup, "release_time", "s", "how long", "0.05", "[0,1e6]")),
        gain_(number(setup, "gain", "m/s/N", "velocity for a lack of force", "0.002", "(0,inf)")),
        integral_time_(number(setup, "integral_time", "s", "of the PI law", "0.5", "(0,inf)")),
        velocity_max_(number(setup, "velocity_max", "m/s", "largest speed in both directions", "0.02", "(0,inf)")),
        acceleration_max_(number(setup, "acceleration_max", "m/s^2", "bounds every change", "1.0", "(0,inf)")) {}

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (release_ >= touch_)
      diagnostics.error(Code::kOutOfRange, "/release_force", "not below contact_force",
                        "release_force < contact_force");
    if (approach_ > velocity_max_)
      diagnostics.error(Code::kOutOfRange, "/approach_velocity", "above velocity_max", "at most velocity_max");
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    const bool complete = !wanted_.null() && !force_.null();
    if (cycle.first || !complete) begin();
    if (!complete) {
      velocity_.set_null();
      return contact_.set_null();
    }
    look_for_contact(cycle.dt);
    const double error = *wanted_ - *force_;
    const double law = in_contact_ ? gain_ * error + integral_ : approach_;
    const double step = acceleration_max_ * cycle.dt;
    const double bounded = std::clamp(law, -velocity_max_, velocity_max_);
    last_ = std::clamp(bounded, last_ - step, last_ + step);
    if (in_contact_) {
      // What the bounds took away does not wind up: the integral is what makes the law give the bounded velocity.
      integral_ += gain_ * cycle.dt / integral_time_ * error + std::min(1.0, cycle.dt / integral_time_) * (last_ - law);
      if (!std::isfinite(integral_)) integral_ = 0.0;
    }
    velocity_.set(last_);
    contact_.set(in_contact_);
  }

 private:
  static double number(Setup& setup, const char* name, const char* unit, const char* doc, const char* example,
                       const char* range) {
    return setup.parameter<Real>(name, {.unit = unit, .doc = doc, .range = range, .example = example});
  }
  void begin() {
    in_contact_ = false;
    lost_for_ = 0;
    last_ = integral_ = 0.0;
  }
  void look_for_contact(double dt) {
    if (!in_contact_ && *force_ >= touch_) {
      in_contact_ = true;
      lost_for_ = 0;
      integral_ = last_ - gain_ * (*wanted_ - *force_);
    }
    lost_for_ = *force_ < release_ ? lost_for_ + 1 : 0;
    if (lost_for_ > cycles_of(release_time_, dt)) in_contact_ = false;
  }

  In<Real> wanted_, force_;
  Out<Real> velocity_;
  Out<Boolean> contact_;
  double approach_, touch_, release_, release_time_, gain_, integral_time_, velocity_max_, acceleration_max_;
  bool in_contact_ = false;
  std::int64_t lost_for_ = 0;
  double last_ = 0.0, integral_ = 0.0;
};

TAKT_PRIMITIVE(ImpedanceLaw, "force",
               "A spring and a damper in six directions: stiffness * error + damping * twist_error + feed_forward. The "
               "first cycle is like any other.");
TAKT_PRIMITIVE(AdmittanceLaw, "force",
               "Motion of a body with mass, damper and spring in each of six directions under a wrench. It begins at "
               "rest without offset, in the first cycle, at a reset and after null; the first cycle has run for one "
               "period.");
TAKT_PRIMITIVE(
    ForceController, "force",
    "Velocity along one direction that brings a contact force to its desired value: approaches, switches to force "
    "control without a jump at contact (PI law with anti-windup), and approaches again when contact is lost. It "
    "begins free and at rest, in the first cycle and after null.");

}  // namespace
}  // namespace takt::primitives
