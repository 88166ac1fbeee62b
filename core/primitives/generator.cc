// Family "generator": jerk-limited motion that is planned in the cycle, towards targets that may change at any time.
#include <optional>
#include <string>
#include <type_traits>

#include "core/motion/online_generator.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;
using motion::JointVector;
using motion::OnlineGenerator;

/// One number per axis, for a Real too.
JointVector axes(Real value) { return JointVector::Constant(1, value); }
JointVector axes(const JointArray& value) { return value.map(); }
template <class T>
T payload(const JointVector& v) {
  if constexpr (std::is_same_v<T, Real>) {
    return v[0];
  } else {
    return JointArray(v);
  }
}

enum class Interface { kPosition, kVelocity };

/// The state of the motion as it leaves, and how it begins.
template <class T, Interface interface>
class JerkLimited : public Primitive {
  static constexpr bool kPosition = interface == Interface::kPosition;

 public:
  explicit JerkLimited(Setup& setup)
      : target_(setup.in<T>("target", {.unit = kPosition ? "u" : "u/s", .doc = "where to; may change in every cycle"})),
        acceleration_max_(setup.in<T>("acceleration_max", {.unit = "u/s^2", .doc = "> 0"})),
        jerk_max_(setup.in<T>("jerk_max", {.unit = "u/s^3", .doc = "> 0"})),
        start_(setup.in<T>(
            "start",
            {.unit = "u", .doc = "position where it begins, at rest", .on_null = OnNull::kHandled, .optional = true})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: begins anew"))),
        position_(setup.out<T>("position", {.unit = "u", .doc = "of this cycle", .may_be_null = true})),
        velocity_(setup.out<T>("velocity", {.unit = "u/s", .doc = "first derivative", .may_be_null = true})),
        acceleration_(setup.out<T>("acceleration", {.unit = "u/s^2", .doc = "second derivative", .may_be_null = true})),
        arrived_(setup.out<Boolean>("arrived", {.doc = "the target is reached", .may_be_null = true})),
        time_left_(setup.out<Real>(
            "time_left", {.unit = "s", .doc = "to the target, if it stays where it is", .may_be_null = true})) {
    if constexpr (kPosition) {
      velocity_max_ = setup.in<T>("velocity_max", {.unit = "u/s", .doc = "> 0"});
      target_velocity_ = setup.in<T>("target_velocity", {.unit = "u/s",
                                                         .doc = "with which the target is passed; null: 0",
                                                         .on_null = OnNull::kHandled,
                                                         .optional = true});
    }
    if constexpr (!std::is_same_v<T, Real>) {
      count_ = setup.parameter<Integer>("joints", {.doc = "how many", .range = "[1,12]", .example = "7"});
      synchronization_ = setup.parameter<std::string>(
          "synchronization", "time",
          {.doc = "time: all arrive at once; phase: on a straight line where the state allows it; none",
           .range = "time|phase|none"});
    }
    setup.latency("target", "position", {.cycles = 0, .data_dependent = true});
  }

  Diagnostics prepare() override {
    using enum OnlineGenerator::Synchronization;
    generator_.emplace(static_cast<int>(count_), synchronization_ == "none"    ? kNone
                                                 : synchronization_ == "phase" ? kPhase
                                                                               : kTime);
    return {};
  }

  void update(const Cycle& cycle) override {
    if (cycle.first || reset_.value_or(false)) running_ = false;
    const bool complete =
        !target_.null() && !acceleration_max_.null() && !jerk_max_.null() && (!kPosition || !velocity_max_.null());
    if (!complete || (!running_ && !begin())) return give_up();
    const auto status = advance(cycle.dt);
    using enum OnlineGenerator::Status;
    running_ = status == kMoving || status == kArrived;
    if (!running_) return give_up();
    const OnlineGenerator::State& state = generator_->state();
    position_.set(payload<T>(state.q));
    velocity_.set(payload<T>(state.dq));
    acceleration_.set(payload<T>(state.ddq));
    arrived_.set(status == kArrived);
    time_left_.set(generator_->time_left());
  }

 private:
  bool begin() {
    const JointVector rest = JointVector::Zero(count_);
    const JointVector place = !start_.null() ? axes(*start_) : kPosition ? axes(*target_) : rest;
    const bool usable = place.size() == count_ && (place.array().abs() <= OnlineGenerator::kMost).all();
    if (usable) generator_->start({.q = place, .dq = rest, .ddq = rest});
    return usable;
  }

  OnlineGenerator::Status advance(double dt) {
    const OnlineGenerator::Limits limits{
        .velocity = axes(*velocity_max_), .acceleration = axes(*acceleration_max_), .jerk = axes(*jerk_max_)};
    if constexpr (kPosition) {
      const JointVector passing =
          target_velocity_.null() ? JointVector(JointVector::Zero(count_)) : axes(*target_velocity_);
      return generator_->follow_position(axes(*target_), passing, limits, dt);
    } else {
      return generator_->follow_velocity(axes(*target_), limits, dt);
    }
  }

  void give_up() {
    running_ = false;
    position_.set_null();
    velocity_.set_null();
    acceleration_.set_null();
    arrived_.set_null();
    time_left_.set_null();
  }

  In<T> target_, acceleration_max_, jerk_max_, velocity_max_, target_velocity_, start_;
  In<Boolean> reset_;
  Out<T> position_, velocity_, acceleration_;
  Out<Boolean> arrived_;
  Out<Real> time_left_;
  Integer count_ = 1;
  std::string synchronization_ = "time";
  std::optional<OnlineGenerator> generator_;
  bool running_ = false;
};

using JerkLimitedPosition = JerkLimited<Real, Interface::kPosition>;
using JerkLimitedVelocity = JerkLimited<Real, Interface::kVelocity>;
using JerkLimitedJointPosition = JerkLimited<JointArray, Interface::kPosition>;
using JerkLimitedJointVelocity = JerkLimited<JointArray, Interface::kVelocity>;

TAKT_PRIMITIVE(
    JerkLimitedPosition, "generator",
    "Moves to a position in the shortest time within bounds on velocity, acceleration and jerk, from any "
    "state. It begins at `start`, else at the target; in the first cycle it has already run for one period. "
    "Null for a target or limits beyond 1e9, limits below 1e-6, a target velocity beyond the limit, and where "
    "no profile is found; then, and after null, it begins anew.");
TAKT_PRIMITIVE(
    JerkLimitedVelocity, "generator",
    "Moves at a velocity that is reached in the shortest time within bounds on acceleration and jerk. It "
    "begins at `start`, else at 0; in the first cycle it has already run for one period. Null for a target or "
    "limits beyond 1e9, limits below 1e-6, and where no profile is found; then, and after null, it begins "
    "anew.");
TAKT_PRIMITIVE(
    JerkLimitedJointPosition, "generator",
    "Moves all joints to their positions within bounds on velocity, acceleration and jerk of each, as fast as "
    "the slowest allows. It begins at `start`, else at the target; in the first cycle it has already run for "
    "one period. Null for arrays of another size, numbers beyond 1e9, limits below 1e-6, a target velocity "
    "beyond the limit, and where no profile is found; then, and after null, it begins anew.");
TAKT_PRIMITIVE(JerkLimitedJointVelocity, "generator",
               "Moves all joints at velocities that are reached within bounds on acceleration and jerk of each. It "
               "begins at `start`, else at 0; in the first cycle it has already run for one period. Null for arrays of "
               "another size, numbers beyond 1e9, limits below 1e-6, and where no profile is found; then, and after "
               "null, it begins anew.");

}  // namespace
}  // namespace takt::primitives
