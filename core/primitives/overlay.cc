// Family "overlay": what is laid over a planned motion of a frame.
#include <cmath>
#include <numbers>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

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
        duration_(setup.parameter<Real>("duration",
                                        {.unit = "s", .doc = "of the path", .range = "[0,inf)", .example = "4.0"})),
        ramp_(setup.parameter<Real>("ramp", {.unit = "s",
                                             .doc = "path time in which it grows from the start and fades to the end",
                                             .range = "(0,inf)",
                                             .example = "0.5"})) {}

  void update(const Cycle&) override {
    if (time_.null() || rate_.null() || rate_derivative_.null()) {
      for (Out<Real>* out : {&value_, &velocity_, &acceleration_}) out->set_null();
      return;
    }
    const double omega = 2.0 * std::numbers::pi * frequency_, t = *time_;
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
  double amplitude_, frequency_, duration_, ramp_;
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

TAKT_PRIMITIVE(Weave, "overlay",
               "A sine over the path time of a motion, which grows smoothly from its start and fades to its end. The "
               "first cycle is like any other.");
TAKT_PRIMITIVE(OffsetFrame, "overlay",
               "A moving frame displaced along a direction of its own, with velocity and acceleration. The first cycle "
               "is like any other.");

}  // namespace
}  // namespace takt::primitives
