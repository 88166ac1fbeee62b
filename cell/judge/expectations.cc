#include "cell/judge/expectations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cell/judge/device_expectations.h"
#include "cell/judge/limit_monitor.h"
#include "cell/judge/pair_expectations.h"
#include "cell/judge/part_expectations.h"
#include "cell/judge/pose_expectations.h"
#include "cell/judge/step_window.h"
#include "core/base/keys_of.h"
#include "core/base/object_reader.h"
#include "core/net/description.h"
#include "core/net/registry.h"

namespace takt::cell {
namespace {

/// Which force is meant where several touches push against each other.
enum class ForceMeant { kPressing, kResultant };

ForceMeant read_force_meant(ObjectReader& reader) {
  return reader.choice("force", {"pressing", "resultant"}, std::optional<std::string>("pressing")) == "resultant"
             ? ForceMeant::kResultant
             : ForceMeant::kPressing;
}

/// Of the true force between two things.
class BetweenExpectation : public Expectation {
 protected:
  BetweenExpectation(ObjectReader& reader, BuiltCell& built)
      : between_(reader.texts("between")), meant_(read_force_meant(reader)) {
    if (between_.size() != 2) {
      reader.diagnostics().error(Code::kWrongSize, reader.at("between"), fmt::format("{} names", between_.size()),
                                 "Name exactly two");
      return;
    }
    const auto watch = built.world->watch_contact(between_[0], between_[1]);
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
  ContactForceExpectation(ObjectReader& reader, BuiltCell& built, const StepNames& steps)
      : BetweenExpectation(reader, built),
        below_N_(reader.number("below_N", {}, kPositive)),
        at_least_N_(reader.number("at_least_N", 0.0, kNotNegative)),
        during_(read_during(reader, steps)) {}

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
  MeanForceExpectation(ObjectReader& reader, BuiltCell& built)
      : BetweenExpectation(reader, built),
        at_least_N_(reader.number("at_least_N", {}, kNotNegative)),
        below_N_(reader.number("below_N", {}, kPositive)) {}

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
  PeakForceExpectation(ObjectReader& reader, const BuiltCell& built)
      : sensor_(reader.choice("sensor", keys_of(built.cell.sensors))),
        below_N_(reader.number("below_N", {}, kPositive)) {}

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

class LimitsExpectation final : public Expectation {
 public:
  LimitsExpectation(ObjectReader& reader, const BuiltCell& built) : arm_(read_arm_name(reader, built)) {
    const auto found = built.cell.arms.find(arm_);
    if (found == built.cell.arms.end()) return;
    const device::ArmDescription& description = found->second.device->description();
    monitor_.emplace(description.limits, description.joint_names, to_seconds(built.core->period()), description.effort);
  }

  void watch(const BuiltCell& built) override {
    monitor_->watch(*built.cell.arms.find(arm_)->second.device);
    if (const sim::SimArm* machine = built.world->arm(arm_)) monitor_->add_torque(machine->wanted_torque());
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    const LimitMonitor::Worst worst = monitor_->worst();
    ExpectationResult result;
    result.value = worst.share;
    result.passed = monitor_->held();
    result.upper = 1.0;
    result.measured = fmt::format("{:.1f} % of a limit at most: {}", 100 * worst.share, worst.what);
    return result;
  }

 private:
  std::string arm_;
  std::optional<LimitMonitor> monitor_;
};

/// Ids of the monitors of a net, those inside fragments with their path.
std::vector<std::string> monitors_of(const net::NetDescription& net, const std::string& path = {}) {
  std::vector<std::string> ids;
  for (const auto& primitive : net.primitives) {
    const net::PrimitiveInfo* info = net::Registry::global().find(primitive.type);
    if (info != nullptr && info->monitor) ids.push_back(path + primitive.id);
  }
  for (const auto& fragment : net.fragments)
    std::ranges::copy(monitors_of(fragment.net, path + fragment.id + "/"), std::back_inserter(ids));
  return ids;
}

class MonitorExpectation final : public Expectation {
 public:
  MonitorExpectation(ObjectReader& reader, const BuiltCell& built)
      : net_(reader.choice("net", keys_of(built.cell.nets))), monitor_(reader.text("monitor")) {
    if (const auto* is = reader.child("is")) is_ = *is;
    at_least_ = reader.number("at_least", at_least_);
    at_most_ = reader.number("at_most", at_most_);
    if (!is_ && !reader.has("at_least") && !reader.has("at_most"))
      reader.diagnostics().error(Code::kMissing, reader.pointer(), "no bound is given",
                                 "Give \"is\", \"at_least\" or \"at_most\"");
    const auto net = built.cell.nets.find(net_);
    if (net != built.cell.nets.end()) check_monitor(*net->second, reader);
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const auto net = outcome.variables.monitors.find(net_);
    if (net == outcome.variables.monitors.end()) return {.measured = fmt::format("net '{}' did not run", net_)};
    const auto shown = net->second.find(monitor_);
    if (shown == net->second.end()) return {.measured = fmt::format("'{}' of '{}' showed nothing", monitor_, net_)};
    const std::string& text = shown->second;
    const auto value = nlohmann::ordered_json::parse(text);
    ExpectationResult result;
    result.measured = fmt::format("'{}' of '{}' ended as {}", monitor_, net_, text);
    if (value.is_number()) result.value = value.get<double>();
    if (std::isfinite(at_least_)) result.lower = at_least_;
    if (std::isfinite(at_most_)) result.upper = at_most_;
    result.passed = is_ ? value == *is_ : value.is_number() && result.value >= at_least_ && result.value <= at_most_;
    return result;
  }

 private:
  void check_monitor(const net::NetDescription& net, ObjectReader& reader) const {
    std::vector<std::string> ids = monitors_of(net);
    if (std::ranges::find(ids, monitor_) != ids.end()) return;
    reader.diagnostics().error(Code::kUnknownName, reader.at("monitor"),
                               fmt::format("net '{}' has no monitor '{}'", net_, monitor_),
                               nearest_choice(monitor_, ids));
  }

  std::string net_, monitor_;
  std::optional<nlohmann::ordered_json> is_;
  double at_least_ = -std::numeric_limits<double>::infinity(), at_most_ = std::numeric_limits<double>::infinity();
};

class DurationExpectation final : public Expectation {
 public:
  explicit DurationExpectation(ObjectReader& reader) : below_s_(reader.number("below_s", {}, kPositive)) {}
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result;
    result.value = outcome.sim_time;
    result.passed = outcome.sim_time < below_s_;
    result.unit = "s";
    result.upper = below_s_;
    result.measured = fmt::format("{:.3f} s (below {:g})", outcome.sim_time, below_s_);
    return result;
  }

 private:
  double below_s_;
};

class StepExpectation final : public Expectation {
 public:
  StepExpectation(ObjectReader& reader, const std::optional<std::vector<std::string>>& steps)
      : step_(steps ? reader.choice("step", *steps) : reader.text("step")) {}
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result;
    result.value = static_cast<double>(std::ranges::count(outcome.steps_begun, step_));
    result.passed = result.value > 0;
    result.measured = fmt::format("step '{}' ran {:g} times", step_, result.value);
    return result;
  }

 private:
  std::string step_;
};

class RepeatsExpectation final : public Expectation {
 public:
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    if (!outcome.run_again) return {.judged = false, .measured = "not run a second time"};
    const std::string second = outcome.run_again();
    ExpectationResult result;
    result.passed = second == outcome.digest;
    result.measured = result.passed ? "a second run has the same digest"
                                    : fmt::format("a second run has digest {}, this one {}", second, outcome.digest);
    return result;
  }
};

/// Gives the entry's name to what its expectation finds.
class Named final : public Expectation {
 public:
  Named(const ExpectationEntry& entry, std::unique_ptr<Expectation> expectation)
      : name_(entry.name), kind_(entry.kind), expectation_(std::move(expectation)) {}
  void begin(const activity::Variables& variables) override { expectation_->begin(variables); }
  void watch(const BuiltCell& built) override { expectation_->watch(built); }
  void step_begins(std::string_view name) override { expectation_->step_begins(name); }
  void steps_run(std::span<const std::string> paths) override { expectation_->steps_run(paths); }
  void happened(const LogEntry& entry) override { expectation_->happened(entry); }
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result = expectation_->judge(outcome);
    result.name = name_;
    result.kind = kind_;
    return result;
  }

 private:
  std::string name_, kind_;
  std::unique_ptr<Expectation> expectation_;
};

std::unique_ptr<Expectation> make_one(const std::string& kind, ObjectReader& reader, BuiltCell& built,
                                      const std::optional<std::vector<std::string>>& steps) {
  if (kind == "estimate") return estimate_expectation(reader, built);
  if (kind == "belief") return belief_expectation(reader, built);
  if (kind == "object_pose") return object_pose_expectation(reader, built, steps);
  if (kind == "tool_pose") return tool_pose_expectation(reader, built, steps);
  if (kind == "contact_force") return std::make_unique<ContactForceExpectation>(reader, built, steps);
  if (kind == "mean_force") return std::make_unique<MeanForceExpectation>(reader, built);
  if (kind == "peak_force") return std::make_unique<PeakForceExpectation>(reader, built);
  if (kind == "monitor") return std::make_unique<MonitorExpectation>(reader, built);
  if (kind == "value") return value_expectation(reader, built, steps);
  if (kind == "event") return event_expectation(reader, steps);
  if (kind == "order") return order_expectation(reader, steps);
  if (kind == "contacts") return contacts_expectation(reader, built);
  if (kind == "gripper") return gripper_expectation(reader, built);
  if (kind == "screw") return screw_expectation(reader, built);
  if (kind == "signal") return signal_expectation(reader, built);
  if (kind == "relative_pose") return relative_pose_expectation(reader, built, steps);
  if (kind == "limits") return std::make_unique<LimitsExpectation>(reader, built);
  if (kind == "duration") return std::make_unique<DurationExpectation>(reader);
  if (kind == "step") return std::make_unique<StepExpectation>(reader, steps);
  if (kind == "repeats") return std::make_unique<RepeatsExpectation>();
  return nullptr;
}

}  // namespace

const std::vector<ExpectationKind>& expectation_kinds() {
  static const std::vector<ExpectationKind> kinds{
      {"belief",
       "A frame or object is where the program believes it to be. Keys: frame, position_within_m, angle_within_deg."},
      {"contact_force",
       "True force between two bodies stays below a bound, while a step runs or all along. Keys: between [a, b], "
       "below_N, at_least_N, force (pressing, resultant), during."},
      {"contacts",
       "Nothing begins to touch but these pairs of devices, objects and the floor. Keys: only [[a, b], ...]."},
      {"duration", "The program ends in time. Keys: below_s."},
      {"estimate", "A fitted pose is near the truth. Keys: estimate, of, position_within_m, angle_within_deg."},
      {"event",
       "Something of the log happens so often. Keys: source, event, text, during; times, or at_least, at_most; from_s, "
       "to_s."},
      {"gripper", "What a gripper does at the end: idle, moving, holding or lost. Keys: gripper, is."},
      {"limits",
       "No set point leaves the joint limits, differentiated from what was sent, and no motor is asked for more torque "
       "than it has. Keys: arm."},
      {"mean_force",
       "True force between two bodies, in the mean over the cycles from their first to their last touch. Keys: between "
       "[a, b], at_least_N, below_N, force (pressing, resultant)."},
      {"monitor",
       "The last value that a net's monitor showed. Keys: net, monitor, and at_least, at_most (numbers) or is (any)."},
      {"object_pose",
       "An object is truly near a pose, at the end or while a step runs. Keys: object, in, position_m, rpy_deg or "
       "quaternion, position_within_m, angle_within_deg, during."},
      {"order",
       "Several things of the log happen one after the other. Keys: events, each with source, event, text, during, "
       "within_s after the one before it."},
      {"peak_force", "A sensor's raw reading stays below a bound. Keys: sensor, below_N."},
      {"relative_pose",
       "The tool of one arm stays where it was to that of another one, between the begins of two steps. Keys: arms [a, "
       "b], from, to, position_within_m, angle_within_deg."},
      {"repeats", "A second run has the same digest."},
      {"screw",
       "How a screw is in its thread, and by how many turns. Keys: screw, is (free, caught, crossed, seated); "
       "turns_at_least, turns_at_most."},
      {"signal",
       "What an input or output is at the end, and how often it rose. Keys: signal; is, rises; or at_least, at_most."},
      {"step", "A named step has run. Keys: step."},
      {"tool_pose",
       "The tool of an arm, or a base, is truly near a pose, at the end or while a step runs. Keys: arm, in, "
       "position_m, "
       "rpy_deg or quaternion, position_within_m, angle_within_deg, during."},
      {"value",
       "The value of an expression while a step runs, or all along. Keys: value, during, from_s, to_s; "
       "at_least, at_most, share of the cycles in which they hold; mean_at_least, mean_at_most."},
  };
  return kinds;
}

Result<std::vector<std::unique_ptr<Expectation>>> make_expectations(
    const std::vector<ExpectationEntry>& entries, BuiltCell& built,
    const std::optional<std::vector<std::string>>& steps) {
  std::vector<std::string> kinds;
  for (const ExpectationKind& kind : expectation_kinds()) kinds.emplace_back(kind.name);
  Diagnostics diagnostics;
  std::vector<std::unique_ptr<Expectation>> expectations;
  for (const ExpectationEntry& entry : entries) {
    ObjectReader reader(entry.json, entry.pointer, diagnostics);
    (void)reader.text("name", "");
    (void)reader.choice("kind", kinds);
    auto expectation = make_one(entry.kind, reader, built, steps);
    if (!expectation) continue;
    reader.finish();
    expectations.push_back(std::make_unique<Named>(entry, std::move(expectation)));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return expectations;
}

}  // namespace takt::cell
