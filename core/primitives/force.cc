// Family "force": the force/torque sensor and what makes a contact force of its raw reading.
#include "core/device/force_torque_sensor.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr const char* kReadingUnit = "N,N*m";

class ForceTorqueSensor final : public Primitive {
 public:
  explicit ForceTorqueSensor(Setup& setup)
      : wrench_(setup.out<Wrench>(
            "wrench",
            {.unit = kReadingUnit, .frame = "S", .doc = "raw reading in measuring frame S", .may_be_null = true})),
        overload_(setup.out<Boolean>("overload", {.doc = "a channel is at its range", .may_be_null = true})),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        sensor_(setup.device<device::ForceTorqueSensor>("device", device::ForceTorqueSensor::kKind,
                                                        "the sensor that is read")) {}

  void update(const Cycle&) override {
    if (!sensor_->has_sample()) {
      wrench_.set_null();
      overload_.set_null();
      return age_.set_null();
    }
    wrench_.set(sensor_->sample().wrench);
    overload_.set(sensor_->sample().overload);
    age_.set(to_seconds(sensor_->sample_age()));
  }

 private:
  Out<Wrench> wrench_;
  Out<Boolean> overload_;
  Out<Real> age_;
  device::ForceTorqueSensor* sensor_;
};

class Tare final : public Primitive {
 public:
  explicit Tare(Setup& setup)
      : wrench_(setup.in<Wrench>(
            "wrench", {.unit = kReadingUnit, .frame = "S", .doc = "wrench to tare", .on_null = OnNull::kHandled})),
        trigger_(setup.in<Boolean>("trigger",
                                   {.doc = "begins a tare when it becomes true", .on_null = OnNull::kCountsAsFalse})),
        tared_(setup.out<Wrench>("tared", {.unit = kReadingUnit,
                                           .frame = "S",
                                           .doc = "wrench - bias; null until the first tare is done and during a tare",
                                           .may_be_null = true})),
        bias_(setup.out<Wrench>("bias", {.unit = kReadingUnit,
                                         .frame = "S",
                                         .doc = "mean over the newest tare; null before",
                                         .may_be_null = true})),
        done_(setup.out<Boolean>("done", {.doc = "a bias is known and no tare runs; never null"})),
        cycles_(setup.parameter<Integer>("cycles",
                                         {.doc = "samples in the mean", .range = "[1,1000000]", .example = "3"})) {
    setup.latency("trigger", "tared", {.cycles = 0, .data_dependent = true});
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) reset();
    const bool now = trigger_.value_or(false);
    if (now && !before_) begin();
    before_ = now;
    if (missing_ > 0 && !wrench_.null()) take();
    write();
  }

 private:
  void reset() {
    before_ = known_ = false;
    missing_ = 0;
  }
  void begin() {
    missing_ = cycles_;
    sum_ = Wrench{};
  }
  void take() {
    sum_.force += wrench_->force;
    sum_.torque += wrench_->torque;
    if (--missing_ > 0) return;
    const double share = 1.0 / static_cast<double>(cycles_);
    mean_ = {.force = share * sum_.force, .torque = share * sum_.torque};
    known_ = true;
  }
  void write() {
    const bool done = known_ && missing_ == 0;
    done_.set(done);
    if (known_) {
      bias_.set(mean_);
    } else {
      bias_.set_null();
    }
    if (!done || wrench_.null()) return tared_.set_null();
    tared_.set({.force = wrench_->force - mean_.force, .torque = wrench_->torque - mean_.torque});
  }

  In<Wrench> wrench_;
  In<Boolean> trigger_;
  Out<Wrench> tared_, bias_;
  Out<Boolean> done_;
  std::int64_t cycles_;
  std::int64_t missing_ = 0;
  bool before_ = false, known_ = false;
  Wrench sum_, mean_;
};

class PayloadCompensation final : public Primitive {
 public:
  explicit PayloadCompensation(Setup& setup)
      : wrench_(setup.in<Wrench>("wrench", {.unit = kReadingUnit, .frame = "S", .doc = "raw reading in S"})),
        frame_(setup.in<Frame>("frame", {.unit = "m", .frame = "W>S", .doc = "pose of S in the world W"})),
        acceleration_(setup.in<Vector>(
            "acceleration", {.unit = "m/s^2",
                             .frame = "W",
                             .doc = "of the payload's centre in W; the constant [0, 0, 0] leaves inertia in"})),
        compensated_(setup.out<Wrench>(
            "compensated", {.unit = kReadingUnit, .frame = "S", .doc = "without weight and inertia of the payload"})),
        mass_(setup.parameter<Real>(
            "mass", {.unit = "kg", .doc = "of all on the tool side", .range = "[0,inf)", .example = "0.5"})),
        centre_(setup.parameter<Vector>("centre",
                                        {.unit = "m", .doc = "centre of mass in S", .example = "[0.0, 0.0, 0.05]"})),
        gravity_(
            setup.parameter<Vector>("gravity", Vector(0.0, 0.0, -9.81), {.unit = "m/s^2", .doc = "gravity in W"})) {}

  void update(const Cycle&) override {
    if (wrench_.null() || frame_.null() || acceleration_.null()) return compensated_.set_null();
    const Vector force = mass_ * (frame_->linear().transpose() * (gravity_ - *acceleration_));
    compensated_.set({.force = wrench_->force - force, .torque = wrench_->torque - centre_.cross(force)});
  }

 private:
  In<Wrench> wrench_;
  In<Frame> frame_;
  In<Vector> acceleration_;
  Out<Wrench> compensated_;
  double mass_;
  Vector centre_, gravity_;
};

TAKT_PRIMITIVE(ForceTorqueSensor, "device",
               "The newest raw reading of a force/torque sensor: what surroundings and gravity exert on the tool side. "
               "Null until the first sample and when the newest is older than the device allows.");
TAKT_PRIMITIVE(Tare, "force",
               "Subtracts the mean of a number of readings, taken from the cycle on in which the trigger becomes true "
               "(true in the first cycle counts). Readings of null do not count.");
TAKT_PRIMITIVE(PayloadCompensation, "force",
               "Takes weight and inertia of a known payload, seen as a point mass, out of a raw reading. The first "
               "cycle is like any other.");

}  // namespace
}  // namespace takt::primitives
