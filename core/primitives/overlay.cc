// Family "overlay": what is laid over a planned motion of a frame.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/motion/limits.h"
#include "core/motion/online_generator.h"
#include "core/motion/stop_range.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;
using motion::JointVector;
using motion::OnlineGenerator;

/// A number and its first two derivatives.
struct Jet {
  double value = 0.0, first = 0.0, second = 0.0;
};

Jet product(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}

/// From 0 to 1 over [0, length], at rest at both ends up to the second derivative.
Jet smooth_step(double t, double length) {
  if (t <= 0.0) return {};
  if (t >= length) return {.value = 1.0};
  const double x = t / length;
  return {x * x * x * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x * x * (x - 1.0) * (x - 1.0) / length,
          60.0 * x * (1.0 + x * (2.0 * x - 3.0)) / (length * length)};
}

/// Out of time of a path, so it stops and goes back with the motion that it is laid over.
class Weave final : public Primitive {
 public:
  explicit Weave(Setup& setup)
      : time_(setup.in<Real>("time", {.unit = "s", .doc = "path time"})),
        rate_(setup.in<Real>("rate", {.unit = "1", .doc = "path time per time"})),
        rate_derivative_(setup.in<Real>("rate_derivative", {.unit = "1/s", .doc = "change of the rate"})),
        value_(setup.out<Real>("value", {.unit = "m", .doc = "offset"})),
        velocity_(setup.out<Real>("velocity", {.unit = "m/s", .doc = "its first derivative with respect to time"})),
        acceleration_(setup.out<Real>("acceleration", {.unit = "m/s^2", .doc = "its second derivative"})),
        amplitude_(setup.parameter<Real>("amplitude",
                                         {.unit = "m", .doc = "largest offset", .range = "[0,1]", .example = "0.002"})),
        frequency_(setup.parameter<Real>(
            "frequency", {.unit = "Hz", .doc = "per path time", .range = "[0,1000]", .example = "2.0"})),
        begin_(setup.parameter<Real>("begin", 0.0, {.unit = "s", .doc = "path time", .range = "[0,inf)"})),
        duration_(setup.parameter<Real>(
            "duration", {.unit = "s", .doc = "path time from there to its end", .range = "[0,inf)", .example = "4.0"})),
        ramp_(setup.parameter<Real>("ramp", {.unit = "s",
                                             .doc = "path time in which it grows, and in which it fades to the end",
                                             .range = "(0,inf)",
                                             .example = "0.5"})) {}

  void update(const Cycle&) override {
    if (time_.null() || rate_.null() || rate_derivative_.null()) {
      for (Out<Real>* out : {&value_, &velocity_, &acceleration_}) out->set_null();
      return;
    }
    const double omega = 2.0 * std::numbers::pi * frequency_, t = *time_ - begin_;
    const double sine = std::sin(omega * t), cosine = std::cos(omega * t);
    const Jet wave{amplitude_ * sine, amplitude_ * omega * cosine, -amplitude_ * omega * omega * sine};
    const double ramp = std::min(ramp_, 0.5 * duration_);
    const Jet rise = smooth_step(t, ramp), rest = smooth_step(duration_ - t, ramp);
    const Jet w = product(wave, product(rise, {rest.value, -rest.first, rest.second}));
    value_.set(w.value);
    velocity_.set(w.first * *rate_);
    acceleration_.set(w.second * *rate_ * *rate_ + w.first * *rate_derivative_);
  }

 private:
  In<Real> time_, rate_, rate_derivative_;
  Out<Real> value_, velocity_, acceleration_;
  double amplitude_, frequency_, begin_, duration_, ramp_;
};

/// p + R d w, with the velocity and acceleration that follow.
class OffsetFrame final : public Primitive {
 public:
  explicit OffsetFrame(Setup& setup)
      : frame_(setup.in<Frame>("frame", {.frame = "A>B", .doc = "pose of B in A"})),
        twist_(setup.in<Twist>("twist", {.unit = "m/s,rad/s", .frame = "A", .doc = "velocity of B"})),
        acceleration_(setup.in<Twist>("acceleration",
                                      {.unit = "m/s^2,rad/s^2", .frame = "A", .doc = "time derivative of the twist"})),
        offset_(setup.in<Real>("offset", {.unit = "m", .doc = "along the direction"})),
        offset_velocity_(setup.in<Real>("offset_velocity", {.unit = "m/s", .doc = "its first derivative"})),
        offset_acceleration_(setup.in<Real>("offset_acceleration", {.unit = "m/s^2", .doc = "its second derivative"})),
        moved_frame_(setup.out<Frame>("moved_frame", {.frame = "A>B", .doc = "B with the offset"})),
        moved_twist_(setup.out<Twist>("moved_twist", {.unit = "m/s,rad/s", .frame = "A", .doc = "its velocity"})),
        moved_acceleration_(
            setup.out<Twist>("moved_acceleration", {.unit = "m/s^2,rad/s^2", .frame = "A", .doc = "its acceleration"})),
        direction_(
            setup.parameter<Vector>("direction", {.unit = "1",
                                                  .doc = "in the axes of B; an offset of 1 m moves by its length",
                                                  .example = "[0.0, 1.0, 0.0]"})) {}

  void update(const Cycle&) override {
    if (frame_.null() || twist_.null() || acceleration_.null() || offset_.null() || offset_velocity_.null() ||
        offset_acceleration_.null()) {
      moved_frame_.set_null();
      moved_twist_.set_null();
      return moved_acceleration_.set_null();
    }
    const Vector along = frame_->linear() * direction_;
    const Vector p = along * *offset_, v = along * *offset_velocity_;
    const Vector &w = twist_->angular, &dw = acceleration_->angular;
    Frame frame = *frame_;
    frame.translation() += p;
    moved_frame_.set(frame);
    moved_twist_.set({.linear = twist_->linear + v + w.cross(p), .angular = w});
    moved_acceleration_.set({.linear = acceleration_->linear + along * *offset_acceleration_ + 2.0 * w.cross(v) +
                                       dw.cross(p) + w.cross(w.cross(p)),
                             .angular = dw});
  }

 private:
  In<Frame> frame_;
  In<Twist> twist_, acceleration_;
  In<Real> offset_, offset_velocity_, offset_acceleration_;
  Out<Frame> moved_frame_;
  Out<Twist> moved_twist_, moved_acceleration_;
  Vector direction_;
};

/// Each cycle the wanted velocity is the target of a jerk-limited generator. Where the next state could no longer stop
/// inside of the range the target is 0 instead, and that it can follow: the state before could stop.
class BoundedOffset final : public Primitive {
 public:
  explicit BoundedOffset(Setup& setup)
      : velocity_(setup.in<Real>("velocity", {.unit = "m/s", .doc = "wanted", .on_null = OnNull::kHandled})),
        rest_(setup.in<Boolean>("rest", {.doc = "true: it comes to rest; so does null", .on_null = OnNull::kHandled})),
        value_(setup.out<Real>("value", {.unit = "m", .doc = "offset"})),
        rate_(setup.out<Real>("rate", {.unit = "m/s", .doc = "its first derivative"})),
        acceleration_(setup.out<Real>("acceleration", {.unit = "m/s^2", .doc = "its second derivative"})),
        standing_(setup.out<Boolean>("standing", {.doc = "it does not move"})),
        held_back_(setup.out<Boolean>("held_back", {.doc = "the end of its range keeps it from the wanted velocity"})),
        lower_(setup.parameter<Real>("lower",
                                     {.unit = "m", .doc = "never below", .range = "[-10,0]", .example = "-0.01"})),
        upper_(
            setup.parameter<Real>("upper", {.unit = "m", .doc = "never above", .range = "[0,10]", .example = "0.01"})),
        velocity_max_(setup.parameter<Real>(
            "velocity_max", {.unit = "m/s", .doc = "never faster", .range = "[1e-6,100]", .example = "0.02"})),
        acceleration_max_(setup.parameter<Real>(
            "acceleration_max", {.unit = "m/s^2", .doc = "of every change", .range = "[1e-6,1000]", .example = "0.5"})),
        jerk_max_(setup.parameter<Real>(
            "jerk_max", {.unit = "m/s^3", .doc = "of every change", .range = "[1e-6,1e6]", .example = "20.0"})) {}

  Diagnostics prepare() override {
    generator_.emplace(1, OnlineGenerator::Synchronization::kNone);
    const auto one = [](double value) { return JointVector(JointVector::Constant(1, value)); };
    limits_ = {.velocity = one(velocity_max_), .acceleration = one(acceleration_max_), .jerk = one(jerk_max_)};
    stop_time_ = motion::longest_stop({.lower = one(lower_),
                                       .upper = one(upper_),
                                       .velocity = limits_.velocity,
                                       .acceleration = limits_.acceleration,
                                       .jerk = limits_.jerk});
    return {};
  }

  [[nodiscard]] double stop_time_bound() const override { return stop_time_; }

  void update(const Cycle& cycle) override {
    if (cycle.first) generator_->start({one_zero(), one_zero(), one_zero()});
    const bool rest = cycle.stop_requested || velocity_.null() || rest_.value_or(true);
    const double wanted = rest ? 0.0 : std::clamp(*velocity_, -velocity_max_, velocity_max_);
    const double may = bounded(wanted);
    const bool held_back = !advance(may, cycle.dt) || may != wanted;
    const OnlineGenerator::State& now = generator_->state();
    value_.set(now.q[0]);
    rate_.set(now.dq[0]);
    acceleration_.set(now.ddq[0]);
    standing_.set(now.dq[0] == 0.0 && now.ddq[0] == 0.0);
    held_back_.set(!rest && held_back);
  }

 private:
  static JointVector one_zero() { return JointVector::Zero(1); }

  /// With half of the acceleration, since it takes time to build up: so the range's end is seldom met at full braking.
  [[nodiscard]] double bounded(double wanted) const {
    const double at = generator_->state().q[0];
    const double up = std::sqrt(acceleration_max_ * std::max(0.0, upper_ - at));
    const double down = std::sqrt(acceleration_max_ * std::max(0.0, at - lower_));
    return std::clamp(wanted, -down, up);
  }

  /// @return false: it has to brake, so that it stays inside.
  bool advance(double target, double dt) {
    const OnlineGenerator::State before = generator_->state();
    (void)generator_->follow_velocity(JointVector::Constant(1, target), limits_, dt);
    const OnlineGenerator::State& after = generator_->state();
    const auto range = motion::stop_range(after.q[0], after.dq[0], after.ddq[0], acceleration_max_, jerk_max_);
    if (range.lowest >= lower_ && range.highest <= upper_) return true;
    generator_->start(before);
    (void)generator_->follow_velocity(one_zero(), limits_, dt);
    return false;
  }

  In<Real> velocity_;
  In<Boolean> rest_;
  Out<Real> value_, rate_, acceleration_;
  Out<Boolean> standing_, held_back_;
  double lower_, upper_, velocity_max_, acceleration_max_, jerk_max_;
  std::optional<OnlineGenerator> generator_;
  OnlineGenerator::Limits limits_;
  double stop_time_ = 0.0;
};

TAKT_PRIMITIVE(BoundedOffset, "overlay",
               "An offset that moves with a desired velocity, never out of its range and never beyond its bounds of "
               "velocity, acceleration and jerk; it stops in front of the ends. A velocity of null counts as 0, and so "
               "does any while `rest` holds or is null, and once the net is to stop. It begins at 0, at rest; in the "
               "first cycle it has already run for one period.");
TAKT_PRIMITIVE(
    Weave, "overlay",
    "A sine over the path time of a motion, or of a part of it, which grows smoothly from its begin and fades "
    "to its end; before and after it is 0. The first cycle is like any other.");
TAKT_PRIMITIVE(OffsetFrame, "overlay",
               "A moving frame displaced along a direction of its own, with velocity and acceleration. The first cycle "
               "is like any other.");

}  // namespace
}  // namespace takt::primitives
