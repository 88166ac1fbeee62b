// Family "filter": smoothing, differentiation, integration.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/linear.h"
#include "core/primitives/payload_types.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A filter of one signal. It begins in the first cycle, after null, and after a value that it could not hold any more
/// (not finite), so nothing that once came in spoils it for ever.
template <class T>
class Filter : public Primitive {
 protected:
  Filter(Setup& setup, std::string_view value, std::string_view unit = free_unit<T>(), bool may_be_null = false)
      : input_(setup.in<T>("input", free_spec<T>("value to filter"))),
        value_(
            setup.out<T>("value", {.unit = unit, .frame = free_frame<T>(), .doc = value, .may_be_null = may_be_null})) {
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }
  /// The first value; std::nullopt: not known yet.
  virtual std::optional<T> begin(const T& input, double dt) = 0;
  virtual std::optional<T> follow(const T& input, double dt) = 0;

 public:
  void update(const Cycle& cycle) final {
    const bool goes_on = running_ && !cycle.first;
    running_ = !input_.null();
    if (!running_) return value_.set_null();
    const std::optional<T> value = goes_on ? follow(*input_, cycle.dt) : begin(*input_, cycle.dt);
    if (!value) return value_.set_null();
    running_ = finite(*value);
    value_.set(*value);
  }

 private:
  In<T> input_;
  Out<T> value_;
  bool running_ = false;
};

template <class T>
class LowPassOf : public Filter<T> {
 public:
  explicit LowPassOf(Setup& setup)
      : Filter<T>(setup, "the smoothed input"),
        cutoff_(setup.parameter<Real>(
            "cutoff", {.unit = "Hz", .doc = "frequency at -3 dB", .range = "(0,inf)", .example = "50.0"})) {}

 private:
  std::optional<T> begin(const T& input, double) override { return state_ = input; }
  std::optional<T> follow(const T& input, double dt) override {
    if (!same_shape(state_, input)) return begin(input, dt);
    // Exact for an input that is constant between the cycles.
    return state_ = toward(state_, input, -std::expm1(-kTurn * cutoff_ * dt));
  }
  double cutoff_;
  T state_{};
};

using LowPass = LowPassOf<Real>;
using LowPassVector = LowPassOf<Vector>;
using LowPassTwist = LowPassOf<Twist>;
using LowPassWrench = LowPassOf<Wrench>;
using LowPassJoints = LowPassOf<JointArray>;

template <class T>
class MovingAverageOf : public Filter<T> {
 public:
  explicit MovingAverageOf(Setup& setup)
      : Filter<T>(setup, "mean of the newest inputs"),
        cycles_(setup.parameter<Integer>("cycles", {.doc = "how many at most", .range = "[1,10000]", .example = "5"})) {
  }
  Diagnostics prepare() override {
    window_.resize(static_cast<std::size_t>(cycles_));
    return {};
  }

 private:
  std::optional<T> begin(const T& input, double dt) override {
    count_ = next_ = 0;
    sum_ = times(input, 0.0);
    return follow(input, dt);
  }
  std::optional<T> follow(const T& input, double dt) override {
    if (!same_shape(sum_, input)) return begin(input, dt);
    if (count_ == window_.size()) {
      sum_ = minus(sum_, window_[next_]);
    } else {
      ++count_;
    }
    sum_ = plus(sum_, input);
    window_[next_] = input;
    if (++next_ == window_.size()) {
      next_ = 0;
      add_up();
    }
    return times(sum_, 1.0 / static_cast<double>(count_));
  }
  /// Anew once a round: rounding errors of a running sum would otherwise stay for ever.
  void add_up() {
    sum_ = window_[0];
    for (std::size_t i = 1; i < count_; ++i) sum_ = plus(sum_, window_[i]);
  }
  std::int64_t cycles_;
  std::vector<T> window_;
  std::size_t count_ = 0, next_ = 0;
  T sum_{};
};

using MovingAverage = MovingAverageOf<Real>;
using MovingAverageVector = MovingAverageOf<Vector>;
using MovingAverageWrench = MovingAverageOf<Wrench>;

class Differentiator final : public Filter<Real> {
 public:
  explicit Differentiator(Setup& setup) : Filter(setup, "change since the last cycle", "u/s", true) {}

 private:
  std::optional<Real> begin(const Real& input, double) override {
    last_ = input;
    return std::nullopt;
  }
  std::optional<Real> follow(const Real& input, double dt) override {
    const double slope = (input - last_) / dt;
    last_ = input;
    return slope;
  }
  double last_ = 0.0;
};

class FilteredDifferentiator final : public Filter<Real> {
 public:
  explicit FilteredDifferentiator(Setup& setup)
      : Filter(setup, "smoothed change per second", "u/s"),
        cutoff_(setup.parameter<Real>(
            "cutoff",
            {.unit = "Hz", .doc = "frequency of the smoothing at -3 dB", .range = "(0,inf)", .example = "50.0"})) {}

 private:
  std::optional<Real> begin(const Real& input, double) override {
    last_ = input;
    return slope_ = 0.0;
  }
  std::optional<Real> follow(const Real& input, double dt) override {
    slope_ += -std::expm1(-kTurn * cutoff_ * dt) * ((input - last_) / dt - slope_);
    last_ = input;
    return slope_;
  }
  double cutoff_;
  double last_ = 0.0, slope_ = 0.0;
};

/// y = b0 x + b1 x' + b2 x'' - a1 y' - a2 y'', in transposed direct form II, which keeps rounding errors small.
class SecondOrder : public Filter<Real> {
 protected:
  struct Coefficients {
    double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
  };
  explicit SecondOrder(Setup& setup) : Filter(setup, "the filtered input") {}
  virtual Coefficients design(double dt) const = 0;

 private:
  /// As if the input had been what it is for ever.
  std::optional<Real> begin(const Real& input, double dt) override {
    c_ = design(dt);
    const double steady = input * ((c_.b0 + c_.b1 + c_.b2) / (1.0 + c_.a1 + c_.a2));
    later_ = c_.b2 * input - c_.a2 * steady;
    next_ = c_.b1 * input - c_.a1 * steady + later_;
    return steady;
  }
  std::optional<Real> follow(const Real& input, double) override {
    const double value = c_.b0 * input + next_;
    next_ = c_.b1 * input - c_.a1 * value + later_;
    later_ = c_.b2 * input - c_.a2 * value;
    return value;
  }
  Coefficients c_;
  double next_ = 0.0, later_ = 0.0;
};

class Biquad final : public SecondOrder {
 public:
  explicit Biquad(Setup& setup)
      : SecondOrder(setup),
        c_{number(setup, "b0", "0.2"), number(setup, "b1", "0.4"), number(setup, "b2", "0.2"),
           number(setup, "a1", "-0.4"), number(setup, "a2", "0.2")} {}
  Diagnostics prepare() override {
    Diagnostics diagnostics;
    const bool stable = std::abs(c_.a2) < 1.0 && std::abs(c_.a1) < 1.0 + c_.a2;
    if (!stable)
      diagnostics.error(Code::kOutOfRange, "/a1", "the filter is not stable", "Keep |a2| < 1 and |a1| < 1 + a2");
    return diagnostics;
  }

 private:
  static double number(Setup& setup, const char* name, const char* example) {
    return setup.parameter<Real>(name, {.unit = "1", .doc = "coefficient", .example = example});
  }
  Coefficients design(double) const override { return c_; }
  Coefficients c_;
};

/// A second-order filter from frequency and quality, by the bilinear transform with the frequency met exactly.
/// A frequency that the cycle cannot tell counts as 0.49 of the number of cycles a second.
class Designed : public SecondOrder {
 protected:
  Designed(Setup& setup, const char* frequency, const char* doc)
      : SecondOrder(setup),
        frequency_(setup.parameter<Real>(frequency, {.unit = "Hz", .doc = doc, .range = "(0,inf)", .example = "50.0"})),
        quality_(setup.parameter<Real>(
            "quality", std::numbers::sqrt2 / 2.0,
            {.unit = "1", .doc = "large: a sharp peak or notch; 0.707: no peak (Butterworth)", .range = "(0,inf)"})) {}
  /// The analogue filter (n2 S^2 + n1 S / Q + n0) / (S^2 + S / Q + 1), S = s / frequency.
  struct Prototype {
    double n2, n1, n0;
  };
  [[nodiscard]] virtual Prototype prototype() const = 0;

 private:
  Coefficients design(double dt) const override {
    const auto [n2, n1, n0] = prototype();
    const double w = std::tan(0.5 * kTurn * std::min(frequency_ * dt, 0.49));
    const double w2 = w * w, wq = w / quality_, scale = 1.0 / (1.0 + wq + w2);
    return {.b0 = scale * (n2 + n1 * wq + n0 * w2),
            .b1 = scale * 2.0 * (n0 * w2 - n2),
            .b2 = scale * (n2 - n1 * wq + n0 * w2),
            .a1 = scale * 2.0 * (w2 - 1.0),
            .a2 = scale * (1.0 - wq + w2)};
  }
  double frequency_, quality_;
};

class SecondOrderLowPass final : public Designed {
 public:
  explicit SecondOrderLowPass(Setup& setup) : Designed(setup, "cutoff", "above it the input is weakened") {}

 private:
  [[nodiscard]] Prototype prototype() const override { return {0.0, 0.0, 1.0}; }
};

class SecondOrderHighPass final : public Designed {
 public:
  explicit SecondOrderHighPass(Setup& setup) : Designed(setup, "cutoff", "below it the input is weakened") {}

 private:
  [[nodiscard]] Prototype prototype() const override { return {1.0, 0.0, 0.0}; }
};

class Notch final : public Designed {
 public:
  explicit Notch(Setup& setup) : Designed(setup, "frequency", "frequency to remove") {}

 private:
  [[nodiscard]] Prototype prototype() const override { return {1.0, 0.0, 1.0}; }
};

class Integrator final : public Primitive {
 public:
  explicit Integrator(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to integrate"})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to `initial`"))),
        value_(setup.out<Real>("value", {.unit = "u*s", .doc = "the integral, this cycle not counted"})),
        limited_(setup.out<Boolean>("limited", {.doc = "the integral is at a bound"})),
        initial_(setup.parameter<Real>("initial", 0.0, {.unit = "u*s", .doc = "where it begins"})),
        lower_(setup.parameter<Real>("lower", -1e300, {.unit = "u*s", .doc = "never below"})),
        upper_(setup.parameter<Real>("upper", 1e300, {.unit = "u*s", .doc = "never above"})) {}

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (!(lower_ <= initial_ && initial_ <= upper_))
      diagnostics.error(Code::kOutOfRange, "/initial", "initial is outside [lower, upper]",
                        "Keep lower <= initial <= upper");
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    if (cycle.first || reset_.value_or(false)) state_ = initial_;
    if (input_.null()) {
      limited_.set_null();
      return value_.set_null();
    }
    value_.set(state_);
    limited_.set(state_ <= lower_ || state_ >= upper_);
    state_ = std::clamp(state_ + *input_ * cycle.dt, lower_, std::max(lower_, upper_));
  }

 private:
  In<Real> input_;
  In<Boolean> reset_;
  Out<Real> value_;
  Out<Boolean> limited_;
  double initial_, lower_, upper_;
  double state_ = 0.0;
};

constexpr const char* kLowPass = "First-order low pass. The first cycle, and the first after null, gives the input.";
constexpr const char* kAverage = "Mean of the newest inputs; of those there are, in the first cycles and after null.";
TAKT_PRIMITIVE(LowPass, "filter", kLowPass);
TAKT_PRIMITIVE(LowPassVector, "filter", kLowPass);
TAKT_PRIMITIVE(LowPassTwist, "filter", kLowPass);
TAKT_PRIMITIVE(LowPassWrench, "filter", kLowPass);
TAKT_PRIMITIVE(LowPassJoints, "filter", kLowPass);
TAKT_PRIMITIVE(MovingAverage, "filter", kAverage);
TAKT_PRIMITIVE(MovingAverageVector, "filter", kAverage);
TAKT_PRIMITIVE(MovingAverageWrench, "filter", kAverage);
TAKT_PRIMITIVE(Differentiator, "filter",
               "Backward difference per second. Null in the first cycle and in the first after null.");
TAKT_PRIMITIVE(FilteredDifferentiator, "filter",
               "Backward difference per second behind a first-order low pass. 0 in the first cycle and in the first "
               "after null.");
TAKT_PRIMITIVE(Biquad, "filter",
               "y = b0 x + b1 x' + b2 x'' - a1 y' - a2 y'', where ' is the cycle before. It begins as if the input had "
               "always been what it is in the first cycle, or in the first after null.");
TAKT_PRIMITIVE(SecondOrderLowPass, "filter",
               "Second-order low pass. It begins settled: the first cycle, and the first after null, gives the input.");
TAKT_PRIMITIVE(SecondOrderHighPass, "filter",
               "Second-order high pass. It begins settled: the first cycle, and the first after null, gives 0.");
TAKT_PRIMITIVE(
    Notch, "filter",
    "Takes one frequency out. It begins settled: the first cycle, and the first after null, gives the input.");
TAKT_PRIMITIVE(Integrator, "filter",
               "Sum of input * period since the reset, inside bounds, without wind-up beyond them. The first cycle "
               "gives `initial`; null is passed on, and meanwhile the integral does not change.");

}  // namespace
}  // namespace takt::primitives
