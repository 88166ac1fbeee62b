#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cell/judge/expectation_kinds.h"

namespace takt::cell {
namespace {

/// Which force is meant where several touches push against each other.
enum class ForceMeant { kPressing, kResultant };

Key force_key() {
  return choice_key(
             "force", {"pressing", "resultant"},
             "Of touches that push against each other: pressing, what those that push one way sum up to, so that "
             "two fingers with 40 N each press with 40 N; resultant, the length of the sum of all, in which they "
             "cancel.")
      .by_default("pressing");
}

/// Of the true force between two things.
class BetweenExpectation : public Expectation {
 protected:
  explicit BetweenExpectation(ExpectationReader& reader)
      : between_(reader.texts("between")),
        meant_(reader.choice("force") == "resultant" ? ForceMeant::kResultant : ForceMeant::kPressing) {
    if (between_.size() != 2) return;
    const auto watch = reader.built.world->watch_contact(between_[0], between_[1]);
    if (watch) {
      watch_ = *watch;
    } else {
      reader.diagnostics().append(watch.error(), reader.at("between"));
    }
  }
  /// N, in the last physics step.
  [[nodiscard]] double force(const BuiltCell& built) const {
    const sim::ContactReading& reading = built.world->contact(watch_);
    return resultant() ? reading.force : reading.pressing;
  }
  /// N, the largest of all physics steps.
  [[nodiscard]] double max_force(const BuiltCell& built) const {
    const sim::ContactReading& reading = built.world->contact(watch_);
    return resultant() ? reading.max_force : reading.max_pressing;
  }
  [[nodiscard]] std::string names() const {
    return fmt::format("{}'{}' and '{}'", resultant() ? "in sum between " : "between ", between_[0], between_[1]);
  }

 private:
  [[nodiscard]] bool resultant() const { return meant_ == ForceMeant::kResultant; }

  std::vector<std::string> between_;
  ForceMeant meant_;
  std::size_t watch_ = 0;
};

/// The largest force of the run, of every step of the physics; or while a step runs, of every cycle.
class ContactForceExpectation final : public BetweenExpectation {
 public:
  explicit ContactForceExpectation(ExpectationReader& from)
      : BetweenExpectation(from),
        below_N_(from.number("below_N")),
        at_least_N_(from.number("at_least_N")),
        during_(from.during()) {}

  void steps_run(std::span<const std::string> paths) override { during_.look(paths); }
  void watch(const BuiltCell& built) override {
    if (during_.name().empty() || !during_.inside()) return;
    ran_ = true;
    greatest_ = std::max(greatest_, force(built));
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const bool always = during_.name().empty();
    if (!always && !ran_) return {.measured = fmt::format("'{}' did not run", during_.name())};
    ExpectationResult result;
    result.value = always ? max_force(outcome.built) : greatest_;
    result.passed = result.value < below_N_ && result.value >= at_least_N_;
    result.unit = "N";
    if (at_least_N_ > 0.0) result.lower = at_least_N_;
    result.upper = below_N_;
    result.measured = fmt::format("{:.2f} N at most {}{} (below {:g})", result.value, names(),
                                  always ? "" : fmt::format(" in '{}'", during_.name()), below_N_);
    return result;
  }

 private:
  double below_N_, at_least_N_;
  StepWindow during_;
  bool ran_ = false;       ///< the step
  double greatest_ = 0.0;  ///< while it ran, N
};

/// Over the cycles from the first to the last in which they touch, those between in which they do not included.
class MeanForceExpectation final : public BetweenExpectation {
 public:
  explicit MeanForceExpectation(ExpectationReader& from)
      : BetweenExpectation(from), at_least_N_(from.number("at_least_N")), below_N_(from.number("below_N")) {}

  void watch(const BuiltCell& built) override {
    const double now = force(built);
    if (now > 0.0) {
      cycles_ += 1 + pause_;
      pause_ = 0;
      sum_ += now;
    } else if (cycles_ > 0) {
      ++pause_;
    }
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    ExpectationResult result;
    result.value = cycles_ > 0 ? sum_ / static_cast<double>(cycles_) : 0.0;
    result.passed = cycles_ > 0 && result.value >= at_least_N_ && result.value < below_N_;
    result.unit = "N";
    result.lower = at_least_N_;
    result.upper = below_N_;
    result.measured = fmt::format("{:.2f} N in the mean of {} cycles {} ({:g} to {:g})", result.value, cycles_, names(),
                                  at_least_N_, below_N_);
    return result;
  }

 private:
  double at_least_N_, below_N_;
  double sum_ = 0.0;
  std::int64_t cycles_ = 0, pause_ = 0;
};

/// A reading that nobody has seen may have been the peak: a sensor that falls silent says nothing about it.
class PeakForceExpectation final : public Expectation {
 public:
  explicit PeakForceExpectation(ExpectationReader& from)
      : sensor_(from.name("sensor", keys_of(from.built.cell.sensors))), below_N_(from.number("below_N")) {}

  void step_begins(std::string_view) override { begun_ = true; }
  void watch(const BuiltCell& built) override {
    const device::ForceTorqueSensor& sensor = *built.cell.sensors.find(sensor_)->second.device;
    if (!sensor.has_sample()) {
      if (begun_) ++silent_;
      return;
    }
    begun_ = true;
    const device::WrenchSample& sample = sensor.sample();
    if (sample.sequence != sequence_) count(sample, built.core->period(), sensor.timing().cycle);
    peak_ = std::max(peak_, sample.wrench.force.norm());
    overloaded_ = overloaded_ || sample.overload;
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    ExpectationResult result;
    const std::string unseen = why_unseen();
    result.value = peak_;
    result.passed = peak_ < below_N_ && unseen.empty();
    result.unit = "N";
    result.upper = below_N_;
    result.measured =
        fmt::format("{:.2f} N at most read by '{}', tool weight included (below {:g})", peak_, sensor_, below_N_);
    if (!unseen.empty()) result.measured += "; " + unseen;
    return result;
  }

 private:
  /// A sensor that is faster than the cycle skips some by itself.
  void count(const device::WrenchSample& sample, Nanoseconds period, Nanoseconds cycle) {
    const std::uint64_t usual = cycle > 0 ? static_cast<std::uint64_t>((period + cycle - 1) / cycle) : 1;
    const std::uint64_t step = sample.sequence > sequence_ ? sample.sequence - sequence_ : 1;
    if (sequence_ > 0 && step > usual) lost_ += step - usual;
    read_ += 1;
    sequence_ = sample.sequence;
  }
  [[nodiscard]] std::string why_unseen() const {
    constexpr double kMostLost = 0.01;  // of the readings
    if (read_ == 0) return "it gave no reading";
    if (silent_ > 0) return fmt::format("it gave no reading in {} cycles", silent_);
    const double share = static_cast<double>(lost_) / static_cast<double>(lost_ + read_);
    if (share > kMostLost) return fmt::format("{:.1f} % of its readings were lost", 100.0 * share);
    return overloaded_ ? "it was overloaded" : "";
  }

  std::string sensor_;
  double below_N_;
  double peak_ = 0.0;
  bool begun_ = false, overloaded_ = false;  ///< begun: the program, or the readings
  std::int64_t silent_ = 0;                  ///< cycles without a reading
  std::uint64_t sequence_ = 0, read_ = 0, lost_ = 0;
};

}  // namespace

ExpectationKind contact_force_expectation() {
  return expectation_kind<ContactForceExpectation>(
      "contact_force",
      {"The largest true contact force between two things is in this range.",
       {pair_key("between", "Two of: object, device as a whole, DEVICE/LINK."), below_key(),
        number_key("at_least_N", "N", kNotNegative, "Lower bound.").by_default(0.0), force_key(), during_key()}});
}

ExpectationKind mean_force_expectation() {
  return expectation_kind<MeanForceExpectation>(
      "mean_force",
      {"The true force between two things, in the mean over the cycles from their first to their last touch.",
       {pair_key("between", "Objects, devices, or DEVICE/LINK."),
        number_key("at_least_N", "N", kNotNegative, "Lower bound."), force_key(), below_key()}});
}

ExpectationKind peak_force_expectation() {
  return expectation_kind<PeakForceExpectation>(
      "peak_force", {"The largest raw force that a sensor measured, tool weight included, was lower. It does not hold "
                     "where the sensor gave no reading in some cycle, lost more than 1 % of them, or was overloaded.",
                     {text_key("sensor", "Which sensor."), below_key()}});
}

}  // namespace takt::cell
