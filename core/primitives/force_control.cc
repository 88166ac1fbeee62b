// Family "force": what presses with a force (docs/force-control.md).
#include <algorithm>
#include <cmath>

#include "core/device/servo.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/arm_kinematics.h"
#include "core/primitives/surface_observer.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;
using kinematics::JointVector;

/// Figures of the arm for a force controller, at the posture of now. They change slowly, so they are computed now and
/// then.
class ServoStiffness final : public Primitive {
 public:
  explicit ServoStiffness(Setup& setup)
      : q_(setup.in<JointArray>("q", {.unit = "rad", .doc = "joint positions", .on_null = OnNull::kMayPass})),
        direction_(setup.in<Vector>(
            "direction",
            {.unit = "1", .doc = "in the axes of the base; any length but 0", .on_null = OnNull::kMayPass})),
        stiffness_(setup.out<Real>("stiffness", {.unit = "N/m",
                                                 .doc = "with which the arm holds its tool along the direction; null "
                                                        "where nothing holds it",
                                                 .may_be_null = true})),
        frequency_(
            setup.out<Real>("natural_frequency", {.unit = "rad/s", .doc = "of the tool on it", .may_be_null = true})),
        damping_(setup.out<Real>("damping_ratio", {.unit = "1", .doc = "of the same", .may_be_null = true})),
        delay_(setup.out<Real>("delay", {.unit = "s", .doc = "from a set point to when the arm follows it"})),
        kinematics_(setup),
        tip_T_(setup.parameter<Vector>(
            "tip_compliance", Vector(Vector::Zero()),
            {.unit = "m/N", .doc = "by how much the tool gives way by itself, along each axis of T"})) {
    setup.costs(3000.0);
  }

  Diagnostics prepare() override { return kinematics_.check(); }

  void update(const Cycle& cycle) override {
    if (cycle.first) wait_ = 0;
    delay_.set(delay(cycle.dt));
    const device::Compliance& compliance = kinematics_.arm->compliance();
    if (compliance.mode != mode_) wait_ = 0;
    mode_ = compliance.mode;
    if (q_.null() || direction_.null() || !(direction_->norm() > kShortest)) {
      wait_ = 0;
      return give(nullptr);
    }
    if (wait_-- <= 0) {
      wait_ = kCycles - 1;
      response_ = kinematics_.look(q_) ? respond(compliance) : device::ServoResponse{};
    }
    give(response_.stiffness > 0.0 ? &response_ : nullptr);
  }

 private:
  static constexpr int kCycles = 50;  ///< from one computation to the next
  static constexpr double kShortest = 1e-9;

  [[nodiscard]] device::ServoResponse respond(const device::Compliance& compliance) const {
    const device::PayloadSetting& load = kinematics_.arm->tool().payload;
    const kinematics::Payload payload{load.mass, load.p_FC, load.I_C};
    const JointVector q = q_->map();
    const Eigen::Matrix3d R_BT = kinematics_.X_BT.linear();
    const Eigen::Vector3d n_B = direction_->normalized();
    const auto arm = device::servo_response(kinematics_.arm->description(), compliance,
                                            {.q = q, .J_BT = kinematics_.J_BT, .R_BT = R_BT, .payload = payload}, n_B);
    return device::through_tip(arm, (R_BT.transpose() * n_B).cwiseAbs2().dot(tip_T_));
  }

  /// One cycle until the set point is sent, and what its back end declares.
  [[nodiscard]] double delay(double dt) const {
    const device::BackendTiming timing = kinematics_.arm->timing();
    return dt + to_seconds(timing.driver_delay + timing.dead_time);
  }

  void give(const device::ServoResponse* response) {
    if (response == nullptr) {
      stiffness_.set_null();
      frequency_.set_null();
      return damping_.set_null();
    }
    stiffness_.set(response->stiffness);
    frequency_.set(response->natural_frequency);
    damping_.set(response->damping_ratio);
  }

  In<JointArray> q_;
  In<Vector> direction_;
  Out<Real> stiffness_, frequency_, damping_, delay_;
  ArmKinematics kinematics_;
  Vector tip_T_;
  device::ControlMode mode_ = device::ControlMode::kPosition;
  device::ServoResponse response_;
  int wait_ = 0;
};

/// How hard it is where the tool presses, arm and surface in series: the slope of the force over the travel, of the
/// last tenth of a second.
class SlopeEstimate {
 public:
  void reset() { squares_ = products_ = 0.0; }
  /// @param velocity, force_rate  filtered alike, m/s and N/s
  void update(double velocity, double force_rate, double h) {
    const double keep = std::exp(-h / kMemory_s);
    squares_ = keep * squares_ + velocity * velocity * h;
    products_ = keep * products_ + velocity * force_rate * h;
  }
  /// About as far it has gone in its memory, m.
  [[nodiscard]] double travel() const { return std::sqrt(squares_ * kMemory_s); }
  /// N/m, >= 0. Something has moved.
  [[nodiscard]] double slope() const { return std::max(0.0, products_ / squares_); }

 private:
  static constexpr double kMemory_s = 0.1;
  double squares_ = 0.0, products_ = 0.0;
};

/// Free until something is touched, then a velocity in proportion to the lack of force (docs/force-control.md).
class ForceController final : public Primitive {
 public:
  explicit ForceController(Setup& setup)
      : wanted_(setup.in<Real>("wanted", {.unit = "N", .doc = "force that the tool is to exert, >= 0"})),
        force_(setup.in<Real>("force", {.unit = "N", .doc = "with which it presses, along the approach"})),
        stiffness_(
            servo(setup, "stiffness", "N/m", "of the arm along the approach (ServoStiffness); without it `gain`")),
        frequency_(servo(setup, "natural_frequency", "rad/s", "of the arm; without it filter_frequency")),
        damping_(servo(setup, "damping_ratio", "1", "of the arm; without it 1")),
        delay_(servo(setup, "delay", "s", "from a velocity to when the arm follows it; without it one cycle")),
        path_(setup.in<Vector>("path_velocity",
                               {.unit = "m/s",
                                .doc = "of the path that the tool follows, in axes that do not turn: with it a surface "
                                       "that moves is learned as one that is tilted",
                                .on_null = OnNull::kMayPass,
                                .optional = true})),
        moves_(setup.in<Real>("moves", {.unit = "m/s",
                                        .doc = "as fast as the tool is moved along the approach, a cycle ago; without "
                                               "it as fast as was wanted",
                                        .on_null = OnNull::kMayPass,
                                        .optional = true})),
        held_back_(setup.in<Boolean>(
            "held_back",
            {.doc = "the tool cannot go where the velocity would take it: nothing is learned of the surface meanwhile",
             .on_null = OnNull::kMayPass,
             .optional = true})),
        velocity_(setup.out<Real>("velocity", {.unit = "m/s", .doc = "along the approach"})),
        contact_(setup.out<Boolean>("contact", {.doc = "the force is controlled"})),
        at_force_(setup.out<Boolean>("at_force", {.doc = "in contact, and the force (20 Hz) is inside the band"})),
        approach_(number(setup, "approach_velocity", "m/s", "while nothing has been touched", "0.01", "[0,1]")),
        touch_(number(setup, "contact_force", "N", "from here on there is contact", "2.0", "(0,inf)")),
        release_(
            number(setup, "release_force", "N", "below it for release_time there is none any more", "0.5", "[0,inf)")),
        release_time_(number(setup, "release_time", "s", "how long", "0.05", "[0,1e6]")),
        band_(setup.parameter<Real>(
            "band", 0.1, {.unit = "1", .doc = "share of the wanted force: so far off is at force", .range = "(0,1]"})),
        gain_(setup.parameter<Real>(
            "gain", 0.0,
            {.unit = "m/s/N",
             .doc = "velocity for a lack of force; 0: from the stiffness; at most twice what that gives",
             .range = "[0,inf)",
             .example = "0.002"})),
        integral_(setup.parameter<Boolean>(
            "surface_moves", false,
            {.doc = "an integral part follows a surface that comes or goes, as under a tool that slides on a slope"})),
        measures_(setup.parameter<Boolean>(
            "measures_stiffness", false,
            {.doc = "a soft surface, as it shows while the force is brought up, raises the gain"})),
        sensor_delay_(setup.parameter<Real>(
            "sensor_delay", 0.001, {.unit = "s", .doc = "from a force to when it is known", .range = "[0,10]"})),
        filter_frequency_(setup.parameter<Real>(
            "filter_frequency", 60.0,
            {.unit = "rad/s", .doc = "of the force, where no natural_frequency is linked", .range = "(0,inf)"})),
        velocity_max_(number(setup, "velocity_max", "m/s", "largest speed in both directions", "0.02", "(0,inf)")),
        acceleration_max_(number(setup, "acceleration_max", "m/s^2", "bounds every change", "1.0", "(0,inf)")),
        approach_acceleration_(setup.parameter<Real>(
            "approach_acceleration", 0.0,
            {.unit = "m/s^2",
             .doc =
                 "bounds how fast the approach begins, so that the weight of a tool that is accelerated is not taken "
                 "for a contact; 0: acceleration_max",
             .range = "[0,inf)",
             .example = "0.1"})) {}

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (release_ >= touch_)
      diagnostics.error(Code::kOutOfRange, "/release_force", "not below contact_force",
                        "Keep release_force < contact_force");
    if (approach_ > velocity_max_)
      diagnostics.error(Code::kOutOfRange, "/approach_velocity", "above velocity_max", "Choose at most velocity_max");
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    const bool known = !wanted_.null() && !force_.null() && (gain_ > 0.0 || !stiffness_.null());
    if (cycle.first || !known) begin();
    if (!known) {
      velocity_.set_null();
      at_force_.set_null();
      return contact_.set_null();
    }
    const double h = cycle.dt, error = *wanted_ - *force_;
    look_at_servo(h);
    look_for_contact(error, h);
    filter_error(error, h);
    mean_ += std::min(1.0, h * kMeanRate) * (*force_ - mean_);
    const bool at_force = in_contact_ && std::abs(mean_ - *wanted_) <= band_ * *wanted_;
    brought_up_ = brought_up_ || at_force;
    measure(h);
    adapt_gain(error, h);
    feel_surface(h);
    move(h);
    velocity_.set(last_);
    contact_.set(in_contact_);
    at_force_.set(at_force);
  }

 private:
  static constexpr double kMeanRate = 125.0;     ///< 1/s: 20 Hz
  static constexpr double kShare = 0.25;         ///< of what dead time and resonance allow
  static constexpr double kObservedShare = 0.2;  ///< likewise, where an observer of the surface takes part
  static constexpr double kLeastTravel = 1e-6;   ///< m: nothing is known of a surface before
  static constexpr double kSoftTravel = 2e-5;    ///< m: nothing is known of a soft one before
  static constexpr double kCaution = 1.25;       ///< times the slope that was seen
  static constexpr double kSoftest = 0.02;       ///< of the arm's own stiffness: no surface counts as softer
  /// Times the arm's own stiffness: no surface can make it harder than 1, so from here on the figures of the arm are
  /// wrong, and what is seen counts. Blows and noise stay below.
  static constexpr double kImpossible = 1.5;
  static constexpr double kMostGain = 2.0;       ///< times the arm's own: where the law is half as far from swinging
  static constexpr double kRaise_s = 0.1;        ///< in which a gain goes up; it comes down at once
  static constexpr double kIntegralShare = 0.5;  ///< of the rate of the law
  static constexpr double kEdge = 0.66;          ///< of the wanted force: what misses more than that is no slope
  static constexpr double kPathRests = 1e-3;     ///< m/s: a path that is slower shows nothing of a tilt

  static double number(Setup& setup, const char* name, const char* unit, const char* doc, const char* example,
                       const char* range) {
    return setup.parameter<Real>(name, {.unit = unit, .doc = doc, .range = range, .example = example});
  }
  static In<Real> servo(Setup& setup, const char* name, const char* unit, const char* doc) {
    return setup.in<Real>(name, {.unit = unit, .doc = doc, .on_null = OnNull::kMayPass, .optional = true});
  }
  void begin() {
    in_contact_ = touched_ = brought_up_ = false;
    lost_for_ = 0;
    last_ = mean_ = 0.0;
    drift_ = 0.0;
    surface_.begin();
    filter_.begin(0.0);
    forget_surface(0.0);
  }
  [[nodiscard]] Vector path() const { return path_.null() ? Vector::Zero() : *path_; }
  /// What the next touch shows begins with it.
  void forget_surface(double force) {
    begin_measuring(force, 0.0);
    seen_ = learned_ = 0.0;
  }
  void begin_measuring(double force, double velocity) {
    pressed_.begin(force);
    travel_.begin(velocity);
    slope_.reset();
  }

  /// Figures of the arm, the rate of the law on the hardest surface, and the gain that gives it.
  void look_at_servo(double h) {
    servo_ = {.stiffness = stiffness_.value_or(0.0),
              .natural_frequency = frequency_.value_or(filter_frequency_),
              .damping_ratio = damping_.value_or(1.0)};
    dead_time_ = sensor_delay_ + delay_.value_or(h);
    observes_ = integral_ && servo_.stiffness > 0.0 && servo_.natural_frequency >= SurfaceObserver::kFastest;
    rate_ = (observes_ ? kObservedShare : kShare) / (dead_time_ + servo_.damping_time());
    base_ = servo_.stiffness > 0.0 ? rate_ / servo_.stiffness : gain_;
    if (gain_ > 0.0) base_ = servo_.stiffness > 0.0 ? std::min(gain_, kMostGain * base_) : gain_;
  }

  void look_for_contact(double error, double h) {
    if (!in_contact_ && *force_ >= touch_) {
      // From here on as if the law had always moved it like this: nothing of a fast approach is kept.
      if (!touched_) filter_.begin(std::min(error, last_ / base_));
      if (!touched_) mean_ = *force_;
      in_contact_ = touched_ = true;
      lost_for_ = 0;
      forget_surface(*force_);
      surface_.meet(*force_);
    }
    lost_for_ = *force_ < release_ ? lost_for_ + 1 : 0;
    if (lost_for_ <= cycles_of(release_time_, h)) return;
    in_contact_ = brought_up_ = false;
    learned_ = seen_ = 0.0;
    drift_ = 0.0;
    surface_.fade(h);
  }

  /// Until the force has been there once the filter does not hold back what brakes: so it does not go beyond.
  void filter_error(double error, double h) {
    filter_.update(error, servo_.natural_frequency, servo_.damping_ratio, h);
    const bool brakes = error < filter_.value && filter_.value > 0.0;
    if (in_contact_ && !brought_up_ && brakes) filter_.begin(std::max(error, 0.0));
  }

  /// Force over travel, of both since the touch and through the same filter. Along a path a tilted surface changes the
  /// force without any travel, so nothing can be said there.
  void measure(double h) {
    if (!in_contact_ || !(servo_.stiffness > 0.0)) return;
    if (path().norm() > kPathRests) return begin_measuring(*force_, last_);
    pressed_.update(*force_, servo_.natural_frequency, servo_.damping_ratio, h);
    travel_.update(last_, servo_.natural_frequency, servo_.damping_ratio, h);
    slope_.update(travel_.value, pressed_.rate, h);
    if (slope_.travel() > kLeastTravel) seen_ = slope_.slope();
  }
  /// Gain that the lag of arm and filter allows on a surface of this slope.
  [[nodiscard]] double gain_on(double slope) const {
    const double lag = dead_time_ + 2.0 * servo_.damping_ratio / servo_.natural_frequency;
    return 0.25 / (std::max(slope, kSoftest * servo_.stiffness) * lag);
  }
  /// What a soft surface shows while the force is brought up raises the gain. What is far from the wanted force later
  /// is not what was measured.
  void adapt_gain(double error, double h) {
    if (brought_up_ && std::abs(error) > 0.5 * *wanted_) learned_ = 0.0;
    if (!measures_ || !in_contact_ || brought_up_ || !(slope_.travel() > kSoftTravel && seen_ > 0.0)) return;
    const double allowed = gain_on(kCaution * seen_);
    learned_ = std::min(allowed, learned_ + std::min(1.0, h / kRaise_s) * allowed);
  }
  [[nodiscard]] double gain() const {
    const bool impossible = servo_.stiffness > 0.0 && seen_ > kImpossible * servo_.stiffness;
    return impossible ? std::min(base_, gain_on(kCaution * seen_)) : std::max(base_, learned_);
  }

  /// Under a tool that follows a path: what comes and goes with the way.
  void feel_surface(double h) {
    if (!integral_) return;
    surface_.move(moves_.value_or(last_), last_path_);
    last_path_ = path();
    if (!observes_) return;
    const bool knows_motion = !moves_.null() || !held_back_.value_or(false);
    const bool touches = in_contact_ && lost_for_ == 0 && knows_motion;
    surface_.feel(*force_, servo_, dead_time_, touches, h);
  }
  /// A change of the surface's velocity, m/s: where no path moves; and along a path, as one of its tilt, under an arm
  /// that is too slow for an observer.
  void learn(double change) {
    const double square = path().squaredNorm();
    if (square <= kPathRests * kPathRests) {
      drift_ = std::clamp(drift_ + change, -velocity_max_, velocity_max_);
    } else if (!observes_) {
      surface_.lean(change / square * path());
    }
  }

  void move(double h) {
    double wanted = approach_;
    if (touched_) {
      const double per_newton = gain();
      const double law = per_newton * filter_.value + drift_ + surface_.velocity(path());
      // Where it has lost the surface it does not come back faster than it came, beside what the surface goes away.
      const bool touches = in_contact_ && lost_for_ == 0;
      const double fastest = touches ? velocity_max_ : approach_ + std::max(0.0, surface_.velocity(path()));
      wanted = std::clamp(law, -velocity_max_, std::min(fastest, velocity_max_));
      if (integral_ && brought_up_ && wanted == law && !held_back_.value_or(false)) {
        const double lesson = std::clamp(filter_.value, -kEdge * *wanted_, kEdge * *wanted_);
        learn(kIntegralShare * rate_ * per_newton * lesson * h);
      }
    }
    const double step = acceleration_max_ * h;
    const bool begins = !touched_ && approach_acceleration_ > 0.0;
    const double faster = begins ? std::min(step, approach_acceleration_ * h) : step;
    last_ = std::clamp(wanted, last_ - step, last_ + faster);
    if (!std::isfinite(last_)) begin();
  }

  In<Real> wanted_, force_, stiffness_, frequency_, damping_, delay_;
  In<Vector> path_;
  In<Real> moves_;
  In<Boolean> held_back_;
  Out<Real> velocity_;
  Out<Boolean> contact_, at_force_;
  double approach_, touch_, release_, release_time_, band_, gain_;
  bool integral_, measures_;
  double sensor_delay_, filter_frequency_, velocity_max_, acceleration_max_, approach_acceleration_;

  device::ServoResponse servo_;
  double dead_time_ = 0.0, rate_ = 0.0, base_ = 0.0;
  bool observes_ = false;  ///< the surface; else an integral part learns its tilt
  bool in_contact_ = false, touched_ = false, brought_up_ = false;
  std::int64_t lost_for_ = 0;
  ServoLowPass filter_;            ///< of the missing force
  ServoLowPass pressed_, travel_;  ///< since the touch: the force, the velocity
  SlopeEstimate slope_;
  double seen_ = 0.0;     ///< slope, N/m; 0: not known
  double learned_ = 0.0;  ///< gain for the surface as it was measured; 0: not measured
  double last_ = 0.0;     ///< velocity
  double drift_ = 0.0;    ///< velocity of the surface, where no path moves
  SurfaceObserver surface_;
  Vector last_path_ = Vector::Zero();
  double mean_ = 0.0;  ///< force
};

TAKT_PRIMITIVE(ServoStiffness, "force",
               "How stiffly an arm holds its tool along a direction, and how fast it moves there by itself: from the "
               "position loops of its device file and its inertia, or from its springs where it is compliant. What a "
               "ForceController needs to know of an arm. Computed in the first cycle, after null, after a change of "
               "the control mode, and every 50 cycles.");
TAKT_PRIMITIVE(ForceController, "force",
               "Velocity along one direction that brings a contact force to its desired value: approaches, then moves "
               "in proportion to the filtered lack of force, with a gain that follows from the stiffness and the delay "
               "of the arm; nothing of the approach speed is kept. After a loss of contact it approaches again, no "
               "faster than before. It begins free and at rest, in the first cycle and after null. Either `stiffness` "
               "or `gain` has to be there, else the outputs are null.");

}  // namespace
}  // namespace takt::primitives
