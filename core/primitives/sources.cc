// Family "source": values that come from nothing but parameters and time.
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/random.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

template <class T>
constexpr std::string_view example_text() {
  if constexpr (std::is_same_v<T, Boolean>) return "true";
  if constexpr (std::is_same_v<T, Integer>) return "3";
  if constexpr (std::is_same_v<T, Real>) return "3.5";
  if constexpr (std::is_same_v<T, Text>) return R"("text")";
  if constexpr (std::is_same_v<T, Vector>) return "[1.0, 2.0, 3.0]";
  if constexpr (std::is_same_v<T, Rotation>) return "[1.0, 0.0, 0.0, 0.0]";
  if constexpr (std::is_same_v<T, Frame>) return R"({"position": [1.0, 2.0, 3.0], "quaternion": [1.0, 0.0, 0.0, 0.0]})";
  if constexpr (std::is_same_v<T, Twist>) return R"({"linear": [1.0, 2.0, 3.0], "angular": [0.0, 0.0, 0.0]})";
  if constexpr (std::is_same_v<T, Wrench>) return R"({"force": [1.0, 2.0, 3.0], "torque": [0.0, 0.0, 0.0]})";
  return "[1.0, 2.0]";
}

template <class T>
class Constant final : public Primitive {
 public:
  explicit Constant(Setup& setup)
      : value_(setup.out<T>("value", free_spec<T>("always the same"))),
        constant_(setup.parameter<T>("value", {.doc = "the constant", .example = example_text<T>()})) {}
  void update(const Cycle&) override { value_.set(constant_); }

 private:
  Out<T> value_;
  T constant_;
};

/// A Real that is a function of the time since the first cycle.
class Signal : public Primitive {
 protected:
  explicit Signal(Setup& setup) : value_(setup.out<Real>("value", {.unit = "u", .doc = "the signal"})) {}
  /// @param t  s since the first cycle
  [[nodiscard]] virtual double at(double t) const = 0;
  [[nodiscard]] static double number(Setup& setup, const char* name, const char* unit, const char* doc,
                                     const char* example, const char* range = "") {
    return setup.parameter<Real>(name, {.unit = unit, .doc = doc, .range = range, .example = example});
  }

 public:
  void update(const Cycle& cycle) final { value_.set(at(static_cast<double>(cycle.index_in_net) * cycle.dt)); }

 private:
  Out<Real> value_;
};

class Ramp final : public Signal {
 public:
  explicit Ramp(Setup& setup)
      : Signal(setup),
        from_(number(setup, "from", "u", "value in the first cycle", "0.0")),
        to_(number(setup, "to", "u", "value that is kept in the end", "1.0")),
        duration_(number(setup, "duration", "s", "time from one to the other", "2.0", "(0,inf)")) {}

 private:
  [[nodiscard]] double at(double t) const override {
    return t >= duration_ ? to_ : from_ + (to_ - from_) * (t / duration_);
  }
  double from_, to_, duration_;
};

class Step final : public Signal {
 public:
  explicit Step(Setup& setup)
      : Signal(setup),
        before_(number(setup, "before", "u", "value at first", "0.0")),
        after_(number(setup, "after", "u", "value from the step on", "1.0")),
        time_(number(setup, "time", "s", "of the step, after the first cycle", "0.5", "[0,inf)")) {}

 private:
  [[nodiscard]] double at(double t) const override { return t >= time_ - 1e-9 ? after_ : before_; }
  double before_, after_, time_;
};

/// What swings: turns since the first cycle, beginning at the phase.
class Oscillation : public Signal {
 protected:
  explicit Oscillation(Setup& setup)
      : Signal(setup),
        amplitude_(number(setup, "amplitude", "u", "largest distance from the mean", "1.0")),
        mean_(setup.parameter<Real>("mean", 0.0, {.unit = "u", .doc = "what it swings about"})),
        frequency_(number(setup, "frequency", "Hz", "how often", "2.0", "(0,inf)")),
        phase_(setup.parameter<Real>("phase", 0.0, {.unit = "1", .doc = "where it begins, in turns"})) {}
  /// The part of a turn in [0, 1) at a time.
  [[nodiscard]] double part(double t) const {
    const double turns = t * frequency_ + phase_;
    return turns - std::floor(turns);
  }
  [[nodiscard]] double about_mean(double share) const { return mean_ + amplitude_ * share; }

 private:
  double amplitude_, mean_, frequency_, phase_;
};

class SineWave final : public Oscillation {
 public:
  explicit SineWave(Setup& setup) : Oscillation(setup) {}

 private:
  [[nodiscard]] double at(double t) const override { return about_mean(std::sin(2.0 * std::numbers::pi * part(t))); }
};

class SquareWave final : public Oscillation {
 public:
  explicit SquareWave(Setup& setup)
      : Oscillation(setup),
        duty_(setup.parameter<Real>("duty", 0.5,
                                    {.unit = "1", .doc = "part of a turn that is high", .range = "[0,1]"})) {}

 private:
  [[nodiscard]] double at(double t) const override { return about_mean(part(t) < duty_ ? 1.0 : -1.0); }
  double duty_;
};

/// Random numbers: the same for the same seed and stream, whatever else the net holds (row D5).
class Noise : public Primitive {
 protected:
  explicit Noise(Setup& setup)
      : value_(setup.out<Real>("value", {.unit = "u", .doc = "another number each cycle"})),
        begin_{static_cast<std::uint64_t>(setup.parameter<Integer>("seed", {.doc = "any number", .example = "1"})),
               setup.parameter<std::string>("stream", std::string(),
                                            {.doc = "name; another stream is independent under the same seed"})},
        random_(begin_) {}
  [[nodiscard]] virtual double draw(Random& random) const = 0;

 public:
  void update(const Cycle& cycle) final {
    if (cycle.first) random_ = begin_;
    value_.set(draw(random_));
  }

 private:
  Out<Real> value_;
  Random begin_, random_;
};

class UniformNoise final : public Noise {
 public:
  explicit UniformNoise(Setup& setup)
      : Noise(setup),
        low_(setup.parameter<Real>("low", {.unit = "u", .doc = "smallest number", .example = "-1.0"})),
        high_(setup.parameter<Real>("high", {.unit = "u", .doc = "all are below", .example = "1.0"})) {}
  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (low_ > high_) diagnostics.error(Code::kOutOfRange, "/low", "low is above high", "Keep low <= high");
    return diagnostics;
  }

 private:
  [[nodiscard]] double draw(Random& random) const override { return random.uniform(low_, high_); }
  double low_, high_;
};

class NormalNoise final : public Noise {
 public:
  explicit NormalNoise(Setup& setup)
      : Noise(setup),
        mean_(setup.parameter<Real>("mean", 0.0, {.unit = "u", .doc = "mean"})),
        deviation_(setup.parameter<Real>(
            "deviation", {.unit = "u", .doc = "standard deviation", .range = "[0,inf)", .example = "0.1"})) {}

 private:
  [[nodiscard]] double draw(Random& random) const override { return mean_ + deviation_ * random.normal(); }
  double mean_, deviation_;
};

class Time final : public Primitive {
 public:
  explicit Time(Setup& setup)
      : elapsed_(setup.out<Real>("elapsed", {.unit = "s", .doc = "since the first cycle of the net, which has 0"})),
        clock_(setup.out<Real>("clock", {.unit = "s", .doc = "time of the core"})),
        cycle_(setup.out<Integer>("cycle", {.doc = "number of the cycle in the net, from 0"})),
        period_(setup.out<Real>("period", {.unit = "s", .doc = "length of a cycle"})) {}
  void update(const Cycle& cycle) override {
    elapsed_.set(static_cast<double>(cycle.index_in_net) * cycle.dt);
    clock_.set(to_seconds(cycle.time));
    cycle_.set(cycle.index_in_net);
    period_.set(cycle.dt);
  }

 private:
  Out<Real> elapsed_, clock_;
  Out<Integer> cycle_;
  Out<Real> period_;
};

TAKT_PRIMITIVE_FOR_ALL(Constant, "source", "A value that never changes.");
TAKT_PRIMITIVE(Ramp, "source", "Goes in a straight line from one value to another and stays there.");
TAKT_PRIMITIVE(Step, "source", "One value, and another from some time on.");
TAKT_PRIMITIVE(SineWave, "source", "mean + amplitude sin(2 pi (frequency t + phase)), t = 0 in the first cycle.");
TAKT_PRIMITIVE(SquareWave, "source",
               "mean + amplitude in the first part of each turn, mean - amplitude in the rest; t = 0 in the first "
               "cycle.");
TAKT_PRIMITIVE(UniformNoise, "source",
               "A random number a cycle, evenly spread over [low, high). Begins anew in the first cycle.");
TAKT_PRIMITIVE(NormalNoise, "source",
               "A random number a cycle, normally distributed and cut at six deviations. Begins anew in the first "
               "cycle.");
TAKT_PRIMITIVE(Time, "source", "The time of the cycle.");

}  // namespace
}  // namespace takt::primitives
